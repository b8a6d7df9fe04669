"""Normals of drawn surfaces."""

import numpy as np
import pytest
import trimesh

from text2sim.templates.shading import Shell


def test_a_box_has_flat_sides_and_a_ball_has_none():
    box = trimesh.creation.box((1, 1, 1)).subdivide()
    shell = Shell(np.asarray(box.vertices), np.asarray(box.faces))
    normals = shell.normals(np.asarray(box.vertices))
    assert np.sort(np.abs(normals), axis=1) == pytest.approx(np.tile([0, 0, 1], (len(normals), 1)), abs=1e-6)
    # Eight corners are drawn three times, the middles of twelve edges twice, the middles of six sides once.
    assert len(shell.sources) == 8 * 3 + 12 * 2 + 6
    ball = trimesh.creation.icosphere(subdivisions=2)
    shell = Shell(np.asarray(ball.vertices), np.asarray(ball.faces))
    assert len(shell.sources) == len(ball.vertices)
    assert (shell.normals(np.asarray(ball.vertices)) * ball.vertices[shell.sources]).sum(axis=1).min() > 0.99


def test_normals_follow_a_surface_that_bends():
    x = np.linspace(0, 1, 11)
    flat = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((11, 11))], axis=-1).reshape(-1, 3)
    a = (np.arange(10)[:, None] * 11 + np.arange(10)).ravel()
    faces = np.concatenate([np.stack([a, a + 11, a + 12], axis=1), np.stack([a, a + 12, a + 1], axis=1)])
    shell = Shell(flat, faces)
    angle = np.pi * flat[:, 0]
    rolled = np.stack([np.sin(angle), flat[:, 1], 1 - np.cos(angle)], axis=1)
    wanted = np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], axis=1)[shell.sources]
    inner = (flat[shell.sources][:, 0] > 0) & (flat[shell.sources][:, 0] < 1)
    assert (shell.normals(rolled) * wanted).sum(axis=1)[inner].min() > 0.99
    assert len(shell.sources) == len(flat)


def test_a_seam_of_the_texture_is_not_seen_in_the_light():
    # Two triangles that share an edge in space, but no vertex: their texture coordinates differ there.
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.2], [1, 0, 0], [1, 1, 0], [0, 1, 0.2]], float)
    shell = Shell(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    normals = shell.normals(vertices)
    assert sorted(shell.sources.tolist()) == [0, 1, 2, 3, 4, 5]
    by_vertex = normals[np.argsort(shell.sources)]
    assert by_vertex[1] == pytest.approx(by_vertex[3])
    assert by_vertex[2] == pytest.approx(by_vertex[5])


def test_a_triangle_without_area_has_a_normal_all_the_same():
    shell = Shell(np.eye(3), np.array([[0, 1, 2]]))
    assert np.linalg.norm(shell.normals(np.zeros((3, 3))), axis=1) == pytest.approx([1, 1, 1])


def test_a_triangle_that_spans_a_gap_is_not_whole():
    from text2sim.templates.shading import Shell

    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], float)
    shell = Shell(vertices, np.array([(0, 1, 2), (1, 3, 2)]))
    away = vertices + (vertices[:, :1] * (2, 0, 0)) * (vertices[:, 1:2] < 0.5)  # one corner goes 2 m off
    assert shell.whole(vertices, 0.5).all()
    assert shell.whole(away, 2.5).all(), "stretched, not torn"
    apart = vertices.copy()
    apart[3] += 3.0
    assert shell.whole(apart, 1.0).tolist() == [True, False]
