"""Places on a body: in a corner or at an edge of its top, against a wall inside it."""

import math
from collections.abc import Callable, Sequence

from text2sim.compiler.placing.group import PlacedGroup
from text2sim.compiler.placing.place_error import PlaceError
from text2sim.compiler.shapes.regions import RegionError, region_middle
from text2sim.compiler.shapes.rotation import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Vec,
    frame_apply,
    quat_rotate,
    vector_dot,
    vector_times,
)
from text2sim.compiler.shapes.skin import skin_of
from text2sim.compiler.shapes.sweep import sweep
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.regions import SIDES, BodyRegion

_UNITS = (X_AXIS, Y_AXIS, Z_AXIS)
_LIFT = 1e-5
"""Height [m] above the floor at which something is pushed against a wall, so that it does not stick."""
_MAX_ROUNDS = 20
_REGION_SHARE = 0.95
"""Part of the way from a body's middle to a region of it."""
_WALL_GAP = 1e-6
"""Gap [m] that is left to a wall, so that what stands there can still fall."""


def region_point(target: PlacedGroup, region: BodyRegion) -> Vec:
    """Return the middle [m] of a region of one body, in the world.

    Raises:
        PlaceError: if it is a plane, or several bodies, or nothing lies in the region.
    """
    if target.planes:
        raise PlaceError("a plane has neither sides nor corners; say `at: [x, y]`", "at")
    if len(target.members) > 1:
        raise PlaceError("this means several copies, but a region belongs to one body: name one of them", "at")
    (spot,) = target.members
    try:
        middle = region_middle(region, skin_of(target.sizes.pieces(spot)))
    except RegionError as error:
        raise PlaceError(str(error), "at") from None
    return frame_apply(spot.pos, spot.quat, middle)


def face_under(place: Place, target: PlacedGroup) -> Vec:
    """Return the normal of the face of the target on which something is placed, at `at` or else at its middle.

    Raises:
        PlaceError: if nothing lies in the region of `at`.
    """
    x, y, _ = target.middle()
    if isinstance(place.at, BodyRegion) and len(target.members) == 1:
        # Somewhat inwards: a side or a corner of a face belongs to other faces as well.
        a, b, _ = region_point(target, place.at)
        x, y = x + _REGION_SHARE * (a - x), y + _REGION_SHARE * (b - y)
    elif isinstance(place.at, tuple):
        x, y = place.at
    return target.upward(x, y)


def footing(
    place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec, height: Callable[[float, float], float]
) -> tuple[float, float]:
    """Return the shift in x and y [m] to a region of the target.

    At a side, an edge or a corner the two are flush, but for the inset, by their bounds in the target's own frame;
    along the other axes, their middles agree. At any other region the subject's own point goes over its middle.

    Args:
        place: The relation; `at` is a region.
        subject: What is placed.
        target: What it is placed on.
        middle: The subject's own point.
        height: The shift in z that goes with a shift in x and y.

    Raises:
        PlaceError: if the target is a plane, or nothing lies in the region.
    """
    region = place.at
    assert isinstance(region, BodyRegion)
    if not region.sides:
        x, y, _ = region_point(target, region)
        return x - middle[0], y - middle[1]
    if target.planes:
        raise PlaceError("a plane has neither sides nor corners; say `at: [x, y]`", "at")
    frame = target.frame()
    axes = tuple(quat_rotate(frame, unit) for unit in _UNITS)
    up = max(range(3), key=lambda k: abs(axes[k][2]))
    signs = _signs(place, axes, up)
    signs[up] = 1 if axes[up][2] > 0 else -1
    own, target_bounds = subject.bounds(frame), target.bounds(frame)
    wanted = _flush(place, own, target_bounds, signs)
    # On top of its uppermost face: right wherever that face is flat, level or not.
    wanted[up] = target_bounds[1][up] - own[0][up] if signs[up] > 0 else target_bounds[0][up] - own[1][up]
    x, y, z = (sum(w * axis[k] for w, axis in zip(wanted, axes, strict=True)) for k in range(3))
    across = [k for k in range(3) if k != up]
    if all(abs(axes[k][2]) < 1e-12 for k in across):
        return x, y
    # Elsewhere on a slope, the height changes with the place, and the place along the slope with the height.
    last = math.inf
    for _ in range(_MAX_ROUNDS):
        z = height(x, y)
        off = [wanted[k] - vector_dot(axes[k], (x, y, z)) for k in across]
        x += sum(o * axes[k][0] for o, k in zip(off, across, strict=True))
        y += sum(o * axes[k][1] for o, k in zip(off, across, strict=True))
        left = max(map(abs, off))
        if left < 1e-10 or left > 0.7 * last:
            break
        last = left
    return x, y


