"""Regions of deformable bodies, which the program finds by where points are at the start.

The engine makes the points of a body itself, so nobody knows before which of them lie in a region.
"""

from pathlib import Path
from typing import Any

from text2sim.compiler.literal import Code, literal
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.regions import RegionError, check_border, check_sides, empty_region_message, end_region
from text2sim.compiler.shapes.rotation import IDENTITY, Vec
from text2sim.compiler.shapes.sagging import SHEET_THICKNESS
from text2sim.spec_schema.models.regions import SIDES, BodyRegion

SIDE_LAYER = {"mpm": 1.0, "pbd": 0.5, "fem": 0.5, "ipc": 0.5}
"""Depth of a side in distances of points: particles fill a body almost at random, vertices lie on its sides."""


def region_finder(region: BodyRegion | None, shape: Any, spacing: float, solver: str, folder: Path) -> Code:
    """Return the constructor of the function that finds the points of a region in the program.

    Args:
        region: The region; the whole body if None.
        shape: Shape of the body.
        spacing: Distance [m] of its points.
        solver: Its solver.
        folder: The case's folder.

    Raises:
        RegionError: if the body does not reach into the region.
        AssetError: if a file of the shape cannot be used.
    """
    if region is None:
        return Code("everything")
    low, high = extents(shape, IDENTITY, folder)
    region = end_region(shape, region, SIDE_LAYER[solver] * spacing)
    if region.sides:
        if shape.kind in ("sheet", "disc"):  # which counts as a thin plate where bodies are placed
            low, high = (*low[:2], 0.0), (*high[:2], 0.0)
        if shape.kind == "ribbon":
            low, high = ([c + sign * SHEET_THICKNESS / 2 for c in side] for side, sign in ((low, 1), (high, -1)))
        check_sides(region, [b - a for a, b in zip(low, high, strict=True)])
        check_border(shape, region)
        sides = ", ".join(literal(SIDES[side]) for side in region.sides)
        return Code(f"sides({sides}, within={literal(SIDE_LAYER[solver] * spacing)})")
    if region.box is not None:
        _check_reach(region.box.min, region.box.max, 0.0, low, high)
        return Code(f"box({literal(tuple(region.box.min))}, {literal(tuple(region.box.max))})")
    if region.sphere is not None:
        middle, radius = region.sphere.center, region.sphere.radius
        _check_reach(middle, middle, radius, low, high)
        return Code(f"ball({literal(tuple(middle))}, {literal(radius)})")
    assert region.nearest is not None
    return Code(f"nearest({literal(tuple(region.nearest))})")


def _check_reach(first: Vec, last: Vec, radius: float, low: Vec, high: Vec) -> None:
    """Check that a box, or a ball about a point, reaches the bounds of the body."""
    gaps = [max(a - d, c - b, 0.0) for a, b, c, d in zip(first, last, low, high, strict=True)]
    away = sum(gap * gap for gap in gaps) ** 0.5 - radius
    if away > 0.0:
        raise RegionError(empty_region_message(away))
