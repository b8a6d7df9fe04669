"""Liquids keep their volume: after a splash, and in a drop that is alone."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

INNER, DEPTH = 0.206, 0.0353
"""Inner width of the tank, and depth [m] that 1.5 litres have in it."""
SPLASH = """
scene:
  duration: 1.4
  statics:
    base: {shape: {kind: box, size: [0.26, 0.26, 0.06]}, pose: {pos: [0, 0, -0.03]}}
    left: {shape: {kind: box, size: [0.03, 0.26, 0.24]}, pose: {pos: [-0.118, 0, 0.12]}}
    right: {shape: {kind: box, size: [0.03, 0.26, 0.24]}, pose: {pos: [0.118, 0, 0.12]}}
    back: {shape: {kind: box, size: [0.206, 0.03, 0.24]}, pose: {pos: [0, 0.118, 0.12]}}
    front: {shape: {kind: box, size: [0.206, 0.03, 0.24]}, pose: {pos: [0, -0.118, 0.12]}}
bodies:
  water: {kind: liquid, cell: 0.0125, shape: {kind: box, size: [0.1, 0.1, 0.15]}, pose: {pos: [0, 0, 0.4]}}
"""


def test_what_splashed_has_its_volume_again_and_no_drop_runs_away(simulate):
    """What fell into a tank rests with its centre at half its depth, and half a cell above it: particles keep away from walls.

    Nothing ends faster than it could fall. Where the volume of particles is integrated from velocities alone, drops fly
    off at 9 m/s and end in nan.
    """
    trial = simulate(SPLASH)
    points, _ = rows(trial.states, "water")
    assert np.isfinite(points).all()
    speed = np.linalg.norm(np.diff(points, axis=0), axis=2).max() / np.diff(trial.time).min()
    assert speed < 1.25 * np.sqrt(2 * 9.81 * 0.475)
    height = points[-1, :, 2].mean()
    assert abs(points[-1, :, :2]).max() < INNER / 2
    assert DEPTH / 2 < height < DEPTH / 2 + 0.0125 / 2, f"{1000 * height:.1f} mm"
