"""Surfaces: Disney's principled material for each finish of the language, with generated textures.

Colours are attributes of mesh faces, so that all parts with one finish share one mesh and material. On uneven surfaces
a texture blends from the colour to a darker or lighter shade.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from text2sim.compiler.looks import MIN_HIDING_OPACITY
from text2sim.rendering.renderer import mitsuba

if TYPE_CHECKING:
    from text2sim.rendering.decorating import Layer

Array = NDArray[np.floating]

COLOR, SHADE = "face_color", "face_shade"
"""Face attributes of the meshes: linear colour, and the shade that it is blended with. Vertex attributes would be black
in thin triangles, where the renderer finds no interpolation weights."""
TEXELS = 1024
FINEST = 256
"""Largest number of periods of a detail along a texture: finer ones would show the texels in close views."""
HAZE = 0.0225
"""Fraction of the light that a face of clear glass scatters, which makes it visible. A pane has two."""
HAZE_OF_COLOR = 0.3
"""What is added to that for a transparent colour, as a fraction of its opacity."""
MILKY = 0.45
"""Fraction of the light that frosted glass scatters; the rest passes straight through and shows its contents."""
GEL = 0.2
"""Fraction of the light that jelly scatters back, because it is cloudy; the rest passes through."""
TINT = 0.62
"""Fraction of the light that dark glass scatters."""
EDGE = 0.55
"""The same of the narrow sides of clear panes, where one looks along the glass."""
EDGE_TINT = (0.5, 0.8, 0.74)
"""Factor on the colour of these sides: the iron of plain glass absorbs red."""


RIPPLE, RIPPLES = 0.01, 5
"""Height of the ripples that keep reliefs from being level, relative to their depth, and their number along a side."""


@dataclass(frozen=True)
class Finish:
    """Parameters of a finish."""

    roughness: float
    specular: float = 0.5
    metallic: float = 0.0
    clearcoat: float = 0.0
    sheen: float = 0.0
    anisotropic: float = 0.0
    texture: str = ""
    """Name of its texture."""
    shade: float = 1.0
    """Factor on the colour at the other end of the blend."""
    tile: float = 1.0
    """Length that the texture covers in a scene of the size of a room [m]."""
    bump: float = 0.0
    """Depth of its relief, as a fraction of the tile."""
    kind: str = "solid"
    """solid, clear, edge (of clear), frosted, tinted or gel."""


FINISHES = {
    "rough": Finish(0.62, 0.35),
    "painted": Finish(0.38, 0.5, clearcoat=0.25),
    "plastic": Finish(0.28, 0.5),
    "smooth": Finish(0.12, 0.55, clearcoat=0.6),
    "rubber": Finish(0.72, 0.25, sheen=0.25),
    "metal": Finish(0.34, metallic=1.0),
    "brushed_metal": Finish(0.38, metallic=1.0, anisotropic=0.7, texture="streaks", shade=0.86, tile=0.25),
    "polished_metal": Finish(0.1, metallic=1.0),
    "wood": Finish(0.42, 0.4, clearcoat=0.15, texture="grain", shade=0.6, tile=0.5, bump=0.0005),
    "plaster": Finish(0.9, 0.15, texture="clouds", shade=0.86, tile=1.1, bump=0.0015),
    "concrete": Finish(0.8, 0.25, texture="clouds", shade=0.72, tile=1.6, bump=0.003),
    "brick": Finish(0.85, 0.2, texture="pits", shade=0.7, tile=0.25, bump=0.012),
    "ceramic": Finish(0.09, 0.6, clearcoat=1.0),
    "glass": Finish(0.0, kind="clear"),
    "glass_edge": Finish(0.15, 0.6, clearcoat=0.8, kind="edge"),
    "frosted_glass": Finish(0.3, kind="frosted"),
    "tinted_glass": Finish(0.05, 0.6, clearcoat=1.0, kind="tinted"),
    "cloth": Finish(0.85, 0.15, sheen=0.7, texture="weave", shade=0.8, tile=0.03, bump=0.01),
    "silicone": Finish(0.45, 0.35, sheen=0.3, clearcoat=0.1),
    "paper": Finish(0.9, 0.1, texture="fibres", shade=0.94, tile=0.2),
    "sand": Finish(0.95, 0.1, texture="specks", shade=0.7, tile=0.12, bump=0.01),
    "cardboard": Finish(0.9, 0.15, texture="flutes", shade=0.86, tile=0.25, bump=0.0008),
    "leather": Finish(0.5, 0.45, sheen=0.2, texture="cells", shade=0.5, tile=0.12, bump=0.03),
    "felt": Finish(1.0, 0.05, sheen=1.0, texture="fuzz", shade=0.72, tile=0.08, bump=0.02),
    "marble": Finish(0.12, 0.55, clearcoat=0.8, texture="veins", shade=0.42, tile=0.7),
    "jelly": Finish(0.08, 0.55, clearcoat=1.0, kind="gel"),
    "peel": Finish(0.38, 0.5, clearcoat=0.35, texture="dimples", shade=0.82, tile=0.07, bump=0.035),
    "foliage": Finish(0.6, 0.3, sheen=0.5, texture="leaves", shade=0.5, tile=0.7, bump=0.02),
    "bark": Finish(0.95, 0.1, texture="furrows", shade=0.46, tile=0.6, bump=0.035),
    "fur": Finish(0.95, 0.1, sheen=1.0, texture="hairs", shade=0.55, tile=0.16, bump=0.03),
    "crust": Finish(0.45, 0.4, sheen=0.2, clearcoat=0.2, texture="blotches", shade=0.62, tile=0.7, bump=0.012),
    "stone": Finish(0.9, 0.2, texture="chips", shade=0.58, tile=0.8, bump=0.025),
}
SCATTERED = {"frosted": MILKY, "tinted": TINT, "edge": EDGE}
"""Fraction of the light that kinds of glass scatter; the rest passes straight through."""
PLAIN = "rough"
DEEP = 0.65
"""Brightest channel of a colour below which glass is dark, like a wine bottle, and tints what is behind it."""


def drawn_finish(finish: str, color: tuple[float, float, float], opacity: float = 1.0) -> str:
    """Return the rendered finish for a finish of the language: dark glass has its own.

    What is rather transparent is drawn as glass with haze. A stochastic cut-out would be as noisy as the film has few
    samples, and hide from the denoiser what is behind it.

    Args:
        finish: Finish of the language.
        color: The colour, RGB from 0 to 1.
        opacity: 0 to 1; 1 is opaque.
    """
    if opacity < MIN_HIDING_OPACITY and finish_of(finish).kind == "solid" and not finish_of(finish).metallic:
        return "glass"
    return "tinted_glass" if finish == "glass" and max(color) < DEEP else finish


def finish_of(name: str) -> Finish:
    """Return a finish by name; a plain one if it is unknown."""
    return FINISHES.get(name, FINISHES[PLAIN])


def material(
    name: str,
    *,
    opacity: float = 1.0,
    two_sided: bool = False,
    picture: Array | None = None,
    layer: "Layer | None" = None,
    texture_scale: float = 1.0,
) -> Any:
    """Return a Mitsuba material; cached by its arguments, because the renderer treats each object separately.

    Args:
        name: Name of the finish.
        opacity: 0 to 1; 1 is opaque.
        two_sided: Whether its back is visible.
        picture: Texture instead of its colour: sRGB with or without alpha, 0 to 1, top row first.
        layer: Layer over its colour.
        texture_scale: Factor on the length that the texture of the finish covers.
    """
    if picture is None and layer is None:
        return _plain(name, opacity, two_sided, texture_scale)
    return _made(name, opacity, two_sided, texture_scale, picture, layer)


@cache
def _plain(name: str, opacity: float, two_sided: bool, texture_scale: float) -> Any:
    return _made(name, opacity, two_sided, texture_scale)


def _made(
    name: str,
    opacity: float,
    two_sided: bool,
    texture_scale: float,
    picture: Array | None = None,
    layer: "Layer | None" = None,
) -> Any:
    mi, finish = mitsuba(), finish_of(name)
    finish = replace(finish, tile=finish.tile * texture_scale)
    if finish.kind == "clear":
        haze = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": attribute(COLOR)}}
        weight = HAZE if opacity == 1 else HAZE + HAZE_OF_COLOR * opacity
        return mi.load_dict({
            "type": "blendbsdf", "weight": weight, "bsdf_0": {"type": "thindielectric", "int_ior": 1.6}, "bsdf_1": haze,
        })  # fmt: skip
    if finish.kind in SCATTERED:
        milky = {"type": "twosided", "bsdf": _principled(finish, attribute(COLOR))}
        return mi.load_dict({"type": "mask", "opacity": SCATTERED[finish.kind], "bsdf": milky})
    bsdf: dict[str, Any]
    if finish.kind == "gel":
        # A refracting material is transparent; a scattering one shows its colour where it is thick.
        clear = _principled(finish, attribute(COLOR)) | {"spec_trans": 0.9, "eta": 1.35, "roughness": 0.12}
        bsdf = {
            "type": "blendbsdf",
            "weight": GEL,
            "bsdf_0": {key: value for key, value in clear.items() if key != "specular"},
            "bsdf_1": {"type": "twosided", "bsdf": _principled(finish, attribute(COLOR))},
        }
    elif picture is not None:
        bsdf = _principled(finish, _bitmap(picture[..., :3], raw=False))
    elif finish.texture:
        weight = _bitmap(_pattern(finish.texture), raw=True, tile=finish.tile)
        bsdf = {
            "type": "blendbsdf",
            "weight": weight,
            "bsdf_0": _principled(finish, attribute(SHADE)),
            "bsdf_1": _principled(finish, attribute(COLOR)),
        }
        if finish.bump:
            relief = _bitmap(rippled(_pattern(finish.texture)), raw=True, tile=finish.tile)
            bsdf = {"type": "bumpmap", "texture": relief, "scale": finish.bump * finish.tile, "bsdf": bsdf}
    else:
        bsdf = _principled(finish, attribute(COLOR))
    if layer is not None:
        bsdf = _under(layer, bsdf, finish)
    if two_sided and finish.kind != "gel":
        bsdf = {"type": "twosided", "bsdf": bsdf}
    if picture is not None and picture.shape[-1] == 4 and picture[..., 3].min() < 1:
        bsdf = {"type": "mask", "opacity": _bitmap(picture[..., 3:], raw=True), "bsdf": bsdf}
    if opacity < 1:
        bsdf = {"type": "mask", "opacity": opacity, "bsdf": bsdf}
    return mi.load_dict(bsdf)


def _under(layer: "Layer", made: dict[str, Any], finish: Finish) -> dict[str, Any]:
    """Return a material with a layer on top."""
    # Nested bump maps are wrong: the outer one passes its frame to the inner one in local coordinates.
    if layer.relief is not None and made["type"] == "bumpmap":
        made = made["bsdf"]
    over = _bitmap(layer.picture[..., :3], raw=False, tile=layer.period)
    alpha = _bitmap(layer.picture[..., 3:], raw=True, tile=layer.period)
    both = {"type": "blendbsdf", "weight": alpha, "bsdf_0": made, "bsdf_1": _principled(finish, over)}
    if layer.relief is None:
        return both
    relief = _bitmap(rippled(layer.relief), raw=True, tile=layer.period)
    return {"type": "bumpmap", "texture": relief, "scale": layer.depth, "bsdf": both}


def rippled(relief: Array) -> Array:
    """Return a tileable height map, shape (h, w), without level parts.

    Where the height does not change at all, Mitsuba's bump maps yield an undefined frame, and black, on surfaces whose
    texture runs along the world's z: they compare the normal in local coordinates with a tangent in those of the world.
    """
    v, u = (2 * np.pi * RIPPLES * np.arange(n) / n for n in relief.shape)
    return relief + RIPPLE * (np.sin(v)[:, None] + np.cos(u)[None])


def needs_uvs(name: str) -> bool:
    """Return whether a finish needs texture coordinates."""
    return bool(finish_of(name).texture)


def _principled(finish: Finish, color: dict[str, Any]) -> dict[str, Any]:
    bsdf: dict[str, Any] = {"type": "principled", "base_color": color, "roughness": finish.roughness}
    bsdf["metallic" if finish.metallic else "specular"] = finish.metallic or finish.specular
    for name in ("clearcoat", "sheen", "anisotropic"):
        if getattr(finish, name):
            bsdf[name] = getattr(finish, name)
    if finish.clearcoat:
        bsdf["clearcoat_gloss"] = 0.9
    return bsdf


def attribute(name: str) -> dict[str, Any]:
    """Return the texture that reads an attribute of a mesh."""
    return {"type": "mesh_attribute", "name": name}


def _bitmap(values: Array, *, raw: bool, tile: float | tuple[float, float] = 1.0) -> dict[str, Any]:
    mi = mitsuba()
    if values.ndim == 2:
        values = values[..., None]
    bitmap = mi.Bitmap(np.ascontiguousarray(values, np.float32))
    if not raw:
        bitmap = mi.Bitmap(np.ascontiguousarray((values * 255 + 0.5).astype(np.uint8)))
    texture: dict[str, Any] = {"type": "bitmap", "bitmap": bitmap, "raw": raw}
    if tile != 1.0:
        width, height = tile if isinstance(tile, tuple) else (tile, tile)
        texture["to_uv"] = mi.ScalarTransform3f().scale([1 / width, 1 / height])
    return texture


def _pattern(name: str) -> Array:
    """Return a tileable texture, 0 to 1, shape (TEXELS, TEXELS)."""
    chance = np.random.default_rng(sum(name.encode()))
    if name == "grain":  # along v
        bent = _noise(chance, 2.5, (3.0, 0.6))
        fibres = _noise(chance, 1.0, (90.0, 2.0))
        rings = 0.5 + 0.5 * np.sin(2 * np.pi * (np.linspace(0, 9, TEXELS, endpoint=False)[None] + 2.2 * bent))
        return _stretched(0.65 * rings**0.6 + 0.45 * fibres)
    if name == "streaks":
        return _stretched(_noise(chance, 0.6, (1.0, 120.0)))
    if name == "clouds":
        return _stretched(_noise(chance, 1.5, (1, 1)) + 0.35 * _noise(chance, 0.2, (1, 1)))
    if name == "pits":
        coarse = _noise(chance, 0.9, (1, 1))
        return _stretched(np.minimum(coarse, 0.4) + 0.25 * _noise(chance, 0.1, (1, 1)))
    if name == "weave":
        x = np.arange(TEXELS) * (2 * np.pi * 16 / TEXELS)
        over, under = np.abs(np.sin(x))[:, None], np.abs(np.sin(x))[None]
        upper = np.sin(x / 2)[:, None] * np.sin(x / 2)[None] > 0
        return _stretched(np.where(upper, over, under))
    if name == "fibres":
        return _stretched(_noise(chance, 0.8, (2.0, 6.0)))
    if name == "flutes":  # of corrugated board, along v
        waves = 0.5 + 0.5 * np.cos(2 * np.pi * 36 * np.arange(TEXELS) / TEXELS)
        return _stretched(0.3 * waves[None] + _noise(chance, 0.7, (2.0, 5.0)))
    if name == "veins":
        bent = _noise(chance, 1.6, (1, 1.6))
        return _stretched(np.minimum(np.abs(bent - 0.5), 0.12) + 0.06 * _noise(chance, 1.2, (1, 1)))
    if name in ("cells", "dimples"):
        return _pores(chance, 900 if name == "cells" else 420, hollow=name == "dimples")
    if name == "leaves":
        return _leaves(chance, 1500)
    if name == "furrows":  # of bark, along v
        bent = _noise(chance, 1.25, (3.2, 0.8))
        return _stretched(np.minimum(np.abs(bent - 0.5), 0.16) + 0.12 * _noise(chance, 0.5, (3.0, 1.0)))
    if name == "hairs":
        return _stretched(_noise(chance, 0.9, (7.0, 1.6)) + 0.5 * _noise(chance, 1.6, (1, 1)))
    if name == "blotches":
        return _stretched(_noise(chance, 1.6, (1, 1)) + 0.25 * _noise(chance, 0.4, (1, 1)))
    if name == "chips":
        return _stretched(np.minimum(_noise(chance, 1.15, (1, 1)), 0.55) + 0.3 * _noise(chance, 1.7, (1, 1)))
    if name == "fuzz":
        return _stretched(_noise(chance, 0.35, (1, 1)))
    return _stretched(_noise(chance, 0.05, (1, 1)) ** 2)  # specks


def _pores(chance: np.random.Generator, many: int, *, hollow: bool) -> Array:
    """Return the distance to the border, or to the centre, of Voronoi cells of random points."""
    from scipy.spatial import KDTree

    spots = (np.stack(np.meshgrid(*[np.arange(int(many**0.5))] * 2), -1).reshape(-1, 2) + 0.5) / int(many**0.5)
    spots = (spots + chance.uniform(-0.4, 0.4, spots.shape) / many**0.5) % 1
    texels = (np.stack(np.meshgrid(*[np.arange(TEXELS)] * 2), -1).reshape(-1, 2) + 0.5) / TEXELS
    away, _ = KDTree(spots, boxsize=1.0).query(texels, k=2)
    near, next_ = away.reshape(TEXELS, TEXELS, 2).transpose(2, 0, 1) * many**0.5
    return np.clip(near / 0.35, 0, 1) if hollow else np.clip((next_ - near) / 0.35, 0, 1) ** 0.5


def _leaves(chance: np.random.Generator, count: int) -> Array:
    """Return leaves of random size and direction, each above the earlier ones and brighter, with a bright midrib."""
    relief = np.zeros((TEXELS, TEXELS))
    for level in np.linspace(0.4, 1.0, count):
        half = int(TEXELS * chance.uniform(0.022, 0.045))
        y, x = np.mgrid[-half : half + 1, -half : half + 1] / half
        angle, center = chance.uniform(0, 2 * np.pi), chance.integers(0, TEXELS, 2)
        along, across = x * np.cos(angle) + y * np.sin(angle), np.abs(y * np.cos(angle) - x * np.sin(angle))
        width = 0.5 * (1 - along**2)
        rows, columns = (np.arange(-half, half + 1) + c for c in center)
        texels = np.ix_(rows % TEXELS, columns % TEXELS)
        shade = level * (1 - 0.35 * across / np.maximum(width, 1e-3)) * chance.uniform(0.75, 1.0)
        relief[texels] = np.where(across < width, shade, relief[texels])
    return relief


def _noise(chance: np.random.Generator, slope: float, stretch: tuple[float, float]) -> Array:
    """Return noise with a spectrum of 1 / f^slope, stretched along the axes, standard deviation 1/4 about 1/2."""
    f = np.fft.fftfreq(TEXELS) * TEXELS
    size = np.hypot(f[None] / stretch[0], f[:, None] / stretch[1])
    spectrum = np.fft.fft2(chance.standard_normal((TEXELS, TEXELS))) / np.maximum(size, 0.7) ** slope
    spectrum *= np.exp(-((np.hypot(f[None], f[:, None]) / FINEST) ** 4))
    spectrum[0, 0] = 0
    noise = np.fft.ifft2(spectrum).real
    return 0.5 + 0.25 * noise / noise.std()


def _stretched(values: Array) -> Array:
    low, high = np.percentile(values, (1, 99))
    return np.clip((values - low) / (high - low), 0.0, 1.0)
