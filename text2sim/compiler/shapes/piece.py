"""Pieces, which every shape becomes for contact: convex, except exact meshes."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.distance_field import DistanceField
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    Quaternion,
    Vec,
    frame_apply,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    vector_cross,
    vector_minus,
)
from text2sim.spec_schema.models.shapes import Cup, Funnel, Tube

if TYPE_CHECKING:
    import numpy as np

Ball = tuple[Vec, float]
"""Centre and radius [m]."""
CONE_SIDES = 32

WEDGE_FACES = (
    (0, 3, 2), (0, 2, 1), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
    (2, 3, 7), (2, 7, 6), (1, 2, 6), (1, 6, 5), (0, 4, 7), (0, 7, 3),
)  # fmt: skip
"""Triangles of a wedge. Its corners: inner and outer at its first side, outer and inner at its second; bottom first."""


@dataclass(frozen=True)
class Piece:
    """A convex solid in its body's frame (`mesh`: what the engine makes of a file, or an exact surface)."""

    kind: str
    """box, sphere, cylinder, capsule, ellipsoid, hull or mesh."""
    pos: Vec = ORIGIN
    """[m]; hulls keep the body's frame."""
    quat: Quaternion = IDENTITY
    size: tuple[float, ...] = ()
    """Box: full lengths; sphere: radius; cylinder: radius, height; capsule: radius, straight length;
    ellipsoid: half lengths [m]; mesh: scale."""
    vertices: tuple[Vec, ...] = ()
    """Corners [m] of a hull (or of a mesh's convex hull, scaled), in the piece's frame."""
    faces: tuple[tuple[int, int, int], ...] = ()
    """Triangles of a hull, counterclockwise from outside."""
    file: str | None = None
    """Of a mesh: path inside the case's folder."""
    enclosed: float = 0.0
    """Of a mesh: volume [m3] that its surface encloses; 0 if it is open, so that its convex hull counts."""
    collision: str = "hull"
    """Of a mesh: `hull`, `decompose` (touches by several convex pieces) or `exact` (by its surface)."""
    field: DistanceField | None = None
    """Of an exact mesh: the grid of its distances."""
    part: str | None = None
    """Of a compound: name of the part."""

    @cached_property
    def ball(self) -> Ball:
        """Centre [m] and radius [m] of a ball around the piece, in the body's frame."""
        size = self.size
        if self.kind in ("hull", "mesh"):
            n = len(self.vertices)
            sx, sy, sz = (sum(axis) / n for axis in zip(*self.vertices, strict=True))
            center = (sx, sy, sz)
            radius = max(math.dist(center, v) for v in self.vertices)
            return frame_apply(self.pos, self.quat, center), radius
        if self.kind == "box":
            return self.pos, math.hypot(*size) / 2
        if self.kind == "cylinder":
            return self.pos, math.hypot(size[0], size[1] / 2)
        if self.kind == "capsule":
            return self.pos, size[0] + size[1] / 2
        return self.pos, max(size)

    @cached_property
    def turned(self) -> dict[Quaternion, Any]:
        """What other modules derive from the piece by orientation of its body, kept here since copies share pieces."""
        return {}

    def at(self, pos: Vec, quat: Quaternion, part: str | None = None) -> "Piece":
        """Return the piece in the frame around (`pos`, `quat`).

        Args:
            pos: Origin of the piece's present frame in the other one [m].
            quat: Orientation of that frame (w, x, y, z).
            part: Name of its part of the body; stays as it is if None.
        """
        part = part or self.part
        if self.kind == "hull":
            return replace(self, vertices=tuple(frame_apply(pos, quat, v) for v in self.vertices), part=part)
        if quat == IDENTITY:
            return replace(self, pos=frame_apply(pos, quat, self.pos), part=part)
        return replace(self, pos=frame_apply(pos, quat, self.pos), quat=quat_multiply(quat, self.quat), part=part)

    def volume(self) -> float:
        """Return the volume [m3] of the piece, from which the mass follows."""
        return self._volume

    @cached_property
    def thickness(self) -> float:
        """Smallest thickness [m] of the piece, which a fast body may jump over."""
        if self.kind == "box":
            return min(self.size)
        if self.kind == "cylinder":
            return min(2 * self.size[0], self.size[1])
        if self.field is not None:
            return self.field.wall
        if self.kind == "mesh":
            # The edges of a scanned hull say nothing about how thick it is.
            return min(max(axis) - min(axis) for axis in zip(*self.vertices, strict=True))
        if self.kind == "hull":
            return min(_widths(self), default=0.0)
        return 2 * min(self.size[:1] if self.kind == "capsule" else self.size)

    @cached_property
    def _volume(self) -> float:
        size = self.size
        if self.kind == "box":
            return size[0] * size[1] * size[2]
        if self.kind == "sphere":
            return 4 / 3 * math.pi * size[0] ** 3
        if self.kind == "cylinder":
            return math.pi * size[0] ** 2 * size[1]
        if self.kind == "capsule":
            return math.pi * size[0] ** 2 * size[1] + 4 / 3 * math.pi * size[0] ** 3
        if self.kind == "ellipsoid":
            return 4 / 3 * math.pi * size[0] * size[1] * size[2]
        if self.enclosed:
            return self.enclosed
        total = 0.0
        for i, j, k in self.faces:
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.vertices[i], self.vertices[j], self.vertices[k]
            total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        return total / 6


