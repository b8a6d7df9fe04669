"""Dots on curved surfaces: round, whole, and nowhere across an edge."""

import numpy as np
import trimesh

from text2sim.rendering.dots import RADIUS, SPACING, dot_picture, dotted

SIZE = 0.04


def test_dots_on_a_curved_surface_are_round_and_keep_their_distance() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.1)
    found = dotted(np.asarray(ball.vertices), np.asarray(ball.faces), SIZE)
    assert found is not None
    corners, uvs = ball.vertices[found.vertices][found.faces], found.uvs[found.faces]
    away = np.linalg.norm(uvs - SIZE, axis=2)
    inked = (away < RADIUS * SIZE).all(axis=1)
    lengths, flat = (np.linalg.norm(rows - np.roll(rows, 1, axis=1), axis=2) for rows in (corners, uvs))
    np.testing.assert_allclose(flat[inked], lengths[inked], rtol=0.02)
    # The densest packing of discs of the spacing covers at most pi / (2 sqrt 3) of a plane; random ones about half.
    share = ball.area_faces[inked].sum() / ball.area
    assert 0.1 < share < 0.91 * (2 * RADIUS / SPACING) ** 2


def test_no_dot_lies_across_an_edge() -> None:
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    for _ in range(5):
        box = box.subdivide()
    found = dotted(np.asarray(box.vertices), np.asarray(box.faces), SIZE)
    assert found is not None
    corners, uvs = box.vertices[found.vertices][found.faces], found.uvs[found.faces]
    inked = (np.linalg.norm(uvs - SIZE, axis=2) < RADIUS * SIZE).any(axis=1)
    assert inked.any()
    # Projected from another face, a triangle would be shorter.
    lengths, flat = (np.linalg.norm(rows - np.roll(rows, 1, axis=1), axis=2) for rows in (corners, uvs))
    np.testing.assert_allclose(flat[inked], lengths[inked], rtol=1e-6)


def test_triangles_that_are_larger_than_dots_get_none() -> None:
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    assert dotted(np.asarray(box.vertices), np.asarray(box.faces), SIZE) is None


def test_the_corners_of_a_tile_show_the_body() -> None:
    picture = dot_picture((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert picture[0, 0, 3] == 0.0
    assert picture[64, 64].tolist() == [1.0, 0.0, 0.0, 1.0]
    assert 0.9 < picture[..., 3].sum() / (np.pi * (RADIUS * 64) ** 2) < 1.1
