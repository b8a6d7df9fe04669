"""Checks of the bodies, joints and regions of measures."""

from collections.abc import Sequence

from text2sim.spec_schema.models import events, measures
from text2sim.spec_schema.models.bodies import Articulated, BallMount, HingeMount, Rigid
from text2sim.spec_schema.models.controls import Spring
from text2sim.spec_schema.models.placed import Linked
from text2sim.spec_schema.names.control_references import check_joint, joints_of
from text2sim.spec_schema.names.derived_measure_references import (
    Pair,
    check_pair,
    check_spring_force,
    check_threaded,
    plain_measures,
)
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.names.selectors import quoted
from text2sim.spec_schema.names.soft_measure_references import (
    check_gap,
    check_other_side,
    check_parts_touched,
    check_soft_measure,
    check_submerging,
)
from text2sim.spec_schema.text.document import Path

JOINT_KINDS = (measures.JointPosition, measures.JointVelocity, measures.JointForce)
CONTACT_KINDS = ("contact_force", "contact_count", "penetration")
PAIRS = ("difference", "ratio")
"""Measures of two other measures."""
_OF_STATICS = (*CONTACT_KINDS, "position", "extent")
"""Measures that statics may have."""


def check_measures(table: NameTable) -> None:
    """Check every measure."""
    for name, measure in table.loaded.case.actions.measures.items():
        where: Path = ("actions", "measures", name)
        since, duration = measure.change_from, table.loaded.case.scene.duration
        if isinstance(since, float) and since > duration:
            table.report((*where, "change_from"), f"is after the end of the run ({duration:g} s)", "after-end")
        if isinstance(measure, measures.Distance):
            _check_distance(table, where, measure)
            continue
        if isinstance(measure, measures.Gap):
            check_gap(table, where, measure)
            continue
        if isinstance(measure, measures.SpringForce):
            check_spring_force(table, where, measure)
            continue
        if isinstance(measure, measures.Threaded):
            check_threaded(table, where, measure)
            continue
        if isinstance(measure, Pair):
            check_pair(table, where, measure)
            continue
        others: list[Member] = []
        if measure.kind in CONTACT_KINDS:
            others = table.find_all(getattr(measure, "by", None), (*where, "by"), many=True, touching=True)
            check_other_side(table, measure, others)
            # The penetration of deformable bodies comes from the positions of their points.
            sides = [side for side in (measured(table, measure), others) if side]
            if measure.kind != "penetration" or not any(all(one.deforms for one in side) for side in sides):
                check_contacts_recorded(table, where)
        check_carrier(table, where, measure)
        if isinstance(measure, measures.Submerged):
            check_submerging(table, where, measure)
        if isinstance(measure, measures.Extent | measures.Displacement) and measure.frame is not None:
            frame = table.find(measure.frame, (*where, "frame"))
            if frame is not None:
                _check_rigid(table, (*where, "frame"), frame, "can be the frame")
        members = table.find_all(
            measure.of,
            (*where, "of"),
            joint=isinstance(measure, JOINT_KINDS),
            many=True,
            touching=measure.kind in CONTACT_KINDS,
        )
        if measure.kind in CONTACT_KINDS:
            check_parts_touched(table, [*members, *others])
        fitting = [member for member in members if _check_subject(table, where, measure, member)]
        if isinstance(measure, JOINT_KINDS):
            _check_joints(table, members)
        if fitting and len(fitting) == len(members):
            _check_stat(table, where, measure, members[0])


def measured(table: NameTable, measure: measures.Measure) -> list[Member]:
    """Return the bodies of a measure, without those of invalid selectors, which are already reported."""
    return [member for side in measured_sides(table, measure) for member in side]


def measured_sides(table: NameTable, measure: measures.Measure) -> list[list[Member]]:
    """Return the bodies of a measure as `measured` does, those on each side of a distance or gap by themselves.

    The sides of a difference or ratio are those of its measures.
    """
    if isinstance(measure, Pair):
        plain = plain_measures(table.loaded.case.actions.measures, measure)
        return [side for each in plain for side in measured_sides(table, each)]
    quiet = NameTable(table.loaded, counts=table.counts)
    sides: Sequence[str | list[str] | None] = (getattr(measure, "of", None),)
    if isinstance(measure, measures.Distance):
        sides = measure.between
    elif isinstance(measure, measures.Gap):
        sides = (measure.of, measure.to)
    elif isinstance(measure, measures.Threaded | measures.Submerged):
        sides = (measure.of, measure.by)
    elif isinstance(measure, measures.SpringForce):
        spring = table.loaded.case.actions.controls.get(measure.spring)
        sides = (spring.body, spring.to) if isinstance(spring, Spring) else ()
    touching = measure.kind in (*CONTACT_KINDS, "threaded")
    return [quiet.find_all(selectors, (), many=True, touching=touching) for selectors in sides]