def _signs(place: Place, axes: Sequence[Vec], up: int) -> dict[int, int]:
    """Return the sides that are named, by axis, without the one that the relation implies."""
    region = place.at
    assert isinstance(region, BodyRegion)
    signs: dict[int, int] = {}
    meant = -1 if place.relation == "below" else 1
    for side in region.sides:
        axis, sign = SIDES[side]
        if axis != up:
            signs[axis] = sign
        elif sign * axes[up][2] * meant < 0:
            where = "down" if meant > 0 else "up"
            raise PlaceError(
                f"the {side} of `{place.target}` points {where} as it lies, and `{place.relation}` decides the height; "
                f"leave out `{side}`",
                "at",
            )
    return signs


def _flush(place: Place, mine: tuple[Vec, Vec], theirs: tuple[Vec, Vec], signs: dict[int, int]) -> list[float]:
    """Return the shift [m] along each axis at which named sides are flush, and the middles agree on the others."""
    (low, high), (bottom, top) = mine, theirs
    shift = [(bottom[k] + top[k] - low[k] - high[k]) / 2 for k in range(3)]
    for k, sign in signs.items():
        shift[k] = bottom[k] + place.inset - low[k] if sign < 0 else top[k] - place.inset - high[k]
    return shift


def slide(place: Place, subject: PlacedGroup, target: PlacedGroup, start: Vec) -> Vec:
    """Return the shift [m] of a subject that is lifted a little and pushed against walls from the inside.

    Args:
        place: `inside`, with a region in `at` or with `align`.
        subject: What is placed.
        target: What has the walls.
        start: Shift [m] to where it stands free.

    Raises:
        PlaceError: if there is no wall on a side.
    """
    pushes = _pushes(place, target)
    x, y, z = start
    z += _LIFT + max((gap for _, gap, _ in pushes), default=0.0)
    for direction, gap, key in pushes:
        far = sweep(subject.solids(), target.solids(), direction, gap=max(gap, _WALL_GAP), start=(x, y, z))
        if far is None:
            raise PlaceError(f"`{place.target}` has no wall on this side", key)
        x, y = x + far * direction[0], y + far * direction[1]
    return (x, y, z)


def _pushes(place: Place, target: PlacedGroup) -> list[tuple[Vec, float, str]]:
    """Return horizontal directions to push the subject in, the gap to leave, and the key of `place` that asks."""
    region = place.at
    if region is None:
        ends = [(k, place.alignment(k)) for k in (0, 1)]
        signs = {k: -1.0 if end == "min" else 1.0 for k, end in ends if end in ("min", "max")}
        return [(vector_times(_UNITS[k], sign), 0.0, "align") for k, sign in signs.items()]
    assert isinstance(region, BodyRegion)
    if not region.sides:
        raise PlaceError("`inside` takes a side, an edge or a corner, or `at: [x, y]`", "at")
    axes = tuple(quat_rotate(target.frame(), unit) for unit in _UNITS)
    found = []
    for side in region.sides:
        axis, sign = SIDES[side]
        direction = vector_times(axes[axis], sign)
        if abs(direction[2]) > 1e-9:
            message = f"the {side} of `{place.target}` does not point sideways as it lies; leave it out"
            raise PlaceError(message, "at")
        found.append((direction, place.inset, "at"))
    return found
