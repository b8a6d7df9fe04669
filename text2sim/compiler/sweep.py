"""How far convex pieces can move in a straight line before they touch others.

Conservative advancement: the separating plane between the closest points (GJK) says how far a piece can
safely go. Every step rests on a plane that was checked against both pieces, so that what is found is never
too far: bodies that are placed with it touch to within `TOLERANCE`, and do not overlap. As the distance is
a convex function of the way gone, these steps are Newton's, and few are needed.
"""

import math
from collections.abc import Iterator, Sequence

from text2sim.compiler.gjk import TOLERANCE, distance, separation
from text2sim.compiler.rotation import Vec, vector_cross, vector_unit
from text2sim.compiler.solid import Solid, solids

__all__ = ["ORIGIN", "TOLERANCE", "Solid", "distance", "least_distance", "solids", "sweep"]

ORIGIN: Vec = (0.0, 0.0, 0.0)
_STEPS = 100
_FEW = 400
"""Pairs up to which a loop is quicker than loading numpy."""
_MANY = 1_000_000
"""Pairs that are looked at together."""

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
        start: Moves the movers [m] before.

    Returns:
        0 if they are as near from the beginning; None if they never are.
    """
    best: float | None = None
    for nearest, m, o in sorted(_on_the_way(movers, others, direction, gap, start)):
        if best is not None and nearest >= best:
            break
        found = _advance(movers[m], others[o], direction, gap, math.inf if best is None else best, start)
        if found is not None and (best is None or found < best):
            best = found
    return best


def least_distance(
    movers: Sequence[Solid], others: Sequence[Solid], *, start: Vec = ORIGIN, enough: float = math.inf
) -> float:
    """Return the smallest distance [m] between two groups of solids, `enough` if it is not smaller; 0 if they overlap.

    Args:
        movers: One group, moved by `start` [m].
        others: The other.
        start: Moves the first.
        enough: From where on it does not matter.
    """
    best = enough
    for nearest, m, o in sorted(_near(movers, others, start, enough)):
        if nearest >= best:
            break
        best = min(best, distance(movers[m], others[o], start))
        if best == 0.0:
            break
    return best


def _frame(direction: Vec) -> tuple[Vec, Vec, Vec]:
    """The direction, and two axes across it: those of the world where possible, so that their spans are shared."""
    x, y, z = (abs(c) for c in direction)
    if z >= x and z >= y:
        u = vector_unit(vector_cross((0.0, 1.0, 0.0), direction))
    else:
        u = vector_unit(vector_cross(direction, (0.0, 0.0, 1.0)))
    return direction, u, vector_cross(direction, u)


def _bounds(solid: Solid, frame: tuple[Vec, Vec, Vec]) -> Bounds:
    a, b, c = frame
    return (*solid.span(a), *solid.span(b), *solid.span(c))


def _moved(bounds: Bounds, frame: tuple[Vec, Vec, Vec], by: Vec) -> Bounds:
    a, b, c = (axis[0] * by[0] + axis[1] * by[1] + axis[2] * by[2] for axis in frame)
    low, high, left, right, front, back = bounds
    return (low + a, high + a, left + b, right + b, front + c, back + c)


def _on_the_way(
    movers: Sequence[Solid], others: Sequence[Solid], direction: Vec, gap: float, start: Vec
) -> Iterator[Pair]:
    """Pairs that may meet, with a lower bound [m] of the way to it: that between the planes across the way."""
    frame = _frame(direction)
    mine = [_moved(_bounds(solid, frame), frame, start) for solid in movers]
    theirs = [_bounds(solid, frame) for solid in others]
    if len(mine) * len(theirs) > _FEW:
        yield from _on_the_way_of_many(mine, theirs, gap)
        return
    for m, (low, high, left, right, front, back) in enumerate(mine):
        low, left, right, front, back = low - gap, left - gap, right + gap, front - gap, back + gap
        for o, other in enumerate(theirs):
            if other[1] > low and other[2] < right and other[3] > left and other[4] < back and other[5] > front:
                yield other[0] - high - gap, m, o


def _on_the_way_of_many(mine: list[Bounds], theirs: list[Bounds], gap: float) -> Iterator[Pair]:
    import numpy as np

    others = np.array(theirs).T
    rows = max(_MANY // len(theirs), 1)
    for first in range(0, len(mine), rows):
        low, high, left, right, front, back = np.array(mine[first : first + rows]).T[:, :, None]
        meets = others[1] > low - gap
        meets &= (others[2] < right + gap) & (others[3] > left - gap)
        meets &= (others[4] < back + gap) & (others[5] > front - gap)
        m, o = np.nonzero(meets)
        yield from zip((others[0][o] - high[m, 0] - gap).tolist(), (m + first).tolist(), o.tolist(), strict=True)


_WORLD = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _near(movers: Sequence[Solid], others: Sequence[Solid], start: Vec, enough: float) -> Iterator[Pair]:
    """Pairs nearer than `enough`, by the gap between their upright boxes."""
    mine = [_moved(_bounds(solid, _WORLD), _WORLD, start) for solid in movers]
    theirs = [_bounds(solid, _WORLD) for solid in others]
    for m, a in enumerate(mine):
        for o, b in enumerate(theirs):
            apart = max(b[0] - a[1], a[0] - b[1], b[2] - a[3], a[2] - b[3], b[4] - a[5], a[4] - b[5], 0.0)
            if apart < enough:
                yield apart, m, o


def _advance(mover: Solid, other: Solid, m: Vec, gap: float, limit: float, start: Vec) -> float | None:
    rounding = mover.rounding + other.rounding + gap
    x, y, z = start
    way, n = 0.0, None
    for _ in range(_STEPS):
        apart, n = separation(mover, other, (x + way * m[0], y + way * m[1], z + way * m[2]), n)
        left = apart - rounding
        if left <= TOLERANCE:
            return way
        closing = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
        if closing <= 1e-9:
            return None
        # Half a tolerance short of the plane, so that rounding cannot push it over.
        way += (left - TOLERANCE / 2) / closing
        if way >= limit:
            return None
    return way
