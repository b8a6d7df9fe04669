"""Measures: numbers over time, computed from recorded frames. Each function states its formula.

A body counts as a whole: if it has several links, its origin, orientation and rotation are those of its root link,
and its velocity is that of the common centre of mass.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from text2sim.evidence import contact_measures, soft_measures, threading
from text2sim.evidence.deformation import DeformationError
from text2sim.evidence.recorded_case import RecordedCase, links_of, soft_of
from text2sim.evidence.selection import RecordedTarget, SelectionError
from text2sim.evidence.spring_forces import spring_force
from text2sim.recording.geometry import axis_in, reach_along
from text2sim.recording.states import Array, JointRecord
from text2sim.recording.vectors import rotate, rotate_back
from text2sim.spec_schema.models import measures
from text2sim.spec_schema.models.base import AXES
from text2sim.spec_schema.names.derived_measure_references import JOINT_UNITS, Pair, ratio_unit

_COLUMN = {"x": 0, "y": 1, "z": 2}


MeasureError = soft_measures.SoftMeasureError
"""A measure that has no value in this recording."""


@dataclass(frozen=True)
class Series:
    """A measure over time."""

    name: str
    unit: str
    """SI, or deg; empty for a count."""
    values: Array
    """One for each frame, shape (F,); NaN without a value."""
    problem: str = ""
    """Why it could not be computed; all values are NaN then."""


def evaluate(recording: RecordedCase) -> dict[str, Series]:
    """Evaluate every measure of the case, in its order."""
    found: dict[str, Series] = {}
    all_measures = recording.case.actions.measures
    needs = {name: getattr(measure, "measures", ()) for name, measure in all_measures.items()}
    for name in TopologicalSorter(needs).static_order():
        if (measure := all_measures.get(name)) is None:
            continue
        try:
            with np.errstate(all="ignore"):  # a diverged run holds numbers that overflow
                values, unit = _of_two(measure, found) if isinstance(measure, Pair) else _value(recording, measure)
                values = _changed(recording.states.time, np.asarray(values, dtype=float), measure.change_from)
                values = _so_far(values, measure.so_far)
            found[name] = Series(name, unit, values)
        except (SelectionError, MeasureError, DeformationError) as error:
            found[name] = Series(name, measure.unit, np.full(recording.states.frames, np.nan), str(error))
    return {name: found[name] for name in all_measures}


def _of_two(measure: Pair, found: dict[str, Series]) -> tuple[Array, str]:
    """Difference a - b, or ratio a / b, which has no value where b is 0 and the unit of a over that of b."""
    for name in measure.measures:
        if name not in found or found[name].problem:
            raise MeasureError(f"`{name}`: {found[name].problem if name in found else 'there is no such measure'}")
    a, b = (found[name] for name in measure.measures)
    if isinstance(measure, measures.Difference):
        if a.unit != b.unit:
            raise MeasureError(f"`{a.name}` is in {a.unit or '1'} and `{b.name}` in {b.unit or '1'}: no difference")
        return a.values - b.values, a.unit
    return np.where(b.values == 0, np.nan, a.values / b.values), ratio_unit(a.unit, b.unit)


def _changed(time: Array, values: Array, since: str | float | None) -> Array:
    """x(t) - x(t0), linearly interpolated between frames."""
    if since is None or not len(time):
        return values
    if isinstance(since, str):
        return values - values[0]
    if since > time[-1] + 1e-9:
        raise MeasureError(f"its change is counted from {since:g} s, and the run ended at {time[-1]:.4g} s")
    return values - np.interp(since, time, values)


def _so_far(values: Array, stat: str | None) -> Array:
    """Largest or smallest value up to each frame, or their difference; frames without a value are skipped."""
    if stat is None:
        return values
    highest, lowest = np.fmax.accumulate(values), np.fmin.accumulate(values)
    return {"max": highest, "min": lowest, "range": highest - lowest}[stat]


def _value(recording: RecordedCase, measure: measures.Measure) -> tuple[Array, str]:
    if isinstance(measure, measures.JointPosition | measures.JointVelocity | measures.JointForce):
        joints = recording.names.select_joints(measure.of)
        kinds = {joint.kind for _, joint in joints}
        if len(kinds) != 1 or not kinds <= {"hinge", "slider"}:
            named = ", ".join(measure.subjects)
            raise MeasureError(f"{named}: only hinges and sliders have a position (got {', '.join(sorted(kinds))})")
        unit = JOINT_UNITS[measure.kind][kinds.pop()]
        values = [
            np.where(recording.gone(joint.body), np.nan, _joint(recording, measure.kind, joint)) for _, joint in joints
        ]
        return _reduce(measure, values), "" if measure.stat == "count" else unit
    if isinstance(measure, measures.Bend):
        values = [_bend(recording, joint) for joint in recording.names.select_bends(measure.of)]
        return _reduce(measure, values, "joints"), measure.value_unit
    if measure.kind in _PER_TARGET:
        targets = recording.names.select(measure.of)  # type: ignore[union-attr]
        present = np.stack([~recording.gone(t.copy) for t in targets])
        values = [_PER_TARGET[measure.kind](recording, measure, t) for t in targets]
        values = [np.where(row, value, np.nan) for row, value in zip(present, values, strict=True)]
        return _reduce(measure, values, present=present), measure.value_unit
    return _COLLECTIVE[measure.kind](recording, measure), measure.value_unit


def _reduce(measure: Any, values: list[Array], what: str = "bodies", present: Array | None = None) -> Array:
    """Reduce the series of several copies to one; `present`, shape (n, F), masks copies that have left the scene.

    `std` is sqrt(mean of (x - mean)^2), `range` is max - min, and `count` is the number of copies within the bounds.
    """
    stack = np.stack(values)
    if measure.stat is None:
        if len(values) > 1:
            named = ", ".join(measure.subjects)
            raise MeasureError(f"{named} means {len(values)} {what}: `stat` says how they become one number")
        return stack[0]
    if measure.stat == "count":
        above = stack > (-np.inf if measure.above is None else measure.above)
        below = stack < (np.inf if measure.below is None else measure.below)
        return (above & below).sum(axis=0)
    if present is not None and not present.all():
        masked = np.ma.masked_array(stack, ~present)
        is_range = measure.stat == "range"
        reduced = masked.max(axis=0) - masked.min(axis=0) if is_range else getattr(masked, measure.stat)(axis=0)
        return np.ma.filled(reduced, np.nan)
    if measure.stat == "range":
        return stack.max(axis=0) - stack.min(axis=0)
    return getattr(stack, measure.stat)(axis=0)


# --- of one target, then reduced ---------------------------------------------------


def _path(recording: RecordedCase, measure: Any, target: RecordedTarget) -> Array:
    if measure.region is None:
        return recording.origin(target)
    return soft_measures.region_path(recording, target, measure.region)


def _motion(recording: RecordedCase, measure: Any, target: RecordedTarget) -> Array:
    """Velocity [m/s]; of a region, the central difference of its middle over the frames before and after."""
    if measure.region is None:
        return recording.velocity(target)
    path = soft_measures.region_path(recording, target, measure.region)
    return np.gradient(path, recording.states.time, axis=0) if len(path) > 1 else np.zeros_like(path)


def _needs_frame(target: RecordedTarget, kind: str) -> None:
    if target.soft is not None:
        raise MeasureError(f"{target.label} deforms, so that it has no {kind} of its own; measure regions of it")


def _position(recording: RecordedCase, measure: measures.Position, target: RecordedTarget) -> Array:
    """A coordinate of the origin; for a deformable body, of its centre of mass or the centre of a region."""
    return _path(recording, measure, target)[:, _COLUMN[measure.axis]]


def _velocity(recording: RecordedCase, measure: measures.Velocity, target: RecordedTarget) -> Array:
    """A component of the velocity of the centre of mass, or of the middle of a region."""
    return _motion(recording, measure, target)[:, _COLUMN[measure.axis]]


def _speed(recording: RecordedCase, measure: Any, target: RecordedTarget) -> Array:
    """|v| of the centre of mass, or of the middle of a region."""
    return np.linalg.norm(_motion(recording, measure, target), axis=1)


def _angular_speed(recording: RecordedCase, measure: Any, target: RecordedTarget) -> Array:
    """|w|."""
    _needs_frame(target, "angular_speed")
    return np.linalg.norm(recording.states.ang[:, target.root].astype(float), axis=1)


def _angular_velocity(recording: RecordedCase, measure: Any, target: RecordedTarget) -> Array:
    """Component w . a, with a an axis of the world or one that rotates with the body."""
    _needs_frame(target, measure.kind)
    turning = recording.states.ang[:, target.root].astype(float)
    if measure.frame == "body":
        turning = rotate_back(recording.states.quat[:, target.root].astype(float), turning)
    return turning[:, _COLUMN[measure.axis]]


def _count_turns(recording: RecordedCase, measure: measures.Turns, target: RecordedTarget) -> Array:
    """Sum of the rotations between recorded poses, about the axis, over 2 pi.

    A rotation is known up to whole turns, which the engine's angular velocity decides. Its integral alone would drift:
    what a body is in contact with can change its velocity within every step.
    """
    _needs_frame(target, measure.kind)
    states = recording.states
    quat, rate = (rows[:, target.root].astype(float) for rows in (states.quat, states.ang))
    if len(quat) < 2:
        return np.zeros(len(quat))
    turned = Rotation.from_quat(quat, scalar_first=True)
    if measure.frame == "body":
        rate = rotate_back(quat, rate)
        between = (turned[:-1].inv() * turned[1:]).as_rotvec()
    else:
        between = (turned[1:] * turned[:-1].inv()).as_rotvec()
    angle = np.linalg.norm(between, axis=1, keepdims=True)
    about = between / np.maximum(angle, 1e-12)
    integral = 0.5 * (rate[1:] + rate[:-1]) * np.diff(states.time)[:, None]
    # Without any rotation left over, whole turns are about the axis of the velocity.
    about = np.where(angle > 1e-6, about, integral / np.maximum(np.linalg.norm(integral, axis=1, keepdims=True), 1e-12))
    whole = np.round(((integral * about).sum(axis=1, keepdims=True) - angle) / (2.0 * np.pi))
    steps = (between + 2.0 * np.pi * whole * about)[:, _COLUMN[measure.axis]]
    return np.concatenate([[0.0], np.cumsum(steps)]) / (2.0 * np.pi)


def _displacement(recording: RecordedCase, measure: measures.Displacement, target: RecordedTarget) -> Array:
    """|x(t) - x(0)|, or its component along an axis.

    In the frame of a body with origin o and rotation R, R^T (x - o) takes the place of x.
    """
    origin = _path(recording, measure, target)
    if measure.frame is not None:
        frame = recording.names.select(measure.frame)[0].root
        states = recording.states
        origin = rotate_back(states.quat[:, frame].astype(float), origin - states.pos[:, frame].astype(float))
    moved = origin - origin[:1]
    return np.linalg.norm(moved, axis=1) if measure.axis is None else moved[:, _COLUMN[measure.axis]]


def _tilt(recording: RecordedCase, measure: measures.Tilt, target: RecordedTarget) -> Array:
    """Angle between R(t) a and R(0) a, from its sine and cosine, which is exact for small angles too."""
    _needs_frame(target, "tilt")
    quat = recording.states.quat[:, target.root].astype(float)
    now = rotate(quat, np.array(AXES[measure.axis]))
    start = np.broadcast_to(now[:1], now.shape)
    sine = np.linalg.norm(np.cross(start, now), axis=1)
    return np.degrees(np.arctan2(sine, (start * now).sum(axis=1)))


def _joint(recording: RecordedCase, kind: str, joint: JointRecord) -> Array:
    """Position, velocity or the motor's force of a joint with one degree of freedom."""
    states = recording.states
    if kind == "joint_position":
        return states.qpos[:, joint.q[0]].astype(float)
    rows = states.dofs_velocity if kind == "joint_velocity" else states.dofs_force
    return rows[:, joint.dof[0]].astype(float)


