"""Signed distances [m] to the parts of a sculpt, negative inside: exact, or exact to first order near the surface.

Formulas of round cone and box after Inigo Quilez (https://iquilezles.org/articles/distfunctions/); those
of an ellipsoid and of a cross-section are f / |grad f|, which has the true surface and, on it, the slope of a distance.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from text2sim.spec_schema.models.sculpts import SculptBox, SculptEllipsoid, SculptLimb, SculptLoft, SculptRevolve

Array = np.ndarray
PIECES_PER_SPAN = 4
"""Pieces of a curve from one of its points to the next."""
TIP_SHARE = 0.35
"""A tip of a bar or loft thinner than this part of its thickest place is not a feature: a coarse grid may lose it."""
TABLE_SIZE = 192
"""Points of a table of distances to a profile, along its longer side."""
Curve = Callable[[Array], Array]
OTHER_AXES = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}


@dataclass(frozen=True)
class Bit:
    """A piece of a part."""

    distance: Callable[[Array], Array]
    """Distances (n,) of points (n, 3)."""
    low: Array
    """Lowest and highest corner (3,) of a box around it."""
    high: Array


@dataclass(frozen=True)
class PartUnion:
    """A part in its own frame: the union of its bits."""

    bits: list[Bit]
    thin: float
    """Thickness of its thinnest feature."""
    atoms: list[Array]
    """Points (k, 3) of its convex pieces; neighbours follow each other in the list."""


def form_of(part: SculptEllipsoid | SculptBox | SculptLimb | SculptRevolve | SculptLoft) -> PartUnion:
    """Return the geometry of a part."""
    if isinstance(part, SculptEllipsoid):
        radii = np.array(part.radii)
        ball = spread_directions() * radii
        return PartUnion([Bit(lambda p: _ellipsoid(p, radii), -radii, radii)], 2 * float(radii.min()), [ball])
    if isinstance(part, SculptBox):
        half, rounding = np.array(part.size) / 2, part.rounding
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * (half - rounding)
        atom = (corners[:, None] + rounding * spread_directions()[None]).reshape(-1, 3) if rounding else corners
        return PartUnion([Bit(lambda p: _box(p, half, rounding), -half, half)], 2 * float(half.min()), [atom])
    if isinstance(part, SculptLimb):
        return _limb(part)
    return _revolve(part) if isinstance(part, SculptRevolve) else _loft(part)


def spread_directions(count: int = 60) -> Array:
    """Return unit vectors (count + 6, 3) spread over the sphere by Fibonacci's lattice, and those of the axes."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, k * math.pi * (1 + math.sqrt(5))
    ring = np.sqrt(1 - z * z)
    return np.concatenate([np.stack([ring * np.cos(turn), ring * np.sin(turn), z], 1), np.eye(3), -np.eye(3)])


def _ellipsoid(p: Array, radii: Array) -> Array:
    near = np.linalg.norm(p / radii, axis=1)
    slope = np.linalg.norm(p / radii**2, axis=1)
    return np.where(near < 0.2, (near - 1) * radii.min(), near * (near - 1) / np.maximum(slope, 1e-300))


def _box(p: Array, half: Array, rounding: float) -> Array:
    q = np.abs(p) - (half - rounding)
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0) - rounding


# --- bars along a curve -----------------------------------------------------------------------------------------


