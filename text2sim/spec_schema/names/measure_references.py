"""Whether what measures look at is there, and has what is measured."""

from text2sim.spec_schema.models import measures
from text2sim.spec_schema.names.cast import Cast, Member
from text2sim.spec_schema.names.control_references import check_joint
from text2sim.spec_schema.text.document import Path

JOINT_KINDS = (measures.JointPosition, measures.JointVelocity, measures.JointForce)
CONTACT_KINDS = ("contact_force", "contact_count", "penetration")
_OF_STATICS = (*CONTACT_KINDS, "position", "extent")
"""Measures of something that never moves which still say something."""


def check_measures(cast: Cast) -> None:
    """Check every measure."""
    for name, measure in cast.loaded.case.actions.measures.items():
        where: Path = ("actions", "measures", name)
        if isinstance(measure, measures.Distance):
            _check_distance(cast, where, measure)
            continue
        if measure.kind in CONTACT_KINDS:
            check_contacts_recorded(cast, where)
            if getattr(measure, "by", None) is not None:
                cast.find(measure.by, (*where, "by"))  # type: ignore[union-attr]
        if measure.of is None:
            continue
        joint = isinstance(measure, JOINT_KINDS)
        member = cast.find(measure.of, (*where, "of"), joint=joint)
        if member is not None:
            _check_subject(cast, where, measure, member)


def measured(cast: Cast, measure: measures.Measure) -> list[Member]:
    """The bodies that a measure is about, without selectors that mean nothing: those are reported already."""
    quiet = Cast(cast.loaded)
    selectors = measure.between if isinstance(measure, measures.Distance) else (measure.of,)
    found = [quiet.find(selector, ()) for selector in selectors if selector is not None]
    return [member for member in found if member is not None]


def check_contacts_recorded(cast: Cast, where: Path) -> None:
    """Report that there will be no contacts to look at."""
    if not cast.loaded.case.scene.record.contacts:
        message = "needs contacts, and `scene.record.contacts` is false"
        cast.report(where, message, "contacts-not-recorded", key=True)


def _check_distance(cast: Cast, where: Path, measure: measures.Distance) -> None:
    members = [cast.find(selector, (*where, "between", index)) for index, selector in enumerate(measure.between)]
    first, second = members
    if first is not None and second is not None and first.text == second.text and first.count == 1:
        cast.report((*where, "between", 1), f"`{first.text}` has no distance from itself", "itself")


def _check_subject(cast: Cast, where: Path, measure: measures.Measure, member: Member) -> None:
    if isinstance(measure, JOINT_KINDS):
        check_joint(cast, (*where, "of"), member, "measure")
    elif member.static and measure.kind not in _OF_STATICS:
        cast.report((*where, "of"), f"`{member.name}` is a static, which never moves", "not-dynamic")
        return
    per_copy = "stat" in type(measure).model_fields and not isinstance(measure, measures.Extent)
    if per_copy and measure.stat is None and member.count > 1:  # type: ignore[union-attr]
        message = f"`{member.text}` means {member.count} copies: `stat` says how they become one number"
        cast.report(where, message, "needs-stat", key=True)