def _bend(recording: RecordedCase, joint: JointRecord) -> Array:
    """Angle [deg] between q(0) and q(t): for hinges |q - q0|, for balls 2 atan2(|v|, |w|) of the quaternion q0* q."""
    q = recording.states.qpos[:, slice(*joint.q)].astype(float)
    if joint.kind == "hinge":
        return np.degrees(np.abs(q - q[:1]).ravel())
    w, v = q[:, :1], q[:, 1:]
    w0, v0 = q[:1, :1], q[:1, 1:]
    turned = np.linalg.norm(w0 * v - w * v0 - np.cross(v0, v), axis=1)
    return np.degrees(2.0 * np.arctan2(turned, np.abs((q * q[:1]).sum(axis=1))))


_PER_TARGET: dict[str, Callable[[RecordedCase, Any, RecordedTarget], Array]] = {
    "position": _position,
    "velocity": _velocity,
    "speed": _speed,
    "angular_speed": _angular_speed,
    "angular_velocity": _angular_velocity,
    "turns": _count_turns,
    "displacement": _displacement,
    "tilt": _tilt,
}

# --- of all targets together -------------------------------------------------------


def _extent(recording: RecordedCase, measure: measures.Extent) -> Array:
    """Highest or lowest coordinate of the corners of all shapes, or the difference.

    Shapes are the recorded meshes: exact for polyhedra; round ones extend as far as the engine's mesh. Deformable
    bodies extend as far as the vertices of their surface, or, without one, their particles; a region as far as its
    points.
    """
    targets = recording.names.select(measure.of)
    frame = None if measure.frame is None else recording.names.select(measure.frame)[0].root
    low, high = _reach_of_links(recording, targets, measure.axis, frame)
    origin, direction = axis_in(recording.states, measure.axis, frame)
    for number in soft_of(targets):
        body = recording.states.deformables[number]
        points = body.seen
        if measure.region is not None:
            points = body.points[:, soft_measures.region_rows(recording, body, measure.region)].astype(float)
        along = ((points - origin[..., None, :]) * direction[..., None, :]).sum(axis=-1)
        low, high = np.fmin(low, along.min(axis=1)), np.fmax(high, along.max(axis=1))
    if len(low) and np.isnan(low[0]):
        raise MeasureError(f"{', '.join(measure.subjects)} has no recorded shape")
    return {"min": low, "max": high, "range": high - low}[measure.stat]


