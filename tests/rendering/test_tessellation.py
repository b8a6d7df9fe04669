"""Cloth that is drawn with finer triangles."""

import numpy as np
import pytest

from text2sim.rendering.tessellation import MAX_RISE, MAX_TRIANGLES, Tessellation


def grid(columns, rows):
    """Points of a grid, as numbers of column and row, and its triangles."""
    u, v = (c.ravel() for c in np.meshgrid(np.arange(columns), np.arange(rows)))
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + columns], axis=1), np.stack([a + 1, a + columns + 1, a + columns], axis=1)]
    )
    return u, v, faces


def roll(u, v, radius=1.0, step=0.4):
    """A roll of cloth around y, of points that are `step` [rad] apart."""
    return np.stack([radius * np.sin(step * u), 0.3 * v, radius * np.cos(step * u)], axis=1)


def test_a_roll_becomes_round_and_its_points_stay():
    """The middle of a chord over an angle a is r (1 - cos a/2) off the circle: 0.02 r for 0.4. An eighth is left."""
    u, v, faces = grid(8, 5)
    points = roll(u, v)
    finer = Tessellation(faces, np.arange(len(points)))
    x, y, z = made = finer.vertices(points).T
    assert len(finer.faces) == 16 * len(faces)
    assert made.T[: len(points)] == pytest.approx(points)
    inner = (np.abs(np.arctan2(x, z) - 1.4) < 0.9) & (np.abs(y - 0.6) < 0.31)  # at margins, normals know one side only
    assert inner.sum() > 100
    assert np.abs(np.hypot(x, z)[inner] - 1).max() < (1 - np.cos(0.2)) / 8


def test_flat_cloth_stays_flat_and_coordinates_are_between():
    u, v, faces = grid(3, 3)
    points = np.stack([u, v, 0 * u], axis=1).astype(float)
    finer = Tessellation(faces, np.arange(9))
    made = finer.vertices(points)
    assert made == pytest.approx(finer.between(points))
    corners = made[finer.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert area[:, 2].sum() / 2 == pytest.approx(4.0)
    assert (area[:, 2] > 0).all(), "no triangle is turned over"
    marked = np.arange(len(faces)) == 0
    center = corners[finer.each(marked)].mean(axis=(0, 1))
    assert center == pytest.approx(points[faces[0]].mean(axis=0)), "the parts of the first triangle"


def test_seams_stay_closed_and_creases_do_not_overshoot():
    u, v, faces = grid(8, 2)
    points = roll(u, v, step=2.0)
    twice = np.concatenate([points, points])
    seam = np.concatenate([faces[::2], faces[1::2] + len(points)])  # neighbours share places, not vertices
    finer = Tessellation(seam, np.tile(np.arange(len(points)), 2))
    ends = finer._levels[0].ends
    middles = finer.vertices(twice)[len(twice) : len(twice) + len(ends)]
    places = {}
    for row, middle in zip((ends % len(points)).tolist(), middles, strict=True):
        places.setdefault(frozenset(row), []).append(middle)
    shared = [two for two in places.values() if len(two) == 2]
    assert shared
    for one, other in shared:
        assert one == pytest.approx(other)
    edges = twice[ends]
    rise, long = middles - edges.mean(axis=1), np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    assert (np.linalg.norm(rise, axis=1) <= MAX_RISE * long + 1e-12).all()


def test_fine_cloth_is_left_as_it_is():
    u, v, faces = grid(150, 150)
    assert len(faces) < MAX_TRIANGLES < 4 * len(faces)
    finer = Tessellation(faces, np.arange(len(u)))
    assert finer.faces is not None
    assert len(finer.vertices(roll(u, v))) == len(u)
