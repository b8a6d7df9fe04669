"""Surfaces of revolution without thickness, by what is known of spheres, cones and discs."""

from math import cos, dist, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.piece import piece_reach
from text2sim.compiler.shapes.regions import region_points
from text2sim.compiler.shapes.revolved import profile_length, revolved_area, rows_of
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.sagging import SHEET_THICKNESS
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.sheets import Revolve

HERE = Path(__file__).parent
R = 0.3


def revolve(profile: list, *, smooth: bool = False) -> Revolve:
    return Revolve.model_validate({"kind": "revolve", "profile": profile, "smooth": smooth})


@pytest.fixture
def dome() -> Revolve:
    """Half of a sphere of radius `R`, rim down, through eight points of its circle."""
    angles = [pi / 2 * k / 7 for k in range(8)]
    return revolve([(R * cos(a) if k < 7 else 0.0, R * sin(a)) for k, a in enumerate(angles)], smooth=True)


def test_a_smooth_dome_is_half_a_sphere(dome):
    assert profile_length(dome) == pytest.approx(pi * R / 2, rel=2e-3)
    assert revolved_area(dome) == pytest.approx(2 * pi * R**2, rel=2e-3)
    mesh = soft_surface(dome, HERE, R / 10)
    assert np.linalg.norm(mesh.vertices, axis=1) == pytest.approx(np.full(len(mesh.vertices), R), rel=5e-3)
    # Seen from outside, triangles are counterclockwise.
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    assert (outward > 0).all()
    # The top is round, not a tip: the ring next to it lies as deep as that of a sphere.
    height = np.unique(mesh.vertices[:, 2])[-2]
    ring = mesh.vertices[mesh.vertices[:, 2] == height]
    assert R - height == pytest.approx(R - sqrt(R**2 - (ring[0, :2] ** 2).sum()), rel=0.2)


def test_a_profile_may_begin_on_the_axis(dome):
    turned = revolve(dome.profile[::-1], smooth=True)
    assert np.array(rows_of(turned, R / 10)) == pytest.approx(np.array(rows_of(dome, R / 10)[::-1]), abs=1e-9)


def test_its_rim_is_its_lower_edge_and_nothing_else(dome):
    mesh = soft_surface(dome, HERE, R / 10)
    rim = region_points(BodyRegion.model_validate({"edge": "bottom"}), mesh.vertices)
    assert sorted(rim) == sorted(np.flatnonzero(mesh.vertices[:, 2] < 1e-9))
    assert len(rim) == round(2 * pi * 10)


def test_it_reaches_as_far_as_its_profile(dome):
    low, high = extents(dome, IDENTITY, HERE)
    assert low == pytest.approx((-R, -R, 0), abs=1e-3)
    assert high == pytest.approx((R, R, R), abs=1e-3)
    reached = max(piece_reach(piece, (0.6, 0.0, 0.8)) for piece in pieces(dome, HERE))
    assert reached == pytest.approx(R, rel=0.02)


@pytest.mark.parametrize(
    "profile", [[(0.3, 0), (0.2, 0.2), (0, 0.3)], [(0, 0.3), (0.2, 0.2), (0.3, 0)], [(0.1, 0), (0.3, 0)]]
)
def test_its_plates_are_as_thick_as_sheets_and_look_outwards(profile):
    shape = revolve(profile)
    total = 0.0
    for piece in pieces(shape, HERE):
        corners = np.array(piece.vertices)[np.array(piece.faces)]
        own = np.linalg.det(corners - np.mean(piece.vertices, axis=0)).sum() / 6
        assert own > 0
        total += own
    # A regular polygon of n corners has sin(2 pi / n) n / (2 pi) of the area of its circle, 1.1 % less with 24.
    assert total == pytest.approx(revolved_area(shape) * SHEET_THICKNESS, rel=0.03)


def test_rows_keep_corners_and_are_even_between_them():
    hat = revolve([(0.3, 0), (0.15, 0), (0.149, 0.1), (0.147, 0.2), (0, 0.2)])
    rows = rows_of(hat, 0.03)
    for corner in ((0.3, 0), (0.15, 0), (0.147, 0.2), (0, 0.2)):
        assert corner in rows
    lengths = [dist(a, b) for a, b in zip(rows, rows[1:], strict=False)]
    assert min(lengths) > 0.025
    assert max(lengths) < 0.035


@pytest.mark.parametrize("end", [(0.05, -0.1), (0, 0.3), (0.05, 0)])
def test_a_smooth_line_of_two_points_has_each_once(end):
    shape = revolve([(0.01, 0), end], smooth=True)
    assert len(set(rows_of(shape, 0.01))) == len(rows_of(shape, 0.01))
    assert soft_surface(shape, HERE, 0.01).faces.size


def test_a_cone_and_a_ring_have_their_areas():
    assert revolved_area(revolve([(0.3, 0), (0, 0.4)])) == pytest.approx(pi * 0.3 * 0.5)
    assert revolved_area(revolve([(0.3, 0), (0.1, 0)])) == pytest.approx(pi * (0.09 - 0.01))


@pytest.mark.parametrize(
    ("profile", "says"),
    [
        ([(0.1, 0), (-0.1, 0.1)], "must not be negative"),
        ([(0, 0), (0, 1)], "lies on the axis"),
        ([(0.1, 0), (0, 0.1), (0.1, 0.2)], "only the first and the last point"),
        ([(0.1, 0), (0.1, 0)], "points 0 and 1 of the profile coincide"),
    ],
)
def test_profiles_that_make_no_surface(profile, says):
    with pytest.raises(ValidationError, match=says):
        revolve(profile)