def curve(points: Array, values: Array, *, smooth: bool, closed: bool = False) -> tuple[Array, Array]:
    """Return the points (n, k) of a finely divided line through given ones, and values (n,) along it.

    A smooth line is a centripetal Catmull-Rom spline, which makes no loops; values follow monotone cubics.

    Args:
        points: (n, k).
        values: (n,).
        smooth: Whether it is a spline; otherwise the points stay as they are.
        closed: Whether it comes back to its first point.
    """
    if not smooth:
        return points, values
    ring = np.concatenate([points, points[:1]]) if closed else points
    along = np.concatenate([[0.0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(ring, axis=0), axis=1)))])
    before = ring[-2] if closed else 2 * ring[0] - ring[1]
    after = ring[1] if closed else 2 * ring[-1] - ring[-2]
    whole = np.concatenate([[before], ring, [after]])
    first = along[-1] - along[-2] if closed else along[1]
    last = along[1] if closed else along[-1] - along[-2]
    knots = np.concatenate([[-first], along, [along[-1] + last]])
    found = []
    for k in range(len(ring) - 1):
        a, b, c, d = whole[k : k + 4]
        ta, tb, tc, td = knots[k : k + 4]
        t = np.linspace(tb, tc, PIECES_PER_SPAN + 1)[:-1, None]
        ab, bc, cd = _mix(a, b, ta, tb, t), _mix(b, c, tb, tc, t), _mix(c, d, tc, td, t)
        found.append(_mix(_mix(ab, bc, ta, tc, t), _mix(bc, cd, tb, td, t), tb, tc, t))
    line = np.concatenate([*found, ring[-1:]])
    fine = [np.linspace(a, b, PIECES_PER_SPAN + 1)[:-1] for a, b in zip(along, along[1:], strict=False)]
    at = np.concatenate([*fine, along[-1:]])
    return line, values if closed else monotone(along, values)(at)


def _mix(a: Array, b: Array, ta: float, tb: float, t: Array) -> Array:
    return a + (b - a) * ((t - ta) / (tb - ta))


