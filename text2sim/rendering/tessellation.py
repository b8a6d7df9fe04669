"""Finer triangles for cloth, whose points are too far apart to look like cloth.

Phong tessellation (Boubekeur and Alexa 2008): each edge gets a point where the arc through its ends would be that has
their normals. Recorded points stay where they are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from text2sim.templates.shading import smooth_normals

Array = NDArray[np.floating]
Indices = NDArray[np.integer]

MAX_TRIANGLES = 60_000
"""Most triangles of a finer surface."""
MAX_LEVELS = 2
ARC = 0.5
"""Part of the way to the tangent planes that lies on a circle, for small angles."""
MAX_RISE = 0.12
"""Largest distance of a new point from its edge, as a share of the edge: normals at creases tell little."""


@dataclass(frozen=True)
class _Level:
    ends: Indices
    """Ends of the edges, shape (e, 2)."""
    faces: Indices
    """The finer triangles, four for each in turn, shape (4 f, 3)."""


class Tessellation:
    """Splits each triangle into 4 or 16, or leaves a fine mesh as it is.

    Args:
        faces: Triangles, shape (f, 3).
        places: Number of the place of each vertex, shape (n,): vertices in one place share it.
    """

    def __init__(self, faces: Indices, places: Indices):
        self._faces, self._places, self._levels = faces.astype(np.int64), places, list[_Level]()
        count, now = len(places), self._faces
        while len(self._levels) < MAX_LEVELS and 4 * len(now) <= MAX_TRIANGLES:
            sides = np.sort(now[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
            ends, number = np.unique(sides, axis=0, return_inverse=True)
            ab, bc, ca = (count + number.reshape(-1, 3)).T
            a, b, c = now.T
            corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
            now = np.stack([np.stack(corner, axis=1) for corner in corners], axis=1).reshape(-1, 3)
            self._levels.append(_Level(ends, now))
            count += len(ends)

    @property
    def faces(self) -> Indices:
        """The finer triangles, those of each coarse one in turn."""
        return self._levels[-1].faces if self._levels else self._faces

    def each(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return for each finer triangle whether the coarse one is marked that it is a part of, from shape (f,)."""
        return np.repeat(values, 4 ** len(self._levels))

    def between(self, values: Array) -> Array:
        """Return values at the finer vertices, interpolated linearly, from an array of shape (n, k)."""
        for level in self._levels:
            values = np.concatenate([values, values[level.ends].mean(axis=1)])
        return values

    def unit(self, normals: Array) -> Array:
        """Return unit normals at the finer vertices, shape (m, 3), from those at the coarse ones, shape (n, 3)."""
        finer = self.between(normals.astype(float))
        return finer / np.maximum(np.linalg.norm(finer, axis=1, keepdims=True), 1e-9)

    def vertices(self, vertices: Array) -> Array:
        """Return the finer vertices [m], shape (m, 3), for coarse ones at these places [m], shape (n, 3)."""
        count = int(self._places.max(initial=-1)) + 1
        corners = self._places[self._faces].ravel()
        normals = smooth_normals(vertices[self._faces], corners, count)[self._places].astype(float)
        for level in self._levels:
            (a, b), (at_a, at_b) = (np.moveaxis(values[level.ends], 1, 0) for values in (vertices, normals))
            edge = b - a
            lean_a, lean_b = ((edge * n).sum(axis=1, keepdims=True) for n in (at_a, at_b))
            rise = ARC / 4 * (lean_b * at_b - lean_a * at_a)
            most = MAX_RISE * np.linalg.norm(edge, axis=1, keepdims=True)
            rise *= np.minimum(1.0, most / np.maximum(np.linalg.norm(rise, axis=1, keepdims=True), 1e-12))
            middle = at_a + at_b
            middle /= np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-9)
            vertices, normals = np.concatenate([vertices, (a + b) / 2 + rise]), np.concatenate([normals, middle])
        return vertices
