"""Liquid in narrow cans keeps its level, however thick the walls are and wherever they stand between nodes."""

import pytest

from tests.physics.conftest import rows
from text2sim.evidence.crowding import crowding

pytestmark = pytest.mark.engine

CELL, INNER, DEPTH = 0.02, 0.14, 0.1
"""Cell of the grid, inner width of the cans, and depth of the liquid at the start [m]."""
CANS = {"thin": (0.5, ""), "thick": (1.15, ""), "felt": (0.8, "material: {soft_reach: 0.009}, ")}
"""Thickness of the walls [cells], and what else is given of a can."""


def _can(name: str, x: float) -> str:
    cells, given = CANS[name]
    wall, parts = cells * CELL, []
    for side, (i, j) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        size = [wall, INNER + 2 * wall, 0.16] if i else [INNER, wall, 0.16]
        middle = [i * (INNER + wall) / 2, j * (INNER + wall) / 2, 0.08]
        parts.append(f"side{side}: {{shape: {{kind: box, size: {size}}}, pose: {{pos: {middle}}}}}")
    shape = f"{{kind: compound, parts: {{{', '.join(parts)}}}}}"
    return f"    {name}: {{shape: {shape}, {given}pose: {{pos: [{x}, 0, 0]}}}}"


CASE = f"""
scene:
  duration: 1.5
  statics:
    floor: {{shape: {{kind: plane}}}}
{chr(10).join(_can(name, 0.24 * (k - 1)) for k, name in enumerate(CANS))}
bodies:
""" + "\n".join(
    f"  in_{name}: {{kind: liquid, cell: {CELL}, shape: {{kind: box, size: [{INNER - 2e-4}, {INNER - 2e-4}, {DEPTH}]}},"
    f" pose: {{pos: [{0.24 * (k - 1)}, 0, {DEPTH / 2}]}}}}"
    for k, name in enumerate(CANS)
)


def test_a_liquid_keeps_its_level(simulate):
    """A liquid of constant volume keeps the height of its centre of mass, but for half a cell, as corners fill up.

    The walls stand half-way between nodes. Where these are not stopped (templates/solid_walls.py), what is in the thin
    can falls into itself within half a second.
    """
    trial = simulate(CASE)
    for name in CANS:
        points, _ = rows(trial.states, f"in_{name}")
        height = points[:, :, 2].mean(axis=1)
        assert height[0] - height[-1] < CELL / 2, f"{name}: {1000 * (height[0] - height[-1]):.1f} mm"
        body = next(one for one in trial.states.deformables if one.body == f"in_{name}")
        assert crowding(trial.recording, body) is None, name
