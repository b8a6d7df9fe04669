"""Tearing: the pieces into which a body of particles has come apart.

In mpm only particles less than about two grid cells apart interact: those farther from all others have separated,
whatever their material. Pieces are the connected components of that relation. In a body with a `tear_stretch` those
that were neighbours at the start are connected, until one of them has torn: what touches does not grow together.
"""

from functools import lru_cache

import numpy as np

from text2sim.assets.surface import connected
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array

MAX_TIED_DISTANCE = 2 / 0.64
"""Two cells, in distances of particles."""
FIRST_TRIED_DISTANCE = 1.8
"""A shorter distance to try first, in distances of particles: most bodies are in one piece by it."""
NEIGHBOURS_WITHIN = 1.5
"""Distance of neighbours at rest, in distances of particles: the shortest ties do not reach across a cut."""
MIN_PIECE_SHARE = 0.01
"""Least part of a body that counts as a piece; less is a few lost particles."""


@lru_cache(maxsize=8)
def pieces(body: RecordedDeformable) -> tuple[Array, Array]:
    """Return the number of pieces of at least 1 % of a body, and the fraction of the largest one, both of shape (F,).

    All particles of a body have the same mass.
    """
    if body.solver != "mpm":  # elements stay connected
        return np.ones(len(body.points)), np.ones(len(body.points))
    counts, largest, torn, ties = [], [], body.torn, None
    if torn is not None and torn.any():
        ties = neighbours(body.rest, body.spacing)
    for k, points in enumerate(body.points):
        if ties is None or torn is None:
            sizes = _sizes(points.astype(float), body.spacing) / len(points)
        else:
            sizes = np.bincount(labels(points.astype(float), torn[k], ties, body.spacing)) / len(points)
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


def neighbours(rest: Array, spacing: float) -> Array:
    """Return the pairs of particles that are neighbours at rest, shape (n, 2).

    Args:
        rest: Particles at rest [m], shape (p, 3).
        spacing: Their distance [m].
    """
    from scipy.spatial import KDTree

    return KDTree(rest).query_pairs(NEIGHBOURS_WITHIN * spacing, output_type="ndarray")


def labels(points: Array, torn: Array, ties: Array, spacing: float) -> Array:
    """Return the index of the piece of each particle, shape (p,); what has torn belongs to the nearest that has not.

    Args:
        points: Particles [m], shape (p, 3).
        torn: Which of them have torn, shape (p,).
        ties: Those that were neighbours, from `neighbours`.
        spacing: Their distance at rest [m].
    """
    from scipy.spatial import KDTree

    sound = ~torn & np.isfinite(points).all(axis=1)
    if not sound.any():
        return np.zeros(len(points), int)
    first, second = ties[sound[ties].all(axis=1)].T
    near = np.linalg.norm(points[first] - points[second], axis=1) < MAX_TIED_DISTANCE * spacing
    piece = connected(np.stack([first, second], axis=1)[near], len(points))
    lost = np.flatnonzero(~sound & np.isfinite(points).all(axis=1))
    piece[lost] = piece[sound][KDTree(points[sound]).query(points[lost])[1]]
    return np.unique(piece, return_inverse=True)[1]


def _labels(points: Array, reach: float) -> Array:
    """Return the index of the piece of each point."""
    from scipy.spatial import KDTree

    return connected(KDTree(points).query_pairs(reach, output_type="ndarray"), len(points))
