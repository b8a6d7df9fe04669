"""Checks of all names and selectors of a case."""

from collections.abc import Mapping
from typing import Any

from text2sim.spec_schema.errors import Problem, sort_problems
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import Articulated, Rigid
from text2sim.spec_schema.models.place_rules import contradictions
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.soft_bodies import Round
from text2sim.spec_schema.names.control_references import check_controls
from text2sim.spec_schema.names.event_references import check_events
from text2sim.spec_schema.names.expect_references import check_expectations
from text2sim.spec_schema.names.film_references import check_film
from text2sim.spec_schema.names.measure_references import check_measures
from text2sim.spec_schema.names.name_table import Member, NameTable, Parts
from text2sim.spec_schema.names.reference_cycles import find_cycles
from text2sim.spec_schema.names.removal_references import check_removals
from text2sim.spec_schema.names.selectors import parse_selector
from text2sim.spec_schema.names.time_references import check_time
from text2sim.spec_schema.names.tree_references import check_mount, check_tree
from text2sim.spec_schema.text.document import Path


def check_references(
    loaded: LoadedCase, parts: Mapping[str, Parts] | None = None, counts: Mapping[str, int] | None = None
) -> list[Problem]:
    """Check every name and selector of a case.

    Args:
        loaded: The case.
        parts: Links and joints of files, chains, nets and ragdolls by name of the body, which only the compiler knows;
            those of other bodies are assumed to exist.
        counts: Number of copies of texts and sketches by name; only the compiler knows that of sketches.

    Returns:
        The problems, in the order of the file. The compiler makes the checks that need geometry.
    """
    table = NameTable(loaded, parts or {}, counts=counts or {})
    _check_names(table)
    _check_places(table)
    check_time(table)
    _check_friction(table)
    for name, body in table.bodies.items():
        if isinstance(body, Articulated):
            check_tree(table, name, body)
        elif isinstance(body, Rigid):
            check_mount(table, name, body)
    check_controls(table)
    check_measures(table)
    check_events(table)
    check_expectations(table)
    check_removals(table)
    check_film(table)
    return sort_problems(table.problems)


def _check_names(table: NameTable) -> None:
    for name in table.bodies:
        if name in table.statics:
            line = table.loaded.line(("scene", "statics", name))
            message = f"`{name}` is already the name of a static (line {line}); choose another name"
            table.report(("bodies", name), message, "duplicate-name", key=True)


def _check_friction(table: NameTable) -> None:
    contact = table.loaded.case.scene.contact
    for name, pair in contact.pairs.items():
        where: Path = ("scene", "contact", "pairs", name)
        if contact.model in ("sap", "ipc"):
            message = f"contact model {contact.model} combines the friction of both bodies and ignores pairs"
            table.report(where, message, "pair-friction", key=True)
        found = [table.find(selector, (*where, "between", k)) for k, selector in enumerate(pair.between)]
        members = [member for member in found if member is not None]
        for k, member in enumerate(members):
            if member.deforms:
                message = f"`{member.name}` deforms, and its friction is that of the other body's material"
                table.report((*where, "between", k), message, "pair-friction")
        if len(members) == 2 and all(member.static for member in members):
            table.report((*where, "between"), "two statics never touch each other", "pair-friction")


def _check_places(table: NameTable) -> None:
    targets: dict[str, str] = {}
    roots: dict[str, Path] = {}
    for section, models in ((("scene", "statics"), table.statics), (("bodies",), table.bodies)):
        for name, model in models.items():
            roots[name] = (*section, name)
            for number, item in enumerate(getattr(model, "along", None) or ()):
                if isinstance(item, Round):
                    table.find(item.round, (*section, name, "along", str(number), "round"), parts=False)
            if model.place is not None:
                found = _check_place(table, (*section, name, "place"), name, model)
                if found is not None:
                    targets[name] = found.name
    for cycle in find_cycles(targets):
        way = " -> ".join([*cycle, cycle[0]])
        message = f"is placed relative to itself: {way}; give one of them a pose, or place it relative to another body"
        table.report((*roots[cycle[0]], "place"), message, "circular-place", key=True)


def _check_place(table: NameTable, where: Path, name: str, model: Any) -> Member | None:
    """Check one place; return the body that it is relative to."""
    place: Place = model.place
    for key, message in contradictions(place):
        table.report((*where, key), message, "placement")
    if isinstance(place.facing, str):
        facing = table.find(place.facing, (*where, "facing"), parts=False)
        if facing is not None and facing.name == name:
            table.report((*where, "facing"), "it cannot face itself", "itself")
    found = table.find(place.target, (*where, place.relation), parts=False)
    if found is None:
        return None
    copies = table.copies(name, model)
    if model.repeat is not None and parse_selector(place.target).indexed and found.count not in (1, copies):
        message = (
            f"copies are placed one by one on a selector with brackets, but `{found.text}` selects {found.count} and "
            f"`{name}` has {copies}; `{found.name}` means all of them together"
        )
        table.report((*where, place.relation), message, "pairs", found.name)
    return found
