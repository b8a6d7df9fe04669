"""Extrusions: outlines with holes and curves, as solids."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.flatforms import flat_surface, prisms
from text2sim.compiler.shapes.geometry import volume
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.shapes import Extrusion, Shape

HERE = Path(".")
SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
HOLE = [(0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)]


def extrusion(outline: Any, depth: float = 0.2, **fields: Any) -> Extrusion:
    shape = TypeAdapter(Shape).validate_python({"kind": "extrusion", "outline": outline, "depth": depth, **fields})
    assert isinstance(shape, Extrusion)
    return shape


def circle(radius: float, count: int) -> list[tuple[float, float]]:
    turns = 2 * math.pi * np.arange(count) / count
    return list(zip((radius * np.cos(turns)).tolist(), (radius * np.sin(turns)).tolist(), strict=True))


@pytest.mark.parametrize("outline", [SQUARE, SQUARE[::-1]], ids=["counterclockwise", "clockwise"])
def test_prisms_fill_an_outline_whichever_way_round(outline: Any) -> None:
    (prism,) = prisms(extrusion(outline), HERE)
    assert prism.volume() == pytest.approx(0.2)
    assert np.ptp(np.array(prism.vertices), axis=0) == pytest.approx((1.0, 0.2, 1.0))


def test_holes_go_right_through() -> None:
    shape = extrusion(SQUARE, holes=[HOLE])
    assert volume(shape, HERE) == pytest.approx(0.75 * 0.2)
    assert sum(prism.volume() for prism in prisms(shape, HERE)) == pytest.approx(0.75 * 0.2)
    assert all(prism.ball[1] < 0.72 for prism in prisms(shape, HERE)), "none covers the hole"


def test_a_concave_ramp_is_exact_and_drawn_smooth() -> None:
    """A quarter of a circle of radius 1, cut out of a square: 12 chords turn by 7.5 deg each, which is no edge."""
    turns = np.linspace(0, math.pi / 2, 13)
    arc = list(zip((1 - np.sin(turns)).tolist(), (1 - np.cos(turns)).tolist(), strict=True))
    shape = extrusion([(0.0, 0.0), *arc])
    area = 1 - 12 * math.sin(math.pi / 24) / 2  # of the square, less that of 12 triangles
    assert volume(shape, HERE) == pytest.approx(area * 0.2)
    assert sum(prism.volume() for prism in prisms(shape, HERE)) == pytest.approx(area * 0.2)
    surface = flat_surface(shape, HERE)
    walls = np.abs(surface.normals[:, 1]) < 0.5
    bent = walls & (np.abs(surface.normals[:, [0, 2]]).max(axis=1) < 0.999)
    assert bent.sum() >= 2 * 2 * 11, "normals of the curve lie between those of its chords"


def test_a_smooth_outline_is_a_curve_through_its_points() -> None:
    """Eight points of a circle give its area within two thousandths; as straight edges a tenth is missing."""
    smooth, straight = (extrusion(circle(0.1, 8), smooth=value) for value in (True, False))
    full = math.pi * 0.01 * 0.2
    assert volume(smooth, HERE) == pytest.approx(full, rel=2e-3)
    assert volume(straight, HERE) == pytest.approx(full * 8 / math.pi * math.sin(math.pi / 4) / 2)
    assert sum(prism.volume() for prism in prisms(smooth, HERE)) == pytest.approx(full, rel=1e-2)


def test_bounds_and_the_drawn_surface_enclose_it() -> None:
    shape = extrusion([(0.2, 0), (0.6, 0), (0.6, 0.1), (0.3, 0.1), (0.3, 0.5), (0.2, 0.5)])
    low, high = extents(shape, IDENTITY, HERE)
    assert (*low, *high) == pytest.approx((0.2, -0.1, 0, 0.6, 0.1, 0.5))
    mesh = flat_surface(shape, HERE)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(volume(shape, HERE))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"outline": [(0, 0), (1, 1), (1, 0), (0, 1)]}, "the outline crosses or touches itself"),
        ({"outline": [(0, 0), (1, 1), (2, 2)]}, "the outline"),
        ({"outline": SQUARE, "holes": [[(0.5, 0.5), (2, 0.5), (0.5, 0.8)]]}, "a hole is not inside the outline"),
        ({"outline": SQUARE, "holes": [HOLE, HOLE]}, "a hole is not inside the outline, or meets another"),
        ({"outline": [(0, 0), (0, 0), (1, 0), (0, 1)], "smooth": True}, "two points of a smooth outline are the same"),
    ],
)
def test_what_is_no_outline_is_said(fields: Any, message: str) -> None:
    with pytest.raises(AssetError, match=message):
        prisms(extrusion(**fields), HERE)
