"""Ropes that are laid along points and round pulleys: where their joints are at the start."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from text2sim.compiler.placing.place_error import PatternError
from text2sim.compiler.shapes.rotation import (
    Z_AXIS,
    Quaternion,
    Vec,
    frame_apply,
    quat_conjugate,
    quat_rotate,
    vector_unit,
)
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.spec_schema.models.bodies import HingeMount
from text2sim.spec_schema.models.soft_bodies import Rope, Round

Array = np.ndarray[Any, np.dtype[np.float64]]

PULLEY_GAP = 0.02
"""Gap between rope and pulley at the start, as a fraction of the rope's radius."""
TURN_PITCH = 2.2
"""Distance between the centre lines of neighbouring turns along the pulley, in radii of the rope."""
ARC_STEP = math.radians(2)
TANGENT_PASSES = 60
"""Number of passes in which the tangents are found: each depends on those at the neighbouring pulleys."""
MAX_LINK_LENGTH = 1.0
"""Largest length of a link, in radii of the pulley that it goes round."""
MIN_LINK_LENGTH = 1e-6
"""Smallest length [m] of a link."""
MIN_AXIS_COSINE = 0.999
"""Smallest cosine of the angle between the axis of a hinge and that of its pulley."""


@dataclass
class _Wheel:
    """A pulley as the rope sees it: a circle of `radius` [m] about an axis; `sense` is the way round."""

    key: tuple[str, ...]
    name: str
    center: Array
    axis: Array
    side: Array
    turns: int
    radius: float
    sense: float = 1.0
    arrive: float = 0.0
    """Angle [rad] about the axis, from `side`, at which the rope arrives; `leave`, at which it leaves."""
    leave: float = 0.0
    rise: float = 0.0
    """Distance [m] along the axis from the first turn to the last."""

    @property
    def across(self) -> Array:
        return np.cross(self.axis, self.side)

    def at(self, angle: float, part: float = 0.5) -> Array:
        """Return the point [m] at an angle [rad], after the fraction `part` of the way round."""
        flat = math.cos(angle) * self.side + math.sin(angle) * self.across
        return self.center + self.radius * flat + (part - 0.5) * self.rise * self.axis

    def tangent(self, point: Array, sign: float, rough: bool) -> float:
        """Return the angle at which a line leaves the circle to a point (sign 1), or arrives from it (-1).

        Raises:
            PatternError: if the point is inside the circle, unless the circle is `rough`.
        """
        away = point - self.center
        x, y = float(away @ self.side), float(away @ self.across)
        distance = math.hypot(x, y)
        if distance <= self.radius and not rough:
            more = math.floor(1e4 * (self.radius - distance) + 1) / 10
            raise PatternError(
                f"{'comes from' if sign < 0 else 'goes on to'} a point {1e3 * distance:.4g} mm from the axis of "
                f"`{self.name}`, and the ends of its straight links lie round it at {1e3 * self.radius:.4g} mm; move "
                f"that point {more:.1f} mm away from the axis (less with more `segments`)", *self.key,
            )  # fmt: skip
        return math.atan2(y, x) - sign * self.sense * math.acos(min(1.0, self.radius / max(distance, 1e-12)))

    def sweep(self) -> float:
        """Return the angle [rad] that the rope goes round."""
        return (self.sense * (self.leave - self.arrive)) % (2 * math.pi) + 2 * math.pi * self.turns


def lay_rope(rope: Rope, pos: Vec, quat: Quaternion, find: Callable[[str], Sequence[CopySpot]]) -> Rope:
    """Return a rope with `along` as the places [m] of its joints and its length, in its own frame.

    Args:
        rope: The rope; `along` is not None.
        pos: Where its frame is [m].
        quat: How it is turned.
        find: Gives the copies that a selector means.

    Raises:
        PatternError: if it cannot be laid like that.
    """
    assert rope.along is not None
    path: list[Array | _Wheel] = []
    for number, item in enumerate(rope.along):
        key = ("along", str(number))
        if isinstance(item, Round):
            path.append(_wheel(item, rope.radius, key, find))
        else:
            path.append(np.array(frame_apply(pos, quat, item)))
    _settle(path, rough=True)
    wheels = [item for item in path if isinstance(item, _Wheel)]
    link = _length(_points(path)) / rope.segments
    if link < MIN_LINK_LENGTH:
        raise PatternError(f"leads nowhere: its {rope.segments} links would be shorter than 1 um", "along")
    for wheel in wheels:
        if link > MAX_LINK_LENGTH * wheel.radius:
            more = math.ceil(rope.segments * link / wheel.radius * 2)
            raise PatternError(
                f"has links of {1e3 * link:.3g} mm, too long to lie round `{wheel.name}` with a radius of "
                f"{1e3 * wheel.radius:.3g} mm; `segments: {more}` makes them half as long as that", *wheel.key,
            )  # fmt: skip
        # The middle of a link is nearer to the axis than its ends are.
        wheel.radius = math.hypot(wheel.radius, link / 2)
    _settle(path)
    nodes, length = _chords(_points(path), rope.segments)
    back = quat_conjugate(quat)
    own = tuple(quat_rotate(back, (node - np.array(pos)).tolist()) for node in nodes)
    return rope.model_copy(update={"along": own, "length": length * rope.segments})


