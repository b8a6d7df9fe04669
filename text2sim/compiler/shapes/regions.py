"""Regions on bodies: which vertices lie in them, and where their middle is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.sagging import hem
from text2sim.compiler.shapes.skin import SurfaceSkin
from text2sim.spec_schema.models.regions import SIDES, BodyRegion
from text2sim.spec_schema.models.sheets import Ribbon, Sheet

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

SIDE_DEPTH = 1e-3
"""A side reaches this part of the body's length inwards."""
_AROUND = ("left", "right", "front", "back")
BORDERS = {
    "sheet": _AROUND,
    "disc": _AROUND,
    "ribbon": _AROUND,
    "sleeve": ("bottom", "top"),
    "revolve": ("bottom", "top"),
}
"""Sides on which cloths have a border, which is what `edge` means of them."""
FLATNESS = 1e-6
"""A body thinner than this part of its longest side is flat."""


class RegionError(ValueError):
    """A region in which there is nothing; the message says how far the nearest vertex is."""


def region_points(region: BodyRegion, vertices: "np.ndarray") -> "np.ndarray":
    """Return which vertices of a body lie in a region.

    Args:
        region: The region.
        vertices: (n, 3) float [m], in the body's own frame, before it is turned or bent.

    Returns:
        Their indices in increasing order, at least one.

    Raises:
        RegionError: if there are none.
    """
    import numpy as np

    if region.nearest is not None:
        return np.array([int(np.linalg.norm(vertices - region.nearest, axis=1).argmin())])
    apart = _distances(region, vertices)
    found = np.flatnonzero(apart <= 0.0)
    if len(found) == 0:
        raise RegionError(empty_region_message(float(apart.min())))
    return found


def region_middle(region: BodyRegion, skin: SurfaceSkin) -> Vec:
    """Return the middle [m] of a region of a surface, in the body's own frame.

    For a side, an edge or a corner it lies there, half way along; for a box or a ball it is the centroid of the surface
    inside; for a nearest point it is that point.

    Raises:
        RegionError: if nothing lies in the region.
    """
    import numpy as np

    if region.nearest is not None:
        return _vec(skin.nearest(region.nearest)[0])
    points, areas = skin.samples
    if region.sphere is not None:
        # A small ball may lie between the points, and still meet the surface.
        point, apart = skin.nearest(region.sphere.center)
        if apart > region.sphere.radius:
            raise RegionError(empty_region_message(apart - region.sphere.radius))
        points, areas = np.vstack([points, point]), np.append(areas, 0.0)
    found = region_points(region, points)
    if not region.sides:
        weights = areas[found] if areas[found].sum() > 0 else None
        return _vec(np.average(points[found], axis=0, weights=weights))
    low, high = skin.bounds
    middle = (points[found].min(0) + points[found].max(0)) / 2
    for side in region.sides:
        axis, sign = SIDES[side]
        middle[axis] = high[axis] if sign > 0 else low[axis]
    return _vec(middle)


def _vec(point: "np.ndarray") -> Vec:
    """Return a point rounded, for the program to print."""
    x, y, z = (round(c, 9) + 0.0 for c in point.tolist())
    return (x, y, z)


def _distances(region: BodyRegion, vertices: "np.ndarray") -> "np.ndarray":
    """Return how far [m] each vertex is from the region; 0 inside."""
    import numpy as np

    if region.sphere is not None:
        return np.maximum(np.linalg.norm(vertices - region.sphere.center, axis=1) - region.sphere.radius, 0.0)
    if region.box is not None:
        low, high = np.array(region.box.min), np.array(region.box.max)
        return np.linalg.norm(np.maximum(np.maximum(low - vertices, vertices - high), 0.0), axis=1)
    low, high = vertices.min(0), vertices.max(0)
    size = high - low
    check_sides(region, size.tolist())
    missing = np.zeros(len(vertices))
    for side in region.sides:
        axis, sign = SIDES[side]
        away = high[axis] - vertices[:, axis] if sign > 0 else vertices[:, axis] - low[axis]
        missing += np.maximum(away - SIDE_DEPTH * size[axis], 0.0) ** 2
    return np.sqrt(missing)


def check_sides(region: BodyRegion, size: Sequence[float]) -> None:
    """Check that a body with sides of these lengths [m] has the sides that an edge or corner names.

    Raises:
        RegionError: if it is flat there.
    """
    flat = FLATNESS * max(size)
    for side in region.sides if region.face is None else ():
        if size[SIDES[side][0]] <= flat:
            sides_there = [name for name, (k, _) in SIDES.items() if size[k] > flat]
            raise RegionError(f"it is flat, and has no {side}; it has {', '.join(sides_there)}")


def check_border(shape: Any, region: BodyRegion) -> None:
    """Check that the edge of a cloth that a region names is a part of its border.

    Raises:
        RegionError: if it has no border there.
    """
    if region.edge is None or getattr(shape, "kind", None) not in BORDERS:
        return
    there = BORDERS[shape.kind]
    if isinstance(shape, Ribbon) and shape.closed:
        there = ("front", "back")
    if not set(region.sides) & set(there):
        face = f"`face: {region.sides[0]}` is what lies outermost there"
        raise RegionError(f"this {shape.kind} has no border {region.sides[0]}, but {', '.join(there)}; {face}")


def end_region(shape: Any, region: BodyRegion, within: float) -> BodyRegion:
    """Return a region; for an end of a ribbon, or of a sheet over a bar, the box around the hem there.

    Args:
        shape: Shape of the body.
        region: The region.
        within: How deep a side is [m].
    """
    corners: Sequence[Sequence[float]] | None = None
    if isinstance(shape, Ribbon) and not shape.closed and region.edge in ("left", "right"):
        from text2sim.compiler.shapes.ribbons import ribbon_corners

        hems = [side[0 if region.edge == "left" else -1].tolist() for side in ribbon_corners(shape, 1)]
        corners = [[f(pair) for pair in zip(*hems, strict=True)] for f in (min, max)]
    elif isinstance(shape, Sheet) and region.face is None:
        corners = hem(shape, region.sides)
    if corners is None:
        return region
    block = {"min": [c - within for c in corners[0]], "max": [c + within for c in corners[1]]}
    return BodyRegion.model_validate({"box": block})


def empty_region_message(away: float) -> str:
    """Say that nothing lies in a region, and how far away [m] the body is."""
    length = f"{away:.3g} m" if away >= 0.1 else f"{away * 1000:.3g} mm"
    return f"nothing of it lies in this region; the nearest point of it is {length} away"
