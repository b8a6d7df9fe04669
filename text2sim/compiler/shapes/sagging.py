"""Sheets that are bent at the start: hanging between two edges as a parabola, over a bar, or in folds."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import asinh, atan2, copysign, cos, dist, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

from text2sim.compiler.shapes.piece import Piece, wall_pieces
from text2sim.compiler.shapes.rotation import X_AXIS, Y_AXIS, Vec, quat_from_axis_angle, quat_multiply, vector_dot
from text2sim.spec_schema.models.sheets import Disc, Sheet, Sleeve

DISC_STAVES, SLEEVE_STAVES = 16, 32
"""Pieces that stand for a disc with a hole, and for a sleeve: they reach half a percent beyond its radius."""
SHEET_THICKNESS = 1e-3
"""Thickness [m] of a sheet when bodies are placed and compared; its solver has its own."""
SHEET_BOXES = 12
"""Flat pieces that stand for a bent sheet."""
CURVE_STEPS = 400
"""Pieces into which a curve is cut to find points along it: lengths are right to 1e-5 of them."""
CUT = 0.3
"""Part by which the sides of a sheet with gathered ends hang less deep than its middle.

Hammocks are cut so. If all lines were equally long, a ball would lie as deep at a side as in the middle, and roll out.
"""
CRADLE_STRIPS = 8
"""Strips of such pieces side by side, where a sheet has gathered ends."""
A_FOLD = 40
"""The same of each fold, at least."""


def parabola_length(span: float, sag: float) -> float:
    """Return the length [m] of a parabola `z = -sag (1 - (2 x / span)^2)` between its ends."""
    slope = 4 * sag / span
    return span / 2 * (sqrt(1 + slope**2) + (asinh(slope) / slope if slope > 1e-6 else 1.0))


def span_of(sheet: Sheet) -> float:
    """Return the distance [m] of the edges between which a sheet hangs."""
    length, low, high = sheet.size[0], 0.0, sheet.size[0]
    if not sheet.sag:
        return length
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if (parabola_length(middle, sheet.sag) if middle > 0 else -inf) < length else (low, middle)
        )
    return high


@lru_cache(maxsize=64)
def steepness(fullness: float) -> float:
    """Return the largest slope of a sine wave that is `fullness` times as long as the width that it takes up."""
    turns = [cos(pi / 2 * (k + 0.5) / CURVE_STEPS) for k in range(CURVE_STEPS)]
    low, high = 0.0, 2 * pi * fullness  # a slope s makes it longer than 2 s / pi
    for _ in range(60):
        slope = (low + high) / 2
        longer = sum(sqrt(1 + (slope * c) ** 2) for c in turns) / CURVE_STEPS > fullness
        low, high = (low, slope) if longer else (slope, high)
    return high


def fold_radius(sheet: Sheet) -> float:
    """Return the smallest radius of curvature [m] of a sheet in folds: 1 / (slope x wave number) of a sine wave."""
    return sheet.size[0] / sheet.fullness / (2 * pi * sheet.folds * steepness(sheet.fullness))


def _curve(sheet: Sheet) -> list[tuple[float, float]]:
    """Return points (x, z) [m] of a bent sheet, from its left edge to its right one."""
    if sheet.folds:
        width, steps = sheet.size[0] / sheet.fullness, max(CURVE_STEPS, A_FOLD * sheet.folds)
        turn = 2 * pi * sheet.folds / width
        xs = [(k / steps - 0.5) * width for k in range(steps + 1)]
        return [(x, steepness(sheet.fullness) / turn * sin(turn * (x + width / 2))) for x in xs]
    if sheet.over is None:
        span = span_of(sheet)
        xs = [(k / CURVE_STEPS - 0.5) * span for k in range(CURVE_STEPS + 1)]
        return [(x, -sheet.sag * (1 - (2 * x / span) ** 2)) for x in xs]
    r, fold = sheet.over, pi / 2 * sheet.over
    left, right = (part * sheet.size[0] - fold for part in (sheet.over_at, 1 - sheet.over_at))
    turn = [(-r * cos(pi * k / CURVE_STEPS), r * sin(pi * k / CURVE_STEPS)) for k in range(CURVE_STEPS + 1)]
    return [(-r, -left), *turn, (r, -right)]


def points_along_sheet(sheet: Sheet, count: int) -> list[tuple[float, float]]:
    """Return `count + 1` points (x, z) [m], evenly spaced along the sheet from its left edge to its right one."""
    if not is_bent(sheet):
        return [((k / count - 0.5) * sheet.size[0], 0.0) for k in range(count + 1)]
    curve = _curve(sheet)
    lengths = [0.0]
    for (a, b), (c, d) in zip(curve, curve[1:], strict=False):
        lengths.append(lengths[-1] + hypot(c - a, d - b))
    found, k = [], 0
    for index in range(count + 1):
        length = lengths[-1] * index / count
        while k < len(curve) - 2 and lengths[k + 1] < length:
            k += 1
        u = (length - lengths[k]) / max(lengths[k + 1] - lengths[k], 1e-12)
        (a, b), (c, d) = curve[k], curve[k + 1]
        found.append((a + u * (c - a), b + u * (d - b)))
    return found


class Line(NamedTuple):
    """A line along a sheet, which hangs like its middle line, but swung out about its chord."""

    side: float
    """Place of its ends across the sheet [m]."""
    lean: float
    """Angle by which it is swung out [rad]."""
    depth: float
    """Its depth over that of the middle line."""

    def at(self, point: tuple[float, float]) -> Vec:
        """Return its point [m] for a point (x, z) of the middle line."""
        x, z = point
        deep = z * self.depth
        return (x, self.side - deep * sin(self.lean), deep * cos(self.lean))


def sheet_lines(sheet: Sheet, count: int) -> list[Line]:
    """Return `count + 1` lines along a sheet, from its front to its back.

    With gathered ends, the line at v in [-1, 1] hangs `D (1 - CUT v^2)` deep, where D is the sag. Along the middle of
    the sheet, lines are a width W apart: with e = ends / 2, d the depth, a the angle and ' for d/dv, it is
    e^2 + d'^2 + d^2 a'^2 + 2 e d' sin(a) + 2 e d a' cos(a) = (W / 2)^2.
    """
    places = [2 * k / count - 1 for k in range(count + 1)]
    if sheet.ends is None:
        return [Line(v * sheet.size[1] / 2, 0.0, 1.0) for v in places]
    e, angles = sheet.ends / 2, [0.0]
    for k in range(CURVE_STEPS):
        v, a = k / CURVE_STEPS, angles[-1]
        d, change = sheet.sag * (1 - CUT * v * v), -2 * CUT * sheet.sag * v
        b, c = e * cos(a) / d, (e * e + change * change + 2 * e * change * sin(a) - (sheet.size[1] / 2) ** 2) / (d * d)
        angles.append(a + (sqrt(max(b * b - c, 0.0)) - b) / CURVE_STEPS)
    return [Line(v * e, copysign(angles[round(abs(v) * CURVE_STEPS)], v), 1 - CUT * v * v) for v in places]


def is_bent(sheet: Sheet) -> bool:
    """Return whether a sheet is bent at the start."""
    return bool(sheet.sag or sheet.folds) or sheet.over is not None


def _outline(sheet: Sheet) -> list[tuple[float, float]]:
    """Return points (x, z) [m] between which a sheet is nearly straight."""
    if sheet.over is None:
        return points_along_sheet(sheet, 8 * sheet.folds or (SHEET_BOXES if sheet.sag else 1))
    first, *turn, last = _curve(sheet)
    return [first, *turn[:: CURVE_STEPS // SHEET_BOXES], turn[-1], last]


def sheet_pieces(sheet: Sheet) -> list[Piece]:
    """Return the boxes that stand for a sheet when bodies are placed and compared."""
    if not is_bent(sheet):
        return [Piece("box", size=(*sheet.size, SHEET_THICKNESS))]
    points = _outline(sheet)
    if sheet.ends is not None:
        return _cradle_pieces(sheet, points)
    found = []
    for (a, b), (c, d) in zip(points, points[1:], strict=False):
        box = Piece("box", size=(hypot(c - a, d - b), sheet.size[1], SHEET_THICKNESS))
        lean = quat_from_axis_angle(Y_AXIS, -atan2(d - b, c - a))
        found.append(box.at(((a + c) / 2, 0.0, (b + d) / 2), lean))
    return found


def _cradle_pieces(sheet: Sheet, points: list[tuple[float, float]]) -> list[Piece]:
    found = []
    for front, back in pairwise(sheet_lines(sheet, CRADLE_STRIPS)):
        for first, last in pairwise(points):
            corners = front.at(first), front.at(last), back.at(first), back.at(last)
            x, y, z = (sum(corner[i] for corner in corners) / 4 for i in range(3))
            long = (dist(corners[0], corners[1]) + dist(corners[2], corners[3])) / 2
            wide = (dist(corners[0], corners[2]) + dist(corners[1], corners[3])) / 2
            pitch = quat_from_axis_angle(Y_AXIS, -atan2(last[1] - first[1], last[0] - first[0]))
            roll = quat_from_axis_angle(X_AXIS, (front.lean + back.lean) / 2)
            found.append(Piece("box", size=(long, wide, SHEET_THICKNESS)).at((x, y, z), quat_multiply(roll, pitch)))
    return found


def disc_pieces(disc: Disc) -> list[Piece]:
    """Return the plate, or the staves around a hole, that stand for a disc when bodies are placed and compared."""
    half = SHEET_THICKNESS / 2
    if not disc.hole:
        return [Piece("cylinder", size=(disc.radius, SHEET_THICKNESS))]
    wall = disc.hole, disc.radius
    return wall_pieces(wall, wall, -half, half, DISC_STAVES)


def sleeve_pieces(sleeve: Sleeve) -> list[Piece]:
    """Return the staves that stand for a sleeve when bodies are placed and compared."""
    half = SHEET_THICKNESS / 2
    bottom, top = ((r - half, r + half) for r in sleeve.radii)
    return wall_pieces(bottom, top, -sleeve.height / 2, sleeve.height / 2, SLEEVE_STAVES)


def sheet_reach(sheet: Sheet, u: Vec) -> float:
    """Return how far [m] a sheet reaches in a direction from its frame."""
    if sheet.ends is not None:
        reached = (line.at(point) for line in sheet_lines(sheet, CRADLE_STRIPS) for point in _outline(sheet))
        return max(vector_dot(point, u) for point in reached) + SHEET_THICKNESS / 2
    farthest = max(x * u[0] + z * u[2] for x, z in _outline(sheet))
    return farthest + (sheet.size[1] * abs(u[1]) + SHEET_THICKNESS * abs(u[2])) / 2


def hem(sheet: Sheet, sides: Sequence[str]) -> tuple[Vec, Vec] | None:
    """Return the corners [m] of the box of points at an end of a sheet over a bar, or of one with gathered ends.

    The sides of the latter hang out farther than its ends, whose corners are therefore outermost along x alone.

    Args:
        sheet: The sheet.
        sides: Names of the sides: one of left and right, with front or back at most.

    Returns:
        None for other sheets and sides.
    """
    ends = [side for side in sides if side in ("left", "right")]
    if not ends or (sheet.over is None and sheet.ends is None):
        return None
    curve, half = _curve(sheet), (sheet.ends or sheet.size[1]) / 2
    x, z = curve[0] if ends == ["left"] else curve[-1]
    inner = 0.0 if sheet.over is not None else x  # the end of what hangs over a bar leans towards it
    front, back = (-half, half) if "front" not in sides else (-half, -half)
    return (min(x, inner), half if "back" in sides else front, z), (max(x, inner), back, z)
