"""Checks of the bodies, joints and times of controls."""

from collections.abc import Mapping
from typing import Any

from text2sim.spec_schema.errors import SpecError, nearest, there_are
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.bodies import Articulated, Chain, HingeMount, Rigid, SliderMount
from text2sim.spec_schema.models.controls import (
    Attach,
    Control,
    Drive,
    Force,
    Impulse,
    InitialVelocity,
    Reach,
    Release,
    Spring,
    Torque,
)
from text2sim.spec_schema.models.fields import Airflow
from text2sim.spec_schema.models.motion import end_of, start_of
from text2sim.spec_schema.models.placed import Linked, Placed
from text2sim.spec_schema.models.shapes import Stream
from text2sim.spec_schema.models.soft_bodies import Beam, Rope
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.names.selectors import WORLD, parse_selector
from text2sim.spec_schema.names.soft_control_references import (
    check_airflow,
    check_attach_kind,
    check_push_kind,
    check_release_moment,
)
from text2sim.spec_schema.text.document import Path


def check_controls(table: NameTable) -> None:
    """Check every control."""
    duration = table.loaded.case.scene.duration
    for name, control in table.loaded.case.actions.controls.items():
        where: Path = ("actions", "controls", name)
        if isinstance(control, InitialVelocity):
            _check_initial_velocity(table, where, control)
        elif isinstance(control, Impulse | Force | Torque):
            _check_push(table, where, control)
        elif isinstance(control, Airflow):
            check_airflow(table, where, control)
        elif isinstance(control, Drive):
            _check_drive(table, where, control)
        elif isinstance(control, Reach):
            _check_reach(table, where, control)
        elif isinstance(control, Attach):
            _check_attach(table, where, name, control)
        elif isinstance(control, Spring):
            _check_spring(table, where, name, control)
        elif isinstance(control, Release):
            _check_release(table, where, control)
        during = getattr(control, "during", None)
        starts = {"at": getattr(control, "at", 0.0) or 0.0, "during": during[0] if during else 0.0}
        ends = {}
        if isinstance(control, Drive):
            schedules = {mode: getattr(control, mode) for mode in ("position", "velocity", "force")}
            given = {mode: schedule for mode, schedule in schedules.items() if schedule is not None}
            starts |= {mode: start_of(schedule) for mode, schedule in given.items()}
            ends = {mode: end_of(schedule) for mode, schedule in given.items()}
        for field, start in starts.items():
            end = ends.get(field, 0.0)
            if start >= duration:
                message = f"is after the end of the run ({duration:g} s)"
            elif end > duration:
                message = f"gets to its last value at {end:g} s, after the end of the run ({duration:g} s)"
            else:
                continue
            table.report((*where, field), message, "after-end", severity="warning")
        if during is not None and during[0] == span_of(during, duration)[1]:
            impulse = "; for an instant, use `kind: impulse`, in N s" if isinstance(control, Force) else ""
            message = f"a span from {during[0]:g} s to the same time has no time step; let it end later{impulse}"
            table.report((*where, "during"), message, "empty-span")


def check_joint(table: NameTable, where: Path, member: Member, purpose: str) -> Any:
    """Return the hinge or slider that a member names, or report that there is none.

    Args:
        table: The bodies of the case.
        where: Path of the selector.
        member: The selected body or joint.
        purpose: Use of the joint: `drive` or `measure`.

    Returns:
        The joint's model; None if there is none, or if only the compiler knows it.
    """
    model, name = member.model, member.name
    if isinstance(member.model, Linked) and name not in table.parts:
        return None
    joints = joints_of(table, member)
    near = [f"{name}.{key}" for key, joint in joints.items() if isinstance(joint, HingeMount | SliderMount)]
    if member.part is None and (isinstance(model, Articulated) or near):
        listed = f": {', '.join(near)}" if 0 < len(near) <= 12 else ""
        several = "one joint; name it" if len(near) == 1 else "several joints; name one"
        table.report(where, f"`{name}` has {several}{listed}", "no-joint", near[0] if near else None)
        return None
    if isinstance(model, Articulated) and model.links is None and name not in table.parts:
        return None
    if member.part is not None:
        joint = joints.get(member.part)
    else:
        joint = model.mount if isinstance(model, Rigid) else None
    if isinstance(joint, HingeMount | SliderMount):
        return joint
    if isinstance(model, Rigid):
        mount = f"its mount is {joint.kind}" if joint is not None else "it has no links"
        message = f"`{name}` has no joint to {purpose}: {mount}, not hinge or slider"
    elif joint is not None or isinstance(model, Articulated):
        what = _why_none(model, member.part) if joint is None else f"has a {joint.kind} joint"
        message = f"`{member.text}` {what}; only a hinge or slider has something to {purpose}"
    else:
        kind = "static" if member.static else model.kind
        message = f"`{name}` ({kind}) has no hinge or slider to {purpose}"
    table.report(where, message, "no-joint", nearest(member.text, near))
    return None


