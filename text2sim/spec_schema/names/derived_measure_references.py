"""Checks of measures of two other measures, of springs, and of rings on rods."""

from collections.abc import Mapping
from typing import Any

from text2sim.spec_schema.models import measures
from text2sim.spec_schema.models.bodies import Articulated, HingeMount
from text2sim.spec_schema.models.controls import Spring
from text2sim.spec_schema.models.shapes import Compound
from text2sim.spec_schema.names.control_references import check_joint
from text2sim.spec_schema.names.name_table import Member, NameTable, touching_parts
from text2sim.spec_schema.text.document import Path

JOINT_UNITS: Mapping[str, Mapping[str, str]] = {
    "joint_position": {"hinge": "rad", "slider": "m"},
    "joint_velocity": {"hinge": "rad/s", "slider": "m/s"},
    "joint_force": {"hinge": "N m", "slider": "N"},
}
"""Unit of a measure of a joint, by its kind."""
Pair = measures.Difference | measures.Ratio
"""A measure of two others."""
MAX_NESTED = 6
"""How deep differences and ratios may be measures of each other."""
RINGS, RODS = ("torus", "tube"), ("cylinder", "capsule", "box")
"""Shapes of rings, and of rods that pass through them."""


def check_pair(table: NameTable, where: Path, pair: Pair) -> None:
    """Report measures that do not exist, that need the pair itself, or that have no difference.

    Args:
        table: The table; problems are added to it.
        where: Path of the pair.
        pair: The difference or ratio.
    """
    known = table.loaded.case.actions.measures
    named = [
        table.check_known((*where, "measures", index), "measure", name, known)
        for index, name in enumerate(pair.measures)
    ]
    if not all(named):
        return
    if (wrong := _without_end(known, str(where[-1]), pair)) is not None:
        table.report((*where, "measures"), wrong, "nested")
        return
    units = [_unit_of(table, known[name]) for name in pair.measures]
    if isinstance(pair, measures.Difference) and None not in units and len({*units}) == 2:
        words = [f"in {unit}" if unit else "a number without unit" for unit in units]
        a, b = pair.measures
        message = f"`{a}` is {words[0]} and `{b}` {words[1]}: a difference needs equal units; use a `ratio`"
        table.report((*where, "measures"), message, "measure-kind")


def _without_end(known: Mapping[str, measures.Measure], name: str, pair: Pair) -> str | None:
    """Say that a pair needs itself, or is nested too deep; None if neither."""
    level = set(pair.measures)
    for _ in range(MAX_NESTED):
        if name in level:
            return f"`{name}` is worked out from itself"
        level = {inner for each in level for inner in getattr(known.get(each), "measures", ())}
    return f"differences and ratios of each other are nested more than {MAX_NESTED} deep" if level else None


def plain_measures(known: Mapping[str, measures.Measure], pair: Pair) -> list[measures.Measure]:
    """Return the measures from which a difference or ratio is worked out in the end, as far as they exist.

    Args:
        known: All measures by name.
        pair: The difference or ratio.
    """
    found: list[measures.Measure] = []
    level: list[str] = list(pair.measures)
    for _ in range(MAX_NESTED + 1):
        there = [known[name] for name in level if name in known]
        found += [one for one in there if not isinstance(one, Pair)]
        level = [name for one in there if isinstance(one, Pair) for name in one.measures]
    return found


def ratio_unit(above: str, below: str) -> str:
    """Return the unit of a ratio of two measures with units; empty if it has none."""
    if above == below:
        return ""
    divisor = f"({below})" if " " in below or "/" in below else below
    return f"{above or 1}/{divisor}" if divisor else above


def _unit_of(table: NameTable, measure: measures.Measure) -> str | None:
    """Return the unit of a measure; None if only its joints tell, and they are not known."""
    if isinstance(measure, Pair):
        known = table.loaded.case.actions.measures
        above, below = (_unit_of(table, known[name]) if name in known else None for name in measure.measures)
        if above is None or below is None or isinstance(measure, measures.Difference):
            return above if below is not None else None
        return ratio_unit(above, below)
    if measure.kind not in JOINT_UNITS or measure.value_unit or getattr(measure, "stat", None) == "count":
        return measure.value_unit
    quiet = NameTable(table.loaded, table.parts, counts=table.counts)
    for member in quiet.find_all(getattr(measure, "of", None), (), joint=True, many=True):
        for each in quiet.each(member, joint=True):
            joint = check_joint(quiet, (), each, "measure")
            if joint is not None:
                return JOINT_UNITS[measure.kind]["hinge" if isinstance(joint, HingeMount) else "slider"]
    return None


def check_threaded(table: NameTable, where: Path, measure: measures.Threaded) -> None:
    """Report bodies that are not rings or rods.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        measure: The measure.
    """
    for field, kinds, noun in (("of", RINGS, "ring"), ("by", RODS, "rod")):
        for member in table.find_all(getattr(measure, field), (*where, field), many=True, touching=True):
            for each in table.each(member):
                shape = shape_of(each.model, each.part)
                if shape is None or shape.kind not in kinds:
                    table.report(each.where, f"`{each.text}` is no {noun}: {_why_not(each, shape, kinds)}", "no-thread")
                    break


def shape_of(model: Any, part: str | None) -> Any:
    """Return the shape of a body, or of a link or part of it; None if the case gives none."""
    if isinstance(model, Articulated):
        link = (model.links or {}).get(part or "")
        return link.shape if link is not None else None
    shape = getattr(model, "shape", None)
    if part is None or not isinstance(shape, Compound):
        return shape if part is None else None
    return shape.solids[part].shape if part in shape.solids else None


def _why_not(member: Member, shape: Any, kinds: tuple[str, ...]) -> str:
    if isinstance(shape, Compound) and member.part is None:
        fitting = [name for name in touching_parts(member.model) if shape.parts[name].shape.kind in kinds]
        if fitting:
            return f"name the part that is one: {', '.join(f'`{member.name}.{name}`' for name in fitting)}"
    more = "; name a link or part" if member.part is None else ""
    what = f"its shape is a {shape.kind}" if shape is not None else f"it has no shape of its own{more}"
    return f"{what}, and it takes a {', '.join(kinds[:-1])} or {kinds[-1]}"


def check_spring_force(table: NameTable, where: Path, measure: measures.SpringForce) -> None:
    """Report a control that does not exist or is not a spring.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        measure: The measure.
    """
    springs = [name for name, one in table.loaded.case.actions.controls.items() if isinstance(one, Spring)]
    table.check_known((*where, "spring"), "spring", measure.spring, springs)