def _reach_of_links(
    recording: RecordedCase, targets: Sequence[RecordedTarget], axis: str, frame: int | None
) -> tuple[Array, Array]:
    """Return the lowest and highest coordinate (F,) of the links of targets while they are in the scene."""
    leaving = [target for target in targets if target.copy in recording.states.removed]
    staying = [target for target in targets if target not in leaving]
    low, high = reach_along(recording.states, recording.geometry, links_of(staying).tolist(), axis, frame)
    for target in leaving:
        ends = reach_along(recording.states, recording.geometry, links_of([target]).tolist(), axis, frame)
        below, above = (np.where(recording.gone(target.copy), np.nan, row) for row in ends)
        low, high = np.fmin(low, below), np.fmax(high, above)
    return low, high


def _distance(recording: RecordedCase, measure: measures.Distance) -> Array:
    """|x_a - x_b| of the nearest pair of origins; a body is not its own neighbour."""
    first, second = (recording.names.select(selector) for selector in measure.between)
    nearest = np.full(recording.states.frames, np.inf)
    others = np.stack([recording.origin(t) for t in second], axis=1)
    for target in first:
        keep = [i for i, other in enumerate(second) if (other.links, other.soft) != (target.links, target.soft)]
        if keep:
            gaps = np.linalg.norm(others[:, keep] - recording.origin(target)[:, None], axis=2)
            nearest = np.fmin(nearest, np.fmin.reduce(gaps, axis=1))
    if np.isinf(nearest).all() and len(nearest):
        raise MeasureError(f"{' and '.join(measure.between)} are one body: there is no distance")
    return np.where(np.isinf(nearest), np.nan, nearest)


