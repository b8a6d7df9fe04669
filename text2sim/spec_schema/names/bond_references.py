"""Checks of bonds, and of attachments that break: what they can join, and in which scenes."""

from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.bodies import Driven, Rigid
from text2sim.spec_schema.models.controls import Attach, Bond, Release
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.removal_references import fixed_because
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path


def check_bonds(table: NameTable) -> None:
    """Check every control that bonds bodies, or attaches them until it breaks."""
    scene = table.loaded.case.scene
    for name, control in table.loaded.case.actions.controls.items():
        where: Path = ("actions", "controls", name)
        if isinstance(control, Attach) and control.strength is not None:
            _check_strength(table, where, control)
        if not isinstance(control, Bond):
            continue
        members = table.find_all(control.of, (*where, "of"))
        for member in members:
            if not (member.static or isinstance(member.model, Rigid | Driven)) or member.part is not None:
                message = f"`{member.text}` cannot be bonded; only whole rigid and driven bodies, and statics"
                table.report(member.where, message, "not-bondable")
        if members and not any(member.dynamic for member in members):
            table.report((*where, "of"), "none of these bodies moves, so that a bond holds nothing", "not-bondable")
        elif len(members) == len(listed(control.of)) and sum(member.count for member in members) < 2:
            message = f"`{members[0].text}` is a single body; name its copies, or a list of bodies that touch"
            table.report((*where, "of"), message, "not-bondable")
        if why := fixed_because(scene, "what is bonded could not break while it sleeps", "has no bonds"):
            table.report((*where, "kind"), f"nothing can be bonded in this scene: {why}", "not-bondable")


def _check_strength(table: NameTable, where: Path, control: Attach) -> None:
    """Report what an attachment that breaks cannot be or do."""
    case = table.loaded.case
    if isinstance(case.bodies.get(body_of(control.body)), Deformable):
        return  # such ones may begin late, and be released
    releases = (one for one in case.actions.controls.values() if isinstance(one, Release))
    fixed = fixed_because(case.scene, "what is attached could not break while it sleeps", "has none that break")
    reasons = {
        "it turns about a `pivot`": control.pivot is not None,
        "it begins during the run (`at`)": control.at > 0,
        "a `release` ends it": any(one.attach == where[-1] for one in releases),
        fixed or "": fixed is not None,
    }
    for reason in (reason for reason, applies in reasons.items() if applies):
        message = f"this attachment cannot break at a force: {reason}; leave out `strength`, or that"
        table.report((*where, "strength"), message, "no-strength", key=True)
