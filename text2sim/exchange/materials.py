"""Surfaces in the terms that exchange formats share: colour, roughness, metal, opacity, a picture."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from text2sim.recording.film_record import SurfaceLook
from text2sim.rendering.finishes import MILKY, finish_of
from text2sim.rendering.tone import linear

CLEAR = 0.18
"""Opacity of clear glass: these formats say either how much light a surface lets through, or what it mirrors."""
SMOOTHEST = 0.03
"""Roughness below which viewers show glints as single pixels."""

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class ExportMaterial:
    """A surface; equal ones are one material in a file."""

    color: Rgb
    """Linear Rec. 709, 0 to 1; white under a picture."""
    roughness: float
    metallic: float
    opacity: float
    clearcoat: float
    two_sided: bool
    picture: Path | None
    """sRGB, instead of the colour."""


def material_of(look: SurfaceLook, *, two_sided: bool, has_uvs: bool) -> ExportMaterial:
    """Return the surface of a body.

    Args:
        look: As the recording has it.
        two_sided: Whether its back is seen as well.
        has_uvs: Whether it has texture coordinates, without which a picture cannot be laid on it.
    """
    finish = finish_of(look.finish)
    picture = look.picture if has_uvs else None
    red, green, blue = (1.0, 1.0, 1.0) if picture else linear(np.asarray(look.color, float)).tolist()
    opacity = {"clear": CLEAR, "frosted": MILKY}.get(finish.kind, look.opacity)
    roughness = max(finish.roughness, SMOOTHEST)
    return ExportMaterial(
        (red, green, blue), roughness, finish.metallic, float(opacity), finish.clearcoat, two_sided, picture
    )
