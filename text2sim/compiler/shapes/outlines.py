"""Outlines of extrusions, in x and z."""

from functools import lru_cache
from typing import Any

import numpy as np
import shapely
from shapely import Polygon

from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.shapes import Extrusion

Ring = tuple[tuple[float, float], ...]

CURVE_POINTS = 24
"""Points of a smooth outline between two of its given points."""


def outlined(shape: Extrusion) -> Polygon:
    """Return what an extrusion covers in x and z [m].

    Raises:
        AssetError: if its outline crosses itself, or a hole is not inside.
    """
    return _polygon(tuple(shape.outline), tuple(map(tuple, shape.holes)), shape.smooth)


@lru_cache(maxsize=256)
def _polygon(outline: Ring, holes: tuple[Ring, ...], smooth: bool) -> Polygon:
    rings = [_curve(ring) if smooth else ring for ring in (outline, *holes)]
    for k, ring in enumerate(rings):
        _check(Polygon(ring), "the outline" if k == 0 else f"hole {k - 1}")
    polygon = Polygon(rings[0], rings[1:])
    if not polygon.is_valid:
        raise AssetError(f"a hole is not inside the outline, or meets another hole: {_reason(polygon)}")
    return polygon


def _check(polygon: Polygon, name: str) -> None:
    if not polygon.is_valid:
        raise AssetError(f"{name} crosses or touches itself: {_reason(polygon)}; give its corners in order")
    if polygon.area <= 0.0:
        raise AssetError(f"{name} has no area: its corners are on one line")


def _reason(polygon: Polygon) -> str:
    return shapely.is_valid_reason(polygon).replace("[", " at x, z = ").removesuffix("]").lower()


def _curve(ring: Ring) -> Any:
    """Return points of the periodic cubic spline through a ring, by the length of its chords, shape (n, 2)."""
    from scipy.interpolate import CubicSpline

    closed = np.array([*ring, ring[0]])
    chords = np.linalg.norm(np.diff(closed, axis=0), axis=1)
    if (chords <= 0.0).any():
        raise AssetError("two points of a smooth outline are the same")
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    places = np.concatenate(
        [np.linspace(a, b, CURVE_POINTS, endpoint=False) for a, b in zip(knots, knots[1:], strict=False)]
    )
    return CubicSpline(knots, closed, bc_type="periodic")(places)
