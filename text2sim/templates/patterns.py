"""Patterns of surfaces: computed pictures with alpha that are laid over a body's colour.

Repeating patterns are one tile for all bodies. Labels, and patterns that depend on the edges of a face, are painted on
the sheets of the unfolded body (`painting.py`).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

CREAM, INK = (0.965, 0.945, 0.9), (0.08, 0.07, 0.065)
MORTAR = (0.72, 0.69, 0.64)
JOINT = 0.62
"""Opacity of the joints between tiles if the pattern has no colour."""
BRIGHT = 0.55
"""Brightness of a body from which on a pattern without a colour is dark."""


@dataclass(frozen=True)
class Decoration:
    """Pattern and label of a surface; equal ones share their pictures."""

    kind: str = ""
    """Kind of the pattern; empty if there is none."""
    size: float | None = None
    """Size of the pattern [m]; None: derived from the body."""
    color: tuple[float, ...] | None = None
    """Colour of the pattern, sRGB, 0 to 1; None: contrasts with the body."""
    turned: bool = False
    text: str = ""
    ink: tuple[float, ...] | None = None
    plate: tuple[float, ...] | None = None

    @property
    def repeats(self) -> bool:
        """Whether one tile covers the whole body."""
        return self.kind in TILES and not self.text


def decoration_in(look: dict) -> Decoration | None:
    """Return the pattern and label of a look in `looks.json`; None if it has neither."""
    pattern, label = look.get("pattern"), look.get("label")
    if not pattern and not label:
        return None
    found: dict = dict(pattern or {}) | dict(label or {})
    return Decoration(**{key: tuple(value) if isinstance(value, list) else value for key, value in found.items()})


@dataclass(frozen=True)
class Tile:
    """A picture whose opposite edges match."""

    picture: np.ndarray
    """Red, green, blue and alpha, 0 to 1, shape (h, w, 4)."""
    relief: np.ndarray | None
    """Height, 0 to 1, shape (h, w)."""
    period: tuple[float, float]
    """Width and height, in units of the pattern's size."""


# Width and height of a part of the pattern, in units of its size; a whole number of parts fits on a face (0: any
# number). Then, for patterns without a size: number of parts along the middle extent, and around the circumference.
TILES = {
    "planks": ((1.0, 0.0), 5, 18),
    "bricks": ((0.5, 1 / 3), 4, 12),
    "tiles": ((1.0, 1.0), 4, 14),
    "checker": ((2.0, 1.0), 6, 12),
    "gingham": ((2.0, 1.0), 8, 20),
    "stripes": ((2.0, 0.0), 8, 12),
    "dots": ((2.0, 1.0), 8, 16),
}
PLAIN = ("planks", "bricks", "tiles")
"""Patterns that do not depend on the colour of the body."""
DEPTH = {"planks": 0.02, "bricks": 0.03, "tiles": 0.01}
"""Depth of the relief, in units of the pattern's size."""
LONG = 0.3
"""Largest derived size of a pattern [m]."""


def size_for(kind: str, extents: np.ndarray, *, is_round: bool) -> float:
    """Return the size [m] of a pattern on a body.

    Args:
        kind: Kind of the pattern.
        extents: Extents of the body [m], shape (3,).
        is_round: Whether the pattern runs around the body.
    """
    _, parts, around = TILES.get(kind, ((1.0, 1.0), 1, 1))
    if is_round:
        return float(f"{np.pi * extents[0] / around:.3g}")
    low, middle, high = np.sort(extents)
    if kind == "planks":
        return float(f"{min(middle / parts, LONG):.3g}")
    return float(f"{min((high if kind == 'bricks' else middle) / parts, LONG):.3g}")


def fitted(kind: str, size: float, width: float, height: float) -> tuple[float, float]:
    """Return the factors on width and height with which a whole number of parts fits on a sheet.

    Args:
        kind: Kind of the pattern.
        size: Size of the pattern [m].
        width: Width of the sheet [m].
        height: Height of the sheet [m].
    """
    factors = []
    for part, length in zip(TILES[kind][0], (width, height), strict=True):
        many = length / (part * size) if part else 0.0
        factors.append(max(round(many), 1) / many if many > 0.5 else 1.0)
    return factors[0], factors[1]


def contrast(color: tuple[float, ...]) -> tuple[float, ...]:
    """Return a colour that contrasts with the given one, both sRGB."""
    if np.dot(color[:3], (0.21, 0.72, 0.07)) < BRIGHT:
        return CREAM
    return tuple(0.4 * x for x in color[:3])


@cache
def tile(kind: str, color: tuple[float, ...] | None, own: tuple[float, ...], *, joints: bool = True) -> Tile:
    """Return the tile of a pattern.

    Args:
        kind: One of `TILES`.
        color: Colour of the pattern, sRGB; None if the author gave none.
        own: Colour of the body, sRGB.
        joints: Whether planks have ends; the staves of a round body have none.
    """
    return _MAKERS[kind](color, own, joints)


def _canvas(width: int, height: int) -> np.ndarray:
    return np.zeros((height, width, 4))


def _lay(canvas: np.ndarray, color, alpha: np.ndarray) -> None:
    """Blend a colour over the canvas."""
    under = canvas[..., 3] * (1 - alpha)
    total = alpha + under
    mixed = (np.asarray(color)[:3] * alpha[..., None] + canvas[..., :3] * under[..., None]) / np.maximum(total, 1e-9)[
        ..., None
    ]
    canvas[..., :3] = np.where(total[..., None] > 0, mixed, canvas[..., :3])
    canvas[..., 3] = total


