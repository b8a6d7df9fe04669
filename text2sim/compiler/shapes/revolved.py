"""Surfaces of revolution without thickness: domes, bowls, hats and filters of cloth."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import acos, cos, dist, hypot, pi, sin
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.piece import WEDGE_FACES, Piece
from text2sim.compiler.shapes.rings import ROW_HEIGHT, Point, turned
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.sagging import SHEET_THICKNESS
from text2sim.spec_schema.models.sheets import Revolve

if TYPE_CHECKING:
    import numpy as np

CORNER = 0.35
"""Turn [rad] of a profile from which its point is a corner, where a row of points lies."""
ROWS, STAVES = 8, 24
"""Rows along the profile and pieces around it that stand for a surface when bodies are placed and compared."""

AT_AXIS = 1e-6
"""Smallest distance [m] of corners of these pieces from the axis, so that none of their sides has no area."""

ROUNDING = 1e-9
"""Part of the way between two points of a smooth profile that is as good as none."""


def outline(shape: Revolve) -> list[Point]:
    """Return the finely divided profile: distances from the axis and heights [m]."""
    return _smoothed(tuple(shape.profile)) if shape.smooth else shape.profile


@lru_cache(maxsize=64)
def _smoothed(points: tuple[Point, ...]) -> list[Point]:
    import numpy as np

    from text2sim.compiler.shapes.distances import curve

    # A line that meets the axis goes on beyond it, mirrored, so that the surface is round there.
    before = [_mirrored(points[1])] if points[0][0] == 0.0 else []
    after = [_mirrored(points[-2])] if points[-1][0] == 0.0 else []
    whole = np.array([*before, *points, *after])
    fine, number = curve(whole, np.arange(len(whole), dtype=float), smooth=True)
    first, last = len(before), len(before) + len(points) - 1
    kept = fine[(number > first + ROUNDING) & (number < last - ROUNDING)]
    inner = [(max(float(r), 0.0), float(z)) for r, z in kept]
    return [points[0], *inner, points[-1]]


def _mirrored(point: Point) -> Point:
    return -point[0], point[1]


def profile_length(shape: Revolve) -> float:
    """Return the length [m] of the profile."""
    return sum(dist(a, b) for a, b in pairwise(outline(shape)))


def revolved_area(shape: Revolve) -> float:
    """Return the area [m2] of one side."""
    return sum(pi * (a[0] + b[0]) * dist(a, b) for a, b in pairwise(outline(shape)))


def rows_of(shape: Revolve, height: float) -> list[Point]:
    """Return the points of the profile at which rows of triangles begin, about `height` [m] apart.

    They are at equal distances between its ends and corners.
    """
    found: list[Point] = []
    for run in _runs(outline(shape)):
        row = _spaced(run, max(round(sum(dist(a, b) for a, b in pairwise(run)) / height), 1))
        found += row if not found else row[1:]
    return found


def _runs(line: Sequence[Point]) -> list[list[Point]]:
    """Return the line cut at its corners; both parts have the point there."""
    runs = [[line[0]]]
    for before, point, after in zip(line, line[1:], line[2:], strict=False):
        runs[-1].append(point)
        if _turn(before, point, after) > CORNER:
            runs.append([point])
    runs[-1].append(line[-1])
    return runs


def _turn(a: Point, b: Point, c: Point) -> float:
    """Return the angle [rad] by which a line changes its direction at `b`."""
    u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    return acos(min(max((u[0] * v[0] + u[1] * v[1]) / (hypot(*u) * hypot(*v)), -1.0), 1.0))


def _spaced(run: Sequence[Point], rows: int) -> list[Point]:
    """Return `rows` + 1 points of a line at equal distances along it."""
    lengths = [dist(a, b) for a, b in pairwise(run)]
    total, found, k, passed = sum(lengths), [run[0]], 0, 0.0
    for row in range(1, rows):
        goal = total * row / rows
        while passed + lengths[k] < goal:
            passed += lengths[k]
            k += 1
        part = (goal - passed) / lengths[k]
        (r, z), (s, y) = run[k], run[k + 1]
        found.append((r + part * (s - r), z + part * (y - z)))
    return [*found, run[-1]]


def revolved_mesh(shape: Revolve, edge: float) -> "tuple[np.ndarray, np.ndarray]":
    """Return vertices (n, 3) [m] and faces (m, 3) of triangles whose edges are about `edge` [m] long.

    Faces are counterclockwise from the right-hand side of the profile, as seen on the way along it.
    """
    return turned(rows_of(shape, edge * ROW_HEIGHT), edge, closed=False)


def revolved_pieces(shape: Revolve) -> list[Piece]:
    """Return the thin plates that stand for a surface when bodies are placed and compared."""
    rows = rows_of(shape, profile_length(shape) / ROWS)
    turns = [(cos(2 * pi * k / STAVES), sin(2 * pi * k / STAVES)) for k in range(STAVES)]
    found = []
    for (r, z), (s, y) in pairwise(rows):
        long = dist((r, z), (s, y))
        out, up = SHEET_THICKNESS / 2 * (y - z) / long, SHEET_THICKNESS / 2 * (r - s) / long
        section = [
            [(max(radius + side * out, AT_AXIS), height + side * up) for side in (-1, 1, 1, -1)]
            for radius, height in ((r, z), (s, y))
        ]
        for a, b in zip(turns, [*turns[1:], turns[0]], strict=True):
            corners = [
                (radius * c, radius * d, height)
                for row in section
                for (radius, height), (c, d) in zip(row, (a, a, b, b), strict=True)
            ]
            found.append(Piece("hull", vertices=tuple(corners), faces=WEDGE_FACES))
    return found


def revolved_reach(shape: Revolve, u: Vec) -> float:
    """Return how far [m] a surface reaches in a direction from its frame."""
    level = hypot(u[0], u[1])
    return max(r * level + z * u[2] for r, z in outline(shape)) + SHEET_THICKNESS / 2
