"""Ribbons: strips along a smooth curve."""

from math import cos, pi, sin

import numpy as np
import pytest
from numpy.testing import assert_allclose
from trimesh import Trimesh

from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.regions import RegionError, end_region
from text2sim.compiler.shapes.ribbons import course, ribbon_length
from text2sim.compiler.shapes.rotation import IDENTITY, quat_rotate
from text2sim.compiler.shapes.softmesh import hull_area, soft_surface
from text2sim.compiler.soft.regions import region_finder
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.sheets import Ribbon

ARC = [(0.3 * cos(a), 0.0, 0.3 * sin(a)) for a in np.linspace(pi, 0, 9)]
HELIX = [(0.2 * cos(a), 0.2 * sin(a), 0.03 * a) for a in np.linspace(0, 4 * pi, 25)]


def ribbon(points, **fields):
    return Ribbon(kind="ribbon", points=[tuple(map(float, point)) for point in points], width=0.05, **fields)


def test_a_ribbon_passes_through_its_points_at_an_even_pace():
    half_circle = ribbon(ARC)
    assert ribbon_length(half_circle) == pytest.approx(0.3 * pi, rel=1e-3)
    found = course(half_circle, 80)
    steps = np.linalg.norm(np.diff(found.places, axis=0), axis=1)
    assert_allclose(steps, steps.mean(), rtol=2e-3)
    assert_allclose(np.linalg.norm(found.places, axis=1), 0.3, rtol=2e-3)


def test_its_width_is_level_at_first_and_square_to_its_course():
    found = course(ribbon(HELIX), 400)
    assert found.across[0, 2] == pytest.approx(0.0, abs=1e-9)
    assert_allclose((found.across * found.along).sum(axis=1), 0.0, atol=1e-9)
    # In a plane nothing turns it.
    assert_allclose(course(ribbon(ARC), 60).across, np.tile([0.0, 1.0, 0.0], (61, 1)), atol=1e-6)


def test_a_helix_turns_it_by_its_torsion():
    """A frame of least twist falls behind that of Frenet by the integral of the torsion: h / (r^2 + h^2) of a helix."""
    found = course(ribbon(HELIX), 2000)
    radial = np.column_stack([found.places[:, :2], np.zeros(2001)])
    radial -= (radial * found.along).sum(axis=1, keepdims=True) * found.along
    radial /= np.linalg.norm(radial, axis=1, keepdims=True)
    side = np.cross(found.along, radial)
    angle = np.unwrap(np.arctan2((found.across * side).sum(axis=1), (found.across * radial).sum(axis=1)))
    middle = slice(400, 1600)  # the spline is free at its ends
    turned = abs(np.ptp(angle[middle]))
    torsion = 0.03 / (0.2**2 + 0.03**2)
    assert turned == pytest.approx(torsion * found.length * 0.6, rel=0.01)


def test_turns_twist_it_by_the_right_hand_rule():
    found = course(ribbon([(-0.5, 0, 0), (0.5, 0, 0)], turns=0.25), 4)
    assert_allclose(found.across[0], (0, 1, 0), atol=1e-9)
    assert_allclose(found.across[-1], (0, 0, 1), atol=1e-9)


def test_its_mesh_has_even_cells_and_lies_within_its_bounds(tmp_path):
    loop = ribbon(HELIX)
    net = soft_surface(loop, tmp_path, 0.01)
    edges = np.linalg.norm(net.vertices[net.faces] - net.vertices[np.roll(net.faces, 1, axis=1)], axis=2)
    assert 0.006 < edges.min() and edges.max() < 0.02
    assert hull_area(loop, tmp_path) == pytest.approx(0.05 * ribbon_length(loop), rel=0.03)
    low, high = extents(loop, IDENTITY, tmp_path)
    assert (net.vertices >= np.subtract(low, 1e-4)).all() and (net.vertices <= np.add(high, 1e-4)).all()


def test_boxes_stand_for_it_that_follow_its_course(tmp_path):
    boxes = pieces(ribbon(HELIX, turns=1.0), tmp_path)
    places = course(ribbon(HELIX, turns=1.0), len(boxes)).places
    for k, box in enumerate(boxes):
        assert_allclose(box.pos, (places[k] + places[k + 1]) / 2, atol=1e-9)
        along = np.subtract(places[k + 1], places[k])
        assert_allclose(quat_rotate(box.quat, (1, 0, 0)), along / np.linalg.norm(along), atol=1e-6)


def test_points_that_coincide_are_refused():
    with pytest.raises(ValueError, match="points 1 and 2 coincide"):
        ribbon([(0, 0, 0), (1, 0, 0), (1, 0, 0)])


def test_its_ends_are_edges_wherever_they_are() -> None:
    """The first end of a bow is not what lies furthest to the left."""
    bow = ribbon(
        [(-0.1, 0, -0.3), (0, 0, 0), (-0.4, 0, 0.1), (0, 0, 0.2), (0.4, 0, 0.1), (0.05, 0.1, 0), (0.1, 0, -0.3)]
    )
    box = end_region(bow, BodyRegion(edge="left"), 0.01).box
    assert box is not None
    assert_allclose(box.min, (-0.11, -0.035, -0.31), atol=5e-3)
    assert_allclose(box.max, (-0.09, 0.035, -0.29), atol=5e-3)


def test_a_flat_ribbon_has_no_top_edge(tmp_path) -> None:
    flat = ribbon([(-0.5, 0, 0), (0, 0.1, 0), (0.5, 0, 0)])
    with pytest.raises(RegionError, match="it is flat, and has no top"):
        region_finder(BodyRegion(edge="top"), flat, 0.02, "pbd", tmp_path)


RING = [(0.3 * cos(a), 0.0, 0.3 * sin(a)) for a in np.linspace(0, 2 * pi, 9)]
TREFOIL = [(sin(a) + 2 * sin(2 * a), cos(a) - 2 * cos(2 * a), -sin(3 * a)) for a in np.linspace(0, 2 * pi, 31)]


@pytest.mark.parametrize("points", [RING, TREFOIL])
def test_a_band_whose_last_point_is_its_first_has_no_ends(points, tmp_path):
    band = ribbon(points)
    mesh = soft_surface(band, tmp_path, 0.01)
    net = Trimesh(mesh.vertices, mesh.faces, process=False)
    assert net.is_winding_consistent and net.euler_number == 0  # of a band without ends
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    found = course(band, 4000)
    assert_allclose(found.across[0], found.across[-1], atol=1e-6)
    assert_allclose(found.along[0], found.along[-1], atol=1e-6)


def test_edges_of_a_band_are_its_rims(tmp_path) -> None:
    band = ribbon(RING)
    assert "sides((1, -1)" in region_finder(BodyRegion(edge="front"), band, 0.01, "pbd", tmp_path)
    for side in ("left", "top"):
        with pytest.raises(RegionError, match=f"ribbon has no border {side}, but front, back"):
            region_finder(BodyRegion.model_validate({"edge": side}), band, 0.01, "pbd", tmp_path)
    with pytest.raises(RegionError, match="ribbon has no border top, but left, right, front, back"):
        region_finder(BodyRegion(edge="top"), ribbon(ARC), 0.01, "pbd", tmp_path)


def test_a_band_needs_whole_turns_and_three_places():
    with pytest.raises(ValueError, match="needs whole turns"):
        ribbon(RING, turns=0.5)
    with pytest.raises(ValueError, match="needs 4 points"):
        ribbon([(0, 0, 0), (1, 0, 0), (0, 0, 0)])
