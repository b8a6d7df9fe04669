"""Materials in terms that exchange formats share: colour, roughness, metallic, opacity, texture."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from text2sim.recording.film_record import SurfaceLook
from text2sim.rendering.finishes import MILKY, finish_of
from text2sim.rendering.tone import linear

CLEAR_GLASS_OPACITY = 0.18
"""Opacity of clear glass: in these formats, a surface either transmits or reflects light."""
MIN_ROUGHNESS = 0.03
"""Smallest roughness: below, viewers show highlights as single pixels."""

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class ExportMaterial:
    """A material; equal ones are stored once in a file."""

    color: Rgb
    """Linear Rec. 709, 0 to 1; white with a picture."""
    roughness: float
    metallic: float
    opacity: float
    clearcoat: float
    two_sided: bool
    picture: Path | None
    """Texture (sRGB) in place of the colour."""


def material_of(look: SurfaceLook, *, two_sided: bool, has_uvs: bool) -> ExportMaterial:
    """Return the material of a body.

    Args:
        look: Its look in the recording.
        two_sided: Whether its back is visible, too.
        has_uvs: Whether it has texture coordinates, which a picture needs.
    """
    finish = finish_of(look.finish)
    picture = look.picture if has_uvs else None
    red, green, blue = (1.0, 1.0, 1.0) if picture else linear(np.asarray(look.color, float)).tolist()
    opacity = {"clear": CLEAR_GLASS_OPACITY, "frosted": MILKY}.get(finish.kind, look.opacity)
    roughness = max(finish.roughness, MIN_ROUGHNESS)
    return ExportMaterial(
        (red, green, blue), roughness, finish.metallic, float(opacity), finish.clearcoat, two_sided, picture
    )
