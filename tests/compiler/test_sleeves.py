"""Sleeves: open tubes of cloth."""

from math import hypot, pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from trimesh import Trimesh

from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.regions import RegionError, region_points
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.compiler.soft.lowering import area
from text2sim.compiler.soft.regions import region_finder
from text2sim.compiler.soft.scales import sheet_size
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.sheets import Sleeve

SLEEVE = Sleeve(kind="sleeve", radius=0.06, height=0.4)
SKIRT = Sleeve(kind="sleeve", radius=0.3, top_radius=0.12, height=0.5)


@pytest.mark.parametrize("shape", [SLEEVE, SKIRT])
def test_it_is_an_open_tube_of_even_triangles_without_a_seam(shape, tmp_path):
    mesh = soft_surface(shape, tmp_path, 0.01)
    net = Trimesh(mesh.vertices, mesh.faces, process=False)
    assert net.is_winding_consistent
    assert net.euler_number == 0  # of a tube; a closed hull has 2, a sheet 1
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert (net.face_normals * net.triangles_center)[:, :2].sum(axis=1).min() > 0, "it looks outwards"
    assert 0.007 < net.edges_unique_length.min() and net.edges_unique_length.max() < 0.014
    low, high = shape.radii
    # A polygon of n corners lacks (pi / n)^2 / 6 of its circle, 0.1 % with 40.
    assert net.area == pytest.approx(pi * (low + high) * hypot(shape.height, high - low), rel=4e-3)
    assert area(shape, tmp_path) == pytest.approx(pi * (low + high) * hypot(shape.height, high - low))


def test_its_rims_are_its_edges(tmp_path):
    mesh = soft_surface(SKIRT, tmp_path, 0.01)
    net = Trimesh(mesh.vertices, mesh.faces, process=False)
    edges, count = np.unique(net.edges_sorted, axis=0, return_counts=True)
    border = set(edges[count == 1].ravel().tolist())
    rims = [set(region_points(BodyRegion(edge=side), mesh.vertices).tolist()) for side in ("bottom", "top")]
    assert rims[0] | rims[1] == border
    assert "sides((2, 1)" in region_finder(BodyRegion(edge="top"), SKIRT, 0.01, "pbd", tmp_path)
    with pytest.raises(RegionError, match=r"sleeve has no border left, but bottom, top; `face: left` is"):
        region_finder(BodyRegion(edge="left"), SKIRT, 0.01, "pbd", tmp_path)


def test_it_lies_within_its_bounds_and_staves_stand_for_it(tmp_path):
    assert_allclose(extents(SKIRT, IDENTITY, tmp_path), ((-0.3005, -0.3005, -0.25), (0.3005, 0.3005, 0.25)))
    staves = geometry.pieces(SLEEVE, tmp_path)
    radii = [hypot(x, y) for stave in staves for x, y, _ in stave.vertices]
    assert 0.0595 <= min(radii) and max(radii) < 0.0605 * 1.005
    assert sheet_size(SLEEVE, tmp_path) == pytest.approx((2 * pi * 0.06, 0.4))