def monotone(at: Array, values: Array) -> Curve:
    """Return a curve through values (n,) or (n, k) that adds no maxima or minima (Fritsch and Butland, 1984).

    Args:
        at: Their parameters, increasing.
        values: The values.
    """
    wide = np.diff(at).reshape(-1, *([1] * (values.ndim - 1)))
    rise = np.diff(values, axis=0) / wide
    slopes = np.empty_like(values, float)
    slopes[0], slopes[-1] = rise[0], rise[-1]
    one, two = 2 * wide[1:] + wide[:-1], wide[1:] + 2 * wide[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (one + two) / (one / rise[:-1] + two / rise[1:])
    slopes[1:-1] = np.where(rise[:-1] * rise[1:] > 0, mean, 0.0)

    def follow(s: Array) -> Array:
        k = np.clip(np.searchsorted(at, s, "right") - 1, 0, len(at) - 2)
        t = ((s - at[k]) / (at[k + 1] - at[k])).reshape(-1, *([1] * (values.ndim - 1)))
        h = wide[k]
        a, b = values[k], values[k + 1]
        bend = (slopes[k] + slopes[k + 1]) * h - 2 * (b - a)
        return a + t * (slopes[k] * h + t * (3 * (b - a) - (2 * slopes[k] + slopes[k + 1]) * h + t * bend))

    return follow


def _limb(part: SculptLimb) -> PartUnion:
    points = np.array(part.points)
    radii = np.array(part.radii) if isinstance(part.radii, list) else np.full(len(points), part.radii)
    line, bar = curve(points, radii, smooth=part.smooth and len(points) > 2)
    ball, bits, atoms = spread_directions(), [], []
    for a, b, r, s in zip(line, line[1:], bar, bar[1:], strict=False):
        low, high = np.minimum(a - r, b - s), np.maximum(a + r, b + s)
        bits.append(Bit(lambda p, a=a, b=b, r=float(r), s=float(s): round_cone(p, a, b, r, s), low, high))
        atoms.append(np.concatenate([a + r * ball, b + s * ball]))
    return PartUnion(bits, 2 * max(float(radii.min()), TIP_SHARE * float(radii.max())), atoms)


def round_cone(p: Array, a: Array, b: Array, r: float, s: float) -> Array:
    """Return the distance of points (n, 3) from the hull of two balls, at `a` with radius `r` and at `b` with `s`.

    Args:
        p: Points, shape (n, 3) [m].
        a: Middle of the first ball, shape (3,) [m].
        b: Middle of the second ball, shape (3,) [m].
        r: Radius of the first ball [m].
        s: Radius of the second ball [m].
    """
    axis, away = b - a, p - a
    square, fall = float(axis @ axis), r - s
    room = square - fall * fall
    if room <= 0:  # one ball holds the other
        return np.linalg.norm(away, axis=1) - r if r > s else np.linalg.norm(p - b, axis=1) - s
    y = away @ axis
    z = y - square
    across = away * square - y[:, None] * axis
    x2 = np.einsum("ij,ij->i", across, across)
    y2, z2 = y * y * square, z * z * square
    k = math.copysign(1.0, fall) * fall * fall * x2
    found = (np.sqrt(x2 * (room / square)) + y * fall) / square - r
    found = np.where(np.sign(y) * room * y2 < k, np.sqrt(x2 + y2) / square - r, found)
    return np.where(np.sign(z) * room * z2 > k, np.sqrt(x2 + z2) / square - s, found)


# --- turned profiles --------------------------------------------------------------------------------------------


def _revolve(part: SculptRevolve) -> PartUnion:
    from scipy.ndimage import map_coordinates

    points = np.array(part.profile)
    line, _ = curve(points, np.zeros(len(points)), smooth=part.smooth and len(points) > 2, closed=part.closed)
    line = np.maximum(line, (0.0, -np.inf))
    if not part.closed:
        line = np.concatenate([[(0.0, line[0, 1])], line, [(0.0, line[-1, 1])]])
    ring = line[:-1] if (line[0] == line[-1]).all() else line
    low, high = ring.min(0), ring.max(0)
    step = float((high - low).max()) / TABLE_SIZE
    # The table reaches a little beyond the profile; farther away, the distance from its box is added.
    start = low - 8 * step
    start[0] = 0.0
    counts = np.ceil((high + 8 * step - start) / step).astype(int) + 1
    r, z = (start[k] + step * np.arange(counts[k]) for k in (0, 1))
    table = _polygon(np.stack(np.meshgrid(r, z, indexing="ij"), -1).reshape(-1, 2), ring).reshape(counts)

    def distance(p: Array) -> Array:
        flat = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], 1)
        near = np.clip(flat, start, start + step * (counts - 1))
        found = map_coordinates(table, ((near - start) / step).T, order=1, mode="nearest")
        return found + np.linalg.norm(flat - near, axis=1)

    ahead = np.roll(ring, -1, axis=0)
    area = abs(float((ring[:, 0] * ahead[:, 1] - ahead[:, 0] * ring[:, 1]).sum())) / 2
    sides = np.linalg.norm(ahead - ring, axis=1)[(ring[:, 0] > 0) | (ahead[:, 0] > 0)].sum()
    wide = float(high[0])
    # For a wall of thickness t, twice the area over the length of the outline is t.
    thin = min(2 * area / float(sides), 2 * wide, float(high[1] - low[1]))
    turns = 2 * math.pi * np.arange(24) / 24
    circle = np.stack([np.cos(turns), np.sin(turns)], 1)
    atoms = [
        np.concatenate([np.column_stack([r * circle, np.full(24, z)]) for r, z in (a, b)])
        for a, b in zip(line, line[1:], strict=False)
        if a[1] != b[1]
    ]
    return PartUnion([Bit(distance, np.array([-wide, -wide, low[1]]), np.array([wide, wide, high[1]]))], thin, atoms)


def _polygon(p: Array, ring: Array) -> Array:
    """Return the signed distance of points (n, 2) from a polygon, by the even-odd rule."""
    best, inside = np.full(len(p), np.inf), np.zeros(len(p), bool)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        edge, away = b - a, p - a
        square = float(edge @ edge)
        if square > 0:
            t = np.clip(away @ edge / square, 0, 1)
            best = np.minimum(best, np.linalg.norm(away - t[:, None] * edge, axis=1))
        above, ahead = p[:, 1] >= a[1], p[:, 1] >= b[1]
        left = edge[0] * away[:, 1] > edge[1] * away[:, 0]
        inside ^= (above & ~ahead & ~left) | (~above & ahead & left)
    return np.where(inside, -best, best)


