"""Quaternions (w, x, y, z) on arrays of vectors."""

import numpy as np

from text2sim.recording.chunks import Array


def rotate(quat: Array, vectors: Array) -> Array:
    """Turn vectors (..., 3) by quaternions (..., 4), (w, x, y, z)."""
    w, u = quat[..., :1], quat[..., 1:]
    twice = 2.0 * np.cross(u, vectors)
    return vectors + w * twice + np.cross(u, twice)


def rotate_back(quat: Array, vectors: Array) -> Array:
    """Turn vectors (..., 3) by the inverses of quaternions (..., 4): from the world into the frame."""
    return rotate(quat * np.array([1.0, -1.0, -1.0, -1.0]), vectors)