def check_contacts_recorded(table: NameTable, where: Path) -> None:
    """Report that no contacts are recorded."""
    if not table.loaded.case.scene.record.contacts:
        message = "needs contacts, and `scene.record.contacts` is false"
        table.report(where, message, "contacts-not-recorded", key=True)


def check_carrier(table: NameTable, where: Path, thing: measures.Measure | events.Event) -> None:
    """Report a region with an invalid carrier.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure or event.
        thing: The measure or event.
    """
    carrier = getattr(getattr(thing, "region", None), "moves_with", None)
    member = table.find(carrier, (*where, "region", "moves_with")) if carrier is not None else None
    if member is not None:
        _check_rigid(table, (*where, "region", "moves_with"), member, "can carry a region")


def _check_rigid(table: NameTable, where: Path, member: Member, role: str) -> None:
    if member.count > 1 or member.deforms:
        what = "deforms" if member.deforms else f"selects {member.count} copies"
        table.report(where, f"`{member.text}` {what}: only one rigid body, or one link, {role}", "carrier")


def _check_distance(table: NameTable, where: Path, measure: measures.Distance) -> None:
    members = [
        table.find(selector, (*where, "between", index), many=True) for index, selector in enumerate(measure.between)
    ]
    first, second = members
    if first is not None and second is not None and first.text == second.text and first.count == 1:
        table.report((*where, "between", 1), f"`{first.text}` has no distance from itself", "itself")


def _check_subject(table: NameTable, where: Path, measure: measures.Measure, member: Member) -> bool:
    """Report a body that a measure does not fit; return whether it fits."""
    if check_soft_measure(table, where, measure, member):
        return False
    if isinstance(measure, measures.Bend):
        if _bends(table, member) == 0:
            message = f"`{member.name}` has no joints that bend; for a cloth, measure its `wrinkling`"
            table.report(member.where, message, "measure-kind")
            return False
    elif member.static and measure.kind not in _OF_STATICS and not isinstance(measure, JOINT_KINDS):
        table.report(member.where, f"`{member.name}` is a static, which never moves", "not-dynamic")
        return False
    return True


def _check_joints(table: NameTable, members: list[Member]) -> None:
    first: tuple[Member, str] | None = None
    mixed = False
    for member in members:
        found = [check_joint(table, member.where, each, "measure") for each in table.each(member, joint=True)]
        for kind in dict.fromkeys(joint.kind for joint in found if joint is not None):
            first = first or (member, kind)
            if kind == first[1] or mixed:
                continue
            mixed = True
            what = f"`{member.text}` is a {kind}, and `{first[0].text}` a {first[1]}: their positions"
            if member is first[0]:
                what = f"`{member.text}` selects hinges and sliders, whose positions"
            table.report(member.where, f"{what} have different units", "measure-kind")


def _check_stat(table: NameTable, where: Path, measure: measures.Measure, member: Member) -> None:
    """Report several bodies or joints without a `stat` that makes them one number; `member` is the first."""
    together = (measures.Extent, measures.Stretch, measures.Strain)
    if isinstance(measure, together) or getattr(measure, "stat", "") is not None:
        return
    part, bends = member.part, isinstance(measure, measures.Bend)
    several = f"selects {member.count} {'joints' if isinstance(measure, JOINT_KINDS) else 'links'}"
    number = member.count
    if part is None or "*" not in part:
        several = f"selects {member.count} copies"
    if bends:
        number *= 1 if part is not None else _bends(table, member) or 0
        several = f"means {number} links" if part is not None else f"has {number} joints"
    if len(measure.subjects) > 1:
        number, several = 2, "are several joints" if bends or isinstance(measure, JOINT_KINDS) else "are several bodies"
    if number > 1:
        message = (
            f"{quoted(measure.subjects)} {several}: give a `stat` that combines {'their bends' if bends else 'them'}"
        )
        table.report(where, message, "needs-stat", key=True)


def _bends(table: NameTable, member: Member) -> int | None:
    """Return how many joints of a copy bend; None if its joints are not known."""
    model = member.model
    if isinstance(model, Rigid):
        return int(model.mount.kind in ("hinge", "ball"))
    if not isinstance(model, Articulated | Linked):
        return 0
    joints = joints_of(table, member)
    return sum(isinstance(joint, HingeMount | BallMount) for joint in joints.values()) if joints else None
