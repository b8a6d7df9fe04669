"""Sweeps of convex pieces: how far they can move in a straight line before they touch others.

Conservative advancement: the separating plane between the closest points (GJK) says how far a piece can safely go.
Every step uses a plane that was checked against both pieces, so the result is never too far: bodies that are placed
by it touch to within `TOLERANCE`, and do not overlap. As the distance is a convex function of the way gone, these are
Newton steps, and few are needed.
"""

import math
from collections.abc import Iterator, Sequence

from text2sim.compiler.shapes.gjk import TOLERANCE, distance, separation
from text2sim.compiler.shapes.rotation import ORIGIN, X_AXIS, Y_AXIS, Z_AXIS, Vec, vector_cross, vector_unit
from text2sim.compiler.shapes.solid import Solid

_MAX_STEPS = 100
_MAX_LOOPED_PAIRS = 1000
"""With no more pairs than this, a loop is faster than importing numpy."""
_MOVERS_AT_ONCE = 64
"""Movers that are compared at once, if there are many."""

Bounds = tuple[float, float, float, float, float, float]
"""Lowest and highest coordinate [m] along three axes."""
Pair = tuple[float, int, int]
"""A lower bound [m], and the numbers of the two solids."""


def sweep(
    movers: Sequence[Solid], others: Sequence[Solid], direction: Vec, *, gap: float = 0.0, start: Vec = ORIGIN
) -> float | None:
    """Return how far [m] the movers can go together until one is `gap` from one of the others.

    Args:
        movers: What moves.
        others: What stands.
        direction: Unit vector of the motion.
        gap: Distance [m] that is kept.
        start: Shift [m] of the movers before they move.

    Returns:
        0 if they are that near from the beginning; None if they never get there.
    """
    best = math.inf
    frame = _frame(direction)
    mover_boxes = [_move_bounds(_bounds(solid, frame), frame, start) for solid in movers]
    other_boxes = [_bounds(solid, frame) for solid in others]
    for pairs in _on_the_way(mover_boxes, other_boxes, gap):
        for nearest, m, o in sorted(pair for pair in pairs if pair[0] < best):
            if nearest >= best:
                break
            found = _advance(movers[m], others[o], direction, gap, best, start)
            if found is not None and found < best:
                best = found
    return None if best == math.inf else best


def least_distance(
    movers: Sequence[Solid], others: Sequence[Solid], *, start: Vec = ORIGIN, enough: float = math.inf
) -> float:
    """Return the smallest distance [m] between two groups of solids, `enough` if it is not smaller; 0 if they overlap.

    Args:
        movers: One group, moved by `start` [m].
        others: The other.
        start: Moves the first.
        enough: Distance [m] beyond which it does not matter.
    """
    best = enough
    theirs = [_bounds(solid, _WORLD) for solid in others]
    for m, mover in enumerate(movers):
        for nearest, o in sorted(_nearby(_move_bounds(_bounds(mover, _WORLD), _WORLD, start), theirs, best)):
            if nearest >= best:
                break
            best = min(best, distance(movers[m], others[o], start))
            if best == 0.0:
                return best
    return best


_WORLD = (X_AXIS, Y_AXIS, Z_AXIS)


def _frame(direction: Vec) -> tuple[Vec, Vec, Vec]:
    """Return the direction and two axes across it, axes of the world where possible, so that spans are shared."""
    x, y, z = (abs(c) for c in direction)
    if z >= x and z >= y:
        u = vector_unit(vector_cross(Y_AXIS, direction))
    else:
        u = vector_unit(vector_cross(direction, Z_AXIS))
    return direction, u, vector_cross(direction, u)


def _bounds(solid: Solid, frame: tuple[Vec, Vec, Vec]) -> Bounds:
    a, b, c = frame
    return (*solid.span(a), *solid.span(b), *solid.span(c))


