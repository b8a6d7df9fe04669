"""Walls of places as pictures: plaster, tiles, bricks, concrete, with light that falls through a window.

The picture is slightly out of focus, as what is behind a subject is in a photograph.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from text2sim.rendering.backdrop import Wall
from text2sim.rendering.noise import fractal_noise, sampled
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.tone import linear

Array = NDArray[np.floating]

WALLS = ("plain", "plaster", "tiles", "bricks", "concrete")
COLUMNS = 3072
"""Texels along the wall."""
NOISE_TEXELS = 512
UNFOCUSED = 0.004
"""Standard deviation of the blur, in distances of the wall."""
STONES = {"tiles": (0.3, 0.15, 0.04, 0.3), "bricks": (0.26, 0.085, 0.14, -0.35), "concrete": (1.6, 0.8, 0.02, 0.35)}
"""By kind: length and height of a stone [m], variation of brightness from stone to stone, and how much darker joints
are."""
MIN_STONE_SHARE = 0.09
"""Least height of a stone in radii of the scene: smaller ones are noise."""
SKIRTING, SKIRTING_TONE = 0.1, 1.12
"""Height of a skirting board [m], and its brightness relative to the wall's."""
MIN_ROOM = 0.6
"""Radius of a scene [m] from which a wall has a skirting board: below, the floor is a table top."""
FALLOFF = 0.3
"""Relative drop in brightness of a wall from its middle, behind the subject, to its far ends."""
DIM = 0.80
"""Brightness of a wall out of the window's light."""
PANES, PANE, FRAME, SLANT = (2, 3), (0.62, 0.62), 0.09, 0.35
"""Panes across and up; size of a pane and of the bars between them, in radii of the scene; shear of their light."""
LIGHT_AT, LIGHT_EDGE = (-1.1, 0.25), 0.055
"""Lower left corner of the window's light, from the foot of the wall behind the middle, and the softness of its edges,
in radii of the scene."""


def wall_material(kind: str, color: tuple[float, float, float], wall: Wall, stage: float, *, window: bool) -> Any:
    """Return the material of a straight wall.

    Args:
        kind: One of `WALLS`.
        color: Colour, sRGB from 0 to 1.
        wall: The wall.
        stage: Radius of the scene [m].
        window: Whether light falls on it through a window.
    """
    mi = mitsuba()
    picture = np.clip(
        wall_picture(kind, wall, stage, window=window)[..., None] * linear(np.asarray(color, float)), 0.0, 0.95
    )
    return mi.load_dict({
        "type": "twosided",
        "bsdf": {
            "type": "principled",
            "base_color": {
                "type": "bitmap", "raw": True, "wrap_mode": "clamp",
                "bitmap": mi.Bitmap(np.ascontiguousarray(picture, np.float32)),
            },
            "roughness": 0.35 if kind == "tiles" else 0.9,
            "specular": 0.4 if kind == "tiles" else 0.2,
        },
    })  # fmt: skip


def wall_picture(kind: str, wall: Wall, stage: float, *, window: bool) -> Array:
    """Return factors on a wall's linear colour, from its foot upwards, shape (rows, COLUMNS).

    Args:
        kind: One of `WALLS`.
        wall: The wall.
        stage: Radius of the scene [m].
        window: Whether light falls on it through a window.
    """
    (wide, tall), away = wall.size, wall.away
    texel = wide / COLUMNS
    rows = max(round(tall / texel), 2)
    x, y = np.meshgrid((np.arange(COLUMNS) + 0.5) * texel - wide / 2, (np.arange(rows) + 0.5) * texel)
    chance = np.random.default_rng(sum(kind.encode()))
    tones = 1 + 0.035 * sampled(fractal_noise(chance, 1.6, NOISE_TEXELS), x / (5 * stage), y / (5 * stage))
    if kind in STONES:
        tones = tones * _stones(kind, chance, x, y, stage)
    if kind in ("plaster", "tiles") and stage >= MIN_ROOM:
        board = y < SKIRTING
        tones = np.where(board, SKIRTING_TONE, tones) * np.where(np.abs(y - SKIRTING) < 1.5 * texel, 0.75, 1.0)
    if window:
        tones = tones * (DIM + (1 - DIM) * _window_light(x / stage, y / stage))
    tones = tones * (1 - FALLOFF * (1 - np.exp(-((x / (2.2 * away)) ** 2) - (y / (1.6 * away)) ** 2)))
    return gaussian_filter(tones, UNFOCUSED * away / texel)


def _stones(kind: str, chance: np.random.Generator, x: Array, y: Array, stage: float) -> Array:
    long, high, varied, depth = STONES[kind]
    scale = max(1.0, MIN_STONE_SHARE * stage / high)
    long, high = long * scale, high * scale
    course = np.floor(y / high).astype(np.int64)
    along = x / long + (0.5 * (course % 2) if kind != "concrete" else 0.0)
    stone = np.floor(along).astype(np.int64)
    tones = 1 + varied * chance.uniform(-1, 1, (64, 64))
    edge = np.minimum(
        np.minimum(along - stone, 1 - (along - stone)) * long,
        np.minimum(y / high - course, 1 - (y / high - course)) * high,
    )
    joint = np.clip(1 - edge / (0.04 * high), 0.0, 1.0)
    return tones[course % 64, stone % 64] * (1 - depth * joint)


def _window_light(x: Array, y: Array) -> Array:
    """Return how much of a window's light reaches points of a wall, 0 to 1; lengths are in radii of the scene."""
    across = LIGHT_AT[0] - (x + SLANT * (y - LIGHT_AT[1])) + PANES[0] * (PANE[0] + FRAME)
    return _panes(across, PANES[0], PANE[0]) * _panes(y - LIGHT_AT[1], PANES[1], PANE[1])


def _panes(x: Array, count: int, size: float) -> Array:
    """Return 1 where x is within one of several panes side by side from 0, and 0 on the bars between them."""
    low = np.arange(count) * (size + FRAME)
    return sum(
        (np.clip((x - a) / LIGHT_EDGE + 0.5, 0, 1) * np.clip((a + size - x) / LIGHT_EDGE + 0.5, 0, 1) for a in low),
        start=np.zeros(x.shape),
    )
