"""Placement beside something, or touching it."""

import math

from text2sim.compiler.placing.footing import region_point
from text2sim.compiler.placing.group import PlacedGroup
from text2sim.compiler.placing.place_error import PlaceError
from text2sim.compiler.shapes.rotation import Z_AXIS, Vec, quat_from_yaw, quat_rotate, vector_dot, vector_unit
from text2sim.compiler.shapes.sweep import sweep
from text2sim.spec_schema.models.place_rules import direction_of
from text2sim.spec_schema.models.placement import End, Place
from text2sim.spec_schema.models.regions import BodyRegion


def stand_beside(place: Place, subject: PlacedGroup, target: PlacedGroup) -> Vec:
    """Return the shift [m] to a side: `clearance` is the gap between the bounds of the two along the direction.

    Across it their middles line up, and in height their lowest points, unless `align` says otherwise.

    Args:
        place: The relation, with `direction`, `clearance` [m] and `align`.
        subject: What is placed.
        target: What it stands beside.

    Raises:
        PlaceError: if the target is a plane.
    """
    if target.planes:
        raise PlaceError("a plane has no sides", place.relation)
    direction = _unit(place)
    axis = next((k for k in (0, 1) if abs(direction[k]) == 1.0), None)
    shift = [lined_up(subject, target, k, place.alignment(k) or ("center", "center", "min")[k]) for k in range(3)]
    if axis is not None:
        (low, high), (bottom, top) = subject.bounds(), target.bounds()
        gap = place.clearance
        shift[axis] = bottom[axis] - high[axis] - gap if direction[axis] < 0 else top[axis] - low[axis] + gap
        return (shift[0], shift[1], shift[2])
    frame = quat_from_yaw(math.atan2(direction[1], direction[0]))
    (low, high), (bottom, top) = subject.bounds(frame), target.bounds(frame)
    along = top[0] - low[0] + place.clearance
    across = (bottom[1] + top[1] - low[1] - high[1]) / 2
    x, y, _ = quat_rotate(frame, (along, across, 0.0))
    return (x, y, shift[2])


def lined_up(subject: PlacedGroup, target: PlacedGroup, axis: int, end: End) -> float:
    """Return the shift [m] along an axis of the world that lines up two ends, or the middles.

    Args:
        subject: What is moved.
        target: What it is lined up with.
        axis: 0, 1 or 2.
        end: Which ends, or the middles.
    """
    (low, high), (bottom, top) = subject.bounds(), target.bounds()
    if end == "center":
        return (bottom[axis] + top[axis]) / 2 - (low[axis] + high[axis]) / 2
    return bottom[axis] - low[axis] if end == "min" else top[axis] - high[axis]


def touch(place: Place, subject: PlacedGroup, target: PlacedGroup) -> Vec:
    """Return the shift [m] of a subject that comes from far away on the side `direction`, until it touches.

    It comes straight, its middle towards the target's middle, or towards the middle of a region of it.

    Args:
        place: The relation, with `direction`, `clearance` [m] and `align`.
        subject: What is placed.
        target: What it touches.

    Raises:
        PlaceError: if it passes the target, or cannot reach or align with a plane.
    """
    d = _unit(place)
    here = subject.middle()
    aim = region_point(target, place.at) if isinstance(place.at, BodyRegion) else target.middle()
    if not target.members and place.align is not None:
        raise PlaceError("a plane has no ends to align with", "align")
    # So far apart that the balls around the two do not overlap.
    far = place.clearance + sum(math.dist(*group.bounds()) / 2 for group in (subject, target) if group.members) * 1.01
    far += math.dist(aim, target.middle())
    best = math.inf
    for plane in target.planes:
        n = quat_rotate(plane.quat, Z_AXIS)
        closing = vector_dot(n, d)
        if closing < 1e-6:
            raise PlaceError("it cannot touch the plane from this side", "direction")
        low = subject.lowest(n) - vector_dot(n, here)
        best = min(best, far - (place.clearance - low) / closing)
    start = [t - h + far * c for t, h, c in zip(aim, here, d, strict=True)]
    for k in range(3):
        end = place.alignment(k)
        if end is not None:
            start[k] = lined_up(subject, target, k, end)
    x, y, z = start
    if target.members:
        backwards = (-d[0], -d[1], -d[2])
        distance = sweep(subject.solids(), target.solids(), backwards, gap=place.clearance, start=(x, y, z))
        best = min(best, math.inf if distance is None else distance)
    if best == math.inf:
        raise PlaceError(f"it passes `{place.target}` without touching it", "touching")
    return (x - best * d[0], y - best * d[1], z - best * d[2])


def _unit(place: Place) -> Vec:
    try:
        return vector_unit(direction_of(place))
    except ValueError as error:
        raise PlaceError(str(error), "direction") from None
