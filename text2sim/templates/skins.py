"""Surfaces that follow points: every vertex is a fixed combination of points near it."""

import numpy as np

NEIGHBOURS = 32  # points that carry a vertex of a solid
REACH = 2.0  # of a point's weight, in distances between points
STIFFENING = 1e-3  # what keeps a vertex in place where its points lie in a plane
DISTANCES = 2**22  # that are looked at together


class Skin:
    """Vertices that follow points.

    Args:
        points: Indices of the points that carry each vertex, shape (s, k).
        weights: Their weights, shape (s, k); they add up to 1.
    """

    def __init__(self, points: np.ndarray, weights: np.ndarray):
        self._points, self._weights = points, weights[:, None].astype(np.float32)

    def __len__(self) -> int:
        return len(self._points)

    def __call__(self, positions: np.ndarray) -> np.ndarray:
        """Returns where the vertices are, shape (s, 3), when the points are at `positions`, shape (p, 3)."""
        return (self._weights @ positions.astype(np.float32, copy=False).take(self._points, axis=0))[:, 0]


def follow_solid(vertices: np.ndarray, points: np.ndarray, spacing: float) -> Skin:
    """Returns the skin of a solid that is filled with points `spacing` apart, by moving least squares.

    A vertex goes where the affine map goes that fits its nearest points best, the nearer the more. Where these lie in
    a plane the fit across it is open, and a little stiffness closes it, without which weights would grow without bound.

    Args:
        vertices: Of the surface at rest, shape (s, 3) [m].
        points: At rest, shape (p, 3) [m].
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
    """Returns a skin whose vertices lie on the triangles of a sheet, where these are nearest to them at rest.

    Args:
        vertices: Of the surface at rest, shape (s, 3) [m].
        points: Corners of the triangles at rest, shape (p, 3) [m].
        faces: Triangles over the points, shape (f, 3).
    """
    corners = faces.ravel()
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(points))
    starts = np.cumsum(counts) - counts
    columns = np.arange(counts.max())
    # The triangles of each point; a shorter list is filled up with its first.
    around = order[np.minimum(starts, len(order) - 1)[:, None] + np.where(columns < counts[:, None], columns, 0)] // 3
    near = nearest(vertices, points, min(6, len(points)))
    triangles = np.where((counts[near] > 0)[:, :, None], around[near], around[near[:, :1]]).reshape(len(vertices), -1)
    shares, distance = _closest(vertices[:, None], *np.moveaxis(points[faces[triangles]], 2, 0))
    best = distance.argmin(axis=1)
    rows = np.arange(len(vertices))
    return Skin(faces[triangles[rows, best]], shares[rows, best])


def nearest(vertices: np.ndarray, points: np.ndarray, k: int) -> np.ndarray:
    """Returns the indices of the points nearest to each vertex, shape (s, k), in no particular order.

    Args:
        vertices: Positions [m], shape (s, 3).
        points: Positions [m], shape (p, 3).
        k: Number of points for each vertex.
    """
    step = max(1, DISTANCES // len(points))
    squares = (points**2).sum(axis=1)
    parts = [np.zeros((0, k), int)]
    for start in range(0, len(vertices), step):
        distances = squares - 2 * vertices[start : start + step] @ points.T
        parts.append(np.argpartition(distances, k - 1, axis=1)[:, :k])
    return np.concatenate(parts)


def _closest(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the point of each triangle abc that is closest to p: its shares of a, b, c, and its distance squared."""
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
