"""Particles of mpm bodies beside cloth and in corners."""

import numpy as np

from tests.physics.conftest import rows

SCENE = """
scene:
  duration: 0.15
  dt: 0.005
  record: {rate: 200}
  gravity: [0, 0, 0]
  mpm: {cell: 0.025, bounds: {min: [-0.4, 0.7, 0.1], max: [0.4, 1.3, 0.8]}}
bodies:
  cube:
    kind: soft
    solver: mpm
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {youngs_modulus: 5.0e+4, density: 1000}
    pose: {pos: [-0.09, 1, 0.5]}
  sail:
    kind: cloth
    cell: 0.02
    shape: {kind: sheet, size: [0.08, 0.08]}
    material: {area_density: 10, friction: 0.3, air_resistance: 0}
    pose: {pos: [0, 1, 0.5], euler_deg: [0, 90, 0]}
  feather:
    kind: cloth
    shape: {kind: sheet, size: [0.3, 0.3]}
    material: {area_density: 0.1}
    pose: {pos: [-0.09, 1, 0.57]}
actions:
  controls:
    fly: {kind: initial_velocity, body: cube, linear: [1.5, 0, 0]}
    fall: {kind: initial_velocity, body: feather, linear: [0, 0, -0.5]}
"""


def test_a_soft_body_and_cloth_keep_their_momentum(simulate, agree):
    """They exchange impulses m v without rebound: together they go on with the momentum that the cube had.

    The cube's mass is its 1 kg; the cloths have area times area density, 0.064 and 0.009 kg. Only air takes momentum,
    from the feather. The engine's own contact gives each point of the cloth the whole impulse, and the feather explodes.
    """
    trial = simulate(SCENE)
    masses = {"cube": 1.0, "sail": 0.064, "feather": 0.009}
    momentum = sum(mass * rows(trial.states, name)[0][:, :, 0].mean(axis=1) for name, mass in masses.items())
    speed = np.gradient(momentum, trial.time)
    agree("momentum of cube and cloth", speed[-3], 1.5, within=0.02)
    sail = np.gradient(rows(trial.states, "sail")[0][:, :, 0].mean(axis=1), trial.time)
    assert sail[-3] > 1.0
    assert np.abs(np.diff(rows(trial.states, "feather")[0], axis=0)).max() / 0.005 < 5.0


TROUGH = """
scene:
  duration: 0.2
  dt: 0.005
  statics:
    wall: {shape: {kind: box, size: [0.1, 0.4, 0.2]}, pose: {pos: [-0.15, 0, 0.2]}}
    floor: {shape: {kind: box, size: [0.5, 0.4, 0.1]}, pose: {pos: [0.1, 0, 0.05]}}
bodies:
  snow: {kind: snow, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [0, 0, 0.151]}}
"""


def test_snow_that_fills_a_trough_lies_still(simulate):
    """Flush with floor and wall it was squeezed at the start, hardened by exp(10 (1 - Jp)), and ended in nan."""
    points, _ = rows(simulate(TROUGH).states, "snow")
    assert np.abs(points[-1].mean(axis=0) - points[0].mean(axis=0)).max() < 0.02
