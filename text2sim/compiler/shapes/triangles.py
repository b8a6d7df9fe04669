"""Triangles of a surface: their area, and the limit on their number, checked before any is made."""

import math
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.distance_field import rounded_up
from text2sim.compiler.shapes.rings import ROW_HEIGHT
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

MAX_TRIANGLES = 400_000
"""Most triangles of a surface. More would need more particles or tetrahedra than any solver here can handle."""


def check_triangle_count(area: float, edge: float, along: float = 0.0) -> None:
    """Refuse an area [m2] that would take too many triangles.

    Args:
        area: Area of the surface [m2].
        edge: Wanted length of an edge [m].
        along: Total length of the narrowest rows of triangles [m], for shapes thinner than an edge.

    Raises:
        AssetError: if there would be too many; the message gives the smallest possible edge.
    """
    expected = max(area / (ROW_HEIGHT / 2 * edge**2), along / edge)
    if expected > MAX_TRIANGLES:
        least = max(math.sqrt(area / (ROW_HEIGHT / 2 * MAX_TRIANGLES)), along / MAX_TRIANGLES)
        raise AssetError(
            f"with elements of {edge:g} m its surface would have about {expected:,.0f} triangles; at most "
            f"{MAX_TRIANGLES:,} are possible: take a `cell` of {rounded_up(least):g} m or more"
        )


def surface_area(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    """Return the area [m2] of triangles (m, 3) between vertices (n, 3) [m]."""
    from text2sim.assets.surface import triangle_areas

    return float(triangle_areas(vertices[faces]).sum())


def enclosed_volume(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    """Return the volume [m3] that triangles (m, 3) enclose; negative if they face inward."""
    from text2sim.assets.surface import signed_volumes

    return float(signed_volumes(vertices[faces]).sum())
