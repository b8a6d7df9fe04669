"""Triangle meshes as the tools for assets change them: shape apart from paint, every corner of space once.

A vertex on a seam has several places in a picture, so that places and colours belong to the corners of triangles. What
is open, twisted or double can then be seen, and repaired, on the shape alone.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Paint:
    """What a part of a surface is made of, to the eye."""

    rgba: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    """Each channel in 0..1; what a picture is multiplied by."""
    picture: Any = None
    """A picture (of PIL) that `uv` refers to."""
    metallic: float = 0.0
    roughness: float = 0.9


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle mesh, z up."""

    vertices: Array
    """(n, 3) float [m]"""
    faces: Array
    """(m, 3) int, counterclockwise from outside"""
    part: Array
    """(m,) int: which of `paints`"""
    paints: tuple[Paint, ...]
    uv: Array | None = None
    """(m, 3, 2) float: place of each corner in the picture"""
    rgba: Array | None = None
    """(m, 3, 4) uint8: colour of each corner, where the file has such"""

    @property
    def extent(self) -> Array:
        """Lengths along x, y and z [m]."""
        return np.ptp(self.used, axis=0)

    @cached_property
    def used(self) -> Array:
        """The vertices that some triangle has, (k, 3)."""
        return self.vertices[np.unique(self.faces)]

    @property
    def diagonal(self) -> float:
        """Length [m] of the diagonal of its bounds."""
        return float(np.linalg.norm(self.extent))

    @property
    def flat(self) -> bool:
        """Whether it lies in a plane: a cloth or a picture, with an edge that is no hole."""
        middle = self.used - self.used.mean(axis=0)
        return bool(np.sqrt(np.linalg.eigvalsh(middle.T @ middle / len(middle))[0].clip(0)) < 1e-6 * self.diagonal)

    def keep(self, faces: Array) -> "TriangleMesh":
        """Return the surface with some of its triangles: numbers, or a mask."""
        return replace(
            self,
            faces=self.faces[faces],
            part=self.part[faces],
            uv=None if self.uv is None else self.uv[faces],
            rgba=None if self.rgba is None else self.rgba[faces],
        )

    def flip(self, mask: Array) -> "TriangleMesh":
        """Return the surface with some triangles turned around."""

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

    def move(self, vertices: Array) -> "TriangleMesh":
        """Return the surface with its vertices elsewhere."""
        return replace(self, vertices=vertices)

    @cached_property
    def edge_counts(self) -> tuple[int, int]:
        """How many edges belong to one triangle alone, and how many to more than two."""
        edges = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, counts = np.unique(edges[:, 0] * (len(self.vertices) + 1) + edges[:, 1], return_counts=True)
        return int((counts == 1).sum()), int((counts > 2).sum())

    @cached_property
    def coherent(self) -> bool:
        """Whether neighbours face the same side: no edge is run through twice in one direction."""
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        keys = edges[:, 0] * (len(self.vertices) + 1) + edges[:, 1]
        return len(np.unique(keys)) == len(keys)

    @property
    def watertight(self) -> bool:
        """Whether every edge belongs to exactly two triangles, and neighbours face the same side."""
        return len(self.faces) > 0 and self.edge_counts == (0, 0) and self.coherent

    @cached_property
    def components(self) -> tuple[int, Array]:
        """How many pieces there are that hang together, and to which each triangle belongs, (m,)."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        size = len(self.vertices)
        pairs = self.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
        graph = coo_matrix((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), (size, size))
        _, labels = connected_components(graph, directed=False)
        names, own = np.unique(labels[self.faces[:, 0]], return_inverse=True)
        return len(names), own

    def volumes(self) -> Array:
        """Return the signed volume [m3] of each piece, about its own middle; exact where it is closed."""
        count, own = self.components
        corners = self.vertices[self.faces]
        weight = np.bincount(own, minlength=count)[:, None]
        middle = np.stack([np.bincount(own, corners.mean(1)[:, k], count) for k in range(3)], axis=1) / weight
        corners = corners - middle[own][:, None]
        parts = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
        return np.bincount(own, parts, count)

    def areas(self) -> Array:
        """Return the area [m2] of each triangle."""
        corners = self.vertices[self.faces]
        return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)

    def bounds_of_components(self) -> tuple[Array, Array]:
        """Return lowest and highest corners [m] of the pieces, each (c, 3)."""
        count, own = self.components
        corners = self.vertices[self.faces]
        low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(low, own, corners.min(1))
        np.maximum.at(high, own, corners.max(1))
        return low, high


def welded(surface: TriangleMesh, tolerance: float) -> TriangleMesh:
    """Return a surface in which vertices that are nearer to each other than a tolerance [m] are one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    vertices, inverse = np.unique(surface.vertices + 0.0, axis=0, return_inverse=True)
    faces = inverse.reshape(-1)[surface.faces]
    if tolerance > 0:
        pairs = KDTree(vertices).query_pairs(tolerance, output_type="ndarray")
        size = len(vertices)
        graph = coo_matrix((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), (size, size))
        count, label = connected_components(graph, directed=False)
        first = np.full(count, size)
        np.minimum.at(first, label, np.arange(size))
        vertices, faces = vertices[first], label[faces]
    used, faces = np.unique(faces, return_inverse=True)
    return replace(surface, vertices=vertices[used], faces=faces.reshape(-1, 3).astype(np.int64))
