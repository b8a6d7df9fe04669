"""How far convex pieces can move in a straight line before they touch others.

Conservative advancement: the separating plane between the closest points (GJK) says how far a piece can
safely go. Every step rests on a plane that was checked against both pieces, so that what is found is never
too far: bodies that are placed with it touch to within `TOLERANCE`, and do not overlap. As the distance is
a convex function of the way gone, these steps are Newton's, and few are needed.
"""

import math
from collections.abc import Callable, Iterable, Sequence

from text2sim.compiler.piece import Piece, piece_ball
from text2sim.compiler.rotation import Quaternion, Vec, frame_apply, quat_multiply, quat_to_rows

TOLERANCE = 1e-7
"""Gap [m] that counts as touching."""

_STEPS = 100


class Solid:
    """A piece somewhere in the world: a core, known by its support points, and a rounding around it."""

    __slots__ = ("ball", "center", "rounding", "support")

    def __init__(self, piece: Piece, pos: Sequence[float], quat: Quaternion) -> None:
        local_center, self.ball = piece_ball(piece)
        self.center = frame_apply(pos, quat, local_center)
        self.rounding = piece.size[0] if piece.kind in ("sphere", "capsule") else 0.0
        if piece.kind in ("hull", "mesh"):
            q = quat_multiply(quat, piece.quat)
            at = frame_apply(pos, quat, piece.pos)
            self.support = _corners([frame_apply(at, q, v) for v in piece.vertices])
        else:
            rows = quat_to_rows(quat_multiply(quat, piece.quat))
            self.support = _primitive(piece, frame_apply(pos, quat, piece.pos), rows)


Support = Callable[[Vec], Vec]


def _corners(corners: list[Vec]) -> Support:
    def support(d: Vec) -> Vec:
        a, b, c = d
        return max(corners, key=lambda v: a * v[0] + b * v[1] + c * v[2])

    if len(corners) <= 64:
        return support

    import numpy as np

    table = np.array(corners)
    return lambda d: corners[int(np.argmax(table @ np.array(d)))]


def _primitive(piece: Piece, p: Vec, rows: tuple[Vec, Vec, Vec]) -> Support:
    (a, b, c), (d, e, f), (g, h, i) = rows
    px, py, pz = p
    size, kind = piece.size, piece.kind
    if kind == "sphere":
        return lambda way: p

    def local(x: float, y: float, z: float) -> Vec:
        if kind == "box":
            return (
                math.copysign(size[0] / 2, x),
                math.copysign(size[1] / 2, y),
                math.copysign(size[2] / 2, z),
            )
        if kind == "ellipsoid":
            sx, sy, sz = size[0] * size[0] * x, size[1] * size[1] * y, size[2] * size[2] * z
            norm = math.sqrt(sx * x + sy * y + sz * z) or 1.0
            return (sx / norm, sy / norm, sz / norm)
        if kind == "capsule":
            return (0.0, 0.0, math.copysign(size[1] / 2, z))
        across = math.hypot(x, y)
        if across < 1e-12:
            return (0.0, 0.0, math.copysign(size[1] / 2, z))
        return (size[0] * x / across, size[0] * y / across, math.copysign(size[1] / 2, z))

    def support(way: Vec) -> Vec:
        u, v, w = way
        x, y, z = local(a * u + d * v + g * w, b * u + e * v + h * w, c * u + f * v + i * w)
        return (px + a * x + b * y + c * z, py + d * x + e * y + f * z, pz + g * x + h * y + i * z)

    return support


def solids(pieces: Iterable[Piece], pos: Sequence[float], quat: Quaternion) -> list[Solid]:
    """Return a body's pieces where the body is."""
    return [Solid(piece, pos, quat) for piece in pieces]


def sweep(movers: Sequence[Solid], others: Sequence[Solid], direction: Vec, *, gap: float = 0.0) -> float | None:
    """Return how far [m] the movers can go together until one is `gap` from one of the others.

    Args:
        movers: What moves.
        others: What stands.
        direction: Unit vector of the motion.
        gap: Distance [m] that is kept.

    Returns:
        0 if they are as near from the beginning; None if they never are.
    """
    best: float | None = None
    for nearest, mover, other in sorted(_candidates(movers, others, direction, gap), key=lambda c: c[0]):
        if best is not None and nearest >= best:
            break
        found = _advance(mover, other, direction, gap, math.inf if best is None else best)
        if found is not None and (best is None or found < best):
            best = found
    return best


def _candidates(
    movers: Sequence[Solid], others: Sequence[Solid], direction: Vec, gap: float
) -> Iterable[tuple[float, Solid, Solid]]:
    """Pairs whose balls meet on the way, with a lower bound [m] of the way."""
    import numpy as np

    m = np.array(direction)
    centers = np.array([other.center for other in others])
    balls = np.array([other.ball for other in others])
    for mover in movers:
        away = centers - np.array(mover.center)
        along = away @ m
        across = np.einsum("ij,ij->i", away, away) - along**2
        reach = balls + (mover.ball + gap)
        meets = (across <= reach**2) & (along > -reach)
        for k in np.flatnonzero(meets):
            yield float(along[k] - math.sqrt(max(reach[k] ** 2 - across[k], 0.0))), mover, others[int(k)]


