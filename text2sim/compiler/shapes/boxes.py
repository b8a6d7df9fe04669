"""Boxes along the axes: around points, moved, grown, swept, and whether they are apart."""

from collections.abc import Iterable

from text2sim.compiler.shapes.rotation import Vec, vector_minus, vector_plus, vector_times

Bounds = tuple[Vec, Vec]
"""Lowest and highest corner [m]."""
NOWHERE: Bounds = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""The displacements of what stays where it is."""


def around(points: Iterable[Vec]) -> Bounds:
    """Return the box around one or more points."""
    x, y, z = zip(*points, strict=True)
    return (min(x), min(y), min(z)), (max(x), max(y), max(z))


def around_balls(balls: Iterable[tuple[Vec, float]]) -> Bounds:
    """Return the box around one or more balls, each with its centre [m] and radius [m]."""
    return union(grown((center, center), radius) for center, radius in balls)


def middle(box: Bounds) -> Vec:
    """Return the middle [m] of a box."""
    return vector_times(vector_plus(*box), 0.5)


def sides(box: Bounds) -> Vec:
    """Return the width, depth and height [m] of a box."""
    return vector_minus(box[1], box[0])


def moved(box: Bounds, by: Vec) -> Bounds:
    """Return a box moved by a vector [m]."""
    return swept(box, (by, by))


def grown(box: Bounds, by: float) -> Bounds:
    """Return a box that reaches farther by so much [m] on every side."""
    (a, b, c), (d, e, f) = box
    return (a - by, b - by, c - by), (d + by, e + by, f + by)


def swept(box: Bounds, displacements: Bounds) -> Bounds:
    """Return the box of everything that a box covers on displacements that lie in another box."""
    ((a, b, c), (d, e, f)), ((x, y, z), (u, v, w)) = box, displacements
    return (a + x, b + y, c + z), (d + u, e + v, f + w)


def union(boxes: Iterable[Bounds]) -> Bounds:
    """Return the smallest box around one or more boxes."""
    return around(corner for box in boxes for corner in box)


def crosses(box: Bounds, start: Vec, end: Vec) -> bool:
    """Return whether a line goes through a box, and does not only touch it.

    Args:
        box: The box.
        start: One end of the line [m].
        end: Its other end [m].
    """
    first, last = 0.0, 1.0
    for a, b, low, high in zip(start, end, *box, strict=True):
        slope = b - a
        if abs(slope) < 1e-12:
            if not low <= a <= high:
                return False
            continue
        near, far = sorted(((low - a) / slope, (high - a) / slope))
        first, last = max(first, near), min(last, far)
    return first < last


def apart(a: Bounds, b: Bounds, slack: float = 0.0) -> bool:
    """Return whether two boxes do not overlap, or by no more than `slack` [m] along some axis.

    Args:
        a: A box: its lowest and highest corner [m].
        b: Another box.
        slack: Overlap that does not count [m].
    """
    (a0, a1, a2), (a3, a4, a5) = a
    (b0, b1, b2), (b3, b4, b5) = b
    return (
        a3 - b0 <= slack
        or b3 - a0 <= slack
        or a4 - b1 <= slack
        or b4 - a1 <= slack
        or a5 - b2 <= slack
        or b5 - a2 <= slack
    )
