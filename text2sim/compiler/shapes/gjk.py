"""The distance between convex solids (GJK), with a separating plane that proves it.

Vector arithmetic is written out, since a check of many bodies spends most of its time here.
"""

import math

from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.solid import Solid

TOLERANCE = 1e-7
"""Gap [m] that counts as touching."""

_Found = tuple[Vec, list[Vec]]
"""The point of a simplex that is nearest to the origin, and the corners that span it."""


def distance(a: Solid, b: Solid, shift: Vec = (0.0, 0.0, 0.0)) -> float:
    """Return the distance [m] between two solids (a lower bound, good to `TOLERANCE`); 0 if they overlap.

    Args:
        a: One solid, which is moved by `shift` [m].
        b: The other.
        shift: Moves the first.
    """
    found, _ = separation(a, b, shift)
    return max(found - a.rounding - b.rounding, 0.0)


def separation(a: Solid, b: Solid, shift: Vec, guess: Vec | None = None) -> tuple[float, Vec]:
    """Return a lower bound of the distance [m] of two cores, `a` moved by `shift`, and the direction from `a` to `b`.

    Args:
        a: One solid.
        b: The other.
        shift: Moves the first [m].
        guess: A direction from `a` to `b` that may be right.
    """
    sx, sy, sz = shift
    if guess is None:
        guess = (b.center[0] - a.center[0] - sx, b.center[1] - a.center[1] - sy, b.center[2] - a.center[2] - sz)
    v = guess if any(guess) else (1.0, 0.0, 0.0)
    simplex: list[Vec] = []
    best, direction = -math.inf, v
    mine, theirs = a.support, b.support
    for _ in range(64):
        x, y, z = v
        norm = math.sqrt(x * x + y * y + z * z)
        if norm < 1e-11:
            return max(best, 0.0), direction
        x, y, z = x / norm, y / norm, z / norm
        px, py, pz = theirs((-x, -y, -z))
        qx, qy, qz = mine((x, y, z))
        w = (px - qx - sx, py - qy - sy, pz - qz - sz)
        bound = w[0] * x + w[1] * y + w[2] * z
        if bound > best:
            best, direction = bound, (x, y, z)
        if simplex and (norm - bound <= 1e-10 * (1.0 + norm) or w in simplex):
            break
        simplex.append(w)
        v, simplex = _closest(simplex)
        if len(simplex) == 4:
            return max(best, 0.0), direction
    return max(best, 0.0), direction


def _closest(simplex: list[Vec]) -> _Found:
    """Return the nearest point of a simplex whose last corner is new: the origin is not behind the other corners."""
    if len(simplex) == 1:
        return simplex[0], simplex
    if len(simplex) == 2:
        return _closest_segment(simplex[0], simplex[1])
    if len(simplex) == 3:
        return _closest_triangle(simplex[0], simplex[1], simplex[2])
    a, b, c, d = simplex
    found: _Found | None = None
    least = math.inf
    for p, q, opposite in ((a, c, b), (a, b, c), (b, c, a)):
        # The face p, q, d: is the origin on the far side of it from the opposite corner?
        px, py, pz = p
        ux, uy, uz = q[0] - px, q[1] - py, q[2] - pz
        vx, vy, vz = d[0] - px, d[1] - py, d[2] - pz
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        side = -(nx * px + ny * py + nz * pz)
        inner = nx * (opposite[0] - px) + ny * (opposite[1] - py) + nz * (opposite[2] - pz)
        if side * inner >= 0:
            # A flat tetrahedron has no inside: all its faces are candidates.
            size = 1.0 + max(abs(opposite[0]), abs(opposite[1]), abs(opposite[2]))
            if abs(inner) > 1e-12 * math.sqrt(nx * nx + ny * ny + nz * nz) * size:
                continue
        candidate = _closest_triangle(p, q, d)
        x, y, z = candidate[0]
        square = x * x + y * y + z * z
        if square < least:
            found, least = candidate, square
    return found if found is not None else ((0.0, 0.0, 0.0), simplex)


def _closest_segment(a: Vec, b: Vec) -> _Found:
    ax, ay, az = a
    x, y, z = b[0] - ax, b[1] - ay, b[2] - az
    square = x * x + y * y + z * z
    t = -(ax * x + ay * y + az * z) / square if square > 0 else 0.0
    if t <= 0:
        return a, [a]
    if t >= 1:
        return b, [b]
    return (ax + t * x, ay + t * y, az + t * z), [a, b]


def _closest_triangle(a: Vec, b: Vec, c: Vec) -> _Found:
    # Ericson, Real-Time Collision Detection (2005), section 5.1.5, with the point at the origin.
    ax, ay, az = a
    bx, by, bz = b
    cx, cy, cz = c
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    d1, d2 = -(ux * ax + uy * ay + uz * az), -(vx * ax + vy * ay + vz * az)
    d3, d4 = -(ux * bx + uy * by + uz * bz), -(vx * bx + vy * by + vz * bz)
    d5, d6 = -(ux * cx + uy * cy + uz * cz), -(vx * cx + vy * cy + vz * cz)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = va + vb + vc
    if total <= 0 or va <= 0 or vb <= 0 or vc <= 0:
        found = _closest_segment(a, b)
        least = _square(found[0])
        for p in (a, b):
            other = _closest_segment(p, c)
            square = _square(other[0])
            if square < least:
                found, least = other, square
        return found
    v, w = vb / total, vc / total
    return (ax + v * ux + w * vx, ay + v * uy + w * vy, az + v * uz + w * vz), [a, b, c]


def _square(v: Vec) -> float:
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
