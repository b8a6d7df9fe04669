"""Relative placement: where a body goes that is `on`, `inside` or `left_of` something, by its true geometry.

What is placed is a group: one body, or all copies of a pattern, which move together. `at: [x, y]` is where the
origin of a body (the middle of a pattern) goes; without it, the middles of the bounds of the two groups line up.
"""

import math
from collections.abc import Callable

from text2sim.compiler.placing.around import surround
from text2sim.compiler.placing.footing import footing, slide
from text2sim.compiler.placing.group import PlacedGroup
from text2sim.compiler.placing.place_error import PlaceError
from text2sim.compiler.placing.sides import lined_up, stand_beside, touch
from text2sim.compiler.shapes.gjk import TOLERANCE
from text2sim.compiler.shapes.rotation import Z_AXIS, Vec, quat_rotate
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.compiler.shapes.sweep import sweep
from text2sim.spec_schema.models.place_rules import STANDING, contradictions
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.regions import BodyRegion

_DOWN = (0.0, 0.0, -1.0)
_WALL_DIRECTIONS = 16
"""Number of horizontal directions in which walls are looked for."""
_LIFT = 1e-5
"""Height [m] above the floor at which walls are looked for."""

Height = Callable[[Place, PlacedGroup, PlacedGroup, float, float], float]
"""Shift in z [m] of a subject, given its shift in x and y."""


def settle(place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec, *, ringed: bool = False) -> Vec:
    """Return the shift [m] that brings a group into relation with another.

    Args:
        place: The relation.
        subject: What is placed, where it is now.
        target: What it is placed in relation to.
        middle: The point [m] of the subject that `at` places.
        ringed: With `around`: the subject's copies stand around the target, instead of each going round it.

    Raises:
        PlaceError: if there is no such place.
    """
    for key, message in contradictions(place):
        raise PlaceError(message, key)
    relation = place.relation
    if subject.planes:
        raise PlaceError("a plane has no end and cannot be placed; give it a pose", relation)
    if relation in STANDING:
        return _stand(place, subject, target, middle)
    dx, dy, dz = place.offset
    if relation == "around":
        return surround(place, subject, target, middle, ringed)
    x, y, z = (touch if relation == "touching" else stand_beside)(place, subject, target)
    return (x + dx, y + dy, z + dz)


def _stand(place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec) -> Vec:
    if place.relation == "inside":
        return _stand_inside(place, subject, target, middle)
    height: Height = {"on": height_on, "above": _above, "below": _height_below}[place.relation]
    if isinstance(place.at, BodyRegion):
        x, y = footing(place, subject, target, middle, lambda x, y: height(place, subject, target, x, y))
    else:
        x, y = _level(place, subject, target, middle)
    dx, dy, dz = place.offset
    return (x + dx, y + dy, height(place, subject, target, x + dx, y + dy) + dz)


def _stand_inside(place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec) -> Vec:
    dx, dy, dz = place.offset
    if place.align is None and not isinstance(place.at, BodyRegion):
        x, y = _level(place, subject, target, middle)
        return (x + dx, y + dy, _inside(place, subject, target, x + dx, y + dy) + dz)
    x, y = _shift_over(subject, target)
    x, y, z = slide(place, subject, target, (x, y, _inside(place, subject, target, x, y)))
    x, y = x + dx, y + dy
    landed = _fall(subject, target, (x, y, z), 0.0)
    if landed is None:
        landed = target.bounds()[0][2] - subject.bounds()[0][2]
    return (x, y, landed + place.clearance + dz)


def _blamed(place: Place) -> str:
    """Return the key of `place` to blame if something cannot go where it should."""
    return "offset" if any(place.offset[:2]) else "at" if place.at is not None else place.relation


def _shift_over(subject: PlacedGroup, target: PlacedGroup) -> tuple[float, float]:
    here, onto = subject.middle(), target.middle()
    return onto[0] - here[0], onto[1] - here[1]


