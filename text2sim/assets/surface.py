"""Triangle meshes with one vertex per position, and texture coordinates and colours per corner of a triangle.

A vertex on a seam of the texture has several texture coordinates. Because they belong to corners, holes, flipped and
duplicate triangles can be found and repaired on the shape alone.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Paint:
    """Appearance of a part of a surface."""

    rgba: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    """Colour, each channel in 0..1; multiplies the picture."""
    picture: Any = None
    """Texture (a PIL image) for `uv`."""
    metallic: float = 0.0
    roughness: float = 0.9


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle mesh, z up."""

    vertices: Array
    """Positions [m], (n, 3) float."""
    faces: Array
    """Triangles, counterclockwise from outside, (m, 3) int."""
    part: Array
    """Index of each triangle's paint, (m,) int."""
    paints: tuple[Paint, ...]
    uv: Array | None = None
    """Texture coordinates of the corners, (m, 3, 2) float."""
    rgba: Array | None = None
    """Colours of the corners, (m, 3, 4) uint8."""

    @property
    def extent(self) -> Array:
        """Lengths along x, y and z [m]."""
        return np.ptp(self.used, axis=0)

    @cached_property
    def used(self) -> Array:
        """Vertices of triangles, (k, 3)."""
        return self.vertices[np.unique(self.faces)]

    @property
    def diagonal(self) -> float:
        """Diagonal [m] of its bounding box."""
        return float(np.linalg.norm(self.extent))

    @property
    def flat(self) -> bool:
        """Whether it is planar, like a cloth or a picture, whose border is not a hole."""
        middle = self.used - self.used.mean(axis=0)
        return bool(np.sqrt(np.linalg.eigvalsh(middle.T @ middle / len(middle))[0].clip(0)) < 1e-6 * self.diagonal)

    def keep(self, faces: Array) -> "TriangleMesh":
        """Return the surface with some of its triangles, by indices or a mask."""
        return replace(
            self,
            faces=self.faces[faces],
            part=self.part[faces],
            uv=None if self.uv is None else self.uv[faces],
            rgba=None if self.rgba is None else self.rgba[faces],
        )

    def flip(self, mask: Array) -> "TriangleMesh":
        """Return the surface with some triangles flipped."""

        def turned(values: Array) -> Array:
            values = values.copy()
            values[mask] = values[mask][:, ::-1]
            return values

        return replace(
            self,
            faces=turned(self.faces),
            uv=None if self.uv is None else turned(self.uv),
            rgba=None if self.rgba is None else turned(self.rgba),
        )

    @cached_property
    def edge_counts(self) -> tuple[int, int]:
        """Numbers of edges with one triangle, and with more than two."""
        _, counts = np.unique(self._edge_keys(directed=False), return_counts=True)
        return int((counts == 1).sum()), int((counts > 2).sum())

    @cached_property
    def coherent(self) -> bool:
        """Whether neighbours face the same side: no two triangles have an edge in the same direction."""
        keys = self._edge_keys(directed=True)
        return len(np.unique(keys)) == len(keys)

    def _edge_keys(self, *, directed: bool) -> Array:
        """A number for each edge of each triangle, (3 m,), the same for equal edges."""
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        first, second = edges.T if directed else np.sort(edges, axis=1).T
        return first * (len(self.vertices) + 1) + second

    @property
    def watertight(self) -> bool:
        """Whether every edge has exactly two triangles, and neighbours face the same side."""
        return len(self.faces) > 0 and self.edge_counts == (0, 0) and self.coherent

    @cached_property
    def components(self) -> tuple[int, Array]:
        """Number of connected pieces, and the piece of each triangle, (m,)."""
        labels = connected(self.faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(self.vertices))
        names, own = np.unique(labels[self.faces[:, 0]], return_inverse=True)
        return len(names), own

    def volumes(self) -> Array:
        """Return the signed volume [m3] of each piece relative to its centre; exact if it is closed."""
        count, own = self.components
        corners = self.vertices[self.faces]
        weight = np.bincount(own, minlength=count)[:, None]
        middle = np.stack([np.bincount(own, corners.mean(1)[:, k], count) for k in range(3)], axis=1) / weight
        corners = corners - middle[own][:, None]
        return np.bincount(own, signed_volumes(corners), count)

    @cached_property
    def area_vectors(self) -> Array:
        """Outward normals of the triangles, as long as twice their areas [m2], (m, 3)."""
        return scaled_normals(self.vertices[self.faces])

    def areas(self) -> Array:
        """Return the area [m2] of each triangle."""
        return np.linalg.norm(self.area_vectors, axis=1) / 2

    def corner_of_vertices(self) -> Array:
        """Return the index of a corner of each vertex in the list of all corners, (n,); 0 for unused vertices."""
        corner = np.zeros(len(self.vertices), np.int64)
        corner[self.faces.reshape(-1)] = np.arange(3 * len(self.faces))
        return corner

    def diagonals_of_components(self) -> Array:
        """Return the diagonals [m] of the bounding boxes of the pieces, (c,)."""
        low, high = self.bounds_of_components()
        return np.linalg.norm(high - low, axis=1)

    def bounds_of_components(self) -> tuple[Array, Array]:
        """Return the lower and upper bounds [m] of the pieces, each (c, 3)."""
        count, own = self.components
        corners = self.vertices[self.faces]
        low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(low, own, corners.min(1))
        np.maximum.at(high, own, corners.max(1))
        return low, high


def unit_rows(vectors: Array) -> Array:
    """Return vectors (..., k) at unit length; those without a length stay so."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def scaled_normals(corners: Array) -> Array:
    """Return the normals of triangles (m, 3, 3), as long as twice their areas, (m, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def triangle_areas(corners: Array) -> Array:
    """Return the areas of triangles (m, 3, 3), (m,)."""
    return np.linalg.norm(scaled_normals(corners), axis=1) / 2


def signed_volumes(corners: Array) -> Array:
    """Return the volumes between triangles (m, 3, 3) and the origin, negative where they face it, (m,)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.einsum("ij,ij->i", a, np.cross(b, c)) / 6


def connected(pairs: Array, count: int) -> Array:
    """Return for each of `count` points a number that all points have to which pairs (p, 2) connect it, from 0."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), (count, count))
    return connected_components(graph, directed=False)[1]


def welded(surface: TriangleMesh, tolerance: float) -> TriangleMesh:
    """Return a surface whose vertices within a tolerance [m] of each other are merged."""
    from scipy.spatial import KDTree

    vertices, inverse = np.unique(surface.vertices + 0.0, axis=0, return_inverse=True)
    faces = inverse.reshape(-1)[surface.faces]
    if tolerance > 0:
        pairs = KDTree(vertices).query_pairs(tolerance, output_type="ndarray")
        label = connected(pairs, len(vertices))
        first = np.unique(label, return_index=True)[1]
        vertices, faces = vertices[first], label[faces]
    used, faces = np.unique(faces, return_inverse=True)
    return replace(surface, vertices=vertices[used], faces=faces.reshape(-1, 3).astype(np.int64))
