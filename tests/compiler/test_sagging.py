"""Sheets that hang between two edges, over a bar, or in folds."""

from pathlib import Path

import numpy as np
import pytest

from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.regions import end_region
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.sheets import Sheet


@pytest.mark.parametrize("sag", [0.05, 0.4, 0.9])
def test_a_sheet_that_sags_is_as_long_as_ever(sag):
    sheet = Sheet(kind="sheet", size=(2.0, 0.8), sag=sag)
    net = soft_surface(sheet, Path(), 0.02)
    line = net.vertices[np.isclose(net.vertices[:, 1], -0.4)]
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.sum() == pytest.approx(2.0, rel=1e-3)  # chords of a parabola
    assert steps == pytest.approx(steps.mean(), rel=0.02)
    assert line[:, 2].min() == pytest.approx(-sag, abs=1e-3)
    assert line[0, 2] == line[-1, 2] == 0.0
    if sag <= 0.4:  # as the language says of the edges
        assert line[-1, 0] - line[0, 0] == pytest.approx(2.0 - 8 / 3 * sag**2 / 2.0, rel=0.01)
    low, high = extents(sheet, IDENTITY, Path())
    assert low == pytest.approx(net.vertices.min(axis=0), abs=0.03)
    assert high == pytest.approx(net.vertices.max(axis=0), abs=0.03)


def test_the_sides_of_a_sheet_with_gathered_ends_stand_up():
    """A width of 0.9 m lies along the middle; sides hang at 0.7 times its depth about their ends, so that it is a bowl."""
    sheet = Sheet(kind="sheet", size=(2.2, 0.9), sag=0.5, ends=0.2)
    net = soft_surface(sheet, Path(), 0.05)
    rows = net.vertices.reshape(19, 45, 3)
    middle, side = rows[:, 22], rows[0]
    assert np.linalg.norm(np.diff(rows[9], axis=0), axis=1).sum() == pytest.approx(2.2, rel=1e-3)
    assert np.linalg.norm(np.diff(middle, axis=0), axis=1) == pytest.approx(0.05, rel=0.02)
    assert middle[9] == pytest.approx((0, 0, -0.5), abs=1e-9)
    assert side[0, 1] == pytest.approx(-0.1)
    assert np.hypot(middle[0, 1] - side[0, 1], middle[0, 2]) == pytest.approx(0.7 * 0.5)
    assert (np.diff(middle[:10, 2]) < 0).all()
    low, high = extents(sheet, IDENTITY, Path())
    assert low == pytest.approx(net.vertices.min(axis=0), abs=0.01)
    assert high == pytest.approx(net.vertices.max(axis=0), abs=0.01)


def test_a_sheet_hangs_no_deeper_than_it_is_long():
    text = "scene: {duration: 1, dt: 0.01}\nbodies: {s: {kind: cloth, shape: {kind: sheet, size: [1, 1], sag: 0.5}}}\n"
    with pytest.raises(Exception, match="sag may be at most 0.45 of the length, 0.45 m"):
        load_text("text2sim: 2\nname: s\n" + text)


@pytest.mark.parametrize("at", [0.3, 0.5, 0.62])
def test_a_sheet_over_a_bar_is_as_long_as_ever(at):
    """From its left edge up to the bar's top, `at` of its length, and down on the other side."""
    sheet = Sheet(kind="sheet", size=(1.5, 0.3), over=0.05, over_at=at)
    net = soft_surface(sheet, Path(), 0.015)
    line = net.vertices[np.isclose(net.vertices[:, 1], -0.15)]
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.sum() == pytest.approx(1.5, rel=1e-3)  # chords of an arc
    fold = np.pi / 2 * 0.05
    assert line[0] == pytest.approx((-0.05, -0.15, -(1.5 * at - fold)), abs=1e-6)
    assert line[-1] == pytest.approx((0.05, -0.15, -(1.5 * (1 - at) - fold)), abs=1e-6)
    around = line[line[:, 2] > 0]
    assert np.hypot(around[:, 0], around[:, 2]) == pytest.approx(0.05, rel=1e-3)
    low, high = extents(sheet, IDENTITY, Path())
    assert low == pytest.approx(net.vertices.min(axis=0), abs=2e-3)
    assert high == pytest.approx(net.vertices.max(axis=0), abs=2e-3)


