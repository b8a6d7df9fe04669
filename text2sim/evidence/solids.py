"""Rigid shapes as solids, with signed distances of points."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from text2sim.assets.surface import scaled_normals
from text2sim.recording.states import Array

MAX_COMPARED_PAIRS = 1_000_000
"""Largest number of pairs of a point and a triangle that are compared at once."""
SURFACE_SAMPLES = 20_000
"""Number of points that sample the surface of a mesh that is not convex."""
CONVEX_TOLERANCE = 1e-4
"""Distance by which corners of a convex mesh may lie outside a face, as a fraction of the mesh's size."""


@dataclass(frozen=True, eq=False)
class LinkSolid:
    """A solid in the frame of its link."""

    kind: str
    """plane (all below z = 0), box, sphere, cylinder, capsule, hull, or surface (a mesh that is not convex)."""
    pos: Array
    """Origin of its own frame [m], shape (3,)."""
    turn: Array
    """Rotation matrix of its own frame, shape (3, 3)."""
    size: tuple[float, ...] = ()
    """Box: full lengths; sphere: radius; cylinder: radius, height; capsule: radius, straight length [m]."""
    vertices: Array | None = None
    """Vertices of a hull or surface, in its own frame [m], shape (n, 3)."""
    faces: Array | None = None
    """Triangles, shape (m, 3)."""
    part: str = ""
    """Part of a compound that it belongs to."""

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest corner in its own frame [m]; infinite for a plane."""
        if self.vertices is not None:
            return self.vertices.min(axis=0), self.vertices.max(axis=0)
        if self.kind == "plane":
            return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
        radius, *length = self.size
        straight = sum(length) / 2  # 0 for a sphere
        if self.kind == "box":
            half = np.array(self.size) / 2
        elif self.kind == "cylinder":
            half = np.array([radius, radius, straight])
        else:
            half = np.array([radius, radius, radius + straight])
        return -half, half

    def least(self, points: Array) -> tuple[Array, Array]:
        """Return a lower bound of the signed distance [m] of points (n, 3), and a mask of where it is exact, (n,).

        Points are in the solid's own frame; distances are negative inside.
        """
        if self.kind == "hull":
            normals, offsets = self._planes
            height = (normals @ points.T - offsets[:, None]).max(axis=0)
            return height, height <= 0.0
        if self.kind == "surface":
            return self.distance(points), np.ones(len(points), bool)
        return _EXACT[self.kind](self.size, points), np.ones(len(points), bool)

    def distance(self, points: Array) -> Array:
        """Return the signed distance [m] of points (n, 3) from the surface, (n,); negative inside.

        For a non-convex mesh it is that of the nearest of many points sampled on its surface.
        """
        if self.kind == "surface":
            tree, normals = self._samples
            far, near = tree.query(points)
            side = ((points - np.asarray(tree.data)[near]) * normals[near]).sum(axis=1)
            return np.where(side < 0, -far, far)
        bound, exact = self.least(points)
        outside = np.flatnonzero(~exact)
        if len(outside):
            bound[outside] = _to_triangles(points[outside], self.vertices[self.faces])  # type: ignore[index]
        return bound

    @cached_property
    def _planes(self) -> tuple[Array, Array]:
        """Outward normals (m, 3) and offsets (m,) of the faces of a hull."""
        corners = self.vertices[self.faces]  # type: ignore[index]
        a, normal = corners[:, 0], scaled_normals(corners)
        size = np.linalg.norm(normal, axis=1)
        normal, a = normal[size > 0] / size[size > 0, None], a[size > 0]
        middle = self.vertices.mean(axis=0)  # type: ignore[union-attr]
        offset = (normal * a).sum(axis=1)
        flip = np.where(normal @ middle > offset, -1.0, 1.0)
        rows = np.column_stack([normal * flip[:, None], offset * flip])
        _, first = np.unique(np.round(rows, 9), axis=0, return_index=True)
        return rows[first, :3], rows[first, 3]

    @cached_property
    def _samples(self) -> tuple[Any, Array]:
        from scipy.spatial import KDTree

        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))  # type: ignore[index]
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        count = np.maximum(1, np.ceil(SURFACE_SAMPLES * area / max(area.sum(), 1e-30)).astype(int))
        owner = np.repeat(np.arange(len(a)), count)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        # Low-discrepancy points in the triangle: additive recurrence of the plastic number, folded.
        u, v = (0.5 + number * 0.7548776662) % 1, (0.5 + number * 0.5698402910) % 1
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        points = a[owner] + u[:, None] * (b - a)[owner] + v[:, None] * (c - a)[owner]
        return KDTree(points), (normal / np.maximum(area, 1e-30)[:, None])[owner]


def solid_of_mesh(vertices: Array, faces: Array) -> LinkSolid | None:
    """Return a mesh as a solid in the frame of its link; None if it has no volume."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import, and rarely needed

    if not len(vertices) or not np.isfinite(vertices).all():
        return None
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        return None
    if not len(faces) or is_convex(vertices, faces):
        try:
            hull = ConvexHull(vertices)
        except (QhullError, ValueError):  # flat
            return None
        return LinkSolid("hull", np.zeros(3), np.eye(3), (), vertices, hull.simplices)
    return LinkSolid("surface", np.zeros(3), np.eye(3), (), vertices, faces)


