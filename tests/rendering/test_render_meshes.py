"""Round edges: what is drawn has the outlines of what was simulated."""

import numpy as np
import pytest
from filmed import BOX, BOX_FACES
from scipy.spatial import ConvexHull

from text2sim.rendering.meshes import BEVEL, RenderMesh, boxed_uvs, presentable


def volume(mesh: RenderMesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def agreement(mesh: RenderMesh) -> float:
    """The smallest cosine between a triangle and the normals of its corners."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    return float((flat[:, None] * mesh.normals[mesh.faces]).sum(axis=-1).min())


def hull_faces(vertices: np.ndarray) -> np.ndarray:
    hull = ConvexHull(vertices)
    a, b, c = np.moveaxis(vertices[hull.simplices], 1, 0)
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    return np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)


def test_a_box_gets_round_edges_and_keeps_its_faces() -> None:
    mesh = presentable(BOX * (0.1, 0.05, 0.02), BOX_FACES)
    assert np.allclose(np.abs(mesh.vertices).max(axis=0), (0.1, 0.05, 0.02))
    assert 0.97 * 0.0008 < volume(mesh) < 0.0008
    assert agreement(mesh) > 0.9
    top = mesh.vertices[mesh.vertices[:, 2] > 0.02 - 1e-9]
    radius = BEVEL * 0.04
    assert np.allclose(top.max(axis=0)[:2], (0.1 - radius, 0.05 - radius)), "the face ends where the edge begins"


def test_a_coarse_cylinder_becomes_round() -> None:
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    ring = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle)], axis=1)
    vertices = np.concatenate([np.c_[ring, np.full(32, z)] for z in (-0.2, 0.2)] + [[(0, 0, -0.2), (0, 0, 0.2)]])
    k, n = np.arange(32), (np.arange(32) + 1) % 32
    faces = np.concatenate(
        [np.c_[k, n, k + 32], np.c_[n, n + 32, k + 32], np.c_[n, k, k * 0 + 64], np.c_[k + 32, n + 32, k * 0 + 65]]
    )
    mesh = presentable(vertices, faces)
    assert 0.98 * np.pi * 0.004 < volume(mesh) < np.pi * 0.004
    assert agreement(mesh) > 0.95


@pytest.mark.parametrize("shift", [0.0, 0.2])  # about its middle, and about its centre of mass
@pytest.mark.parametrize("tip", [1, -1])
def test_a_cone_keeps_its_tip(shift: float, tip: int) -> None:
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ring = np.c_[0.17 * np.cos(angle), 0.17 * np.sin(angle), np.full(48, -0.4 + shift)]
    vertices = np.concatenate([ring, [(0, 0, -0.4 + shift), (0, 0, 0.4 + shift)]]) * (1, 1, tip)
    mesh = presentable(vertices, hull_faces(vertices))
    assert agreement(mesh) > 0.95
    z = mesh.vertices[:, 2] * tip
    assert (z.min(), z.max()) == pytest.approx((-0.4 + shift, 0.4 + shift))
    assert volume(mesh) == pytest.approx(np.pi * 0.17**2 * 0.8 / 3, rel=0.02)


def test_the_tip_of_a_top_is_rounded_evenly() -> None:
    """Its many faces meet in one point, and no one of their normals is that of the tip."""
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    vertices = np.concatenate(
        [[(0, 0, -0.06), (0, 0, 0.02)], np.c_[0.03 * np.cos(angle), 0.03 * np.sin(angle), 0 * angle]]
    )
    assert agreement(presentable(vertices, hull_faces(vertices))) > 0.9


def test_a_thin_rod_is_no_ball() -> None:
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    ring = np.stack([0.002 * np.cos(angle), 0.002 * np.sin(angle)], axis=1)
    vertices = np.concatenate([np.c_[ring, np.full(64, z)] for z in (-0.225, 0.225)])
    k, n = np.arange(64), (np.arange(64) + 1) % 64
    faces = np.concatenate([np.c_[k, n, k + 64], np.c_[n, n + 64, k + 64]])
    mesh = presentable(vertices, faces)
    assert np.allclose(np.abs(mesh.vertices).max(axis=0), (0.002, 0.002, 0.225), rtol=0.01)


def test_a_coarse_capsule_becomes_round() -> None:
    turn, angle = np.radians([15.0, 45.0, 75.0, 90.0]), np.arange(12) * np.pi / 6
    rings = [
        np.c_[
            0.02 * np.sin(a) * np.cos(angle),
            0.02 * np.sin(a) * np.sin(angle),
            np.full(12, side * (0.05 + 0.02 * np.cos(a))),
        ]
        for side in (-1, 1)
        for a in turn[::side]
    ]
    vertices = np.concatenate([[(0, 0, -0.07)], *rings, [(0, 0, 0.07)]])
    faces = ConvexHull(vertices).simplices
    mesh = presentable(vertices, faces)
    assert len(mesh.vertices) > 2 * len(vertices)
    away = np.hypot(np.hypot(*mesh.vertices[:, :2].T), np.maximum(np.abs(mesh.vertices[:, 2]) - 0.05, 0))
    assert np.allclose(away, 0.02), "it is the capsule that was simulated"
    assert agreement(mesh) > 0.9


def test_what_is_not_convex_keeps_its_vertices() -> None:
    vertices = np.concatenate([BOX, BOX + (3, 0, 0)])
    mesh = presentable(vertices, np.concatenate([BOX_FACES, BOX_FACES + 8]))
    assert volume(mesh) == pytest.approx(16.0)
    assert {tuple(v) for v in mesh.vertices} == {tuple(v) for v in vertices}


def test_coordinates_are_metres_of_each_face() -> None:
    mesh = boxed_uvs(presentable(BOX * (0.5, 0.1, 0.1), BOX_FACES))
    assert mesh.uvs is not None
    a, b = mesh.faces[:, 0], mesh.faces[:, 1]
    long = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    laid = np.linalg.norm(mesh.uvs[a] - mesh.uvs[b], axis=1)
    assert np.all(laid < long + 1e-9)
    assert laid.sum() > 0.9 * long.sum()


@pytest.mark.parametrize("longest", [0, 1, 2])
def test_grain_runs_along_the_longest_side(longest: int) -> None:
    half = np.full(3, 0.05)
    half[longest] = 0.6
    mesh = boxed_uvs(presentable(BOX * half, BOX_FACES))
    assert mesh.uvs is not None
    flat = np.abs(mesh.normals).max(axis=1) > 0.999
    side = flat & (np.abs(mesh.normals[:, longest]) < 0.01)
    assert np.allclose(mesh.uvs[side, 1], mesh.vertices[side, longest]), "v is along it"
