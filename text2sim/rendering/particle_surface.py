"""Surfaces around particles: of liquids, and of the inside of what has torn."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

SMOOTHING_LENGTH, CUBE_SIZE = 2.5, 0.8
"""Reach of a particle and edge of the cells of a liquid's surface, in particle radii."""
SMOOTHING_ITERATIONS = 15
"""Smoothing iterations of a liquid's surface."""


def liquid_surface(points: Array, radius: float, threshold: float = 0.5) -> tuple[Array, NDArray[np.integer]]:
    """Return vertices (n, 3) [m] and triangles (f, 3) of the surface around particles.

    Args:
        points: Particles [m].
        radius: Their radius [m].
        threshold: Density of the surface, relative to that inside: the larger, the deeper it lies.
    """
    import pysplashsurf

    made, _ = pysplashsurf.reconstruction_pipeline(
        np.ascontiguousarray(points, np.float32),
        particle_radius=radius,
        smoothing_length=SMOOTHING_LENGTH,
        cube_size=CUBE_SIZE,
        iso_surface_threshold=threshold,
        mesh_smoothing_weights=True,
        mesh_smoothing_iters=SMOOTHING_ITERATIONS,
        mesh_cleanup=True,
    )
    mesh: Any = made.mesh
    return np.asarray(mesh.vertices, float), np.asarray(mesh.triangles, np.int64)