def _settle(path: list[Array | _Wheel], rough: bool = False) -> None:
    """Find where the rope touches the pulleys; `rough` if their circles still lack what straight links need.

    Raises:
        PatternError: if it cannot.
    """
    wheels = [(k, item) for k, item in enumerate(path) if isinstance(item, _Wheel)]
    for k, wheel in wheels:
        before, after = path[k - 1], path[k + 1]
        before, after = (item.center if isinstance(item, _Wheel) else item for item in (before, after))
        along = float((after - before) @ wheel.across)
        if abs(along) < 1e-9:
            text = f"comes and goes on one line through the axis of `{wheel.name}`; to say which way round"
            raise PatternError(f"{text}, move a point to either side of it, or give another `side`", *wheel.key)
        wheel.sense = math.copysign(1.0, along)
    for _ in range(TANGENT_PASSES):
        for k, wheel in wheels:
            before, after = path[k - 1], path[k + 1]
            first = before.at(before.leave, 1) if isinstance(before, _Wheel) else before
            wheel.arrive = wheel.tangent(first, -1, rough)
            wheel.leave = wheel.tangent(after.at(after.arrive, 0) if isinstance(after, _Wheel) else after, 1, rough)
    for _, wheel in wheels:
        touch = (-wheel.sense * wheel.arrive) % (2 * math.pi)
        if not wheel.turns and touch > wheel.sweep() + 1e-9:
            text = f"passes `{wheel.name}` without touching it at this `side`; move a point, or leave it out"
            raise PatternError(text, *wheel.key)


def _points(path: list[Array | _Wheel]) -> Array:
    """Return the whole path as points, (n, 3)."""
    found: list[Array] = []
    for item in path:
        if not isinstance(item, _Wheel):
            found.append(item)
            continue
        sweep = item.sweep()
        steps = max(2, math.ceil(sweep / ARC_STEP))
        found += [item.at(item.arrive + item.sense * sweep * k / steps, k / steps) for k in range(steps + 1)]
    return np.array(found)


def _wheel(item: Round, thick: float, key: tuple[str, ...], find: Callable[[str], Sequence[CopySpot]]) -> _Wheel:
    spots = find(item.round)
    if len(spots) != 1:
        raise PatternError(f"goes round one body, and `{item.round}` means {len(spots)}", *key)
    (spot,) = spots
    radius = item.radius or getattr(spot.shape, "outer_radius", None) or getattr(spot.shape, "radius", None)
    if radius is None:
        raise PatternError(f"cannot see how thick `{item.round}` is about its z axis; give `radius`", *key)
    mount = getattr(spot.model, "mount", None)
    if isinstance(mount, HingeMount) and abs(vector_unit(mount.axis)[2]) < MIN_AXIS_COSINE:
        raise PatternError(f"goes round the z axis of `{item.round}`, whose own hinge has another `axis`", *key)
    axis = np.array(quat_rotate(spot.quat, Z_AXIS))
    side = np.array(vector_unit(item.side))
    side -= (side @ axis) * axis
    if np.linalg.norm(side) < 1e-3:
        raise PatternError(f"has `side` along the axis of `{item.round}`, its own z; take one across", *key)
    rise = TURN_PITCH * thick * item.turns
    height = getattr(spot.shape, "height", None)
    if height is not None and rise + 2 * thick > height:
        text = f"{item.turns} turns take {1e3 * (rise + 2 * thick):.3g} mm of `{item.round}`, which is"
        raise PatternError(f"{text} {1e3 * height:.3g} mm high", *key)
    return _Wheel(
        key, item.round, np.array(spot.pos), axis, side / np.linalg.norm(side), item.turns,
        radius + (1 + PULLEY_GAP) * thick, rise=rise,
    )  # fmt: skip


def _length(points: Array) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _chords(points: Array, count: int) -> tuple[list[Array], float]:
    """Return the ends of `count` equal chords [m] from the first point to the last, and their length."""
    low, high = 0.0, _length(points) / count * (1 + 1e-9)
    for _ in range(50):
        middle = (low + high) / 2
        _, reached = _walk(points, count, middle)
        low, high = (low, middle) if reached else (middle, high)
    return _walk(points, count, low)[0], low


def _walk(points: Array, count: int, length: float) -> tuple[list[Array], bool]:
    """Step along a path in equal chords; return the places, and whether the path ended before the last chord."""
    here, k, nodes = points[0], 0, [points[0]]
    for _ in range(count):
        while k + 1 < len(points) and np.linalg.norm(points[k + 1] - here) < length:
            k += 1
        if k + 1 == len(points):
            return [*nodes, points[-1]], True
        start, step = points[k] - here, points[k + 1] - points[k]
        # The larger root s of |start + s way| = length.
        a, b, c = step @ step, start @ step, start @ start - length**2
        here = points[k] + (-b + math.sqrt(max(b * b - a * c, 0.0))) / a * step
        nodes.append(here)
    return nodes, False