def _targets(recording: RecordedCase, of: str | list[str] | None) -> Sequence[RecordedTarget]:
    """Return the selected bodies, or all of them except statics and driven ones."""
    return recording.names.loose if of is None else recording.names.select(of)


def _energy(recording: RecordedCase, measure: measures.Energy) -> Array:
    """Kinetic (1/2 m v.v + 1/2 w.I w), potential (-m g.x, zero at the origin), or their sum.

    For deformable bodies: 1/2 m v.v over their points, and -m g.x. Elastic energy is not included.
    """
    kinetic, potential = recording.energies(_targets(recording, measure.of))
    return {"kinetic": kinetic, "potential": potential, "total": kinetic + potential}[measure.part]


def _momentum(recording: RecordedCase, measure: measures.Momentum) -> Array:
    """Sum of m v along an axis."""
    targets, axis, states = _targets(recording, measure.of), _COLUMN[measure.axis], recording.states
    links = links_of(targets)
    total = (states.vel[:, links, axis] * recording.there(links)) @ recording.masses[links]
    for number in soft_of(targets):
        total = total + states.deformables[number].mass * states.soft_velocity[:, number, axis].astype(float)
    return total


def _angular_momentum(recording: RecordedCase, measure: measures.AngularMomentum) -> Array:
    """A component of `RecordedCase.angular_momentum`."""
    return recording.angular_momentum(_targets(recording, measure.of), measure.about)[:, _COLUMN[measure.axis]]


def _count_in(recording: RecordedCase, measure: measures.CountIn) -> Array:
    """Number of copies whose origin (deformable bodies: centre of mass) lies in the region or on its surface."""
    inside = [recording.depth_in(measure.region, recording.origin(t)) >= 0 for t in recording.names.select(measure.of)]
    return np.sum(inside, axis=0)


_COLLECTIVE: dict[str, Callable[[RecordedCase, Any], Array]] = {
    "spring_force": lambda recording, measure: spring_force(recording, measure.spring),
    "extent": _extent,
    "distance": _distance,
    **contact_measures.MEASURES,
    "energy": _energy,
    "momentum": _momentum,
    "angular_momentum": _angular_momentum,
    "count_in": _count_in,
    "threaded": threading.count_threaded,
    **soft_measures.MEASURES,
}