def hull_piece(vertices: "np.ndarray", faces: "np.ndarray") -> Piece:
    """Return a hull with these corners (n, 3) [m] and triangles (m, 3)."""
    corners = tuple((x, y, z) for x, y, z in vertices.tolist())
    return Piece("hull", vertices=corners, faces=tuple((a, b, c) for a, b, c in faces.tolist()))


def wall_radii(shape: Tube | Cup | Funnel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the inner and outer radius [m] of a round wall at its bottom and at its top."""
    if isinstance(shape, Tube):
        return (shape.inner_radius, shape.outer_radius), (shape.inner_radius, shape.outer_radius)
    if isinstance(shape, Cup):
        return (shape.radius - shape.thickness, shape.radius), (shape.radius - shape.thickness, shape.radius)
    low, high = shape.bottom_radius, shape.top_radius
    return (low, low + shape.thickness), (high, high + shape.thickness)


def outer_polygon_radius(outer: float, inner: float, segments: int) -> float:
    """Return the radius [m] of the corners of a wall's outer polygon.

    The inner polygon goes round the inner circle, so that the free space never shrinks; the outer one lies in the
    outer circle, so that the body never grows. Only where a stave would have less than half the thickness in its
    middle does the outer polygon grow, and then just enough.

    Args:
        outer: Outer radius of the wall [m].
        inner: Inner radius of the wall [m].
        segments: Staves around it.
    """
    return max(outer, (inner + (outer - inner) / 2) / math.cos(math.pi / segments))


def wall_pieces(
    bottom: tuple[float, float], top: tuple[float, float], low: float, high: float, segments: int
) -> list[Piece]:
    """Return the staves of a wall around z: wedges with eight corners that meet at their sides.

    Args:
        bottom: Inner and outer radius [m] at the height `low`.
        top: Inner and outer radius [m] at the height `high`.
        low: Lower end [m].
        high: Upper end [m].
        segments: How many staves.
    """
    widen = 1 / math.cos(math.pi / segments)
    rings = [
        (inner * widen, outer_polygon_radius(outer, inner, segments), z)
        for (inner, outer), z in ((bottom, low), (top, high))
    ]
    angles = [2 * math.pi * k / segments for k in range(segments)]
    turns = [(math.cos(a), math.sin(a)) for a in angles]
    turns.append(turns[0])
    staves = []
    for (c0, s0), (c1, s1) in pairwise(turns):
        corners: list[Vec] = []
        for inner, outer, z in rings:
            corners += [(inner * c0, inner * s0, z), (outer * c0, outer * s0, z)]
            corners += [(outer * c1, outer * s1, z), (inner * c1, inner * s1, z)]
        staves.append(Piece("hull", vertices=tuple(corners), faces=WEDGE_FACES))
    return staves


def cone_piece(radius: float, height: float, top: float = 0.0) -> Piece:
    """Return a cone about the middle of its axis, tip up, as a pyramid inside it.

    Args:
        radius: Of the base [m].
        height: Height [m].
        top: Radius of the upper end [m]; 0 for a tip.
    """
    n = CONE_SIDES
    turns = [(math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n)) for k in range(n)]
    rim = [(radius * x, radius * y, -height / 2) for x, y in turns]
    base = [(0, k + 1, k) for k in range(1, n - 1)]
    if top == 0.0:
        sides = [(k, (k + 1) % n, n) for k in range(n)]
        return Piece("hull", vertices=(*rim, (0.0, 0.0, height / 2)), faces=(*sides, *base))
    sides = [face for k in range(n) for face in ((k, (k + 1) % n, n + k), ((k + 1) % n, n + (k + 1) % n, n + k))]
    lid = [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    return Piece(
        "hull", vertices=(*rim, *((top * x, top * y, height / 2) for x, y in turns)), faces=(*sides, *base, *lid)
    )


def ring_pieces(radius: float, bar: float, segments: int) -> list[Piece]:
    """Return a ring about z as capsules, whose joints lie on the circle.

    Args:
        radius: Of the circle at the middle of the bar [m].
        bar: Radius of the bar [m].
        segments: Capsules around the ring.
    """
    points = [
        (radius * math.cos(2 * math.pi * k / segments), radius * math.sin(2 * math.pi * k / segments))
        for k in range(segments)
    ]
    chord = 2 * radius * math.sin(math.pi / segments)
    lying = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)  # z onto y: tangent at angle 0
    pieces = []
    for k in range(segments):
        (ax, ay), (bx, by) = points[k], points[(k + 1) % segments]
        half = math.pi * (2 * k + 1) / segments / 2
        yaw = (math.cos(half), 0.0, 0.0, math.sin(half))
        middle = ((ax + bx) / 2, (ay + by) / 2, 0.0)
        pieces.append(Piece("capsule", pos=middle, quat=quat_multiply(yaw, lying), size=(bar, chord)))
    return pieces


def piece_reach(piece: Piece, direction: Vec) -> float:
    """Return the reach [m] of a piece along a unit vector in its body's frame: the largest `direction . x` in it."""
    u = direction if piece.quat == IDENTITY else quat_rotate(quat_conjugate(piece.quat), direction)
    size = piece.size
    if piece.kind in ("hull", "mesh"):
        own = max(a * u[0] + b * u[1] + c * u[2] for a, b, c in piece.vertices)
    elif piece.kind == "box":
        own = sum(side * abs(c) for side, c in zip(size, u, strict=True)) / 2
    elif piece.kind == "cylinder":
        own = size[0] * math.hypot(u[0], u[1]) + size[1] / 2 * abs(u[2])
    elif piece.kind == "capsule":
        own = size[0] + size[1] / 2 * abs(u[2])
    elif piece.kind == "ellipsoid":
        own = math.hypot(*(r * c for r, c in zip(size, u, strict=True)))
    else:
        own = size[0]
    return own + sum(p * c for p, c in zip(piece.pos, direction, strict=True))


def _widths(piece: Piece) -> Iterator[float]:
    """Yield the widths [m] of a hull across each of its faces."""
    corners = piece.vertices
    for a, b, c, *_ in piece.faces:
        u, v, w = vector_cross(vector_minus(corners[b], corners[a]), vector_minus(corners[c], corners[a]))
        size = math.hypot(u, v, w)
        if size > 0.0:
            heights = [u * x + v * y + w * z for x, y, z in corners]
            yield (max(heights) - min(heights)) / size
