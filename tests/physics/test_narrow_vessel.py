"""Liquid in narrow cans: walls hold up its level only if they are thick enough for the grid to see them."""

import pytest

from tests.physics.conftest import rows
from text2sim.evidence.crowding import crowding

pytestmark = pytest.mark.engine

CELL, INNER, DEPTH = 0.02, 0.14, 0.1
"""Cell of the grid, inner width of the cans, and depth of the liquid at the start [m]."""
CANS = {"thin": (1.0, ""), "thick": (1.15, ""), "felt": (0.8, "material: {soft_reach: 0.009}, ")}
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
  duration: 0.5
  statics:
    floor: {{shape: {{kind: plane}}}}
{chr(10).join(_can(name, 0.24 * (k - 1)) for k, name in enumerate(CANS))}
bodies:
""" + "\n".join(
    f"  in_{name}: {{kind: liquid, cell: {CELL}, shape: {{kind: box, size: [{INNER - 2e-4}, {INNER - 2e-4}, {DEPTH}]}},"
    f" pose: {{pos: [{0.24 * (k - 1)}, 0, {DEPTH / 2}]}}}}"
    for k, name in enumerate(CANS)
)


def test_a_liquid_keeps_its_level_between_walls_of_more_than_a_cell(simulate):
    """A liquid of constant volume keeps the height of its centre of mass, but for half a cell, as corners fill up.

    Between thinner walls no node of the grid stands still, so that pressure holds nothing up, and the liquid falls into
    itself: evidence tells that its particles crowd.
    """
    trial = simulate(CASE)
    for name in CANS:
        points, _ = rows(trial.states, f"in_{name}")
        height = points[:, :, 2].mean(axis=1)
        sunk = height[0] - height[-1]
        crowded = crowding(trial.recording, next(b for b in trial.states.deformables if b.body == f"in_{name}"))
        assert (crowded is not None) == (name == "thin"), (name, crowded)
        assert sunk > CELL / 2 if name == "thin" else sunk < CELL / 2, f"{name}: {1000 * sunk:.1f} mm"
