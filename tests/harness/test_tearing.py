"""Torn bodies: pieces are what particles nearer than two cells of their grid connect."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from program_modules import load_module

from text2sim.evidence.soft_diagnostics import first_torn
from text2sim.evidence.tearing import MAX_TIED_DISTANCE, pieces

SPACING = 0.01


class Body:
    def __init__(self, *frames: np.ndarray, solver: str = "mpm", torn: Any = None) -> None:
        self.points, self.spacing, self.solver = np.array(frames, np.float32), SPACING, solver
        self.rest, self.torn = frames[0], torn


def bar(stretch: float = 1.0, gap: float = 0.0, lost: int = 0) -> np.ndarray:
    """20 x 4 x 4 particles along x, drawn out, with a gap behind a quarter of them, and some far away."""
    grid = np.stack(np.meshgrid(*map(np.arange, (20.0, 4.0, 4.0)), indexing="ij"), axis=-1).reshape(-1, 3) * SPACING
    grid[:, 0] *= stretch
    grid[80:, 0] += gap
    grid[:lost] += 5.0
    return grid


@pytest.mark.parametrize(
    ("frame", "count", "largest"),
    [
        (bar(), 1, 1.0),
        (bar(stretch=3.0), 1, 1.0),  # 1.9 cells from layer to layer: still tied
        (bar(gap=(MAX_TIED_DISTANCE - 1.2) * SPACING), 1, 1.0),
        (bar(gap=MAX_TIED_DISTANCE * SPACING), 2, 0.75),
        (bar(stretch=3.3), 20, 0.05),
        (bar(lost=1), 1, 319 / 320),  # a particle that is lost is no piece
    ],
)
def test_a_body_is_in_pieces_where_its_particles_let_go(frame: np.ndarray, count: int, largest: float) -> None:
    counts, parts = pieces(Body(bar(), frame))  # type: ignore[arg-type]
    assert counts.tolist() == [1, count]
    assert parts == pytest.approx([1.0, largest])


def test_it_heals_and_elements_never_tear() -> None:
    torn: Any = Body(bar(), bar(gap=0.1), bar())
    counts, parts = pieces(torn)
    assert counts.tolist() == [1, 2, 1]
    assert first_torn(1 - parts, np.array([0.0, 0.1, 0.2])) == {"since": 0.1}
    assert first_torn(np.zeros(2), np.arange(2.0)) == {}
    assert pieces(Body(bar(), bar(gap=0.1), solver="fem"))[0].tolist() == [1, 1]  # type: ignore[arg-type]


def test_what_touches_is_apart_once_it_has_torn() -> None:
    """Two layers have torn across a bar that is as it was: they belong to the halves beside them."""
    torn = np.zeros((3, 320), bool)
    torn[1:, 144:176] = True
    torn[2, :] = True
    counts, parts = pieces(Body(bar(), bar(), bar(), torn=torn))  # type: ignore[arg-type]
    assert counts.tolist() == [1, 2, 1]
    assert parts == pytest.approx([1.0, 0.5, 1.0])
    skewed = torn[:2] & (np.arange(320) % 16 > 0)  # a row has held
    assert pieces(Body(bar(), bar(), torn=skewed))[0].tolist() == [1, 1]  # type: ignore[arg-type]


def test_drag_acts_on_each_point() -> None:
    module = load_module("pushes", points=SimpleNamespace(Points=None, choose=None, each_substep=None))
    push = module.Push.__new__(module.Push)
    velocities = np.array([[5.0, 0, 0], [0.0, 0, 0], [9.0, 9, 9]])
    kept: list[np.ndarray] = []
    push.points = SimpleNamespace(
        velocities=lambda: velocities.copy(), set_velocities=kept.append, masses=np.array([1.0, 1.0, 1.0])
    )
    push.chosen, push.mass, push.h, push.drag, push.now = np.array([0, 1]), 2.0, 0.1, 4.0, np.array([4.0, 0, 0])
    push._substep()
    # Each goes towards F / d = 1 m/s by 1 - exp(-d h / M): the nose that runs ahead is held, the tail is pulled on.
    part = 1 - np.exp(-4.0 * 0.1 / 2.0)
    assert kept[0] == pytest.approx(np.array([[5 - 4 * part, 0, 0], [part, 0, 0], [9, 9, 9]]))
