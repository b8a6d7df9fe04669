"""Surfaces of deformable bodies for drawing: normals, parts and tears, and which particles can be seen."""

from pathlib import Path

import numpy as np

SMOOTH = np.cos(np.radians(40.0))  # cosine of the largest angle between triangles that are shaded as one surface
SAME_PLACE = 1e-4  # distance of centers below which triangles are the same [m]
LETS_GO = 2 / 0.64  # gap of two cells of the mpm grid, in particle spacings; particles farther apart do not interact


class Shell:
    """Triangles for drawing, with smooth normals except across sharp edges of the surface at rest.

    A vertex on a sharp edge is drawn once for each side of it.

    Args:
        vertices: Vertices at rest [m], shape (n, 3).
        faces: Shape (f, 3).

    Attributes:
        sources: Index of the vertex behind each drawn one, shape (m,).
        faces: Triangles as indices of drawn vertices, shape (f, 3).
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self._own, self._rest = faces, _lengths(vertices, faces)
        # Vertices in one place count as one, even if their texture coordinates differ.
        places = np.unique(np.round(vertices, 7), axis=0, return_inverse=True)[1].ravel()[faces]
        side = _sides(vertices, faces, places)
        corners = np.stack([faces.ravel(), np.repeat(side, 3)], axis=1)
        drawn, first, own = np.unique(corners, axis=0, return_index=True, return_inverse=True)
        self.sources, self.faces = drawn[:, 0], own.reshape(-1, 3).astype(np.int32)
        spots = np.stack([places.ravel(), np.repeat(side, 3)], axis=1)
        _, spots = np.unique(spots, axis=0, return_inverse=True)
        self._corner_spot, self._drawn_spot = spots.ravel(), spots.ravel()[first]

    def normals(self, vertices: np.ndarray) -> np.ndarray:
        """Return unit normals of the drawn vertices, shape (m, 3), for vertices at these places [m], shape (n, 3)."""
        triangles = vertices[self.sources][self.faces]
        return smooth_normals(triangles, self._corner_spot, len(self.sources))[self._drawn_spot]

    def whole(self, vertices: np.ndarray, gap: float) -> np.ndarray:
        """Return which triangles are whole, shape (f,): no edge is longer than at rest by `gap` [m] or more.

        A body of particles has torn where an edge is.
        """
        return (_lengths(vertices, self._own) < self._rest + gap).all(axis=1)


def part_of_triangles(regions: Path, vertices: np.ndarray, faces: np.ndarray, pos, quat) -> np.ndarray:
    """Return the index of the part whose look each triangle has, shape (f,); -1 stands for the body's own look.

    Args:
        regions: File with the centers of triangles in the body's frame [m], and their parts.
        vertices: Vertices at rest in the world [m], shape (n, 3).
        faces: Shape (f, 3).
        pos: Initial position of the body's frame [m].
        quat: Initial orientation of the body's frame (w, x, y, z).
    """
    w, u = quat[0], -np.asarray(quat[1:], float)  # the inverse rotation
    arms = vertices[faces].mean(axis=1) - pos
    own = arms + 2 * np.cross(u, np.cross(u, arms) + w * arms)
    with np.load(regions) as file:
        centers, parts = file["centers"].astype(float), file["parts"]
    if centers.shape == own.shape and np.abs(centers - own).max() < SAME_PLACE:
        return parts
    # Some solvers mesh the body anew: take the part of the nearest center.
    found = np.empty(len(own), int)
    step = max(1, 2**22 // len(centers))
    for first in range(0, len(own), step):
        some = own[first : first + step]
        found[first : first + step] = ((centers**2).sum(axis=1) - 2 * some @ centers.T).argmin(axis=1)
    return parts[found]


def _lengths(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


def smooth_normals(triangles: np.ndarray, spots: np.ndarray, count: int) -> np.ndarray:
    """Return a unit normal for each spot, shape (count, 3): upward where its triangles cancel out.

    Args:
        triangles: Corners, shape (f, 3, 3).
        spots: Spot of each corner, shape (3 f,).
        count: Number of spots.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    leaning = np.repeat(np.cross(b - a, c - a), 3, axis=0)  # twice the area, so large triangles count more
    total = np.stack([np.bincount(spots, leaning[:, i], count) for i in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])
    return np.where(length > 1e-20, total / np.maximum(length, 1e-20), up).astype(np.float32)


def enclosed(points: np.ndarray, edge: float) -> np.ndarray:
    """Return which points are surrounded, shape (n,): the 26 cells of side `edge` [m] around their own hold points."""
    cells = np.floor((points - points.min(axis=0)) / edge).astype(np.int64) + 1
    size = cells.max(axis=0) + 2
    steps = np.array([size[1] * size[2], size[2], 1])
    keys = cells @ steps
    taken, mine = np.unique(keys, return_inverse=True)
    around = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ steps
    spots = np.searchsorted(taken, taken[:, None] + around).clip(max=len(taken) - 1)
    return (taken[spots] == taken[:, None] + around).all(axis=1)[mine.ravel()]


def _sides(vertices: np.ndarray, faces: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return labels, shape (f,), equal for triangles that are connected without a sharp edge between them."""
    a, b, c = np.moveaxis(vertices[faces].astype(float), 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    ends = np.sort(places[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    pairs = np.stack([order[:-1], order[1:]], axis=1)[same] // 3
    pairs = pairs[(normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1) > SMOOTH]
    label = np.arange(len(faces))
    while True:
        low = label[pairs].min(axis=1)
        new = label.copy()
        for side in pairs.T:
            np.minimum.at(new, label[side], low)  # join the roots as well, which needs fewer rounds
            np.minimum.at(new, side, low)
        new = new[new]
        if (new == label).all():
            return label
        label = new
