"""Checks of controls against the kind of body: rigid or deformable."""

from text2sim.spec_schema.models.controls import Attach, Force, Impulse, Release, Torque
from text2sim.spec_schema.models.fields import Airflow
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.soft_bodies import Cloth
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.text.document import Path

HELD = ("soft", "cloth")
"""Kinds whose points can be held."""


def check_push_kind(table: NameTable, where: Path, control: Impulse | Force | Torque, member: Member) -> None:
    """Report fields of a force, torque or impulse that its body does not support.

    Args:
        table: The table; problems are added to it.
        where: Path of the control.
        control: The control.
        member: Its body.
    """
    if not member.deforms:
        for key in ("region", "drag"):
            if getattr(control, key, None):
                message = f"{key} is for deformable bodies, and `{member.name}` is rigid"
                hint = "point" if key == "region" else None
                table.report((*where, key), message, "not-soft", hint, key=True)
        return
    if isinstance(control, Torque):
        message = f"`{member.name}` deforms, so no torque can act on it; use forces on its regions"
        table.report((*where, "kind"), message, "soft-torque")
    elif isinstance(control, Impulse):
        if control.point is not None and not isinstance(control.point, BodyRegion):
            message = f"`{member.name}` deforms: give a region of it, such as a sphere"
            table.report((*where, "point"), message, "soft-point", key=True)
    else:
        if control.point is not None:
            message = f"`{member.name}` deforms: give a region of it, not a point"
            table.report((*where, "point"), message, "soft-point", "region", key=True)
        if control.frame == "body":
            message = f"`{member.name}` deforms, so it has no body frame; give the force in the world"
            table.report((*where, "frame"), message, "soft-frame", key=True)


def check_airflow(table: NameTable, where: Path, control: Airflow) -> None:
    """Report an airflow on what is not a cloth of solver pbd.

    Args:
        table: The table; problems are added to it.
        where: Path of the control.
        control: The control.
    """
    contact = table.loaded.case.scene.contact
    for member in table.find_all(control.body, (*where, "body")):
        if not isinstance(member.model, Cloth):
            message = f"`{member.name}` is not a cloth: an airflow acts only on cloth; use `force` or `wind`"
            table.report(member.where, message, "no-cloth")
        elif member.model.solver == "ipc" or contact.model == "ipc":
            message = f"an airflow acts on cloth of solver pbd, and `{member.name}` is simulated by ipc"
            table.report(member.where, message, "no-cloth")


def check_attach_kind(table: NameTable, where: Path, control: Attach, body: Member, target: Member | None) -> bool:
    """Report fields of an attachment that its bodies do not support; return whether there are copies to pair.

    Args:
        table: The bodies of the case.
        where: Path of the control.
        control: The control.
        body: The attached body.
        target: Its holder; None for the world.
    """
    if not body.deforms:
        for key in ("region", "points", "stiffness", "to_region") if body.dynamic else ():
            if getattr(control, key) is not None:
                message = f"{key} is for deformable bodies, and `{body.name}` is rigid: it is welded as a whole"
                table.report((*where, key), message, "not-soft", key=True)
        if target is not None and target.deforms:
            message = f"a deformable body cannot be the holder; attach `{target.text}` to `{body.text}` instead"
            table.report((*where, "to"), message, "soft-holder")
            return False
        if target is None and control.pivot is not None:
            message = "a pivot needs something to hold it, not the world: attach to a static, such as a hook or a beam"
            table.report((*where, "pivot"), message, "no-pivot", key=True)
        elif target is None and not table.statics:
            message = "a weld to the world needs a static, and the scene has none"
            table.report((*where, "to"), message, "no-world")
        return target is not None
    cloth = body.model.kind == "cloth"
    if control.strength is not None and not (cloth and target is not None):
        why = "name a static instead of the world" if cloth else f"end that of `{body.name}` by a `release`"
        message = f"strength is for rigid bodies, and for cloth that is sewn or held by bodies; {why}"
        table.report((*where, "strength"), message, "no-strength", key=True)
    sewn = cloth and target is not None and getattr(target.model, "kind", None) == "cloth"
    if control.to_region is not None and not sewn and not (target is not None and target.deforms):
        message = "to_region is for cloth that is sewn to cloth; what is rigid holds points wherever they are"
        table.report((*where, "to_region"), message, "not-soft", key=True)
    if control.pivot is not None:
        message = f"pivot is for rigid bodies, and `{body.name}` deforms: it turns freely about a small `region`"
        table.report((*where, "pivot"), message, "no-pivot", key=True)
    if body.model.kind not in HELD:
        message = f"`{body.name}` ({body.model.kind}) cannot be attached: only soft bodies and cloth can"
        table.report((*where, "body"), message, "not-held")
        return False
    if target is None:
        return False
    if sewn:
        return _can_be_sewn(table, where, control, body, target)
    if target.deforms:
        message = f"`{target.name}` also deforms, and only cloth is sewn to cloth; attach both to a rigid body"
        table.report((*where, "to"), message, "soft-holder")
        return False
    if control.points is not None and body.count == 1 and control.points < target.count:
        message = f"{control.points} points are too few: each of the {target.count} bodies in `{target.text}` needs one"
        table.report((*where, "points"), message, "points")
    return not (body.count == 1 and target.count > 1)  # several holders share one body


def _can_be_sewn(table: NameTable, where: Path, control: Attach, body: Member, target: Member) -> bool:
    """Report what a seam lacks, or cannot join; return whether there are copies to pair."""
    if body.count == 1 and target.count > 1:
        message = f"`{target.text}` has {target.count} copies; name the one to sew `{body.text}` to"
        table.report((*where, "to"), message, "pairs")
        return False
    if body.name != target.name:
        return True
    lacking = [key for key in ("region", "to_region") if getattr(control, key) is None]
    if lacking or control.region == control.to_region:
        message = f"`{body.text}` is sewn to itself: name the two parts, `region` and `to_region`"
        table.report((*where, "to"), message, "itself")
    return False


def check_release_moment(table: NameTable, where: Path, control: Release, attach: Attach) -> None:
    """Report a release that comes too early, or at an unknown event.

    Args:
        table: The table; problems are added to it.
        where: Path of the release.
        control: The release.
        attach: The control that it releases.
    """
    known = table.check_known((*where, "on"), "event", control.on, table.loaded.case.actions.events)
    if known and control.at is not None and control.at <= attach.at:
        message = f"is released before it is attached ({attach.at:g} s)"
        table.report((*where, "at"), message, "order")