def _level(place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec) -> tuple[float, float]:
    """Return the shift in x and y: to `at`, or to the middles or ends that line up."""
    if place.at is not None:
        assert not isinstance(place.at, BodyRegion)
        return place.at[0] - middle[0], place.at[1] - middle[1]
    ends = (place.alignment(0), place.alignment(1))
    if ends == (None, None):
        return _shift_over(subject, target)
    if not target.members:
        raise PlaceError("a plane has no ends to align with; say `at: [x, y]`", "align")
    x, y = (lined_up(subject, target, k, end or "center") for k, end in enumerate(ends))
    return x, y


def _plane_height(plane: CopySpot, subject: PlacedGroup, x: float, y: float, gap: float, relation: str) -> float:
    """Return the shift in z that brings the subject to the plane, from above or (`below`) from below."""
    nx, ny, nz = quat_rotate(plane.quat, Z_AXIS)
    if nz < 1e-6:
        raise PlaceError("the plane does not face upwards", relation)
    up = Z_AXIS if nz > 1 - 1e-15 else (nx, ny, nz)
    level = nx * plane.pos[0] + ny * plane.pos[1] + nz * plane.pos[2]
    if relation == "below":
        edge = level - gap + subject.lowest((-up[0], -up[1], -up[2]))
    else:
        edge = level + gap - subject.lowest(up)
    return (edge - nx * x - ny * y) / nz


def height_on(place: Place, subject: PlacedGroup, target: PlacedGroup, x: float, y: float) -> float:
    """Return the shift in z [m] that lets a group down on another until it touches.

    Args:
        place: The relation `on`, with its clearance.
        subject: What is placed, where it is now.
        target: What it is placed on.
        x: Shift in x [m].
        y: Shift in y [m].

    Raises:
        PlaceError: if it falls past the target.
    """
    gap = place.clearance
    heights = [_plane_height(plane, subject, x, y, gap, "on") for plane in target.planes]
    if target.members:
        z = _flat_top(subject, target, x, y, gap)
        if z is None:
            z = _drop(subject, target, x, y, gap)
        if z is not None:
            heights.append(z)
    if not heights:
        raise PlaceError(_falls_past(place, subject, target, x, y), _blamed(place))
    return max(heights)


def _falls_past(place: Place, subject: PlacedGroup, target: PlacedGroup, x: float, y: float) -> str:
    (low, high), (bottom, top) = subject.bounds(), target.bounds()
    beside = next((k for k, s in enumerate((x, y)) if high[k] + s <= bottom[k] or low[k] + s >= top[k]), None)
    nowhere = f"`{place.target}` is nowhere under it, and it would fall past"
    if beside is None:
        several = "[*]" in (place.target or "")
        hint = "; for one on each, give it a `repeat` with as many copies" if several else ""
        return f"{nowhere}: it passes through{hint}"
    s = (x, y)[beside]
    span = f"{low[beside] + s:.4g} to {high[beside] + s:.4g}"
    its = f"{bottom[beside]:.4g} to {top[beside]:.4g}"
    return f"{nowhere}: along {'xy'[beside]} it would reach from {span}, and `{place.target}` reaches from {its}"


def _flat_top(subject: PlacedGroup, target: PlacedGroup, x: float, y: float, gap: float) -> float | None:
    """Return the height over an upright box that is the target's highest part and supports the whole subject."""
    low, high = subject.bounds()
    top = target.bounds()[1][2]
    for pos, quat, shape, _ in target.members:
        if shape is None or shape.kind != "box" or quat[1] or quat[2] or quat[3]:
            continue
        sx, sy, sz = shape.size
        over = abs(pos[2] + sz / 2 - top) < 1e-12
        if over and pos[0] - sx / 2 <= low[0] + x and high[0] + x <= pos[0] + sx / 2:  # noqa: SIM102
            if pos[1] - sy / 2 <= low[1] + y and high[1] + y <= pos[1] + sy / 2:
                return top - subject.lowest(Z_AXIS) + gap
    return None


