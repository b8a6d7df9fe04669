"""Work of controls and motors: the integrals of force times velocity and torque times angular velocity."""

import numpy as np

from text2sim.compiler.schedules import value_at
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget, SelectionError
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.models.controls import Force, Torque


def work_of_motors(recording: RecordedCase) -> tuple[Array, dict[str, float]]:
    """Return the power [W] of all motors of loose bodies, shape (F,), and the work [J] of each by joint label."""
    states = recording.states
    loose = {target.copy for target in recording.names.loose}
    power, works = np.zeros(states.frames), {}
    for joint in states.joints:
        if joint.kind not in ("hinge", "slider") or joint.body not in loose:
            continue
        power_of_joint = states.dofs_force[:, joint.dof[0]].astype(float) * states.dofs_velocity[:, joint.dof[0]]
        power_of_joint[recording.gone(joint.body)] = 0.0
        power = power + power_of_joint
        several = sum(other.body == joint.body for other in states.joints) > 1
        works[f"{joint.body}.{joint.name}" if several else joint.body] = _integral(power_of_joint, states.time)
    return power, works


def work_of_pushes(recording: RecordedCase) -> dict[str, float]:
    """Return the work [J] of each force and torque on loose bodies, by control; unknown ones are omitted.

    Integrated by the trapezoidal rule between frames. The work of a force on a region of a deformable body, or with
    drag, is unknown, because only the mean velocity of the whole body is recorded.
    """
    found = {}
    for name, control in recording.case.actions.controls.items():
        if isinstance(control, Force | Torque) and (work := _work_of_control(recording, control)) is not None:
            found[name] = work
    return found


def _work_of_control(recording: RecordedCase, control: Force | Torque) -> float | None:
    try:
        targets = recording.names.select(control.body)
    except SelectionError:
        return None
    if isinstance(control, Force) and (control.region is not None or control.drag):
        return None
    if isinstance(control, Force) and control.point is not None and not isinstance(control.point, tuple):
        return None
    return sum(_work_on(recording, control, target) for target in targets)


def _work_on(recording: RecordedCase, control: Force | Torque, target: RecordedTarget) -> float:
    states = recording.states
    start, end = control.during or (0.0, states.end)
    end = min(states.end if isinstance(end, str) else end, states.end, states.removed.get(target.copy, states.end))
    if not states.frames or start >= end:
        return 0.0
    inside = states.time[(states.time > start) & (states.time < end)]
    time = np.concatenate([[start], inside, [end]])
    vector = np.array(control.force if isinstance(control, Force) else control.torque, dtype=float)
    vectors = np.broadcast_to(vector, (states.frames, 3))
    if target.soft is not None:
        velocities = recording.velocity(target)
    else:
        quat = states.quat[:, target.root].astype(float)
        velocities = states.ang[:, target.root].astype(float)
        if control.frame == "body":
            vectors = rotate(quat, vector)
        if isinstance(control, Force):
            velocities, angular_velocity = states.vel[:, target.root].astype(float), velocities
            if control.point is not None:  # the point moves with the body, about the centre of mass
                arm = np.array(control.point, dtype=float) - np.array(states.links[target.root].com)
                velocities = velocities + np.cross(angular_velocity, rotate(quat, arm))
    power = np.interp(time, states.time, (vectors * velocities).sum(axis=1))
    return _integral(power * np.array([value_at(control.scale, float(t)) for t in time]), time)


def _integral(values: Array, time: Array) -> float:
    return float(np.trapezoid(values, time)) if len(time) > 1 else 0.0
