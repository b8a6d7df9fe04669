"""Checks of all names, selectors, times and expectations of a case."""

from collections.abc import Mapping
from typing import Any

from text2sim.spec_schema.errors import Problem, sort_problems
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.bodies import Articulated, Rigid
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.models.place_rules import contradictions
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.soft_bodies import Round
from text2sim.spec_schema.names.belt_references import check_belts
from text2sim.spec_schema.names.bond_references import check_bonds
from text2sim.spec_schema.names.control_references import check_controls
from text2sim.spec_schema.names.event_references import check_events, check_tested_measure
from text2sim.spec_schema.names.film_references import check_film
from text2sim.spec_schema.names.measure_references import check_measures
from text2sim.spec_schema.names.name_table import Member, NameTable, Parts
from text2sim.spec_schema.names.reference_cycles import find_cycles
from text2sim.spec_schema.names.removal_references import check_removals
from text2sim.spec_schema.names.selectors import parse_selector
from text2sim.spec_schema.names.tree_references import check_mount, check_tree
from text2sim.spec_schema.rounding import at_least
from text2sim.spec_schema.text.document import Path

MAX_STEPS = 10_000_000
"""Most time steps of a run: at a millisecond each, three hours."""
MAX_RECORDED = 1_000_000
"""Most recorded frames of a run."""


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
    check_bonds(table)
    check_belts(table)
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
        shown = " -> ".join([*cycle, cycle[0]])
        message = (
            f"is placed relative to itself: {shown}; give one of them a pose, or place it relative to another body"
        )
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
    found = table.find(place.target, (*where, place.relation))
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


def check_time(table: NameTable) -> None:
    """Check the time step and the rate of recording."""
    scene = table.loaded.case.scene
    duration, rate = scene.duration, table.loaded.case.record_rate
    if scene.dt > duration:
        message = f"the time step is longer than the whole run ({duration:g} s)"
        table.report(("scene", "dt"), message, "time-step")
    _check_amount(table, ("scene", "dt"), "time steps", duration / scene.dt, MAX_STEPS)
    recorded = duration * min(rate, 1 / scene.dt)
    _check_amount(table, ("scene", "record", "rate"), "recorded frames", recorded, MAX_RECORDED)
    if duration * rate < 1:
        message = f"records only the start: a run of {duration:g} s needs at least {at_least(1 / duration)}"
        table.report(("scene", "record", "rate"), message, "rate")


def _check_amount(table: NameTable, where: Path, noun: str, amount: float, most: int) -> None:
    if amount > most:
        table.report(where, f"gives {amount:.3g} {noun}; at most {most:,} are possible", "too-many", key=True)


def check_expectations(table: NameTable) -> None:
    """Check every expectation."""
    for name, expect in table.loaded.case.actions.expect.items():
        where: Path = ("actions", "expect", name)
        events = table.loaded.case.actions.events
        for field in ("event", "before", "on"):
            table.check_known((*where, field), "event", getattr(expect, field), events)
        if expect.event is not None:
            _check_event(table, where, expect)
        elif expect.measure is not None:
            check_tested_measure(table, (*where, "measure"), expect.measure, "warning")
            _check_values(table, where, expect)


def _check_event(table: NameTable, where: Path, expect: Expect) -> None:
    duration = table.loaded.case.scene.duration
    if expect.before is not None and expect.before == expect.event:
        table.report((*where, "before"), "an event cannot come before itself", "impossible")
    if expect.within is not None and expect.within[0] > duration:
        table.report((*where, "within"), f"starts after the end of the run ({duration:g} s)", "after-end")
    if isinstance(expect.count, tuple) and expect.count[1] < expect.count[0]:
        table.report((*where, "count"), "the second number must not be smaller than the first", "impossible")
    least = expect.count[1] if isinstance(expect.count, tuple) else expect.count
    if least is not None and least < 0:
        table.report((*where, "count"), "an event cannot happen less than 0 times", "impossible")


def _check_values(table: NameTable, where: Path, expect: Expect) -> None:
    """Check the times and bounds of the values of a measure."""
    duration = table.loaded.case.scene.duration
    if isinstance(expect.at, float) and expect.at > duration:
        table.report((*where, "at"), f"is after the end of the run ({duration:g} s)", "after-end")
    window = expect.during if isinstance(expect.during, tuple) else None
    if max(span_of(window, duration)) > duration:
        table.report((*where, "during"), f"lasts beyond the end of the run ({duration:g} s)", "after-end")
    low = expect.above if expect.above is not None else float("-inf")
    high = expect.below if expect.below is not None else float("inf")
    if expect.equals is not None and expect.tolerance is not None:
        low, high = max(low, expect.equals - expect.tolerance), min(high, expect.equals + expect.tolerance)
    if low >= high:
        table.report(where, f"no value is above {low:g} and below {high:g}", "impossible", key=True)
