"""Checks that controls fit what they act on: bodies of links, or bodies that deform."""

from text2sim.spec_schema.errors import nearest
from text2sim.spec_schema.models.controls import Attach, Force, Impulse, Release, Torque
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.text.document import Path

WORLD = "world"
HELD = ("soft", "cloth")
"""Kinds of which points can be held; grains and drops would slip away."""


def deforms(member: Member) -> bool:
    """Whether a body is points, not links."""
    return isinstance(member.model, Deformable)


def check_push_kind(table: NameTable, where: Path, control: Impulse | Force | Torque, member: Member) -> None:
    """Report what a force, torque or blow says that its body does not have.

    Args:
        table: The table; problems are added to it.
        where: Path of the control.
        control: The control.
        member: What it acts on.
    """
    if not deforms(member):
        for key in ("region", "drag"):
            if getattr(control, key, None):
                message = f"{key} is for bodies that deform, and `{member.name}` does not"
                hint = "point" if key == "region" else None
                table.report((*where, key), message, "not-soft", hint, key=True)
        return
    if isinstance(control, Torque):
        message = f"`{member.name}` deforms, and has no axis to turn about; push regions of it with forces"
        table.report((*where, "kind"), message, "soft-torque")
    elif isinstance(control, Impulse):
        if control.point is not None and not isinstance(control.point, BodyRegion):
            message = f"`{member.name}` deforms: say which region of it is struck, such as a sphere"
            table.report((*where, "point"), message, "soft-point", key=True)
    else:
        if control.point is not None:
            message = f"`{member.name}` deforms: a region of it is pushed, not a point"
            table.report((*where, "point"), message, "soft-point", "region", key=True)
        if control.frame == "body":
            message = f"`{member.name}` deforms, and has no frame that turns with it; give the force in the world"
            table.report((*where, "frame"), message, "soft-frame", key=True)


def check_attach_kind(table: NameTable, where: Path, control: Attach, body: Member, target: Member | None) -> bool:
    """Report what an attachment says that its bodies cannot do; return whether there is anything to pair.

    Args:
        table: The bodies of the case.
        where: The control.
        control: What it says.
        body: What is attached.
        target: What it is attached to; None for the world.
    """
    if not deforms(body):
        for key in ("region", "points", "stiffness") if body.dynamic else ():
            if getattr(control, key) is not None:
                message = f"{key} is for bodies that deform, and `{body.name}` does not: it is welded as a whole"
                table.report((*where, key), message, "not-soft", key=True)
        if target is not None and deforms(target):
            message = f"only a body of links can hold; attach `{target.text}` to `{body.text}` instead"
            table.report((*where, "to"), message, "soft-holder")
            return False
        if target is None and not table.statics:
            message = "a weld to the world needs a static that stands for it, and the scene has none"
            table.report((*where, "to"), message, "no-world")
        return target is not None
    if body.model.kind not in HELD:
        message = f"`{body.name}` ({body.model.kind}) cannot be held: only soft bodies and cloth keep together"
        table.report((*where, "body"), message, "not-held")
        return False
    if target is None:
        return False
    if deforms(target):
        message = (
            f"`{target.name}` deforms, too, and the engine cannot tie points to points; attach both to a body of "
            "links, such as a light rigid one"
        )
        table.report((*where, "to"), message, "soft-holder")
        return False
    if control.points is not None and body.count == 1 and control.points < target.count:
        message = f"{control.points} points are too few for the {target.count} bodies in `{target.text}`: one for each"
        table.report((*where, "points"), message, "points")
    return not (body.count == 1 and target.count > 1)  # one body is shared by all that hold it


def check_release_moment(table: NameTable, where: Path, control: Release, attach: Attach) -> None:
    """Report a release that comes too early, or on nothing.

    Args:
        table: The table; problems are added to it.
        where: Path of the release.
        control: The release.
        attach: What it releases.
    """
    events = table.loaded.case.actions.events
    if control.on is not None and control.on not in events:
        message = f"there is no event `{control.on}`"
        table.report((*where, "on"), message, "unknown-event", nearest(control.on, events))
    elif control.at is not None and control.at <= attach.at:
        message = f"is released before it is attached ({attach.at:g} s)"
        table.report((*where, "at"), message, "order")
