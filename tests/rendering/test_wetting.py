"""Liquids are drawn up to the walls that they touch."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from text2sim.rendering.soft import liquid_surface
from text2sim.rendering.wetting import BEFORE, Wall, cut_off, wetted

SPACING = 0.01


def box(low, high):
    import trimesh

    made = trimesh.creation.box(bounds=[low, high])
    return Wall(np.asarray(made.vertices), np.asarray(made.faces), clear=True)


def block(low, high):
    """Particles of a block, half a distance within its bounds."""
    axes = [np.arange(a + SPACING / 2, b, SPACING) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


TANK = [
    box((-0.3, -0.3, -0.05), (0.3, 0.3, 0.0)),
    box((-0.3, -0.3, 0.0), (-0.2, 0.3, 0.4)),
    box((0.2, -0.3, 0.0), (0.3, 0.3, 0.4)),
    box((-0.2, -0.3, 0.0), (0.2, -0.2, 0.4)),
    box((-0.2, 0.2, 0.0), (0.2, 0.3, 0.4)),
]


def test_water_that_stands_apart_from_its_tank_fills_it_to_the_corners():
    water = block((-0.18, -0.18, 0.02), (0.18, 0.18, 0.12))
    wetting = wetted(water, SPACING, TANK)
    assert_array_equal(wetting.points[: len(water)], water)
    assert wetting.points[:, 2].max() == pytest.approx(0.115, abs=1e-9), "the level stays"
    vertices, faces = liquid_surface(wetting.points, SPACING / 2)
    cut, on = cut_off(vertices, wetting, SPACING)
    low, high, before = cut.min(axis=0), cut.max(axis=0), BEFORE * SPACING
    assert low == pytest.approx(np.add((-0.2, -0.2, 0.0), before), abs=1e-6)
    assert high[:2] == pytest.approx(np.subtract((0.2, 0.2), before), abs=1e-6)
    assert np.linalg.norm(cut - low, axis=1).min() < 1e-6, "one vertex lies in the corner"
    assert on.mean() > 0.5
    a, b, c = cut[faces].transpose(1, 0, 2)
    volume = np.einsum("fi,fi->f", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(0.4 * 0.4 * 0.12, rel=0.02)


def test_what_is_further_away_is_not_drawn_out():
    drop = block((-0.02, -0.02, 0.2), (0.02, 0.02, 0.24))
    for meshes in (TANK, []):
        wetting = wetted(drop, SPACING, meshes)
        assert_array_equal(wetting.points, drop)
        assert not len(wetting.places)


@pytest.mark.parametrize("angle", [-60, 60])
def test_what_is_behind_a_pane_is_not_touched(angle):
    pane = box((0.2, -0.3, 0.0), (0.204, 0.3, 0.4))
    others = [TANK[0], box((-0.3, -0.3, 0.0), (-0.2, 0.3, 0.4)), *TANK[3:]]
    straight, turn = box((-0.005, -0.15, -0.05), (0.005, 0.15, 0.05)), np.radians(angle)
    turned = np.array([(np.cos(turn), 0, np.sin(turn)), (0, 1, 0), (-np.sin(turn), 0, np.cos(turn))])
    board = straight._replace(vertices=straight.vertices @ turned.T + (0.254, 0, 0.05))
    water = block((-0.195, -0.195, 0.005), (0.195, 0.195, 0.1))
    alone, beside = (wetted(water, SPACING, [pane, *others, *more]) for more in ([], [board]))
    assert_array_equal(alone.points, beside.points)
    without, touched = (wetted(water, SPACING, [*others, *more]) for more in ([], [board]))
    assert len(touched.points) > len(without.points) + 100, "the board is near enough"


def test_nothing_is_drawn_between_joined_vessels():
    """Their walls stand back to back, over the roof of the channel that joins them; panes end where others begin."""
    glass = [
        box((-0.13, -0.1, -0.02), (0.13, 0.1, 0.0)),
        *(box((x - 0.015, -0.1, 0.0), (x + 0.015, 0.1, 0.3)) for x in (-0.115, 0.115)),
        *(
            box((low, y - 0.01, 0.0), (high, y + 0.01, top))
            for y in (-0.09, 0.09)
            for low, high, top in ((-0.1, -0.01, 0.3), (-0.01, 0.01, 0.08), (0.01, 0.1, 0.3))
        ),
        *(box((x - 0.0075, -0.08, 0.065), (x + 0.0075, 0.08, 0.3)) for x in (-0.0175, 0.0175)),
        box((-0.01, -0.08, 0.065), (0.01, 0.08, 0.08)),
    ]
    sides = [block((low, -0.075, 0.005), (high, 0.075, 0.2)) for low, high in ((-0.095, -0.03), (0.03, 0.095))]
    water = np.concatenate([*sides, block((-0.03, -0.075, 0.005), (0.03, 0.075, 0.06))])
    wetting = wetted(water, SPACING, glass)
    vertices, faces = liquid_surface(wetting.points, SPACING / 2)
    cut, _ = cut_off(vertices, wetting, SPACING)
    middles = cut[faces].mean(axis=1)
    between = (abs(middles[:, 0]) < 0.02) & (middles[:, 2] > 0.08)
    assert between.sum() < 5, "of thousands; in the roof itself there is a thin sheet"
    assert (np.abs(cut[:, 0] - 0.025) < 1e-3).any(), "and yet the water stands at the walls"


def test_a_slope_is_wetted_across_itself():
    slope = np.array([(-1, -1, -1), (1, -1, 1), (1, 1, 1), (-1, 1, -1)], float) * (0.3, 0.3, 0.3)
    normal = np.array([-1, 0, 1]) / np.sqrt(2)
    drop = 0.025 * normal[None]
    wetting = wetted(drop, SPACING, [Wall(slope, np.array([(0, 1, 2), (0, 2, 3)]))])
    assert np.sort(wetting.points @ normal) == pytest.approx([-0.005, 0.005, 0.015, 0.025], abs=1e-6)
    assert not len(wetting.places), "an opaque wall hides what is in it"
    wetting = wetted(drop, SPACING, [Wall(slope, np.array([(0, 1, 2), (0, 2, 3)]), clear=True)])
    assert len(wetting.points) == 5
    assert_allclose(wetting.normals, np.broadcast_to(normal, wetting.normals.shape), atol=1e-9)
    assert_allclose(wetting.places @ normal, BEFORE * SPACING, atol=1e-9)