@pytest.mark.parametrize(("folds", "fullness"), [(1, 1.2), (6, 1.6), (10, 3.0)])
def test_a_sheet_in_folds_is_as_long_as_ever(folds, fullness):
    sheet = Sheet(kind="sheet", size=(3.0, 0.4), folds=folds, fullness=fullness)
    net = soft_surface(sheet, Path(), 3.0 / folds / 40)
    line = net.vertices[np.isclose(net.vertices[:, 1], -0.2)]
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.sum() == pytest.approx(3.0, rel=5e-3)  # chords of waves
    assert line[-1, 0] - line[0, 0] == pytest.approx(3.0 / fullness, rel=1e-6)
    rising = (line[:-1, 2] < -1e-6) & (line[1:, 2] > -1e-6)
    assert rising.sum() in (folds - 1, folds)  # a vertex may lie on the axis
    low, high = extents(sheet, IDENTITY, Path())
    assert low == pytest.approx(net.vertices.min(axis=0), abs=3e-3)
    assert high == pytest.approx(net.vertices.max(axis=0), abs=3e-3)


@pytest.mark.parametrize(
    ("region", "wanted"),
    [
        ({"edge": "left"}, lambda p: (p[:, 0] < 0) & (p[:, 2] < -0.365)),
        ({"edge": "right"}, lambda p: (p[:, 0] > 0) & (p[:, 2] < -0.965)),
        ({"corner": ["right", "front"]}, lambda p: (p[:, 0] > 0) & (p[:, 2] < -0.965) & (p[:, 1] < -0.144)),
    ],
)
def test_an_edge_of_a_sheet_over_a_bar_is_its_hem(region, wanted):
    """The left end hangs at z = -(0.3 1.5 - pi / 2 0.05) = -0.371, the right one at -0.971; both sides lie in one plane."""
    sheet = Sheet(kind="sheet", size=(1.5, 0.3), over=0.05, over_at=0.3)
    points = soft_surface(sheet, Path(), 0.01).vertices
    box = end_region(sheet, BodyRegion.model_validate(region), 0.005).box
    inside = ((points >= box.min) & (points <= box.max)).all(axis=1)
    assert inside.any()
    assert (inside == wanted(points)).all()
    assert end_region(sheet, face := BodyRegion(face="left"), 0.005) is face
    flat = Sheet(kind="sheet", size=(1.5, 0.3))
    assert end_region(flat, edge := BodyRegion(edge="left"), 0.005) is edge


@pytest.mark.parametrize("region", [{"edge": "left"}, {"corner": ["left", "front"]}, {"corner": ["right", "back"]}])
def test_an_end_of_a_sheet_with_gathered_ends_is_where_it_is_held(region):
    """Its ends are 2 m - 8/3 0.4^2 / 2 m = 1.787 m apart and 1.55 m wide; its sides hang out beyond them."""
    sheet = Sheet(kind="sheet", size=(2.0, 2.0), sag=0.4, ends=1.55)
    points = soft_surface(sheet, Path(), 0.05).vertices
    assert np.abs(points[:, 1]).max() > 0.82
    box = end_region(sheet, BodyRegion.model_validate(region), 0.025).box
    inside = points[((points >= box.min) & (points <= box.max)).all(axis=1)]
    assert len(inside) >= (20 if "edge" in region else 1)
    assert np.abs(inside[:, 0]) == pytest.approx(0.893, abs=0.03)
    assert inside[:, 2] == pytest.approx(0.0, abs=0.03)
    if "corner" in region:
        assert np.abs(inside[:, 1]) == pytest.approx(0.775, abs=0.03)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ("sag: 0.1, over: 0.05", "give at most one of sag, over, folds"),
        ("sag: 0.1, folds: 4", "give at most one of sag, over, folds"),
        ("over: 0.5, over_at: 0.4", "the shorter side must reach around the fold, 0.79 m or more"),
        ("over: 0.1, over_at: 0.1", "the shorter side must reach around the fold, 0.16 m or more"),
        ("over: 0.05, over_at: 1", "less than 1"),
        ("ends: 0.5", "ends needs a sag"),
        ("sag: 0.2, ends: 0.5", "ends must be from 0.52 m to the width, 1 m"),
    ],
)
def test_what_cannot_hang_over_a_bar_is_said(fields, message):
    text = f"scene: {{duration: 1, dt: 0.01}}\nbodies: {{s: {{kind: cloth, shape: {{kind: sheet, size: [1, 1], {fields}}}}}}}\n"
    with pytest.raises(Exception, match=message):
        load_text("text2sim: 2\nname: s\n" + text)
