"""Floors of places as procedural textures: slabs with joints, boards, tiles, asphalt, grass.

Textures are tileable, and their mean is the colour of the floor.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from text2sim.rendering.noise import fractal_noise
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.tone import linear

Array = NDArray[np.floating]

TEXELS = 1024
PATCH_TEXELS, PATCH_LENGTH = 512, 7.3
"""Texels of the map of patches, and the length after which it repeats in lengths of the texture."""


class FloorPattern(NamedTuple):
    """Parameters of a floor pattern."""

    tiles: int
    """Number of tiles along each side of the texture."""
    roughness: float
    specular: float
    contrast: float
    """Standard deviation of its brightness, relative to the mean."""
    patches: float = 0.0
    """Range of its brightness from patch to patch, relative to the mean; a patch is larger than the texture."""
    tint: tuple[float, float, float] = (1.15, 1.0, 0.9)
    """How much patches differ in red, green and blue: dark ones of grass are less dry, of earth overgrown."""


SURFACES = {
    "polished": FloorPattern(4, 0.32, 0.45, 0.008),
    "slabs": FloorPattern(4, 0.5, 0.3, 0.045),
    "boards": FloorPattern(8, 0.42, 0.35, 0.06),
    "tiles": FloorPattern(8, 0.3, 0.4, 0.02),
    "asphalt": FloorPattern(2, 0.85, 0.2, 0.10, 0.22),
    "earth": FloorPattern(2, 0.95, 0.1, 0.15, 0.55, (1.4, 1.0, 1.5)),
    "grass": FloorPattern(2, 0.95, 0.1, 0.22, 0.42),
    "sand": FloorPattern(4, 0.95, 0.1, 0.07, 0.12),
}
PLAIN = "polished"


def floor_material(pattern: str, color: tuple[float, float, float], tile: float) -> Any:
    """Return the material of a floor whose texture coordinates are in metres.

    Args:
        pattern: One of `SURFACES`; an unknown one is drawn plain.
        color: Colour, sRGB from 0 to 1.
        tile: Spacing of joints [m].
    """
    surface = SURFACES.get(pattern, SURFACES[PLAIN])
    length = surface.tiles * tile
    values = texture(pattern) * linear(np.asarray(color, float))
    if not surface.patches:
        return mitsuba().load_dict({"type": "twosided", "bsdf": _coat(surface, values, length)})
    light, dark = (1 + sign * surface.patches / 2 * np.array(surface.tint) for sign in (1, -1))
    where = 0.5 + 0.22 * fractal_noise(np.random.default_rng(5), 1.05, PATCH_TEXELS)[..., None]
    return mitsuba().load_dict({
        "type": "twosided",
        "bsdf": {
            "type": "blendbsdf",
            "weight": _bitmap(np.clip(where, 0.0, 1.0), PATCH_LENGTH * length),
            "light": _coat(surface, values * light, length),
            "dark": _coat(surface, values * dark, length),
        },
    })  # fmt: skip


def _coat(surface: FloorPattern, values: Array, length: float) -> dict[str, Any]:
    return {
        "type": "principled",
        "base_color": _bitmap(np.clip(values, 0.0, 0.95), length),
        "roughness": surface.roughness,
        "specular": surface.specular,
    }


def _bitmap(values: Array, length: float) -> dict[str, Any]:
    """Return a texture that repeats after a length [m]."""
    mi = mitsuba()
    return {
        "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(values, np.float32)), "raw": True,
        "to_uv": mi.ScalarTransform3f().scale([1 / length, 1 / length]),
    }  # fmt: skip


@cache
def texture(pattern: str) -> Array:
    """Return factors on a floor's linear colour, with mean 1, shape (TEXELS, TEXELS, 3)."""
    surface = SURFACES.get(pattern, SURFACES[PLAIN])
    chance = np.random.default_rng(sum(pattern.encode()))
    across, along = np.meshgrid(np.arange(TEXELS), np.arange(TEXELS))
    size = TEXELS // surface.tiles
    tint = np.ones(3)
    if pattern in ("slabs", "tiles"):
        each = chance.normal(0, 0.035 if pattern == "slabs" else 0.012, (surface.tiles, surface.tiles))
        tones = 1 + surface.contrast * fractal_noise(chance, 1.6, TEXELS) + each[along // size, across // size]
        edge = np.minimum(*(np.minimum(c % size, size - 1 - c % size) for c in (across, along)))
        wide = 1.0 if pattern == "slabs" else 1.6
        tones *= 1 - (0.5 if pattern == "slabs" else 0.3) * np.exp(-((edge / wide) ** 2))
    elif pattern == "boards":
        row = along // size
        shift = chance.integers(0, TEXELS, surface.tiles)
        column = ((across + shift[row]) % TEXELS) // (TEXELS // 2)
        each = chance.normal(0, 0.09, (surface.tiles, 2))[row, column]
        grain = gaussian_filter(chance.standard_normal((TEXELS, TEXELS)), (1.2, 60), mode="wrap")
        tones = 1 + surface.contrast * grain / grain.std() + each
        ends = ((across + shift[row]) % TEXELS) % (TEXELS // 2)
        edge = np.minimum(np.minimum(along % size, size - 1 - along % size), np.minimum(ends, TEXELS // 2 - 1 - ends))
        tones *= 1 - 0.55 * np.exp(-((edge / 1.2) ** 2))
        tint = np.array([0.92, 1.0, 1.12])  # darker areas are warmer
    elif pattern == "grass":
        blades = gaussian_filter(chance.standard_normal((TEXELS, TEXELS)), 1.3, mode="wrap")
        tones = 1 + surface.contrast * (0.2 * fractal_noise(chance, 1.5, TEXELS) + 0.95 * blades / blades.std())
        tint = np.array([1.1, 1.0, 1.2])
    elif pattern in ("asphalt", "sand", "earth"):
        grit = gaussian_filter(chance.standard_normal((TEXELS, TEXELS)), 1.0, mode="wrap")
        tones = 1 + surface.contrast * (0.9 * grit / grit.std() + 0.35 * fractal_noise(chance, 1.6, TEXELS))
    else:
        tones = 1 + surface.contrast * fractal_noise(chance, 1.8, TEXELS)
    tones = np.clip(tones, 0.15, 2.0)[..., None] ** tint
    return tones / tones.mean(axis=(0, 1))
