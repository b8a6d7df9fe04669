"""Tileable fractal noise for textures and skies."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def fractal_noise(chance: np.random.Generator, slope: float, size: int) -> Array:
    """Return tileable noise with a spectrum of 1 / f^slope, mean 0 and standard deviation 1, shape (size, size).

    Args:
        chance: Source of randomness.
        slope: Exponent of the amplitude spectrum; larger values give smoother noise.
        size: Texels along each side.
    """
    f = np.fft.fftfreq(size) * size
    distance = np.maximum(np.hypot(f[None], f[:, None]), 2.0)
    noise = np.fft.ifft2(np.fft.fft2(chance.standard_normal((size, size))) / distance**slope).real
    noise -= noise.mean()
    return noise / noise.std()


def sampled(tile: Array, x: Array, y: Array) -> Array:
    """Return a tile's values at points, interpolated linearly; the tile has length 1 and repeats.

    Args:
        tile: Tileable values, shape (size, size).
        x: Positions along the columns, any shape.
        y: Positions along the rows, the same shape.
    """
    size = len(tile)
    u, v = np.mod(x, 1.0) * size, np.mod(y, 1.0) * size
    i, j = u.astype(np.int32), v.astype(np.int32)
    u, v = (u - i).astype(tile.dtype), (v - j).astype(tile.dtype)
    i, j = i % size, j % size
    k, m = (i + 1) % size, (j + 1) % size
    return (tile[j, i] * (1 - u) + tile[j, k] * u) * (1 - v) + (tile[m, i] * (1 - u) + tile[m, k] * u) * v