def distance(a: Solid, b: Solid) -> float:
    """Return the distance [m] between two solids (a lower bound, good to `TOLERANCE`); 0 if they overlap."""
    found, _ = _separation(a, b, (0.0, 0.0, 0.0))
    return max(found - a.rounding - b.rounding, 0.0)


def _advance(mover: Solid, other: Solid, m: Vec, gap: float, limit: float) -> float | None:
    rounding = mover.rounding + other.rounding + gap
    way = 0.0
    for _ in range(_STEPS):
        apart, n = _separation(mover, other, (way * m[0], way * m[1], way * m[2]))
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


def _separation(a: Solid, b: Solid, shift: Vec) -> tuple[float, Vec]:
    """Lower bound of the distance [m] of two cores, `a` moved by `shift`, and the way from `a` to `b`."""
    sx, sy, sz = shift
    start = (b.center[0] - a.center[0] - sx, b.center[1] - a.center[1] - sy, b.center[2] - a.center[2] - sz)
    v = start if any(start) else (1.0, 0.0, 0.0)
    simplex: list[Vec] = []
    best, direction = -math.inf, v
    for _ in range(64):
        norm = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        if norm < 1e-11:
            return max(best, 0.0), direction
        n = (v[0] / norm, v[1] / norm, v[2] / norm)
        p, q = b.support((-n[0], -n[1], -n[2])), a.support(n)
        w = (p[0] - q[0] - sx, p[1] - q[1] - sy, p[2] - q[2] - sz)
        bound = w[0] * n[0] + w[1] * n[1] + w[2] * n[2]
        if bound > best:
            best, direction = bound, n
        if simplex and (norm - bound <= 1e-10 * (1.0 + norm) or w in simplex):
            break
        v, simplex = _closest([*simplex, w])
        if len(simplex) == 4:
            return max(best, 0.0), direction
    return max(best, 0.0), direction


def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _minus(a: Vec, b: Vec) -> Vec:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Vec, b: Vec) -> Vec:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _closest(simplex: list[Vec]) -> tuple[Vec, list[Vec]]:
    """The point of a simplex that is nearest to the origin, and the corners that carry it."""
    if len(simplex) == 1:
        return simplex[0], simplex
    if len(simplex) == 2:
        return _closest_segment(simplex[0], simplex[1])
    if len(simplex) == 3:
        return _closest_triangle(*simplex)
    a, b, c, d = simplex
    found: tuple[Vec, list[Vec]] | None = None
    for p, q, r, opposite in ((a, b, c, d), (a, c, d, b), (a, d, b, c), (b, d, c, a)):
        normal = _cross(_minus(q, p), _minus(r, p))
        side, inner = -_dot(normal, p), _dot(normal, _minus(opposite, p))
        # A flat tetrahedron has no inside: all its faces are candidates.
        flat = abs(inner) <= 1e-12 * math.sqrt(_dot(normal, normal)) * (1.0 + max(map(abs, opposite)))
        if flat or side * inner < 0:
            candidate = _closest_triangle(p, q, r)
            if found is None or _dot(candidate[0], candidate[0]) < _dot(found[0], found[0]):
                found = candidate
    return found if found is not None else ((0.0, 0.0, 0.0), simplex)


def _closest_segment(a: Vec, b: Vec) -> tuple[Vec, list[Vec]]:
    ab = _minus(b, a)
    square = _dot(ab, ab)
    t = -_dot(a, ab) / square if square > 0 else 0.0
    if t <= 0:
        return a, [a]
    if t >= 1:
        return b, [b]
    return (a[0] + t * ab[0], a[1] + t * ab[1], a[2] + t * ab[2]), [a, b]


def _closest_triangle(a: Vec, b: Vec, c: Vec) -> tuple[Vec, list[Vec]]:
    # Ericson, Real-Time Collision Detection (2005), section 5.1.5, with the point at the origin.
    ab, ac = _minus(b, a), _minus(c, a)
    d1, d2, d3, d4, d5, d6 = (
        -_dot(ab, a),
        -_dot(ac, a),
        -_dot(ab, b),
        -_dot(ac, b),
        -_dot(ab, c),
        -_dot(ac, c),
    )
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = va + vb + vc
    if total <= 0 or va <= 0 or vb <= 0 or vc <= 0:
        edges = (_closest_segment(a, b), _closest_segment(a, c), _closest_segment(b, c))
        return min(edges, key=lambda edge: _dot(edge[0], edge[0]))
    v, w = vb / total, vc / total
    point = (a[0] + v * ab[0] + w * ac[0], a[1] + v * ab[1] + w * ac[1], a[2] + v * ab[2] + w * ac[2])
    return point, [a, b, c]
