"""Surfaces of deformable bodies follow the points of the simulation."""

import numpy as np
import pytest

from text2sim.templates.skins import follow_sheet, follow_solid, nearest

SPACING = 0.1
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def lattice(nx: int, ny: int, nz: int) -> np.ndarray:
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in (nx, ny, nz)), indexing="ij"), axis=-1)
    return (grid.reshape(-1, 3) + 0.5) * SPACING


def shell_of(points: np.ndarray) -> np.ndarray:
    """Vertices half a spacing outside the outermost points: the corners and centres of faces of their box."""
    low, high = points.min(axis=0) - SPACING / 2, points.max(axis=0) + SPACING / 2
    steps = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return low + (high - low) * steps[(steps != 0.5).any(axis=1)]


@pytest.mark.parametrize("size", [(6, 6, 6), (12, 6, 2), (2, 2, 2)])
def test_a_solid_that_turns_and_stretches_takes_its_surface_along(size):
    points = lattice(*size)
    vertices = shell_of(points)
    move = TURN @ np.diag([1.4, 0.8, 1.0])
    where = follow_solid(vertices, points, SPACING)(points @ move.T + 2.0)
    assert np.abs(where - (vertices @ move.T + 2.0)).max() < 0.03 * SPACING


def test_a_solid_one_layer_thick_keeps_its_surface_together():
    points = lattice(12, 12, 1)
    vertices = shell_of(points)
    rng = np.random.default_rng(0)
    where = follow_solid(vertices, points, SPACING)(points + rng.normal(scale=0.02 * SPACING, size=points.shape))
    assert np.abs(where - vertices).max() < SPACING


def grid(n: int, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + n, a + n + 1], axis=1), np.stack([a, a + n + 1, a + 1], axis=1)])
    return np.stack([x.ravel(), y.ravel(), np.full(n * n, height)], axis=1), faces


def test_a_sheet_carries_vertices_on_its_triangles():
    points, faces = grid(8)
    vertices, _ = grid(21)
    skin = follow_sheet(vertices, points, faces)
    assert skin(points) == pytest.approx(vertices, abs=1e-6)
    # Folded along a line that the triangles follow, the sheet stays flat on both sides of it.
    folded = np.where(points[:, :1] > 4 / 7, [[4 / 7, 0, -4 / 7]] + points @ [[0, 0, 1], [0, 1, 0], [0, 0, 0]], points)
    where = skin(folded)
    assert np.abs(np.where(where[:, 0] < 4 / 7 - 1e-6, where[:, 2], where[:, 0] - 4 / 7)).max() < 1e-6


def test_layers_of_cloth_are_not_mixed_up():
    low, faces = grid(6)
    high, _ = grid(6, height=0.01)
    vertices, _ = grid(11, height=0.01)
    points, both = np.concatenate([low, high]), np.concatenate([faces, faces + len(low)])
    lifted = np.concatenate([low, high + [0, 0, 1]])
    assert follow_sheet(vertices, points, both)(lifted)[:, 2] == pytest.approx(np.full(len(vertices), 1.01))


def test_a_vertex_beside_the_sheet_goes_to_its_edge():
    points, faces = grid(3)
    assert follow_sheet(np.array([[1.3, 0.4, 0.2]]), points, faces)(points)[0] == pytest.approx([1.0, 0.4, 0.0])


def test_nearest_points_are_found_in_parts(monkeypatch):
    points, vertices = np.random.default_rng(1).random((2, 40, 3))
    monkeypatch.setattr("text2sim.templates.skins.MAX_DISTANCES", 100)
    found = np.sort(nearest(vertices, points, 5))
    wanted = np.argsort(np.linalg.norm(vertices[:, None] - points, axis=2), axis=1)[:, :5]
    assert (found == np.sort(wanted)).all()
