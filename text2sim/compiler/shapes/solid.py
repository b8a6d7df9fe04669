"""Convex pieces somewhere in the world, known by their support points.

What depends on a piece and on the orientation of its body, but not on its position, is computed once, since copies of
a body share their pieces.
"""

import math
from collections.abc import Callable, Iterable, Sequence

from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    Quaternion,
    Vec,
    frame_apply,
    quat_multiply,
    quat_rotate,
    quat_to_rows,
)

Support = Callable[[Vec], Vec]
"""The point of a core that lies farthest in a direction."""
Span = tuple[float, float]

ARRAYS_FROM = 64
"""With more corners, arrays are faster than a loop."""
_MEMORY = 256
"""Orientations of a piece, and axes of each, that are remembered."""


class _Turned:
    """A piece, turned with its body, about the body's origin."""

    __slots__ = ("ball", "center", "rounding", "spans", "support")

    def __init__(self, piece: Piece, quat: Quaternion) -> None:
        center, self.ball = piece.ball
        plain = quat == IDENTITY
        self.center = center if plain else quat_rotate(quat, center)
        self.rounding = piece.size[0] if piece.kind in ("sphere", "capsule") else 0.0
        pos = piece.pos if plain else quat_rotate(quat, piece.pos)
        turn = quat_multiply(quat, piece.quat)
        if piece.kind in ("hull", "mesh"):
            still = pos == ORIGIN and turn == IDENTITY
            self.support = _corners(piece.vertices if still else [frame_apply(pos, turn, v) for v in piece.vertices])
        else:
            self.support = _primitive(piece, pos, quat_to_rows(turn))
        self.spans: dict[Vec, Span] = {}

    def span(self, axis: Vec) -> Span:
        """Return the lowest and the highest coordinate [m] along an axis."""
        found = self.spans.get(axis)
        if found is None:
            found = _span(self.support, self.rounding, axis)
            if len(self.spans) < _MEMORY:
                self.spans[axis] = found
        return found


class Solid:
    """A piece somewhere in the world: a core, known by its support points, and a rounding around it."""

    __slots__ = ("_turned", "ball", "center", "pos", "rounding", "support")
    _turned: _Turned | None

    def __init__(self, piece: Piece, pos: Sequence[float], quat: Quaternion) -> None:
        turned: _Turned | None = piece.turned.get(quat)
        if turned is None:
            turned = _Turned(piece, quat)
            if len(piece.turned) < _MEMORY:
                piece.turned[quat] = turned
        self._turned = turned
        x, y, z = pos
        self.pos = (x, y, z)
        self.ball, self.rounding = turned.ball, turned.rounding
        a, b, c = turned.center
        self.center = (x + a, y + b, z + c)
        inner = turned.support

        def support(direction: Vec) -> Vec:
            u, v, w = inner(direction)
            return (x + u, y + v, z + w)

        self.support = support

    def span(self, axis: Vec) -> Span:
        """Return the lowest and the highest coordinate [m] along a unit vector."""
        if self._turned is None:
            return _span(self.support, self.rounding, axis)
        low, high = self._turned.span(axis)
        along = axis[0] * self.pos[0] + axis[1] * self.pos[1] + axis[2] * self.pos[2]
        return low + along, high + along


def _span(support: Support, rounding: float, axis: Vec) -> Span:
    a, b, c = axis
    low, high = support((-a, -b, -c)), support(axis)
    return (
        a * low[0] + b * low[1] + c * low[2] - rounding,
        a * high[0] + b * high[1] + c * high[2] + rounding,
    )


def shrunk(whole: Solid, factor: float) -> Solid:
    """Return a solid that is smaller about its centre."""
    solid = Solid.__new__(Solid)
    support, center = whole.support, whole.center
    x, y, z = center
    solid._turned, solid.pos, solid.center, solid.ball = None, center, center, whole.ball

    def smaller(direction: Vec) -> Vec:
        a, b, c = support(direction)
        return (x + factor * (a - x), y + factor * (b - y), z + factor * (c - z))

    solid.support, solid.rounding = smaller, factor * whole.rounding
    return solid


def solids(pieces: Iterable[Piece], pos: Sequence[float], quat: Quaternion) -> list[Solid]:
    """Return a body's pieces where the body is.

    Args:
        pieces: Pieces in the body's frame.
        pos: Position of the body [m].
        quat: Orientation of the body (w, x, y, z).
    """
    return [Solid(piece, pos, quat) for piece in pieces]


def _corners(corners: Sequence[Vec]) -> Support:
    if len(corners) <= ARRAYS_FROM:

        def support(d: Vec) -> Vec:
            a, b, c = d
            return max(corners, key=lambda v: a * v[0] + b * v[1] + c * v[2])

        return support

    import numpy as np

    table = np.array(corners)
    return lambda d: corners[int(np.argmax(table @ np.array(d)))]


def _primitive(piece: Piece, p: Vec, rows: tuple[Vec, Vec, Vec]) -> Support:
    (a, b, c), (d, e, f), (g, h, i) = rows
    px, py, pz = p
    size, kind = piece.size, piece.kind
    if kind == "sphere":
        return lambda direction: p

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

    def support(direction: Vec) -> Vec:
        u, v, w = direction
        x, y, z = local(a * u + d * v + g * w, b * u + e * v + h * w, c * u + f * v + i * w)
        return (px + a * x + b * y + c * z, py + d * x + e * y + f * z, pz + g * x + h * y + i * z)

    return support
