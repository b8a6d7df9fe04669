"""Surfaces that follow points: every vertex is a fixed linear combination of nearby points."""

import numpy as np

NEIGHBOURS = 32  # number of points that carry a vertex of a solid
REACH = 2.0  # radius of the weight function, in units of the points' spacing
STIFFENING = 1e-3  # regularises the fit of a vertex whose points lie in a plane
DISTANCES = 2**22  # number of distances computed at once


class Skin:
    """Vertices that follow points.

    Args:
        points: Indices of the points that carry each vertex, shape (s, k).
        weights: Weights of these points, shape (s, k); each row adds up to 1.
    """

    def __init__(self, points: np.ndarray, weights: np.ndarray):
        self._points, self._weights = points, weights[:, None].astype(np.float32)

    def __len__(self) -> int:
        return len(self._points)

    def __call__(self, positions: np.ndarray) -> np.ndarray:
        """Returns the vertices [m], shape (s, 3), for points at `positions` [m], shape (p, 3)."""
        return (self._weights @ positions.astype(np.float32, copy=False).take(self._points, axis=0))[:, 0]


def follow_solid(vertices: np.ndarray, points: np.ndarray, spacing: float) -> Skin:
    """Returns the skin of a solid that is filled with points, by moving least squares.

    A vertex moves with the affine map that fits its nearest points best, weighted by distance. If these points lie in a
    plane, the map across it is undetermined; a small regularisation keeps the weights bounded.

    Args:
        vertices: Vertices of the surface at rest [m], shape (s, 3).
        points: Points at rest [m], shape (p, 3).
        spacing: Distance of neighbouring points [m].
    """
    near = nearest(vertices, points, min(NEIGHBOURS, len(points)))
    arms = (points[near] - vertices[:, None]) / spacing
    share = np.exp(-(arms**2).sum(axis=2) / REACH**2)
    share /= share.sum(axis=1, keepdims=True)
    basis = np.concatenate([np.ones((*near.shape, 1)), arms], axis=2)
    moments = np.einsum("ski,sk,skj->sij", basis, share, basis) + STIFFENING * np.diag([0.0, 1.0, 1.0, 1.0])
    at_vertex = np.broadcast_to(np.eye(4)[:, :1], (len(near), 4, 1))
    return Skin(near, share * np.einsum("ski,si->sk", basis, np.linalg.solve(moments, at_vertex)[..., 0]))


def follow_sheet(vertices: np.ndarray, points: np.ndarray, faces: np.ndarray) -> Skin:
    """Returns a skin whose vertices are attached to the nearest triangles of a sheet at rest.

    Args:
        vertices: Vertices of the surface at rest [m], shape (s, 3).
        points: Corners of the triangles at rest [m], shape (p, 3).
        faces: Triangles as indices of points, shape (f, 3).
    """
    corners = faces.ravel()
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(points))
    starts = np.cumsum(counts) - counts
    columns = np.arange(counts.max())
    # The triangles of each point, padded with the first one.
    around = order[np.minimum(starts, len(order) - 1)[:, None] + np.where(columns < counts[:, None], columns, 0)] // 3
    near = nearest(vertices, points, min(6, len(points)))
    triangles = np.where((counts[near] > 0)[:, :, None], around[near], around[near[:, :1]]).reshape(len(vertices), -1)
    shares, distance = _closest(vertices[:, None], *np.moveaxis(points[faces[triangles]], 2, 0))
    best = distance.argmin(axis=1)
    rows = np.arange(len(vertices))
    return Skin(faces[triangles[rows, best]], shares[rows, best])


def nearest(vertices: np.ndarray, points: np.ndarray, k: int) -> np.ndarray:
    """Returns the indices of the k points nearest to each vertex, shape (s, k), in no particular order.

    Args:
        vertices: Positions [m], shape (s, 3).
        points: Positions [m], shape (p, 3).
        k: Number of points for each vertex.
    """
    step = max(1, DISTANCES // len(points))
    middle = points.mean(axis=0)
    vertices, points = vertices - middle, points - middle  # far from the origin the difference below would cancel
    squares = (points**2).sum(axis=1)
    parts = [np.zeros((0, k), int)]
    for start in range(0, len(vertices), step):
        distances = squares - 2 * vertices[start : start + step] @ points.T
        parts.append(np.argpartition(distances, k - 1, axis=1)[:, :k])
    return np.concatenate(parts)


def _closest(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns barycentric coordinates of the point of each triangle abc closest to p, and its squared distance."""
    ab, ac, ap = b - a, c - a, p - a
    dab, dac, dbc = (ab * ab).sum(-1), (ac * ac).sum(-1), (ab * ac).sum(-1)
    pab, pac = (ap * ab).sum(-1), (ap * ac).sum(-1)
    area = np.maximum(dab * dac - dbc**2, 1e-30)
    v, w = (dac * pab - dbc * pac) / area, (dab * pac - dbc * pab) / area
    inside = np.stack([1 - v - w, v, w], axis=-1)
    zero = np.zeros_like(v)

    def along(start, edge):
        return np.clip(((p - start) * edge).sum(-1) / np.maximum((edge * edge).sum(-1), 1e-30), 0.0, 1.0)

    x, y, z = along(a, ab), along(b, c - b), along(c, a - c)
    edges = [(1 - x, x, zero), (zero, 1 - y, y), (z, zero, 1 - z)]
    shares = np.stack([inside, *(np.stack(edge, axis=-1) for edge in edges)])
    spots = shares[..., :1] * a + shares[..., 1:2] * b + shares[..., 2:] * c
    distances = ((spots - p) ** 2).sum(-1)
    distances[0][(inside < 0).any(axis=-1)] = np.inf
    best = distances.argmin(axis=0)[None]
    return np.take_along_axis(shares, best[..., None], 0)[0], np.take_along_axis(distances, best, 0)[0]