def joints_of(table: NameTable, member: Member) -> Mapping[str, Any]:
    """Return the model of each joint of a body of links, by name, as far as they are known."""
    if member.name in table.parts:
        return table.parts[member.name].joints
    links = (member.model.links or {}) if isinstance(member.model, Articulated) else {}
    return {name: link.joint for name, link in links.items() if link.joint is not None}


def _why_none(model: Articulated, part: str | None) -> str:
    link = (model.links or {}).get(part or "")
    return "has no joint" if link is not None and link.parent is not None else "is the root"


def _check_initial_velocity(table: NameTable, where: Path, control: InitialVelocity) -> None:
    member = table.find(control.body, (*where, "body"), parts=False)
    if member is None:
        return
    if isinstance(getattr(member.model, "shape", None), Stream):
        text = f"`{member.name}` is a stream: its shape has the `speed` and `direction` at which it comes out"
        table.report((*where, "body"), text, "not-free")
        return
    if isinstance(member.model, Placed) and member.model.startable:
        return
    who_can = "only a free rigid body, a ragdoll, a loose rope or beam, or a deformable body can start with a velocity"
    message = f"`{member.name}` cannot: {who_can}" if member.dynamic else f"{member.why_not_dynamic}; {who_can}"
    table.report((*where, "body"), message, "not-free")


def _check_push(table: NameTable, where: Path, control: Impulse | Force | Torque) -> None:
    member = table.find(control.body, (*where, "body"))
    if member is not None:
        check_push_kind(table, where, control, member)
    if member is not None and not member.dynamic:
        article = "an" if control.kind[0] in "ai" else "a"
        message = f"{member.why_not_dynamic}: {article} {control.kind} has no effect"
        table.report((*where, "body"), message, "not-dynamic")


def _check_drive(table: NameTable, where: Path, control: Drive) -> None:
    table.check_known((*where, "on"), "event", control.on, table.loaded.case.actions.events)
    member = table.find(control.joint, (*where, "joint"), joint=True, many=True)
    for single in table.each(member, joint=True) if member is not None else ():
        before = len(table.problems)
        _check_motor(table, where, control, single)
        if len(table.problems) > before:  # one problem for a group is enough
            return


def _check_motor(table: NameTable, where: Path, control: Drive, member: Member) -> None:
    joint = check_joint(table, (*where, "joint"), member, "drive")
    if joint is None:
        return
    if joint.actuator is None:
        place = f"in `joints` of `{member.name}`" if getattr(member.model, "file", None) else "at its joint"
        gains = "max_force: …" if control.force is not None else "stiffness: …, damping: …"
        message = f"`{member.text}` has no actuator; give it one {place}: `actuator: {{{gains}}}`"
        if isinstance(member.model, Linked):
            message = f"`{member.text}` has no actuator: the joints of `{member.name}` are passive"
        table.report((*where, "joint"), message, "no-actuator")
    elif control.position is not None and joint.actuator.stiffness == 0:
        message = f"a position needs a stiffness, and the actuator of `{member.text}` has none"
        table.report((*where, "position"), message, "no-gain", key=True)
    elif control.velocity is not None and joint.actuator.damping == 0:
        message = f"a velocity needs a damping, and the actuator of `{member.text}` has none"
        table.report((*where, "velocity"), message, "no-gain", key=True)


def _check_reach(table: NameTable, where: Path, control: Reach) -> None:
    member = table.find(control.body, (*where, "body"))
    if member is None:
        return
    if not isinstance(member.model, Articulated) or member.part is None:
        what = "it has several links: name one" if isinstance(member.model, Articulated) else "it has no links"
        message = f"reach needs a link of an articulated body, and `{member.text}` is none; {what}"
        table.report((*where, "body"), message, "no-link")
    elif member.model.base == "free":
        message = f"`{member.name}` has a free base, so its joints do not determine the positions of its links"
        table.report((*where, "body"), message, "no-link")


