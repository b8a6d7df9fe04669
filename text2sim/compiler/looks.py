"""Looks as numbers: names become colours, and copies vary."""

import colorsys
import random
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

from pydantic import BaseModel

from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec
from text2sim.spec_schema.models.colors import PALETTES, rgb
from text2sim.spec_schema.models.materials import Look, Palette
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound, Mesh

Rgba = tuple[float, float, float, float]

MIN_HIDING_OPACITY = 0.5
"""Least opacity at which something hides what is behind it."""
CLEAR_FINISHES = ("glass", "frosted_glass")
"""Finishes that hide nothing, however opaque."""


def rounded_rgb(color: Any) -> Vec:
    """Return a colour of the language in sRGB, each channel in 0..1 with four digits."""
    red, green, blue = rgb(color)
    return (round(red, 4), round(green, 4), round(blue, 4))


def linear_rgb(color: Sequence[float]) -> Vec:
    """Return the light of an sRGB colour (0 to 1): its channels without their transfer function."""
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in color[:3])
    return (red, green, blue)


def luminance(color: Sequence[float]) -> float:
    """Return the luminance of an sRGB colour (0 to 1), relative to white (Rec. 709)."""
    red, green, blue = linear_rgb(color)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def oklab(color: Sequence[float]) -> Vec:
    """Return an sRGB colour (0 to 1) in Oklab, where distances match what eyes tell apart; white is 1 from black.

    Björn Ottosson's Oklab, https://bottosson.github.io/posts/oklab/.
    """
    r, g, b = linear_rgb(color)
    long = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) ** (1 / 3)
    middle = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) ** (1 / 3)
    short = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b) ** (1 / 3)
    return (
        0.2104542553 * long + 0.7936177850 * middle - 0.0040720468 * short,
        1.9779984951 * long - 2.4285922050 * middle + 0.4505937099 * short,
        0.0259040371 * long + 0.7827717662 * middle - 0.8086757660 * short,
    )


def hides(opacity: float, finish: str) -> bool:
    """Return whether something of this opacity and finish hides what is behind it."""
    return opacity >= MIN_HIDING_OPACITY and finish not in CLEAR_FINISHES


def finish_of_body(model: Any) -> str:
    """Return the finish of a body or static; a liquid that was given none is as clear as water."""
    look = model.look
    return "glass" if getattr(model, "kind", "") == "liquid" and "finish" not in look.model_fields_set else look.finish


def rgba_of(look: Look, copy: Copy) -> Rgba:
    """Return the colour of a copy, each channel in 0..1 with four digits."""
    index = copy.index or 0
    color = look.color
    if color is None:
        color = copy.color
    elif isinstance(color, list):
        color = color[index % len(color)]
    elif isinstance(color, Palette):
        colors = PALETTES[color.palette]
        color = colors[(color.start + index) % len(colors)]
    red, green, blue = rgb(color)
    if look.vary is not None:
        chance = random.Random(f"{look.vary.seed}:{copy.body}:{index}")
        hue, light, saturation = colorsys.rgb_to_hls(red, green, blue)
        hue = (hue + look.vary.hue * chance.uniform(-1, 1)) % 1.0
        light = min(max(light + look.vary.value * chance.uniform(-1, 1), 0.0), 1.0)
        red, green, blue = colorsys.hls_to_rgb(hue, light, saturation)
    return (round(red, 4), round(green, 4), round(blue, 4), look.opacity)


def all_colors(copy: Copy) -> list[Rgba]:
    """Return the colours of a copy: that of the body, which comes first, of its parts and of its links."""
    return list(dict.fromkeys(rgba_of(look, copy) for look in looks_of(copy.model)))


def decoration_of(look: Look) -> dict[str, Any]:
    """Return what a look says besides colour and finish, as data: pattern, label, `alike` for copies."""
    decoration: dict[str, Any] = {}
    if look.pattern is not None:
        color = look.pattern.color
        decoration["pattern"] = {
            "kind": look.pattern.kind,
            "size": look.pattern.size,
            "color": None if color is None else rgb(color),
            "turned": look.pattern.turned,
        }
    if look.label is not None:
        colors = {"ink": look.label.color, "plate": look.label.plate}
        decoration["label"] = {"text": look.label.text, **{k: None if c is None else rgb(c) for k, c in colors.items()}}
    if look.vary is not None:
        decoration["alike"] = True
    return decoration


def has_glass(copy: Copy) -> bool:
    """Return whether some part of a copy can be seen through."""
    own = copy.model.look
    looks = [
        (own.opacity, finish_of_body(copy.model)),
        *((look.opacity, look.finish) for look in looks_of(copy.model)),
    ]
    return any(not hides(*look) for look in looks)


def looks_of(model: Any) -> tuple[Look, ...]:
    """Return all looks within a body, its own first; copies share their model, and the last few thousand are kept."""
    return _kept_looks(ObjectKey(model))


@lru_cache(maxsize=4096)
def _kept_looks(model: ObjectKey) -> tuple[Look, ...]:
    return tuple(_looks_in(model.value))


def _looks_in(model: Any) -> Iterator[Look]:
    """Yield all looks within a body, its own first."""
    if isinstance(model, Look):
        yield model
    elif isinstance(model, BaseModel):
        for name in sorted(type(model).model_fields, key=lambda name: name != "look"):
            yield from _looks_in(getattr(model, name))
    elif isinstance(model, dict):
        for value in model.values():
            yield from _looks_in(value)


def one_color(shape: Any) -> bool:
    """Return whether all of a shape has the colour of its body."""
    if isinstance(shape, Compound):
        return all(part.look is None and not isinstance(part.shape, Mesh) for part in shape.parts.values())
    if isinstance(shape, Sculpt):
        return all(part.look is None for part in shape.parts.values())
    return not isinstance(shape, Mesh)


def colors_of(shape: Any, look: Look, copy: Copy) -> list[Rgba]:
    """Return the colours of one copy of a body, and of its parts.

    Args:
        shape: Shape of the body.
        look: Look of the body.
        copy: The copy.
    """
    looks = [part.look for part in shape.parts.values()] if isinstance(shape, Compound | Sculpt) else []
    return [rgba_of(one, copy) for one in (look, *looks) if one is not None]