def _tones(canvas: np.ndarray, cell: np.ndarray, strength: float, seed: int) -> None:
    """Make each numbered cell a little darker or lighter."""
    tone = np.random.default_rng(seed).uniform(-1, 1, int(cell.max()) + 1)[cell]
    _lay(canvas, (0.0, 0.0, 0.0), np.maximum(-tone, 0) * strength)
    _lay(canvas, (1.0, 1.0, 1.0), np.maximum(tone, 0) * strength * 0.3)


def _planks(color, own, joints) -> Tile:
    wide, long, px = 8, 16, 64
    v, u = np.mgrid[0 : long * px, 0 : wide * px] / px + 0.5 / px
    board = u.astype(int)
    edge = np.abs(u - np.round(u))
    cell = board.copy()
    if joints:
        chance = np.random.default_rng(5)
        first = chance.uniform(0, long, wide)[board]
        second = first + chance.uniform(6.5, 9.5, wide)[board]
        along = (v - first) % long
        cell = board * 2 + (along > second - first)
        ends = np.minimum(np.minimum(along, long - along), np.abs(along - (second - first)))
        nail = np.hypot(np.minimum(np.abs(u % 1 - 0.22), np.abs(u % 1 - 0.78)), ends - 0.22) < 0.045
        edge = np.minimum(edge, ends)
    canvas = _canvas(wide * px, long * px)
    _tones(canvas, cell, 0.27, 11)
    grain = _streaks(v.shape, 3)
    _lay(canvas, (0.0, 0.0, 0.0), 0.22 * grain)
    if joints:
        _lay(canvas, INK, 0.7 * nail)
    gap = np.clip((0.045 - edge) / 0.02, 0, 1)
    _lay(canvas, color or (0.03, 0.02, 0.012), gap * (0.95 if color else 0.8))
    return Tile(canvas, 1 - np.clip((0.07 - edge) / 0.05, 0, 1), (wide, long))


def _streaks(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Return fine lines along v, 0 to 1, whose opposite edges match."""
    height, width = shape
    noise = np.random.default_rng(seed).standard_normal(shape)
    fv, fu = np.fft.fftfreq(height)[:, None] * height, np.fft.fftfreq(width)[None] * width
    made = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-((fv / 7) ** 2)) * np.exp(-((fu / (width / 5)) ** 2))).real
    return np.clip(made / (2.2 * made.std()), 0, 1)


def _bricks(color, own, joints) -> Tile:
    many, px = 4, 192
    v, u = np.mgrid[0 : many * px, 0 : many * px] / px + 0.5 / px
    course = (3 * v).astype(int)
    x = u + 0.5 * (course % 2)
    cell = (x.astype(int) % many) + many * course
    edge = np.minimum(np.abs(x - np.round(x)), np.abs(3 * v - np.round(3 * v)) / 3)
    canvas = _canvas(many * px, many * px)
    _tones(canvas, cell, 0.2, 2)
    rough = 0.008 * np.random.default_rng(1).standard_normal(u.shape)
    _lay(canvas, color or MORTAR, np.clip((0.026 + rough - edge) / 0.01, 0, 1))
    return Tile(canvas, 1 - np.clip((0.04 - edge) / 0.02, 0, 1), (many, many))


def _tiles(color, own, joints) -> Tile:
    many, px = 4, 160
    v, u = np.mgrid[0 : many * px, 0 : many * px] / px + 0.5 / px
    edge = np.minimum(np.abs(u - np.round(u)), np.abs(v - np.round(v)))
    canvas = _canvas(many * px, many * px)
    _tones(canvas, u.astype(int) + many * v.astype(int), 0.12, 4)
    _lay(canvas, color or INK, np.clip((0.02 - edge) / 0.008, 0, 1) * (1.0 if color else JOINT))
    return Tile(canvas, 1 - np.clip((0.035 - edge) / 0.02, 0, 1), (many, many))


def _checker(color, own, joints) -> Tile:
    v, u = np.mgrid[0:256, 0:256] // 128
    canvas = _canvas(256, 256)
    _lay(canvas, color or contrast(own), ((u + v) % 2).astype(float))
    return Tile(canvas, None, (2, 2))


def _gingham(color, own, joints) -> Tile:
    v, u = np.mgrid[0:256, 0:256] // 128
    canvas = _canvas(256, 256)
    _lay(canvas, color or contrast(own), 1 - (1 - 0.55 * u) * (1 - 0.55 * v))
    return Tile(canvas, None, (2, 2))


def _stripes(color, own, joints) -> Tile:
    canvas = _canvas(256, 8)
    _lay(canvas, color or contrast(own), np.tile((np.arange(256) // 128).astype(float), (8, 1)))
    return Tile(canvas, None, (2, 2))


def _dots(color, own, joints) -> Tile:
    v, u = np.mgrid[0:256, 0:256] / 128 + 1 / 256
    canvas, near = _canvas(256, 256), np.full((256, 256), 9.0)
    for x, y in ((0.5, 0.5), (1.5, 1.5)):
        near = np.minimum(near, np.hypot(u - x, v - y))
    _lay(canvas, color or contrast(own), np.clip((0.36 - near) * 60, 0, 1))
    return Tile(canvas, None, (2, 2))


_MAKERS = {
    "planks": _planks, "bricks": _bricks, "tiles": _tiles, "checker": _checker, "gingham": _gingham,
    "stripes": _stripes, "dots": _dots,
}  # fmt: skip
