"""Bonds: the flat faces at which bodies touch at the start, and how large the shared part is."""

from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree
from shapely import MultiPoint

from text2sim.compiler.action_rows import FaceBond, Origin
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.geometry import pieces, volume
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import quat_multiply, quat_to_rows
from text2sim.spec_schema.models.bodies import Rigid
from text2sim.spec_schema.models.controls import Bond
from text2sim.spec_schema.models.shapes import Plane

Array = np.ndarray

LEAST_COSINE = np.cos(np.radians(1))
"""Of the angle between the one normal and the reverse of the other: faces within 1 deg of each other can be bonded."""
MIN_SHARED = 5e-3
"""Least shared area, over that of a side of a cube of the smaller volume: less is an edge that they have in common."""
FACET = 0.1
"""Smallest area of a face of a hull that is looked at, over the least that is bonded."""
CYLINDER_SIDES = 32
"""Corners of the polygon that stands for the end of a cylinder."""
WIDE = 1e3
"""Half of the side of the square that stands for a plane [m]."""
ROUNDING = 1e-6
"""Distance [m] within which positions agree, for a `gap` of 0."""
COPLANAR = 1e-4
"""Difference of normals, and of heights over the size of a hull, within which triangles are of one face."""


class Face(NamedTuple):
    """A flat convex face in the world."""

    normal: Array
    """Outward unit normal, shape (3,)."""
    corners: Array
    """Corners [m], shape (k, 3), in any order."""
    middle: Array
    """Their mean [m], shape (3,)."""


def face_bonds(control: Bond, copies: Sequence[Copy], folder: Path, origin: Origin) -> list[FaceBond]:
    """Return the bonds among copies that touch, in their order.

    Args:
        control: What bonds them.
        copies: The bodies, each once.
        folder: Folder of the case.
        origin: The control.
    """
    # By volume, so that a slender rod is bonded at its ends, too.
    least = [MIN_SHARED * _volume(copy, folder) ** (2 / 3) for copy in copies]
    faces = [list(_faces_of(copy, folder, FACET * own)) for copy, own in zip(copies, least, strict=True)]
    gap = control.gap + ROUNDING
    found = []
    for i, j in _near(faces, gap):
        if not (_moves(copies[i]) or _moves(copies[j])):
            continue
        opposite = _opposite(faces[i], faces[j], gap)
        shared = [part for one, other in opposite if (part := _shared(one, other)) is not None]
        if sum(part[0] for part in shared) <= min(least[i], least[j]):
            continue
        areas, centers, normals = (np.array(column) for column in zip(*shared, strict=True))
        area, normal = areas.sum(), areas @ normals
        center, normal = areas @ centers / area, normal / max(float(np.linalg.norm(normal)), 1e-12)
        shear = control.strength if control.shear_strength is None else control.shear_strength
        a, b = copies[i].name, copies[j].name
        found.append(FaceBond(a, b, _vec(center), _vec(normal), float(area), control.strength, shear, *origin))
    return found


def _moves(copy: Copy) -> bool:
    return isinstance(copy.model, Rigid) and copy.model.mount.kind != "fixed"


def _volume(copy: Copy, folder: Path) -> float:
    return np.inf if isinstance(copy.shape, Plane) else volume(copy.shape, folder)


def _vec(values: Array) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 7) + 0.0 for value in values)
    return x, y, z


def _near(faces: Sequence[Sequence[Face]], gap: float) -> Iterator[tuple[int, int]]:
    """Yield the pairs of bodies whose bounding boxes are no farther apart than a gap [m]."""
    points = [np.concatenate([face.corners for face in own]) if own else np.full((1, 3), np.nan) for own in faces]
    low, high = (np.array([bound(own, axis=0) for own in points]) for bound in (np.min, np.max))
    for i in range(len(faces)):
        close = (low[i + 1 :] <= high[i] + gap).all(axis=1) & (high[i + 1 :] >= low[i] - gap).all(axis=1)
        yield from ((i, i + 1 + int(j)) for j in np.flatnonzero(close))


