"""Liquid in narrow cans keeps its level, however thick the walls are, wherever they stand between nodes, and if they move."""

import numpy as np
import pytest

from tests.physics.conftest import rows
from text2sim.evidence.crowding import crowding

pytestmark = pytest.mark.engine

CELL, INNER, DEPTH = 0.02, 0.14, 0.1
"""Cell of the grid, inner width of the cans, and depth of the liquid at the start [m]."""
CANS = {"thin": (0.5, ""), "thick": (1.15, ""), "felt": (0.8, "material: {soft_reach: 0.009}, ")}
"""Thickness of the walls [cells], and what else is given of a can."""


def _shape(cells: float, base: str = "") -> str:
    wall, parts = cells * CELL, [base] if base else []
    for side, (i, j) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        size = [wall, INNER + 2 * wall, 0.16] if i else [INNER, wall, 0.16]
        middle = [i * (INNER + wall) / 2, j * (INNER + wall) / 2, 0.08]
        parts.append(f"side{side}: {{shape: {{kind: box, size: {size}}}, pose: {{pos: {middle}}}}}")
    return f"{{kind: compound, parts: {{{', '.join(parts)}}}}}"


def _can(name: str, x: float) -> str:
    cells, given = CANS[name]
    return f"    {name}: {{shape: {_shape(cells)}, {given}pose: {{pos: [{x}, 0, 0]}}}}"


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
    """A liquid of constant volume keeps the height of its centre of mass, but for a quarter of a cell, as corners fill up.

    The walls stand half-way between nodes. Where these are not stopped (templates/solid_walls.py), what is in the thin
    can falls into itself within half a second. Where the volume of particles is integrated from velocities alone
    (templates/liquid_volume.py), the lowest layer of a can grows denser, and the centre falls by 3 mm a second.
    """
    trial = simulate(CASE)
    for name in CANS:
        points, _ = rows(trial.states, f"in_{name}")
        height = points[:, :, 2].mean(axis=1)
        assert abs(height[0] - height[-1]) < CELL / 4, f"{name}: {1000 * (height[0] - height[-1]):.1f} mm"
        body = next(one for one in trial.states.deformables if one.body == f"in_{name}")
        assert crowding(trial.recording, body) is None, name


BASE = f"base: {{shape: {{kind: box, size: [{INNER + 0.03}, {INNER + 0.03}, 0.04]}}, pose: {{pos: [0, 0, -0.02]}}}}"
MOVED = (
    f"""
scene: {{duration: 1.2, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  pushed:
    kind: rigid
    shape: {_shape(0.8, BASE)}
    pose: {{pos: [0.003, 0.004, 0.046]}}
    mount: {{kind: slider, axis: x, actuator: {{damping: 3000, max_force: 3000}}}}
  free:
    kind: rigid
    shape: {_shape(1.15, BASE)}
    pose: {{pos: [0.003, 0.304, 0.0401]}}
    material: {{density: 600}}
"""
    + "".join(
        f"  in_{name}: {{kind: liquid, cell: {CELL}, shape: {{kind: box, size: [{INNER - 2e-4}, {INNER - 2e-4}, {DEPTH}]}},"
        f" pose: {{pos: [0.003, {y}, {z + DEPTH / 2 + 1e-4}]}}}}\n"
        for name, y, z in (("pushed", 0.004, 0.046), ("free", 0.304, 0.0401))
    )
    + """actions:
  controls: {move: {kind: drive, joint: pushed, velocity: {kind: ramp, from: 0, to: 0.1, start: 0.3, end: 0.5}}}
"""
)


def test_a_liquid_keeps_its_level_in_a_vessel_that_moves(simulate):
    """Top and centre of mass stay where they are, but for a quarter of a cell.

    Where the nodes at walls that move are not stopped, the top falls by 10 mm and the centre by 15.
    """
    trial = simulate(MOVED)
    for name in ("pushed", "free"):
        points, _ = rows(trial.states, f"in_{name}")
        top, height = np.percentile(points[:, :, 2], 98, axis=1), points[:, :, 2].mean(axis=1)
        assert abs(top[-1] - top[0]) < CELL / 4, f"{name}: {1000 * (top[-1] - top[0]):.1f} mm"
        assert abs(height[0] - height[-1]) < CELL / 4, f"{name}: {1000 * (height[0] - height[-1]):.1f} mm"
    assert rows(trial.states, "in_pushed")[0][-1, :, 0].mean() > 0.07, "the can takes it along"