# --- lofts ------------------------------------------------------------------------------------------------------


def _loft(part: SculptLoft) -> PartUnion:
    axis = "xyz".index(part.axis)
    u, v = OTHER_AXES[part.axis]
    at = np.array([section.at for section in part.sections])
    # Half lengths, middles, and the exponent of the outline |u/a|^n + |v/b|^n = 1.
    rows = np.array([(*(s / 2 for s in section.size), *section.center, 2 / max(1 - section.squareness, 0.1))
                     for section in part.sections])  # fmt: skip
    follow: Curve = monotone(at, rows) if part.smooth and len(at) > 2 else partial(_straight, at, rows)

    tiny = 1e-4 * float(at[-1] - at[0])

    def distance(p: Array) -> Array:
        s = np.clip(p[:, axis], at[0], at[-1])
        row, ahead = follow(s), follow(np.clip(s + tiny, at[0], at[-1]))
        a, b, cu, cv, n = row.T
        x, y = (p[:, u] - cu) / a, (p[:, v] - cv) / b
        near = _outline(x, y, n)
        ax, ay = np.abs(x), np.abs(y)
        floor = np.maximum(near, 1e-9)
        gu, gv = (ax / floor) ** (n - 1) / a, (ay / floor) ** (n - 1) / b
        beyond = _outline((p[:, u] - ahead[:, 2]) / ahead[:, 0], (p[:, v] - ahead[:, 3]) / ahead[:, 1], n)
        steep = (beyond - near) / tiny
        steep = np.where(near < 0.2, 0.0, steep)
        side = (near - 1) / np.maximum(np.sqrt(gu * gu + gv * gv + steep * steep), 1 / np.maximum(a, b))
        end = np.maximum(at[0] - p[:, axis], p[:, axis] - at[-1])
        return np.minimum(np.maximum(side, end), 0) + np.hypot(np.maximum(side, 0), np.maximum(end, 0))

    fine = np.linspace(at[0], at[-1], 8 * len(at))
    row = follow(fine)
    low, high = np.empty(3), np.empty(3)
    low[axis], high[axis] = at[0], at[-1]
    for k, half, middle in ((u, 0, 2), (v, 1, 3)):
        low[k], high[k] = (row[:, middle] - row[:, half]).min(), (row[:, middle] + row[:, half]).max()
    widths = 2 * rows[:, :2].min(axis=1)
    thin = min(max(float(widths.min()), TIP_SHARE * float(widths.max())), float(at[-1] - at[0]))
    turns = 2 * math.pi * np.arange(24) / 24

    def outline(s: float) -> Array:
        a, b, cu, cv, n = follow(np.array([s]))[0]
        cos, sin = np.cos(turns), np.sin(turns)
        far = (np.abs(cos) ** n + np.abs(sin) ** n) ** (-1 / n)
        found = np.empty((24, 3))
        found[:, axis], found[:, u], found[:, v] = s, cu + a * far * cos, cv + b * far * sin
        return found

    places = np.unique(np.concatenate([at, (at[1:] + at[:-1]) / 2]))
    atoms = [np.concatenate([outline(a), outline(b)]) for a, b in zip(places, places[1:], strict=False)]
    return PartUnion([Bit(distance, low, high)], thin, atoms)


def _straight(at: Array, rows: Array, s: Array) -> Array:
    return np.stack([np.interp(s, at, row) for row in rows.T], -1)


def _outline(x: Array, y: Array, n: Array) -> Array:
    return (np.abs(x) ** n + np.abs(y) ** n) ** (1 / n)
