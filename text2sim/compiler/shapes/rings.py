"""Closed surfaces of round solids in triangles of about one size.

They consist of rings around an axis, each with as many points as its length needs, and triangles between them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.piece import wall_radii

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

MIN_SIDES_WIDEST = 20
"""Least number of points around the widest ring: a polygon with so many corners lacks 1.6 % of its circle."""
MIN_SIDES = 5
"""Least number of points around any ring."""
ROW_HEIGHT = math.sqrt(3) / 2
"""Distance of rows over the edge in a lattice of equal triangles."""

ROUND_ABOUT_Z = {"cylinder", "capsule", "cone", "torus", "tube", "cup", "funnel"}
"""Shapes with an axis about which they are round."""

Point = tuple[float, float]
"""Distance from the axis, and height [m]."""


@dataclass(frozen=True)
class Arc:
    """A part of an ellipse about (`radius`, `height`), from the angle `start` to `end` [rad]; 0 points outwards."""

    radius: float
    height: float
    across: float
    """Half axis [m] away from the axis."""
    along: float
    """Half axis [m] along the axis."""
    start: float
    end: float

    @property
    def length(self) -> float:
        """Upper bound of the length [m]."""
        return abs(self.end - self.start) * max(self.across, self.along)

    def point(self, angle: float) -> Point:
        """Return the point at an angle."""
        r = self.radius + self.across * math.cos(angle)
        return (0.0 if abs(r) < 1e-12 * self.across else r, self.height + self.along * math.sin(angle))

    def points(self, edge: float) -> list[Point]:
        """Return points at equal distances, ends included: one for each row of triangles with this edge [m]."""
        fine = 256
        angles = [self.start + (self.end - self.start) * k / fine for k in range(fine + 1)]
        spots = [self.point(angle) for angle in angles]
        run = [0.0]
        for a, b in zip(spots, spots[1:], strict=False):
            run.append(run[-1] + math.dist(a, b))
        least = math.ceil(MIN_SIDES_WIDEST * abs(self.end - self.start) / (2 * math.pi) - 1e-9)
        rows = max(round(run[-1] / (edge * ROW_HEIGHT)), least, 1)
        found, k = [spots[0]], 0
        for row in range(1, rows):
            goal = run[-1] * row / rows
            while run[k + 1] < goal:
                k += 1
            part = (goal - run[k]) / (run[k + 1] - run[k])
            found.append(self.point(angles[k] + part * (angles[k + 1] - angles[k])))
        return [*found, self.point(self.end)]


def _straight(a: Point, b: Point, edge: float) -> list[Point]:
    """Return points from `a` to `b`, both included: one for each row of triangles with this edge [m]."""
    rows = max(round(math.dist(a, b) / (edge * ROW_HEIGHT)), 1)
    return [*((a[0] + (b[0] - a[0]) * k / rows, a[1] + (b[1] - a[1]) * k / rows) for k in range(rows)), b]


Part = Arc | tuple[Point, Point]


def profile_of(parts: Sequence[Part], edge: float) -> list[Point]:
    """Return the points of a profile whose parts follow each other."""
    found: list[Point] = []
    for part in parts:
        row = part.points(edge) if isinstance(part, Arc) else _straight(part[0], part[1], edge)
        found += row if not found else row[1:]
    return found


def profile(shape: Any) -> tuple[list[Part], bool]:
    """Return the parts of a round shape's profile, the solid on their left, and whether it is closed.

    A profile that is not closed begins and ends on the axis.
    """
    kind = shape.kind
    if kind == "sphere":
        return [Arc(0.0, 0.0, shape.radius, shape.radius, -math.pi / 2, math.pi / 2)], False
    if kind == "capsule":
        r, h = shape.radius, shape.length / 2
        return [Arc(0.0, -h, r, r, -math.pi / 2, 0.0), ((r, -h), (r, h)), Arc(0.0, h, r, r, 0.0, math.pi / 2)], False
    if kind == "torus":
        return [Arc(shape.radius, 0.0, shape.bar_radius, shape.bar_radius, 0.0, 2 * math.pi)], True
    corners = profile_corners(shape)
    return list(pairwise(corners)), corners[0] == corners[-1]


def profile_corners(shape: Any) -> list[Point]:
    """Return the corners of the profile of a cylinder, cone, cup, tube or funnel, the solid on their left."""
    h = shape.height / 2
    if shape.kind == "cylinder":
        return [(0.0, -h), (shape.radius, -h), (shape.radius, h), (0.0, h)]
    if shape.kind == "cone":
        top = [(shape.top_radius, h)] if shape.top_radius else []
        return [(0.0, -h), (shape.radius, -h), *top, (0.0, h)]
    if shape.kind == "cup":
        r, t = shape.radius, shape.thickness
        return [(0.0, -h), (r, -h), (r, h), (r - t, h), (r - t, t - h), (0.0, t - h)]
    low, high = wall_radii(shape)
    return [(low[0], -h), (low[1], -h), (high[1], h), (high[0], h), (low[0], -h)]


def turned(
    points: Sequence[Point], edge: float, *, closed: bool, stretch: float = 1.0
) -> "tuple[np.ndarray, np.ndarray]":
    """Turn a profile about z.

    Args:
        points: The profile, the solid on its left; if it is `closed`, the last point is the first one.
        edge: Wanted distance [m] of points along a ring.
        closed: Whether the profile is closed.
        stretch: Length of a ring over that of a circle, for rings that become ellipses.

    Returns:
        Vertices (n, 3) [m] and faces (m, 3), counterclockwise from outside.
    """
    import numpy as np

    widest = max(r for r, _ in points)
    rings = list(points[:-1] if closed else points)
    counts = [
        1
        if r == 0.0
        else max(round(2 * math.pi * r * stretch / edge), math.ceil(MIN_SIDES_WIDEST * r / widest), MIN_SIDES)
        for r, _ in rings
    ]
    shifts = [0.5 * (row % 2) / n for row, n in enumerate(counts)]  # rows of triangles, not of squares
    first = np.cumsum([0, *counts[:-1]])
    own, (r, z) = np.repeat(np.arange(len(rings)), counts), np.array(rings, dtype=float).T
    sizes, starts = np.array(counts), np.array(shifts)
    angles = 2 * math.pi * ((np.arange(len(own)) - first[own]) / sizes[own] + starts[own])
    vertices = np.stack([r[own] * np.cos(angles), r[own] * np.sin(angles), z[own]], axis=1)
    faces = []
    for k in range(len(rings) if closed else len(rings) - 1):
        j = (k + 1) % len(rings)
        bridge = _bridge_rings(counts[k], shifts[k], counts[j], shifts[j])
        faces.append(np.where(bridge < counts[k], first[k] + bridge, first[j] - counts[k] + bridge))
    return vertices, np.concatenate(faces)


@lru_cache(maxsize=256)
def _bridge_rings(n: int, shift_a: float, m: int, shift_b: float) -> "np.ndarray":
    """Return triangles between two rings: one from each edge of either ring to a point of the other.

    Points of the second ring are counted from n on. Long tubes have many pairs of equal rings.
    """
    import numpy as np

    if n == 1 or m == 1:
        around = np.arange(max(n, m))
        ahead = (around + 1) % len(around)
        if n == 1:
            return np.stack([np.zeros(m, int), 1 + ahead, 1 + around], axis=1)
        return np.stack([around, ahead, np.full(n, n)], axis=1)
    # Each step follows an edge of one of the rings, in the order of their middles, so that this edge lies opposite to
    # the third corner of its triangle.
    middles = np.concatenate([(np.arange(n) + 0.5) / n + shift_a, (np.arange(m) + 0.5) / m + shift_b])
    order = np.argsort(np.round(middles, 12), kind="stable")
    on_a = order < n
    i, j = np.cumsum(on_a) - on_a, np.cumsum(~on_a) - ~on_a
    here, beyond = i % n, n + j % m
    ahead = np.where(on_a, (i + 1) % n, n + (j + 1) % m)
    return np.stack([here, ahead, beyond], axis=1)
