"""Steps of the mpm grid that skip empty nodes, transfers to it in turn, and threads change nothing."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from tests.physics.conftest import rows
from text2sim.recording.states import RunStates

SCENE = """
scene:
  duration: 0.2
  statics:
    floor: {shape: {kind: plane}}
    ball: {shape: {kind: sphere, radius: 0.03}, pose: {pos: [0, 0, 0.03]}}
    wall: {shape: {kind: box, size: [0.02, 0.3, 0.2]}, pose: {pos: [0.1, 0, 0.1], euler_deg: [0, 20, 30]}}
  mpm: {cell: 0.02, bounds: {min: [-0.3, -0.2, -0.08], max: [0.3, 0.2, 0.5]}}
bodies:
  water: {kind: liquid, shape: {kind: box, size: [0.08, 0.08, 0.08]}, pose: {pos: [0, 0, 0.11]}}
  dough:
    kind: soft
    solver: mpm
    shape: {kind: box, size: [0.06, 0.06, 0.06]}
    material: {youngs_modulus: 2.0e+4, density: 900, adhesion: 500}
    pose: {pos: [0.08, 0.1, 0.3]}
  sand: {kind: granular, shape: {kind: box, size: [0.04, 0.04, 0.04]}, pose: {pos: [-0.1, 0.1, 0.15]}}
actions:
  controls:
    gust: {kind: wind, direction: x, acceleration: 4}
"""
BODIES = ("water", "dough", "sand")


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(SCENE)


def without(call: str, module: str, trial, warm_engine) -> RunStates:
    """Return the states of a program that lacks a call."""
    other = trial.folder / f"without_{module}"
    shutil.copytree(trial.folder / "program", other / "program")
    path = other / "program" / module
    text = path.read_text()
    shortened = text.replace(f"    {call}\n", "")
    assert shortened != text
    path.write_text(shortened)
    warm_engine.run(other / "program", other)
    return RunStates.load(other)


def test_the_engine_visits_all_nodes_and_comes_to_the_same(trial, warm_engine):
    """Every node that particles do not touch has no mass, so no step depends on it: not a bit differs.

    Water, dough that sticks, solids and wind together use all that happens at nodes. Free bodies would get their forces
    in another order, and differ by how sums are rounded.
    """
    call = "sim.coupler.mpm_grid_op, sim.mpm_solver.reset_dirty_cells = grid.step, grid.clear"
    again = without(call, "grid_step.py", trial, warm_engine)
    for body in BODIES:
        assert np.ptp(rows(trial.states, body)[0][:, :, 2]) > 0.05
        assert np.array_equal(rows(trial.states, body)[0], rows(again, body)[0])


def test_the_engine_adds_atomically_and_comes_to_the_same(trial, warm_engine):
    """The order of sums differs, by 2^-24 of a coordinate in a step, and singular values by 2^-20 of a stretch.

    Where drops part, differences grow. Then the mean of all particles differs by less than a hundredth of a cell.
    """
    again = without('transfer_in_turn(bodies["water"].sim)', "bodies.py", trial, warm_engine)
    for body in BODIES:
        ours, theirs = rows(trial.states, body)[0], rows(again, body)[0]
        assert not np.array_equal(ours, theirs)
        assert np.abs(ours - theirs)[:4].max() < 3e-6
        assert np.abs((ours - theirs).mean(axis=1)).max() < 0.01 * 0.02


def test_threads_change_not_a_bit(trial):
    """What runs on several threads adds nothing up: particles deform and move by themselves."""
    other = trial.folder / "in_threads"
    shutil.copytree(trial.folder / "program", other / "program")
    path = other / "program" / "threads.py"
    text = path.read_text()
    assert "ENOUGH = 16000" in text
    path.write_text(text.replace("ENOUGH = 16000", "ENOUGH = 100"))
    command = [sys.executable, "main.py", "--out", str(other), "--no-film"]
    environment = os.environ | {"QD_NUM_THREADS": "2"}
    subprocess.run(command, cwd=other / "program", env=environment, check=True, capture_output=True)
    again = RunStates.load(other)
    for body in BODIES:
        assert np.array_equal(rows(trial.states, body)[0], rows(again, body)[0])