def _faces_of(copy: Copy, folder: Path, smallest: float) -> Iterator[Face]:
    """Yield the flat faces of the convex pieces of a copy, in the world; of hulls those of at least `smallest` [m2]."""
    if isinstance(copy.shape, Plane):
        turn = np.array(quat_to_rows(copy.quat)).T
        square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) * WIDE
        yield Face(turn[2], square @ turn[:2] + np.array(copy.pos), np.array(copy.pos))
        return
    for piece in pieces(copy.shape, folder):
        turn = np.array(quat_to_rows(quat_multiply(copy.quat, piece.quat)))
        shift = np.array(quat_to_rows(copy.quat)) @ np.array(piece.pos) + np.array(copy.pos)
        for normal, corners in _own_faces(piece, smallest):
            placed = corners @ turn.T + shift
            yield Face(turn @ normal, placed, placed.mean(axis=0))


def _own_faces(piece: Piece, smallest: float) -> Iterator[tuple[Array, Array]]:
    """Yield normal and corners of each flat face of a piece, in its own frame."""
    if piece.kind == "box":
        half = np.array(piece.size) / 2
        for axis, sign in product(range(3), (-1.0, 1.0)):
            corners = np.array([corner for corner in product((-1.0, 1.0), repeat=3) if corner[axis] == sign])
            yield sign * np.eye(3)[axis], half * corners
    elif piece.kind == "cylinder":
        radius, height = piece.size
        turns = 2 * np.pi * np.arange(CYLINDER_SIDES) / CYLINDER_SIDES
        for sign in (-1.0, 1.0):
            flat = np.full(CYLINDER_SIDES, sign * height / 2)
            ring = np.stack([radius * np.cos(turns), radius * np.sin(turns), flat], axis=1)
            yield np.array([0.0, 0.0, sign]), ring
    elif piece.faces:
        yield from _flat_parts(np.array(piece.vertices), np.array(piece.faces), smallest)


def _flat_parts(vertices: Array, triangles: Array, smallest: float) -> Iterator[tuple[Array, Array]]:
    """Yield normal and corners of the faces of a convex hull, each of one or more triangles."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    whole = sizes > 1e-12
    normals, corners, areas = normals[whole] / sizes[whole, None], triangles[whole], sizes[whole] / 2
    size = float(np.ptp(vertices, axis=0).max())
    offsets = np.einsum("ij,ij->i", normals, a[whole]) / max(size, 1e-12)
    planes = np.concatenate([normals, offsets[:, None]], axis=1)
    left = np.ones(len(planes), bool)
    for k, near in enumerate(KDTree(planes).query_ball_point(planes, COPLANAR)):
        if left[k]:
            same = [one for one in near if left[one]]
            left[same] = False
            if areas[same].sum() >= smallest:
                yield normals[k], vertices[np.unique(corners[same])]


def _axes(normal: Array) -> tuple[Array, Array]:
    """Return two unit vectors that make a right-handed frame with a normal."""
    u = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


def _opposite(ours: Sequence[Face], theirs: Sequence[Face], gap: float) -> Iterator[tuple[Face, Face]]:
    """Yield the pairs of faces of two bodies that lie in one plane, but for a gap [m], and face each other."""
    if not ours or not theirs:
        return
    (normals, middles), (others, their_middles) = (
        (np.array([face.normal for face in own]), np.array([face.middle for face in own])) for own in (ours, theirs)
    )
    away = normals @ their_middles.T - np.einsum("ij,ij->i", normals, middles)[:, None]
    facing = (normals @ others.T <= -LEAST_COSINE) & (np.abs(away) <= gap)
    yield from ((ours[i], theirs[j]) for i, j in np.argwhere(facing).tolist())


def _shared(one: Face, other: Face) -> tuple[float, Array, Array] | None:
    """Return area [m2], centre [m] and normal of what two opposite faces share; None if they do not overlap."""
    origin = one.middle
    away = (other.corners - origin) @ one.normal
    u, v = _axes(one.normal)
    mine, theirs = (MultiPoint((face.corners - origin) @ np.stack([u, v], axis=1)).convex_hull for face in (one, other))
    both = mine.intersection(theirs)
    if not both.area:
        return None
    x, y = both.centroid.coords[0]
    return both.area, origin + x * u + y * v + away.mean() / 2 * one.normal, one.normal
