"""Tearing: the pieces into which a body of particles has come apart.

In mpm only particles less than about two grid cells apart interact: those farther from all others have separated,
whatever their material. Pieces are the connected components of that relation.
"""

from functools import lru_cache

import numpy as np

from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array

MAX_TIED_DISTANCE = 2 / 0.64
"""Two cells, in distances of particles."""
FIRST_TRIED_DISTANCE = 1.8
"""A shorter distance to try first, in distances of particles: most bodies are in one piece by it."""
MIN_PIECE_SHARE = 0.01
"""Least part of a body that counts as a piece; less is a few lost particles."""


@lru_cache(maxsize=8)
def pieces(body: RecordedDeformable) -> tuple[Array, Array]:
    """Return the number of pieces of at least 1 % of a body, and the fraction of the largest one, both of shape (F,).

    All particles of a body have the same mass.
    """
    if body.solver != "mpm":  # elements stay connected
        return np.ones(len(body.points)), np.ones(len(body.points))
    counts, largest = [], []
    for points in body.points:
        sizes = _sizes(points.astype(float), body.spacing) / len(points)
        counts.append(max(int((sizes >= MIN_PIECE_SHARE).sum()), 1))
        largest.append(float(sizes.max()))
    return np.array(counts, float), np.array(largest)


def _sizes(points: Array, spacing: float) -> Array:
    """Return the number of points in each piece."""
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return np.ones(1)
    label = _labels(points, FIRST_TRIED_DISTANCE * spacing)
    sizes = np.bincount(label)
    if len(sizes) == 1:
        return sizes
    return np.bincount(_labels(points, MAX_TIED_DISTANCE * spacing))


def _labels(points: Array, reach: float) -> Array:
    """Return the index of the piece of each point."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    pairs = KDTree(points).query_pairs(reach, output_type="ndarray")
    ties = coo_matrix((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    return connected_components(ties, directed=False)[1]
