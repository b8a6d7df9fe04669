"""Relative placement: where a body goes that is `on`, `inside` or `left_of` something, from real geometry.

What is placed is a group: one body, or all copies of a pattern, which move together. `at` is where the
origin of a body (the middle of a pattern) goes; without it the middles of the two groups' bounds are
brought over each other.
"""

import math
from collections.abc import Iterable, Sequence

from text2sim.compiler.geometry import Bounds, pieces
from text2sim.compiler.piece import Piece
from text2sim.compiler.rotation import (
    Quaternion,
    Vec,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    vector_unit,
)
from text2sim.compiler.sizes import Sizes, Spot
from text2sim.compiler.sweep import TOLERANCE, Solid, solids, sweep
from text2sim.spec_schema.placement import Place

ORIGIN: Vec = (0.0, 0.0, 0.0)
_DOWN = (0.0, 0.0, -1.0)


class PlaceError(ValueError):
    """A relation that cannot be fulfilled; `key` is the word of `place` at which it fails."""

    def __init__(self, message: str, key: str, rule: str = "placement", hint: str | None = None) -> None:
        super().__init__(message)
        self.key, self.rule, self.hint = key, rule, hint


class Group:
    """Copies that are placed, or are placed on, together."""

    def __init__(self, spots: Iterable[Spot], sizes: Sizes) -> None:
        self.sizes = sizes
        self.members: list[Spot] = []
        self.planes: list[Spot] = []
        for spot in spots:
            plane = spot.shape is not None and spot.shape.kind == "plane"
            (self.planes if plane else self.members).append(spot)
        self._bounds: Bounds | None = None
        self._solids: list[Solid] | None = None

    def bounds(self, frame: Quaternion | None = None) -> Bounds:
        """Bounds [m] of all copies but planes, along the axes of the world or of `frame`."""
        if frame is None and self._bounds is not None:
            return self._bounds
        low, high = [math.inf] * 3, [-math.inf] * 3
        back = None if frame is None else quat_conjugate(frame)
        for spot in self.members:
            pos, quat = spot.pos, spot.quat
            if back is not None:
                pos, quat = quat_rotate(back, pos), quat_multiply(back, quat)
            a, b = self.sizes.of(spot, quat)
            for k in range(3):
                low[k], high[k] = min(low[k], pos[k] + a[k]), max(high[k], pos[k] + b[k])
        found = (low[0], low[1], low[2]), (high[0], high[1], high[2])
        if frame is None:
            self._bounds = found
        return found

    def middle(self) -> Vec:
        """Middle [m] of the bounds; of a group of planes, the first one's origin."""
        if not self.members:
            return self.planes[0].pos
        low, high = self.bounds()
        return ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)

    def solids(self, shift: Vec = ORIGIN) -> list[Solid]:
        """Convex pieces of all copies but planes, moved by `shift` [m]; a tree counts as its bounds."""
        if shift == ORIGIN and self._solids is not None:
            return self._solids
        found: list[Solid] = []
        for spot in self.members:
            pos = spot.pos
            at = (pos[0] + shift[0], pos[1] + shift[1], pos[2] + shift[2])
            if spot.shape is None:
                low, high = self.sizes.of(spot)
                x, y, z = ((a + b) / 2 + p for a, b, p in zip(low, high, at, strict=True))
                lx, ly, lz = (b - a for a, b in zip(low, high, strict=True))
                found.append(Solid(Piece("box", size=(lx, ly, lz)), (x, y, z), (1.0, 0.0, 0.0, 0.0)))
            else:
                found += solids(pieces(spot.shape, self.sizes.folder), at, spot.quat)
        if shift == ORIGIN:
            self._solids = found
        return found


def settle(place: Place, subject: Group, target: Group, middle: Vec) -> Vec:
    """Return the shift [m] that brings a group into relation with another.

    Args:
        place: The relation.
        subject: What is placed, where it is before.
        target: What it is placed in relation to.
        middle: The point [m] of the subject that `at` speaks of.

    Raises:
        PlaceError: if there is no such place.
    """
    relation = place.relation
    if subject.planes:
        raise PlaceError("a plane has no end and cannot be placed; give it a pose", relation)
    if place.at is not None and relation not in ("on", "above", "below", "inside"):
        raise PlaceError(f"`at` has no meaning with `{relation}`", "at")
    if "direction" in place.model_fields_set and relation != "touching":
        raise PlaceError(f"`direction` has no meaning with `{relation}`", "direction")
    if relation == "touching":
        return _touch(place, subject, target)
    if relation in _SIDES:
        return _beside(place, subject, target)
    if place.at is not None:
        x, y = place.at[0] - middle[0], place.at[1] - middle[1]
    else:
        here, there = subject.middle(), target.middle()
        x, y = there[0] - here[0], there[1] - here[1]
    if relation == "inside":
        return _inside(place, subject, target, x, y)
    return {"on": _on, "above": _above, "below": _below}[relation](place, subject, target, x, y)


def _plane_height(plane: Spot, subject: Group, x: float, y: float, gap: float, relation: str) -> float:
    """Shift in z that brings the subject to the plane, from above or (`below`) from below."""
    nx, ny, nz = quat_rotate(plane.quat, (0.0, 0.0, 1.0))
    if nz < 1e-6:
        raise PlaceError("the plane does not face upwards", relation)
    low, high = subject.bounds(None if nz > 1 - 1e-15 else plane.quat)
    level = nx * plane.pos[0] + ny * plane.pos[1] + nz * plane.pos[2]
    edge = level - gap - high[2] if relation == "below" else level + gap - low[2]
    return (edge - nx * x - ny * y) / nz