def _move_bounds(bounds: Bounds, frame: tuple[Vec, Vec, Vec], by: Vec) -> Bounds:
    a, b, c = (axis[0] * by[0] + axis[1] * by[1] + axis[2] * by[2] for axis in frame)
    low, high, left, right, front, back = bounds
    return (low + a, high + a, left + b, right + b, front + c, back + c)


def _on_the_way(mine: list[Bounds], theirs: list[Bounds], gap: float) -> Iterator[list[Pair]]:
    """Yield pairs that may meet, with a lower bound [m] of the way to go: the gap between them along it."""
    if len(mine) * len(theirs) > _MAX_LOOPED_PAIRS:
        yield from _in_path_of_many(mine, theirs, gap)
        return
    found = []
    for m, (low, high, left, right, front, back) in enumerate(mine):
        low, left, right, front, back = low - gap, left - gap, right + gap, front - gap, back + gap
        for o, other in enumerate(theirs):
            if other[1] > low and other[2] < right and other[3] > left and other[4] < back and other[5] > front:
                found.append((other[0] - high - gap, m, o))
    yield found


def _in_path_of_many(mine: list[Bounds], theirs: list[Bounds], gap: float) -> Iterator[list[Pair]]:
    """Do the same in parts: movers that are near each other, and the others in their strip of space."""
    import numpy as np

    movers, others = np.array(mine), np.array(theirs)
    # Strips along the axis across the way on which the others are spread most.
    k = 2 if np.ptp(others[:, 2]) >= np.ptp(others[:, 4]) else 4
    first, order = np.argsort(movers[:, k]), np.argsort(others[:, k])
    movers, others = movers[first], others[order]
    widest = float((others[:, k + 1] - others[:, k]).max())
    for start in range(0, len(movers), _MOVERS_AT_ONCE):
        part = movers[start : start + _MOVERS_AT_ONCE]
        from_ = np.searchsorted(others[:, k], part[0, k] - widest - gap, "left")
        to = np.searchsorted(others[:, k], part[:, k + 1].max() + gap, "right")
        strip = others[from_:to]
        low, high, left, right, front, back = part.T[:, :, None]
        meets = strip[:, 1] > low - gap
        meets &= (strip[:, 2] < right + gap) & (strip[:, 3] > left - gap)
        meets &= (strip[:, 4] < back + gap) & (strip[:, 5] > front - gap)
        m, o = np.nonzero(meets)
        distances = (strip[o, 0] - high[m, 0] - gap).tolist()
        yield list(zip(distances, first[m + start].tolist(), order[o + from_].tolist(), strict=True))


def _nearby(mine: Bounds, theirs: list[Bounds], enough: float) -> list[tuple[float, int]]:
    """Return the others that are nearer than `enough`, by the gap between boxes along the axes."""
    if len(theirs) > _MAX_LOOPED_PAIRS:
        import numpy as np

        table = np.array(theirs)
        gaps = np.maximum(table[:, 0::2] - mine[1::2], np.array(mine[0::2]) - table[:, 1::2]).max(1).clip(0.0)
        found = np.flatnonzero(gaps < enough)
        return list(zip(gaps[found].tolist(), found.tolist(), strict=True))
    near = []
    for o, b in enumerate(theirs):
        apart = max(b[0] - mine[1], mine[0] - b[1], b[2] - mine[3], mine[2] - b[3], b[4] - mine[5], mine[4] - b[5], 0.0)
        if apart < enough:
            near.append((apart, o))
    return near


def _advance(mover: Solid, other: Solid, m: Vec, gap: float, limit: float, start: Vec) -> float | None:
    rounding = mover.rounding + other.rounding + gap
    x, y, z = start
    distance, n = 0.0, None
    for _ in range(_MAX_STEPS):
        apart, n = separation(mover, other, (x + distance * m[0], y + distance * m[1], z + distance * m[2]), n)
        left = apart - rounding
        if left <= TOLERANCE:
            return distance
        closing = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
        if closing <= 1e-9:
            return None
        # Half a tolerance short of the plane, so that rounding cannot push it over.
        distance += (left - TOLERANCE / 2) / closing
        if distance >= limit:
            return None
    return distance
