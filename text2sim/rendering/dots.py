"""Dots on curved surfaces: each lies in the tangent plane at its centre, so that no seam of a pattern cuts it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from text2sim.assets.surface import scaled_normals
from text2sim.templates.patterns import contrast

Array = NDArray[np.floating]

RADIUS, SPACING = 0.36, 1.25
"""Radius of a dot and least distance of two, in units of the pattern's size."""
MAX_EDGE = 1.0
"""Longest edge of a mesh that is fine enough, in the same units."""
MAX_DOTS, CANDIDATES = 3000, 12
"""Largest number of dots, and number of random points for each."""
MIN_COSINE = 0.4
"""Smallest cosine of the angle between triangles of one dot: there are none across edges."""
PIXELS = 128


class Dotted(NamedTuple):
    """A mesh with texture coordinates for dots."""

    vertices: NDArray[np.integer]
    """Index of the original vertex of each vertex, shape (n,)."""
    faces: NDArray[np.integer]
    """Triangles, shape (f, 3)."""
    uvs: Array
    """Texture coordinates [m], shape (n, 2); the tile of `dot_picture` is 2 sizes wide."""


def dotted(vertices: Array, faces: NDArray[np.integer], size: float) -> Dotted | None:
    """Scatter dots over a mesh, evenly and always in the same way; None if its triangles are too large for that.

    Args:
        vertices: Vertices [m], shape (n, 3).
        faces: Triangles, shape (f, 3).
        size: Size of the pattern [m].
    """
    corners = vertices[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    longest = float(np.percentile(edges, 99))
    if longest > MAX_EDGE * size:
        return None
    # A triangle may meet one dot at most; its corners are less than two thirds of its longest edge from its centre.
    reach = RADIUS * size + 2 / 3 * longest
    normals = scaled_normals(corners)
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas[:, None], 1e-30)
    middles = corners.mean(axis=1)
    points, owners = _spread(corners, areas, max(SPACING * size, 2 * reach))
    around = KDTree(middles).query_ball_point(points, reach)
    kept = [(normals[near] @ normals[k]).min(initial=1.0) > MIN_COSINE for near, k in zip(around, owners, strict=True)]
    if not any(kept):
        return None
    centers, up = points[kept], normals[owners[kept]]
    away, nearest = KDTree(centers).query(middles)
    within = away < reach
    right = np.cross(up, np.eye(3)[np.abs(up).argmin(axis=1)])
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    ahead = np.cross(up, right)
    offsets = corners - centers[nearest][:, None]
    uvs = np.stack([(offsets * axis[nearest][:, None]).sum(axis=2) for axis in (right, ahead)], axis=2) + size
    uvs[~within] = 0.0  # a corner of the tile, which is transparent
    rows = np.column_stack([faces.ravel(), np.round(uvs.reshape(-1, 2) * 1e7).astype(np.int64)])
    own, first, index = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return Dotted(own[:, 0], index.reshape(-1, 3), uvs.reshape(-1, 2)[first])


def dot_picture(color: tuple[float, ...] | None, own: tuple[float, ...]) -> Array:
    """Return the tile with one dot in its middle: sRGB with alpha, 0 to 1, shape (h, w, 4).

    Args:
        color: Colour of the dot, sRGB; None: contrasts with the body.
        own: Colour of the body, sRGB.
    """
    across = (np.arange(PIXELS) + 0.5) * 2 / PIXELS - 1
    away = np.hypot(across[None], across[:, None])
    picture = np.empty((PIXELS, PIXELS, 4))
    picture[..., :3] = color or contrast(own)
    picture[..., 3] = np.clip((RADIUS - away) * PIXELS / 4 + 0.5, 0.0, 1.0)
    return picture


def _spread(corners: Array, areas: Array, spacing: float) -> tuple[Array, NDArray[np.integer]]:
    """Return random points (k, 3) of a surface that keep a distance, and the triangle of each."""
    chance = np.random.default_rng(7)
    wanted = min(max(int(areas.sum() / 2 / spacing**2), 1), MAX_DOTS)
    owners = chance.choice(len(areas), CANDIDATES * wanted, p=areas / areas.sum())
    u, v = np.sort(chance.random((2, len(owners))), axis=0)
    a, b, c = np.moveaxis(corners[owners], 1, 0)
    points = u[:, None] * a + (v - u)[:, None] * b + (1 - v)[:, None] * c
    near, free, chosen = KDTree(points), np.ones(len(points), bool), []
    for k, point in enumerate(points):
        if free[k]:
            chosen.append(k)
            free[near.query_ball_point(point, spacing)] = False
    return points[chosen], owners[chosen]
