"""Solids with a yield stress and a viscosity, against the law of Bingham."""

import numpy as np

from tests.physics.conftest import rows

DENSITY, GRAVITY, HEIGHT, E, YIELD = 1000.0, 9.81, 0.12, 5e4, 500.0
BODIES = {"firm": (2500.0, 40.0), "quick": (YIELD, 40.0), "slow": (YIELD, 400.0), "slower": (YIELD, 800.0), "plain": (YIELD, 0.0)}
"""Yield stress [Pa] and viscosity [Pa s] by name."""
COLUMNS = """
scene: {duration: 0.8, dt: 0.004, record: {rate: 50}, statics: {floor: {shape: {kind: plane}, material: {friction: 0.01}}}}
bodies:
"""
COLUMN = """
  {name}:
    kind: soft
    solver: mpm
    cell: 0.01
    shape: {{kind: box, size: [0.06, 0.06, 0.12]}}
    material: {{model: elasto_plastic, youngs_modulus: 5e4, poisson_ratio: 0.4, yield_stress: {limit}, viscosity: {viscosity}}}
    pose: {{pos: [{x}, 0, 0.065]}}
"""


def test_columns_sink_at_the_rate_of_their_viscosity_to_a_height_that_does_not_depend_on_it(simulate, agree):
    """On a smooth floor each layer is under uniaxial stress, as in the slump test (Pashias et al., J. Rheology, 1996)."""
    columns = [
        COLUMN.format(name=name, limit=limit, viscosity=viscosity, x=0.2 * k)
        for k, (name, (limit, viscosity)) in enumerate(BODIES.items())
    ]
    trial = simulate(COLUMNS + "".join(columns))
    sunk = {}
    for name in BODIES:
        points, _ = rows(trial.states, name)
        top, bottom = (points[:, part, 2].mean(axis=1) for part in ends(points[0, :, 2]))
        sunk[name] = (top - bottom)[0] - (top - bottom)
    print(trial.time[::2])
    for name, (limit, viscosity) in BODIES.items():
        print(name, (1e3 * sunk[name][::2]).round(2))
        if viscosity: print("theory", (1e3 * sinking(trial.time, limit, viscosity)[::2]).round(2))
    assert 0


def ends(z):
    """Return which points are the uppermost and the lowest centimetre."""
    return z > z.max() - 0.01, z < z.min() + 0.01


def sinking(time, limit, viscosity):
    """Return by how much the middle of the uppermost centimetre comes nearer to that of the lowest [m], shape (F,).

    A layer that bore the weight w per area of what is above it, and has the stretch l, bears w l, since its volume stays.
    It is stretched elastically by exp(-w l / E), and flows as d(ln l)/dt = -(w l - limit) / (3 viscosity).
    """
    layer = np.linspace(0.005, HEIGHT - 0.005, 111)
    weight, flown, step, heights = DENSITY * GRAVITY * (HEIGHT - layer), np.zeros(111), 1e-3, []
    for _ in range(round(time[-1] / step) + 1):
        stress = weight * np.exp(flown)
        heights.append(np.trapezoid(1 - np.exp(flown - stress / E), layer))
        flown = flown - step * np.maximum(stress - limit, 0) / (3 * viscosity)
    return np.interp(time, step * np.arange(len(heights)), heights)
