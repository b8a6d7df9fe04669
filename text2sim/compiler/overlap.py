"""Bodies that start inside each other, or under the ground, and that the engine would throw apart."""

import math
from collections.abc import Iterator
from functools import cached_property

from text2sim.compiler import geometry
from text2sim.compiler.lower import Lowering
from text2sim.compiler.placement import Copy
from text2sim.compiler.rotation import Vec, quat_rotate
from text2sim.compiler.sweep import Solid, distance
from text2sim.compiler.tree import StandingPiece, tree_pieces

SHRUNK = 0.97
"""Pieces are compared at this size, so that bodies that touch, or nearly, do not count."""
SUNK = 0.001
"""Depth [m] under a plane that counts."""


def overlaps(placed: dict[str, list[Copy]], lowering: Lowering) -> Iterator[tuple[Copy, Copy]]:
    """Yield pairs of copies of which at least one can move and whose pieces overlap at the start.

    A plane comes second in its pair. Links of one body are not compared with each other.
    """
    copies = [copy for group in placed.values() for copy in group]
    planes = [copy for copy in copies if getattr(copy.shape, "kind", None) == "plane"]
    bodies = [_Body(copy, lowering) for copy in copies if copy not in planes and copy.name in lowering.balls]
    order = {copy.name: index for index, copy in enumerate(copies)}
    for plane in planes:
        up = quat_rotate(plane.quat, (0.0, 0.0, 1.0))
        level = _dot(up, plane.pos)
        for body in bodies:
            if any(_dot(up, c) - r < level for c, r in body.balls) and body.lowest(up) < level - SUNK:
                yield body.copy, plane
    for a, b in _near(bodies):
        pairs = ((x, y) for x, x_moves in a.solids for y, y_moves in b.solids if x_moves or y_moves)
        if any(distance(x, y) == 0.0 for x, y in pairs if _meet(x, y)):
            first, second = sorted((a, b), key=lambda body: (not body.moves, order[body.copy.name]))
            yield first.copy, second.copy


class _Body:
    """A copy with its bounds; its solids are made when they are first needed."""

    def __init__(self, copy: Copy, lowering: Lowering) -> None:
        self.copy, self.lowering = copy, lowering
        self.balls = lowering.balls[copy.name]
        (x, y, z), r = self.balls[0]
        self.low, self.high = (x - r, y - r, z - r), (x + r, y + r, z + r)
        if len(self.balls) > 1:
            self.low = tuple(min(c[k] - r for c, r in self.balls) for k in range(3))
            self.high = tuple(max(c[k] + r for c, r in self.balls) for k in range(3))
        mount = getattr(copy.model, "mount", None)
        self.moves = hasattr(copy.model, "kind") and (mount is None or mount.kind != "fixed")

    @cached_property
    def solids(self) -> list[tuple[Solid, bool]]:
        """Every piece, a little smaller than it is, and whether it can move."""
        return [
            (_shrunk(Solid(piece, pos, quat)), moves)
            for piece, pos, quat, moves in self._pieces()
            if not piece.decompose  # its hull is known, but not what it falls into
        ]

    def lowest(self, up: Vec) -> float:
        """Height [m] along `up` of the lowest point that can move."""
        down = (-up[0], -up[1], -up[2])
        whole = (Solid(piece, pos, quat) for piece, pos, quat, moves in self._pieces() if moves)
        return min((_dot(up, solid.support(down)) - solid.rounding for solid in whole), default=math.inf)

    def _pieces(self) -> list[StandingPiece]:
        tree = self.lowering.trees.get(self.copy.name)
        if tree is not None:
            return tree_pieces(tree, self.copy.pos, self.copy.quat)
        shape, where = self.copy.shape, (self.copy.pos, self.copy.quat)
        return [StandingPiece(piece, *where, self.moves) for piece in geometry.pieces(shape, self.lowering.folder)]


def _near(bodies: list[_Body]) -> Iterator[tuple[_Body, _Body]]:
    """Yield pairs whose bounds overlap: sorted along x, so that far pairs are never looked at."""
    bodies.sort(key=lambda body: body.low[0])
    open_: list[_Body] = []
    for body in bodies:
        open_ = [other for other in open_ if other.high[0] > body.low[0]]
        for other in open_:
            if all(other.low[k] < body.high[k] and body.low[k] < other.high[k] for k in (1, 2)):
                yield other, body
        open_.append(body)


def _shrunk(solid: Solid) -> Solid:
    support, center = solid.support, solid.center

    def smaller(way: Vec) -> Vec:
        point = support(way)
        return tuple(c + SHRUNK * (p - c) for p, c in zip(point, center, strict=True))  # type: ignore[return-value]

    solid.support, solid.rounding = smaller, SHRUNK * solid.rounding
    return solid


def _meet(a: Solid, b: Solid) -> bool:
    return sum((x - y) ** 2 for x, y in zip(a.center, b.center, strict=True)) < (a.ball + b.ball) ** 2


def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