def _check_attach(table: NameTable, where: Path, name: str, control: Attach) -> None:
    body = table.find(control.body, (*where, "body"))
    if body is not None and not body.dynamic:
        message = f"{body.why_not_dynamic}; `body` is the moving one, `to` its holder"
        table.report((*where, "body"), message, "not-dynamic")
    found = len(table.problems)
    for text in _targets(table, name, control):
        target = None if _is_world(table, text) else table.find(text, (*where, "to"))
        if body is None or _lacks_a_link(table, where, body, target) or len(table.problems) > found:
            return
        if check_attach_kind(table, where, control, body, target) and target is not None:
            _check_pair(table, where, control, body, target)


def _check_spring(table: NameTable, where: Path, name: str, control: Spring) -> None:
    if _is_world(table, control.to):
        message = "a spring needs something at both ends: a static, such as a hook or a beam, in place of the world"
        table.report((*where, "to"), message, "no-world")
        return
    body, target = table.find(control.body, (*where, "body")), _find_holder(table, where, name, control)
    if body is None or target is None or _lacks_a_link(table, where, body, target):
        return
    for field, member in (("body", body), ("to", target)):
        if member.deforms:
            message = f"`{member.name}` deforms, and a spring needs a rigid body or a link at both ends"
            table.report((*where, field), message, "soft-spring")
            return
    if not (body.dynamic or target.dynamic):
        message = f"neither end of the spring can be moved by it: {body.why_not_dynamic}, and {target.why_not_dynamic}"
        table.report((*where, "body"), message, "not-dynamic")
    _check_pair(table, where, control, body, target)


def _find_holder(table: NameTable, where: Path, name: str, control: Attach | Spring) -> Member | None:
    target = None
    for text in _targets(table, name, control):
        target = table.find(text, (*where, "to"))
        if target is None:
            break
    return target


def _lacks_a_link(table: NameTable, where: Path, body: Member, target: Member | None) -> bool:
    """Return whether a rope, chain or beam is named without a link, which is reported."""
    for field, member in (("body", body), ("to", target)):
        if member is not None and member.part is None and isinstance(member.model, Rope | Chain | Beam):
            links = table.parts[member.name].links if member.name in table.parts else ()
            last = f" to `{member.text}.{links[-1]}`" if links else ""
            message = f"name a link of `{member.text}`, from `{member.text}.link_0` at its first end{last}"
            table.report((*where, field), message, "no-link")
            return True
    return False


def _check_pair(table: NameTable, where: Path, control: Attach | Spring, body: Member, target: Member) -> None:
    if body.text == target.text and (body.count == 1 or body.part == target.part):
        table.report((*where, "to"), f"`{body.text}` cannot be attached to itself", "itself")
    elif 1 not in (body.count, target.count) and body.count != target.count:
        counts = f"`{body.text}` selects {body.count}, `{target.text}` {target.count}"
        table.report((*where, "to"), f"copies pair one to one, but {counts}", "pairs")


def _targets(table: NameTable, name: str, control: Attach | Spring) -> list[str]:
    """Return the holders of all copies of a body, each once."""
    selection = parse_selector(control.body)
    model = table.bodies.get(selection.body)
    if not table.loaded.varies(("actions", "controls", name, "to")) or model is None:
        return [control.to]
    count = table.copies(selection.body, model)
    found: dict[str, None] = {}
    for i in range(count)[selection.first : selection.last]:
        try:
            variables = {"i": i, "n": count, "u": i / (count - 1) if count > 1 else 0.0}
            copy: Control = table.loaded.control_copy(name, variables)
        except SpecError as error:
            table.problems += error.problems
            break
        if isinstance(copy, Attach | Spring):
            found[copy.to] = None
    return [*found] or [control.to]


def _is_world(table: NameTable, name: str) -> bool:
    """Return whether the name of a holder stands for the world."""
    return name == WORLD and WORLD not in table.bodies and WORLD not in table.statics


def _check_release(table: NameTable, where: Path, control: Release) -> None:
    controls = table.loaded.case.actions.controls
    attach = controls.get(control.attach)
    if not isinstance(attach, Attach):
        known = [name for name, other in controls.items() if isinstance(other, Attach)]
        message = f"there is no attach `{control.attach}`{there_are(known)}"
        if attach is not None:
            message = f"`{control.attach}` is not an attach (it is a {attach.kind})"
        table.report((*where, "attach"), message, "unknown-attach", nearest(control.attach, known))
    else:
        check_release_moment(table, where, control, attach)
