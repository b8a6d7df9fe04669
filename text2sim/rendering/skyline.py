"""What stands far behind an open place: clouds, hills, the edge of a wood, or a town.

All of it is painted by direction of view, as if infinitely far away: it costs no rays, and it passes behind the scene
as a real horizon does. Angles are in radians.
"""

from collections.abc import Sequence
from functools import cache
from math import ceil

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.noise import fractal_noise, sampled

Array = NDArray[np.floating]

STEPS = 16384
"""Directions around the horizon at which its outline is known."""
TEXELS = 512
WHITE, GREY = np.array([0.985, 0.98, 0.97]), np.array([0.80, 0.835, 0.875])
"""Lit and shaded side of clouds, sRGB."""
CLOUD_COVER, CLOUD_OPACITY = (0.35, 1.7), 0.8
"""Noise at which clouds begin and at which they are dense, in standard deviations; opacity of dense ones."""
LOWEST_CLOUD = (0.02, 0.16)
"""Sines of the elevations between which clouds fade into the haze."""
HILLS, TREES = np.array([0.42, 0.52, 0.50]), np.array([0.25, 0.335, 0.17])
"""Colours without haze, sRGB."""
WALLS = np.array([
    (0.72, 0.66, 0.58), (0.62, 0.45, 0.38), (0.78, 0.76, 0.72),
    (0.55, 0.56, 0.58), (0.68, 0.58, 0.46), (0.66, 0.69, 0.72),
])  # fmt: skip
"""Colours of houses without haze, sRGB."""
ROWS: dict[str, tuple[tuple[str, float, float], ...]] = {
    "wood": (("hills", 0.034, 0.62), ("trees", 0.030, 0.42), ("trees", 0.020, 0.2)),
    "town": (("hills", 0.03, 0.66), ("houses", 0.075, 0.5), ("trees", 0.021, 0.3)),
}
"""From the farthest to the nearest: what stands there, its mean height, and the part of haze in its colour."""
TALLEST, FARTHEST = 2.0, 4
"""Height of the tallest trees and houses over the mean height, with some sky; largest multiple of the distance."""
FOOT = -0.12
"""Elevation at which the nearest row ends in haze. The ground hides that."""


def distance_of(kind: str, tops: Sequence[float]) -> int:
    """Return how many times as far away as usual a horizon is, so that the upper edge of no picture cuts its top off.

    Args:
        kind: One of `ROWS`.
        tops: Elevation of the upper edge of each picture.
    """
    tallest = TALLEST * max(height for _, height, _ in ROWS[kind])
    cut = [top for top in tops if 0.0 < top < tallest]
    return min(ceil(tallest / min(cut)), FARTHEST) if cut else 1


def skyline(kind: str, rays: Array, haze: Array, pixel: float, behind: Array, far: int = 1) -> Array:
    """Paint clouds and a horizon over a sky.

    Args:
        kind: One of `ROWS`.
        rays: Unit vectors of the directions of view, shape (h, w, 3).
        haze: Colour of the haze at the horizon, sRGB.
        pixel: Angle that a pixel covers.
        behind: The sky, sRGB, shape (h, w, 3).
        far: How many times as far away as usual it is.
    """
    sky = _clouded(rays, behind)
    rise = np.arcsin(np.clip(rays[..., 2], -1.0, 1.0))
    tallest = 2.2 * max(height for _, height, _ in ROWS[kind])
    seen = np.flatnonzero(((rise < tallest) & (rise > 2 * FOOT)).any(axis=1))
    if len(seen):
        band = slice(seen[0], seen[-1] + 1)
        turn = far * np.arctan2(rays[band, :, 1], rays[band, :, 0]) / (2 * np.pi)
        for k, (row, height, hazy) in enumerate(ROWS[kind]):
            color, top = _PAINTERS[row](turn, far * rise[band], height, k)
            top = top / far
            cover = np.clip((top - rise[band]) / pixel + 0.5, 0.0, 1.0)
            # Mist gathers at the foot of what is far away.
            misty = np.clip(hazy + 0.25 * (1 - rise[band] / np.maximum(top, 1e-3)), 0.0, 0.9) if k == 0 else hazy
            cover = cover * _smooth(rise[band], *((FOOT, 0.0) if k == len(ROWS[kind]) - 1 else (-pixel, pixel)))
            color = color + (haze - color) * np.broadcast_to(misty, rise[band].shape)[..., None]
            sky[band] += (color - sky[band]) * cover[..., None]
    return sky


def _clouded(rays: Array, behind: Array) -> Array:
    """Return a sky with fair-weather clouds, on a plane above: they flatten towards the horizon."""
    up = rays[..., 2]
    sky = np.array(np.broadcast_to(behind, rays.shape), np.float32)
    seen = np.flatnonzero((up > LOWEST_CLOUD[0]).any(axis=1))
    if not len(seen):
        return sky
    band = slice(seen[0], seen[-1] + 1)
    up = np.maximum(up[band], 0.0)
    x, y = (rays[band, :, k] / (up + 0.1) / 7.0 for k in (0, 1))
    noise = _noise(7, 1.75)
    dense = sampled(noise, x, y)
    cover = _smooth(dense, *CLOUD_COVER) * _smooth(up, *LOWEST_CLOUD) * CLOUD_OPACITY
    lit = _smooth(dense - sampled(noise, x + 0.012, y + 0.006), -0.35, 0.3)[..., None]
    color = GREY + (WHITE - GREY) * (0.35 + 0.65 * lit)
    sky[band] += (color - sky[band]) * cover[..., None]
    return sky