def _on(place: Place, subject: Group, target: Group, x: float, y: float) -> Vec:
    gap = place.clearance
    heights = [_plane_height(plane, subject, x, y, gap, "on") for plane in target.planes]
    if target.members:
        z = _flat_top(subject, target, x, y, gap)
        if z is None:
            z = _drop(subject, target, x, y, gap)
        if z is not None:
            heights.append(z)
    if not heights:
        raise PlaceError(f"`{place.target}` is nowhere under it", "on")
    return (x, y, max(heights))


def _flat_top(subject: Group, target: Group, x: float, y: float, gap: float) -> float | None:
    """The height over an upright box that is the target's highest part and carries the whole subject."""
    low, high = subject.bounds()
    top = target.bounds()[1][2]
    for pos, quat, shape, _ in target.members:
        if shape is None or shape.kind != "box" or quat[1] or quat[2] or quat[3]:
            continue
        sx, sy, sz = shape.size
        over = abs(pos[2] + sz / 2 - top) < 1e-12
        if over and pos[0] - sx / 2 <= low[0] + x and high[0] + x <= pos[0] + sx / 2:  # noqa: SIM102
            if pos[1] - sy / 2 <= low[1] + y and high[1] + y <= pos[1] + sy / 2:
                return top - low[2] + gap
    return None


def _drop(subject: Group, target: Group, x: float, y: float, gap: float) -> float | None:
    """The height to which the subject falls on the target, from above it; None if it falls past."""
    bottom, top = target.bounds()[0][2], target.bounds()[1][2]
    flat = top - subject.bounds()[0][2] + gap
    z = _fall(subject, target, (x, y, flat + max(0.01 * (top - bottom), 1e-3)), gap)
    # Flat on flat is exact: say so, rather than leave a tenth of a micrometre.
    return flat if z is not None and abs(z - flat) < 2 * TOLERANCE else z


def _fall(subject: Group, target: Group, start: Vec, gap: float) -> float | None:
    way = sweep(subject.solids(start), target.solids(), _DOWN, gap=gap)
    return None if way is None else start[2] - way


def _above(place: Place, subject: Group, target: Group, x: float, y: float) -> Vec:
    heights = [_plane_height(plane, subject, x, y, place.clearance, "above") for plane in target.planes]
    if target.members:
        heights.append(target.bounds()[1][2] - subject.bounds()[0][2] + place.clearance)
    return (x, y, max(heights))


def _below(place: Place, subject: Group, target: Group, x: float, y: float) -> Vec:
    heights = [_plane_height(plane, subject, x, y, place.clearance, "below") for plane in target.planes]
    if target.members:
        heights.append(target.bounds()[0][2] - subject.bounds()[1][2] - place.clearance)
    return (x, y, min(heights))


def _inside(place: Place, subject: Group, target: Group, x: float, y: float) -> Vec:
    """Let the subject fall: from the middle of the target if it is free there, otherwise through its top.

    It falls until it touches, and is lifted by the clearance then: a gap on all sides would keep it out of a narrow
    cup.
    """
    if target.planes:
        raise PlaceError("a plane has no inside", "inside")
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
        z += place.clearance
        if low[2] + z < top[2] - 1e-6:
            return (x, y, z)
    raise PlaceError(f"it does not fit into `{place.target}` there", "inside")


_SIDES = {"left_of": (0, -1), "right_of": (0, 1), "in_front_of": (1, -1), "behind": (1, 1)}


def _beside(place: Place, subject: Group, target: Group) -> Vec:
    """Bounds against bounds; the middles agree across, the lowest points in height."""
    relation = place.relation
    if target.planes:
        raise PlaceError("a plane has no sides", relation)
    axis, sign = _SIDES[relation]
    (low, high), (bottom, top) = subject.bounds(), target.bounds()
    here, there = subject.middle(), target.middle()
    shift = [there[0] - here[0], there[1] - here[1], bottom[2] - low[2]]
    shift[axis] = bottom[axis] - high[axis] - place.clearance if sign < 0 else top[axis] - low[axis] + place.clearance
    return (shift[0], shift[1], shift[2])


def _touch(place: Place, subject: Group, target: Group) -> Vec:
    """From far away on the side `direction`, straight towards the target's middle, middle to middle."""
    try:
        d = vector_unit(place.direction)
    except ValueError as error:
        raise PlaceError(str(error), "direction") from None
    here, there = subject.middle(), target.middle()
    # A distance at which the balls around the two are apart.
    far = place.clearance + sum(math.dist(*group.bounds()) / 2 for group in (subject, target) if group.members) * 1.01
    best = math.inf
    for plane in target.planes:
        n = quat_rotate(plane.quat, (0.0, 0.0, 1.0))
        closing = _dot(n, d)
        if closing < 1e-6:
            raise PlaceError("it cannot touch the plane from this side", "direction")
        low = subject.bounds(plane.quat)[0][2] - _dot(n, here)
        best = min(best, far - (place.clearance - low) / closing)
    start = tuple(t - h + far * c for t, h, c in zip(there, here, d, strict=True))
    if target.members:
        backwards = (-d[0], -d[1], -d[2])
        way = sweep(subject.solids((start[0], start[1], start[2])), target.solids(), backwards, gap=place.clearance)
        best = min(best, math.inf if way is None else way)
    if best == math.inf:
        raise PlaceError(f"it passes `{place.target}` without touching it", "touching")
    return (start[0] - best * d[0], start[1] - best * d[1], start[2] - best * d[2])


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
