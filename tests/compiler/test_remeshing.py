"""Surfaces with triangles of one size, which are the same each time."""

import trimesh

from text2sim.assets.confined import call_in_child
from text2sim.compiler.shapes import remesh


def test_remeshing_runs_in_a_process_of_its_own(monkeypatch):
    """In this one, what was freed before may change the triangles."""
    ball = trimesh.creation.icosphere(3)
    called = []

    def in_child(function, *args):
        called.append(function.__name__)
        return call_in_child(function, *args)

    monkeypatch.setattr(remesh, "call_in_child", in_child)
    vertices, faces = remesh._remesh(ball.vertices, ball.faces, 0.5, 60)
    assert set(called) == {"remesh_isotropically"}
    assert trimesh.Trimesh(vertices, faces).is_volume
    assert len(faces) < len(ball.faces)
