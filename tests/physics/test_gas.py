"""Gas in closed cloth, against the breathing of a shell."""

import numpy as np

from tests.physics.conftest import rows

SHELL = """
scene: {duration: 0.026, dt: 0.001, gravity: [0, 0, 0], record: {rate: 1000}}
bodies:
  shell:
    kind: cloth
    cell: 0.04
    shape: {kind: sphere, radius: 0.2}
    material: {area_density: 0.5, pressure: 40, gas_modulus: 2000, stretch_compliance: 100, bending_compliance: 1e4, air_resistance: 0}
"""


def test_a_shell_breathes_on_its_gas(simulate, agree):
    """A sphere of radius R and mass m per area without tension, with gas of pressure p and modulus K.

    `m r'' = p + K (V_start / V - 1)` gives `r = R (1 + p / (3 K) (1 - cos(w t)))` with `w^2 = 3 K / (R m)`, to first
    order in p / K. The second order, and the corners of the hull, are some parts in a hundred.
    """
    trial = simulate(SHELL)
    points, _ = rows(trial.states, "shell")
    radii = np.linalg.norm(points - points.mean(axis=1, keepdims=True), axis=2).mean(axis=1)
    w = np.sqrt(3 * 2000 / (0.2 * 0.5))
    swell = 40 / (3 * 2000) * (1 - np.cos(w * trial.time))
    agree("swelling", radii / radii[0] - 1, swell, within=0.1 * 2 * 40 / (3 * 2000))
    agree("gas pushes nowhere as a whole [m]", points.mean(axis=1), points[0].mean(axis=0), within=1e-5)
