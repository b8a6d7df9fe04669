"""Sheets that are bent at the start: hanging between two edges as a parabola, over a bar, or in folds."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import asinh, atan2, copysign, cos, dist, hypot, inf, pi, sin, sqrt

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


def leans(sheet: Sheet, count: int) -> list[float]:
    """Return the angles [rad] by which `count + 1` lines along a sheet lean outwards, from its front to its back.

    Lines along a sheet with gathered ends are equally long and hang from closer points, so that they swing out about
    their chords: a point at the depth d lies d sin(angle) to the side, and d cos(angle) down. Along the middle, at the
    depth D, lines are a width W apart: the angle a of the line at v in [-1, 1] is that of
    (ends / 2 + D cos(a) a')^2 + (D sin(a) a')^2 = (W / 2)^2, with a' = da / dv.
    """
    if sheet.ends is None or sheet.ends == sheet.size[1]:
        return [0.0] * (count + 1)
    depth, end, width = sheet.sag, sheet.ends / 2, sheet.size[1] / 2
    angles = [0.0]
    for _ in range(CURVE_STEPS):
        b = end * cos(angles[-1])
        angles.append(angles[-1] + (sqrt(b * b + width * width - end * end) - b) / depth / CURVE_STEPS)
    found = []
    for k in range(count + 1):
        v = 2 * k / count - 1
        found.append(copysign(angles[round(abs(v) * CURVE_STEPS)], v))
    return found


def cradled(sheet: Sheet, u: float, lean: float, point: tuple[float, float]) -> Vec:
    """Return a point [m] of a sheet from the one (x, z) of its middle line.

    Args:
        sheet: The sheet.
        u: Its place across the sheet, from -1 at the front to 1 at the back.
        lean: Angle [rad] of its line, see `leans`.
        point: The point of the middle line.
    """
    x, z = point
    side = u * (sheet.size[1] if sheet.ends is None else sheet.ends) / 2
    return (x, side - z * sin(lean), z * cos(lean)) if lean else (x, side, z)


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
    lines = leans(sheet, CRADLE_STRIPS)
    found = []
    for k, (lean, after) in enumerate(pairwise(lines)):
        u, w = 2 * k / CRADLE_STRIPS - 1, 2 * (k + 1) / CRADLE_STRIPS - 1
        for first, last in pairwise(points):
            corners = [cradled(sheet, v, a, p) for v, a in ((u, lean), (w, after)) for p in (first, last)]
            x, y, z = ((corners[0][i] + corners[1][i] + corners[2][i] + corners[3][i]) / 4 for i in range(3))
            long = (dist(corners[0], corners[1]) + dist(corners[2], corners[3])) / 2
            wide = (dist(corners[0], corners[2]) + dist(corners[1], corners[3])) / 2
            pitch = quat_from_axis_angle(Y_AXIS, -atan2(last[1] - first[1], last[0] - first[0]))
            roll = quat_from_axis_angle(X_AXIS, (lean + after) / 2)
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
        rows = [(2 * k / CRADLE_STRIPS - 1, lean) for k, lean in enumerate(leans(sheet, CRADLE_STRIPS))]
        reached = (cradled(sheet, v, lean, point) for v, lean in rows for point in _outline(sheet))
        return max(vector_dot(point, u) for point in reached) + SHEET_THICKNESS / 2
    farthest = max(x * u[0] + z * u[2] for x, z in _outline(sheet))
    return farthest + (sheet.size[1] * abs(u[1]) + SHEET_THICKNESS * abs(u[2])) / 2


def hem(sheet: Sheet, sides: Sequence[str]) -> tuple[Vec, Vec] | None:
    """Return the corners [m] of the box of points at an end of a sheet over a bar; None for other sheets and sides.

    Args:
        sheet: The sheet.
        sides: Names of the sides: one of left and right, with front or back at most.
    """
    ends = [side for side in sides if side in ("left", "right")]
    if sheet.over is None or not ends:
        return None
    curve, half = _curve(sheet), sheet.size[1] / 2
    end = curve[0] if ends == ["left"] else curve[-1]
    front, back = (-half, half) if "front" not in sides else (-half, -half)
    return (min(end[0], 0.0), half if "back" in sides else front, end[1]), (max(end[0], 0.0), back, end[1])