def is_convex(vertices: Array, faces: Array) -> bool:
    """Return whether no vertex lies outside the plane of any face."""
    a, normal = vertices[faces[:, 0]], scaled_normals(vertices[faces])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.maximum(size, 1e-30)
    out = max(
        float((normal[k : k + 256] @ vertices.T - (normal * a).sum(axis=1)[k : k + 256, None]).max())
        for k in range(0, len(faces), 256)
    )
    return out <= CONVEX_TOLERANCE * float(np.ptp(vertices, axis=0).max())


# --- signed distances of points (n, 3) in the solid's own frame ----------------------


def _box(size: tuple[float, ...], points: Array) -> Array:
    away = np.abs(points) - np.array(size) / 2
    return np.linalg.norm(np.maximum(away, 0.0), axis=1) + np.minimum(away.max(axis=1), 0.0)


def _cylinder(size: tuple[float, ...], points: Array) -> Array:
    away = np.column_stack([np.hypot(points[:, 0], points[:, 1]) - size[0], np.abs(points[:, 2]) - size[1] / 2])
    return np.linalg.norm(np.maximum(away, 0.0), axis=1) + np.minimum(away.max(axis=1), 0.0)


def _capsule(size: tuple[float, ...], points: Array) -> Array:
    beyond = np.maximum(np.abs(points[:, 2]) - size[1] / 2, 0.0)
    return np.sqrt(points[:, 0] ** 2 + points[:, 1] ** 2 + beyond**2) - size[0]


_EXACT = {
    "plane": lambda size, points: points[:, 2].copy(),
    "box": _box,
    "sphere": lambda size, points: np.linalg.norm(points, axis=1) - size[0],
    "cylinder": _cylinder,
    "capsule": _capsule,
}


def _to_triangles(points: Array, triangles: Array) -> Array:
    """Return the distance [m] of points (n, 3) to the nearest of triangles (m, 3, 3), shape (n,)."""
    found = np.empty(len(points))
    block = max(1, MAX_COMPARED_PAIRS // max(1, len(triangles)))
    for first in range(0, len(points), block):
        p = points[first : first + block, None]
        nearest = np.full((len(p), len(triangles)), np.inf)
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        normal = scaled_normals(triangles)
        size = np.linalg.norm(normal, axis=1)
        over = np.ones(nearest.shape, bool)
        for start, end in ((a, b), (b, c), (c, a)):
            side, away = end - start, p - start
            along = np.clip((away * side).sum(axis=2) / np.maximum((side * side).sum(axis=1), 1e-30), 0.0, 1.0)
            nearest = np.minimum(nearest, ((away - along[..., None] * side) ** 2).sum(axis=2))
            over &= (away * np.cross(normal, side)).sum(axis=2) >= 0
        height = ((p - a) * normal).sum(axis=2) / np.maximum(size, 1e-30)
        nearest = np.where(over & (size > 0), np.minimum(nearest, height**2), nearest)
        found[first : first + block] = np.sqrt(nearest.min(axis=1))
    return found
