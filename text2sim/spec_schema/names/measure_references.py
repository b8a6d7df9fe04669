"""Checks of the bodies, joints and regions of measures."""

from text2sim.spec_schema.models import events, measures
from text2sim.spec_schema.models.bodies import Articulated, BallMount, HingeMount, Rigid
from text2sim.spec_schema.models.placed import Linked
from text2sim.spec_schema.names.control_references import check_joint, joints_of
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.names.soft_measure_references import check_gap, check_other_side, check_soft_measure
from text2sim.spec_schema.text.document import Path

JOINT_KINDS = (measures.JointPosition, measures.JointVelocity, measures.JointForce)
CONTACT_KINDS = ("contact_force", "contact_count", "penetration")
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
        if measure.kind in CONTACT_KINDS:
            by = getattr(measure, "by", None)
            other = table.find(by, (*where, "by"), many=True) if by is not None else None
            if other is not None:
                check_other_side(table, where, measure, other)
            sides = [*measured(table, measure), other]
            # The penetration of deformable bodies comes from the positions of their points.
            if measure.kind != "penetration" or not any(side is not None and side.deforms for side in sides):
                check_contacts_recorded(table, where)
        check_carrier(table, where, measure)
        if isinstance(measure, measures.Extent | measures.Displacement) and measure.frame is not None:
            frame = table.find(measure.frame, (*where, "frame"))
            if frame is not None:
                _check_rigid(table, (*where, "frame"), frame, "can be the frame")
        if measure.of is None:
            continue
        joint = isinstance(measure, JOINT_KINDS)
        member = table.find(measure.of, (*where, "of"), joint=joint, many=True)
        if member is not None:
            _check_subject(table, where, measure, member)


def measured(table: NameTable, measure: measures.Measure) -> list[Member]:
    """Return the bodies of a measure, without those of invalid selectors, which are already reported."""
    quiet = NameTable(table.loaded, counts=table.counts)
    if isinstance(measure, measures.Distance):
        selectors = measure.between
    elif isinstance(measure, measures.Gap):
        selectors = (measure.of, measure.to)
    else:
        selectors = (measure.of,)
    found = [quiet.find(selector, (), many=True) for selector in selectors if selector is not None]
    return [member for member in found if member is not None]


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


def _check_subject(table: NameTable, where: Path, measure: measures.Measure, member: Member) -> None:
    if check_soft_measure(table, where, measure, member):
        return
    if isinstance(measure, measures.Bend):
        _check_bend(table, where, measure, member)
        return
    if isinstance(measure, JOINT_KINDS):
        found = [check_joint(table, (*where, "of"), each, "measure") for each in table.each(member, joint=True)]
        if len({joint.kind for joint in found if joint is not None}) > 1:
            message = f"`{member.text}` selects hinges and sliders, whose positions have different units"
            table.report((*where, "of"), message, "measure-kind")
    elif member.static and measure.kind not in _OF_STATICS:
        table.report((*where, "of"), f"`{member.name}` is a static, which never moves", "not-dynamic")
        return
    together = (measures.Extent, measures.Stretch, measures.Strain)
    per_copy = "stat" in type(measure).model_fields and not isinstance(measure, together)
    if per_copy and measure.stat is None and member.count > 1:  # type: ignore[union-attr]
        what = "copies" if member.part is None or "*" not in member.part else "links"
        what = "joints" if what == "links" and isinstance(measure, JOINT_KINDS) else what
        message = f"`{member.text}` selects {member.count} {what}: give a `stat` that combines them"
        table.report(where, message, "needs-stat", key=True)


def _check_bend(table: NameTable, where: Path, measure: measures.Bend, member: Member) -> None:
    model = member.model
    mounted = isinstance(model, Rigid) and model.mount.kind in ("hinge", "ball")
    joints = joints_of(table, member)
    bending = mounted or sum(isinstance(joint, HingeMount | BallMount) for joint in joints.values())
    if not (mounted or isinstance(model, Articulated | Linked)) or (joints and not bending):
        message = f"`{member.name}` has no joints that bend; for a cloth, measure its `wrinkling`"
        table.report((*where, "of"), message, "measure-kind")
    elif measure.stat is None:
        several = f"means {member.count} links" if member.part is not None else f"has {member.count * bending} joints"
        if member.count * (1 if member.part is not None else bending) > 1:
            message = f"`{member.text}` {several}: give a `stat` that combines their bends"
            table.report(where, message, "needs-stat", key=True)
