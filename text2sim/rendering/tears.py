"""Tears in the skin of an mpm body."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from text2sim.evidence import tearing
from text2sim.rendering.particle_surface import liquid_surface
from text2sim.templates.soft_states import SoftStates

Array = NDArray[np.floating]
Torn = NDArray[np.bool_] | None

SUPPORTED, LIFTED = 1.5, 0.6
"""Distance [particle distances] from its particles at which the skin has torn, and by how much it has grown since the
start: in thin parts and at sharp corners it is larger from the beginning."""
BELOW_SKIN, FLUSH = 0.75, 0.5
"""Density at which torn faces are drawn: a bit below the skin, or, around pieces that are cut off, level with it."""
UNDER = 8
"""Number of particles below a vertex that have to be of one piece."""


class Tears:
    """Where the skin of a body is open, and what shows there.

    Args:
        vertices: Vertices of the skin at rest [m], shape (n, 3).
        particles: Particles at rest [m], shape (p, 3).
        spacing: Their distance [m].
    """

    def __init__(self, vertices: Array, particles: Array, spacing: float):
        self._spacing, self._rest = spacing, particles
        away, self._under = KDTree(particles).query(vertices, min(UNDER, len(particles)))
        self._away = away.reshape(len(vertices), -1)[:, 0] / spacing
        self._ties: NDArray[np.integer] | None = None

    def held(self, vertices: Array, particles: Array, torn: Torn) -> NDArray[np.bool_]:
        """Return below which vertices of the skin there are particles of one piece that have not torn, shape (n,).

        Args:
            vertices: Vertices [m].
            particles: Particles [m].
            torn: Which of them have torn; None if the material knows of no tears.
        """
        away = KDTree(particles).query(vertices)[0] / self._spacing
        near = (away <= SUPPORTED) | (away <= self._away + LIFTED)
        if torn is None or not torn.any():
            return near
        under = np.where(torn, -1, self._pieces(particles, torn))[self._under].reshape(len(vertices), -1)
        return near & (under[:, 0] >= 0) & (under == under[:, :1]).all(axis=1)

    def inside(self, particles: Array, torn: Torn) -> tuple[Array, NDArray[np.integer]]:
        """Return vertices (n, 3) [m] and triangles (f, 3) of a surface just below the skin, around each piece.

        Args:
            particles: Particles [m].
            torn: Which of them have torn, or None.
        """
        piece, density = np.zeros(len(particles), int), BELOW_SKIN
        if torn is not None and torn.any():
            density, piece = FLUSH, self._pieces(particles, torn)
            crumbs = np.bincount(piece) < tearing.MIN_PIECE_SHARE * len(piece)
            piece[crumbs[piece]] = -1
        around = [liquid_surface(particles[piece == one], self._spacing / 2, density) for one in np.unique(piece)]
        starts = np.cumsum([0, *(len(vertices) for vertices, _ in around)])
        faces = [faces + start for (_, faces), start in zip(around, starts[:-1], strict=True)]
        return np.concatenate([vertices for vertices, _ in around]), np.concatenate(faces)

    def _pieces(self, particles: Array, torn: NDArray[np.bool_]) -> NDArray[np.integer]:
        if self._ties is None:
            self._ties = tearing.neighbours(self._rest, self._spacing)
        return tearing.labels(particles, torn, self._ties, self._spacing)


def nearest(vertices: Array, points: Array) -> NDArray[np.integer]:
    """Return the index of the vertex (n, 3) nearest to each point (m, 3), shape (m,)."""
    return np.asarray(KDTree(vertices).query(points)[1])


def torn_at(states: SoftStates, row: dict, around: tuple[int, int, float]) -> Torn:
    """Return which particles of a body have torn between two frames, shape (p,); None if none of the run can tear.

    Args:
        states: The recorded states.
        row: The body's row of the layout.
        around: The two frames, and the fraction between them.
    """
    try:
        return states.at("soft_torn", around)[slice(*row["points"])] >= 0.5
    except KeyError:
        return None