def _drop(subject: PlacedGroup, target: PlacedGroup, x: float, y: float, gap: float) -> float | None:
    """Return the height to which the subject falls on the target, from above it; None if it falls past."""
    bottom, top = target.bounds()[0][2], target.bounds()[1][2]
    flat = top - subject.bounds()[0][2] + gap
    z = _fall(subject, target, (x, y, flat + max(0.01 * (top - bottom), 1e-3)), gap)
    # Flat on flat is known exactly: no need to keep the sweep's tolerance.
    return flat if z is not None and abs(z - flat) < 2 * TOLERANCE else z


def _fall(subject: PlacedGroup, target: PlacedGroup, start: Vec, gap: float) -> float | None:
    distance = sweep(subject.solids(), target.solids(), _DOWN, gap=gap, start=start)
    return None if distance is None else start[2] - distance


def _above(place: Place, subject: PlacedGroup, target: PlacedGroup, x: float, y: float) -> float:
    heights = [_plane_height(plane, subject, x, y, place.clearance, "above") for plane in target.planes]
    if target.members:
        heights.append(target.bounds()[1][2] - subject.bounds()[0][2] + place.clearance)
    return max(heights)


def _height_below(place: Place, subject: PlacedGroup, target: PlacedGroup, x: float, y: float) -> float:
    heights = [_plane_height(plane, subject, x, y, place.clearance, "below") for plane in target.planes]
    if target.members:
        heights.append(target.bounds()[0][2] - subject.bounds()[1][2] - place.clearance)
    return min(heights)


def _walled(subject: PlacedGroup, target: PlacedGroup, there: Vec) -> bool:
    """Return whether walls stop a subject in more than half of the horizontal directions.

    A single wall, however long, stops it in half of them at most.
    """
    movers, others = PlacedGroup(subject.members[:1], subject.sizes).solids(), target.solids()
    x, y, z = there
    start = (x, y, z + _LIFT)
    blocked = 0
    for k in range(_WALL_DIRECTIONS):
        if blocked + _WALL_DIRECTIONS - k <= _WALL_DIRECTIONS / 2:
            return False
        # Directions far from each other come first, which decides sooner.
        angle = 2 * math.pi * (k * 5 % _WALL_DIRECTIONS + 0.5) / _WALL_DIRECTIONS
        blocked += sweep(movers, others, (math.cos(angle), math.sin(angle), 0.0), start=start) is not None
        if blocked > _WALL_DIRECTIONS / 2:
            return True
    return False


def _inside(place: Place, subject: PlacedGroup, target: PlacedGroup, x: float, y: float) -> float:
    """Let the subject fall: from the middle of the target if it is free there, otherwise through its top.

    It falls until it touches, and is then lifted by the clearance: a gap on all sides would keep it out of a narrow
    cup.
    """
    if target.planes:
        raise PlaceError("a plane has no inside", "inside")
    if len(target.members) == 1 and len(target.solids()) == 1:
        message = f"`{place.target}` is one solid piece and has no inside; other relations are on, below, beside, …"
        raise PlaceError(message, "inside")
    (low, high), (bottom, top) = subject.bounds(), target.bounds()
    across = all(bottom[k] <= low[k] + s and high[k] + s <= top[k] for k, s in enumerate((x, y)))
    if across:
        start = target.middle()[2] - subject.middle()[2]
        z = _fall(subject, target, (x, y, start), 0.0)
        if z is not None and start - z < TOLERANCE:
            z = _drop(subject, target, x, y, 0.0)
        if z is None:
            # Nothing holds it from below: an open tube stands on something.
            z = bottom[2] - low[2]
        if low[2] + z + place.clearance < top[2] - 1e-6:
            if not _walled(subject, target, (x, y, z)):
                raise PlaceError(f"`{place.target}` has no inside there: no walls surround the place", "inside")
            return z + place.clearance
    message = (
        f"it does not fit into `{place.target}` there: it takes {_extents(low, high)} m along x, y and z,"
        f" `{place.target}` {_extents(bottom, top)} m from outside"
    )
    raise PlaceError(message, _blamed(place))


def _extents(low: Vec, high: Vec) -> str:
    return " × ".join(f"{high[k] - low[k]:.3g}" for k in range(3))
