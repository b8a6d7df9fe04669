"""The bound on the triangles of a surface, kept before any is made."""

import math

from text2sim.compiler.shapes.rings import ROW
from text2sim.spec_schema.errors import AssetError

MAX_TRIANGLES = 400_000
"""Triangles of a surface. No solver here gets through the particles or tetrahedra that go with more."""


def refuse_many(area: float, edge: float, along: float = 0.0) -> None:
    """Stop at an area [m2] that would take too many triangles.

    Args:
        area: Of the surface [m2].
        edge: Wanted length of an edge [m].
        along: Length [m] of all rows of triangles that a shape has however thin it is, one triangle for each edge.

    Raises:
        AssetError: if so; it says which edge is possible.
    """
    expected = max(area / (ROW / 2 * edge**2), along / edge)
    if expected > MAX_TRIANGLES:
        least = max(math.sqrt(area / (ROW / 2 * MAX_TRIANGLES)), along / MAX_TRIANGLES)
        digits = 10.0 ** (math.floor(math.log10(least)) - 1)
        raise AssetError(
            f"with elements of {edge:g} m its surface would have about {expected:,.0f} triangles; at most "
            f"{MAX_TRIANGLES:,} are possible: take a `cell` of {math.ceil(least / digits) * digits:.2g} m or more"
        )
