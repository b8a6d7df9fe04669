"""Convex pieces by which bodies collide, at their start poses, with their bounds."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, apart, sides
from text2sim.compiler.shapes.meshfile import MeshFile
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    Quaternion,
    Vec,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    quat_to_rows,
    vector_cross,
    vector_unit,
)
from text2sim.compiler.shapes.solid import Solid
from text2sim.spec_schema.models.base import AXES

MAX_HULL_FACES = 100
"""Most faces of a hull whose normals are used."""
MOST_PAIRS = 500_000
"""Most pairs that are compared, for which it takes seconds; a heap of 2,000 has some 20,000."""
MANY_CELLS = 64
"""A box in more grid cells than this is compared with every other box."""


@dataclass(eq=False)
class StandingPart:
    """A convex piece at its start pose."""

    piece: Piece
    pos: Vec
    """Position [m] of the body or link to which it belongs."""
    quat: Quaternion
    """Orientation of that body or link."""
    moves: bool
    """Whether it can move."""
    link: str | None
    """Name of its link; None for a primitive of the engine, and for what is fixed to the world."""
    mesh: MeshFile | None = None
    """The surface, if the piece is not its convex hull."""

    @cached_property
    def solid(self) -> Solid:
        """The piece for `sweep` and `distance`."""
        return Solid(self.piece, self.pos, self.quat)

    @cached_property
    def turn(self) -> Quaternion:
        """Orientation of the piece in the world."""
        return quat_multiply(self.quat, self.piece.quat)

    @property
    def axes(self) -> list[Vec]:
        """Its own x, y and z axis in the world."""
        return list(zip(*quat_to_rows(self.turn), strict=True))  # type: ignore[arg-type]

    @cached_property
    def thickness(self) -> float:
        """Smallest thickness [m]."""
        return self.piece.thickness

    def normals(self) -> list[Vec]:
        """Return the unit normals of the faces of a hull in the world; for more than `MAX_HULL_FACES`, its axes."""
        rows, corners = quat_to_rows(self.turn), self.piece.vertices
        local = list(AXES.values())
        if len(self.piece.faces) <= MAX_HULL_FACES:
            sides = (
                [tuple(q - p for p, q in zip(corners[i], corners[n], strict=True)) for n in (j, k)]
                for i, j, k in self.piece.faces
            )
            local = [vector_cross(a, b) for a, b in sides]
        return [
            vector_unit([a * x + b * y + c * z for a, b, c in rows]) for x, y, z in local if math.hypot(x, y, z) > 0.0
        ]

    @cached_property
    def box(self) -> Bounds:
        """Exact bounding box [m]."""
        (a, b), (c, d), (e, f) = (self.solid.span(axis) for axis in AXES.values())
        return (a, c, e), (b, d, f)

    def lowest(self, up: Vec) -> float:
        """Return the height [m] of the lowest point of the piece along a unit vector."""
        return self.solid.span(up)[0]


class Ground(NamedTuple):
    """A plane: solid below, but only as wide as it is drawn."""

    copy: Copy
    up: Vec
    """Its normal."""
    level: float
    """Height [m] along its normal."""
    half: float
    """Half of its side [m]."""

    def depth(self, part: StandingPart) -> float:
        """Return the depth [m] of the lowest point of a piece below it; negative above."""
        return self.level - part.lowest(self.up)

    def beside(self, point: Vec) -> float:
        """Return how far [m] a point is outside its edge, seen along its normal; negative inside."""
        (a, b, c), (x, y, z) = point, self.copy.pos
        if self.copy.quat != IDENTITY:
            a, b, c = quat_rotate(quat_conjugate(self.copy.quat), (a - x, b - y, c - z))
            return max(abs(a), abs(b)) - self.half
        return max(abs(a - x), abs(b - y)) - self.half


def lowest_of(box: Bounds, up: Vec) -> float:
    """Return the lowest height [m] of a box along a unit vector."""
    return sum(u * (low if u > 0 else high) for u, low, high in zip(up, *box, strict=True))


def near(boxes: list[Bounds], slack: float) -> Iterator[tuple[int, int]]:
    """Yield the index pairs of boxes that are not `apart` by `slack` [m], the smaller index first.

    A grid with cells of twice the median size avoids distant pairs; if thousands of boxes are in one place, only the
    first `MOST_PAIRS` are compared.
    """
    if len(boxes) < 2:
        return
    sizes = sorted(max(sides(box)) for box in boxes)
    cell = 2.0 * sizes[len(sizes) // 2] or sizes[-1] or 1.0
    gap = max(-slack, 0.0)  # between boxes of a pair
    cells: dict[tuple[int, int, int], list[int]] = {}
    large: list[int] = []
    for index, (low, high) in enumerate(boxes):
        ranges = [(int((a - gap) // cell), int((b + gap) // cell)) for a, b in zip(low, high, strict=True)]
        (a, b), (c, d), (e, f) = ranges
        if (b - a + 1) * (d - c + 1) * (f - e + 1) > MANY_CELLS:
            large.append(index)
            continue
        if a == b and c == d and e == f:
            cells.setdefault((a, c, e), []).append(index)
            continue
        for where in product(range(a, b + 1), range(c, d + 1), range(e, f + 1)):
            cells.setdefault(where, []).append(index)
    seen: set[tuple[int, int]] = set()
    looked = 0
    for members in cells.values():
        for k, i in enumerate(members):
            first = boxes[i]
            looked += len(members) - k - 1
            if looked > MOST_PAIRS:
                return
            for j in members[k + 1 :]:
                if not apart(first, boxes[j], slack) and (i, j) not in seen:
                    seen.add((i, j))
                    yield i, j
    alone = set(large)
    for i in large:
        for j in range(len(boxes)):
            if j != i and (j not in alone or j > i) and not apart(boxes[i], boxes[j], slack):
                yield min(i, j), max(i, j)