def _hills(turn: Array, rise: Array, height: float, row: int) -> tuple[Array, Array]:
    top = _at(_waves(row, 2, 24, 1.3), turn)
    return np.broadcast_to(HILLS, (*turn.shape, 3)), height * np.maximum(1 + 0.45 * top, 0.25)


def _trees(turn: Array, rise: Array, height: float, row: int) -> tuple[Array, Array]:
    top = height * np.maximum(1 + 0.22 * _at(_waves(row, 3, 60, 0.9), turn) + 0.34 * _at(_crowns(row), turn), 0.2)
    leaves = sampled(_noise(row, 0.9), 60 * turn, rise * 60 / (2 * np.pi))
    # Crowns catch light at their tops and are dark between each other.
    lit = 0.68 + 0.26 * np.clip(rise / np.maximum(top, 1e-3), 0.0, 1.0) + 0.14 * leaves
    return TREES * np.clip(lit, 0.4, 1.5)[..., None], top


def _houses(turn: Array, rise: Array, height: float, row: int) -> tuple[Array, Array]:
    heights, tints, local = _town(row)
    at = (np.mod(turn, 1.0) * STEPS).astype(np.int32) % STEPS
    top = height * heights[at]
    across, up = np.mod(local[at], 1.0), np.mod(rise / 0.0105, 1.0)
    pane = _smooth(np.abs(across - 0.5), 0.34, 0.26) * _smooth(np.abs(up - 0.45), 0.34, 0.26)
    window = pane * (rise < top - 0.006)
    return WALLS[tints[at]] * (1 - 0.42 * window)[..., None], top


_PAINTERS = {"hills": _hills, "trees": _trees, "houses": _houses}
"""Colour (h, w, 3) and top elevation (h, w) of a row, from the fraction of a turn, elevation, mean height, number."""


def _smooth(x: Array, low: float, high: float) -> Array:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _at(outline: Array, turn: Array) -> Array:
    at = np.mod(turn, 1.0) * STEPS
    low = at.astype(np.int32)
    part = at - low
    return outline[low % STEPS] * (1 - part) + outline[(low + 1) % STEPS] * part


@cache
def _noise(seed: int, slope: float) -> Array:
    return fractal_noise(np.random.default_rng(seed), slope, TEXELS).astype(np.float32)


@cache
def _waves(seed: int, lowest: int, highest: int, slope: float) -> Array:
    """Return a periodic outline with waves of a range of frequencies, standard deviation 1, shape (STEPS,)."""
    chance, k = np.random.default_rng(seed + 11), np.arange(STEPS // 2 + 1)
    strength = np.where((k >= lowest) & (k <= highest), np.maximum(k, 1.0) ** -slope, 0.0)
    noise = np.fft.irfft(strength * np.exp(2j * np.pi * chance.random(len(k))), STEPS)
    return noise / noise.std()


@cache
def _crowns(seed: int) -> Array:
    """Return an outline of tree crowns, 0 to about 2, shape (STEPS,)."""
    chance, heights = np.random.default_rng(seed + 23), np.zeros(STEPS)
    for center, half, tall in zip(
        chance.integers(0, STEPS, 900), chance.uniform(9, 34, 900), chance.uniform(0.5, 1.9, 900), strict=True
    ):
        span = np.arange(-int(half), int(half) + 1)
        where = (center + span) % STEPS
        heights[where] = np.maximum(heights[where], tall * np.sqrt(np.maximum(1 - (span / half) ** 2, 0.0)))
    ragged = chance.standard_normal(STEPS)
    return heights + 0.12 * np.convolve(np.r_[ragged[-3:], ragged, ragged[:3]], np.ones(7) / 7, "valid")


@cache
def _town(seed: int) -> tuple[Array, NDArray[np.int32], Array]:
    """Return for each direction the height of its house, its colour, and the position along its windows."""
    chance = np.random.default_rng(seed + 37)
    heights, tints, local = np.zeros(STEPS), np.zeros(STEPS, np.int32), np.zeros(STEPS)
    start, before = 0, -1
    while start < STEPS:
        wide = int(chance.uniform(70, 210))
        tint = int(chance.choice([k for k in range(len(WALLS)) if k != before]))
        span = slice(start, min(start + wide, STEPS))
        heights[span], tints[span] = chance.uniform(0.5, 1.45), tint
        columns = max(round(wide / 22), 1)
        local[span] = columns * np.arange(span.stop - start) / wide
        start, before = start + wide, tint
    return heights, tints, local


def blurred(picture: Array, sigma: float) -> Array:
    """Return a picture (h, w, 3) as a lens shows it that is focused on something near; `sigma` is in pixels."""
    from scipy.ndimage import gaussian_filter

    return picture if sigma < 0.3 else gaussian_filter(picture, (sigma, sigma, 0), mode="nearest")
