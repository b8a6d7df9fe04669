"""Bodies that stand on cloth on the ground: it carries their weight, and they come to rest."""

import numpy as np
import pytest

pytestmark = pytest.mark.engine

CELL, DENSITY, SIDE, G = 0.02, 0.5, 0.12, 9.81
"""Thickness of cloth as bodies feel it [m], its area density [kg/m^2], side of the cubes [m], gravity [m/s^2]."""
DT, SUBSTEPS = 0.005, 5
MASSES = {"light": 0.25, "heavy": 2.0}
"""Mass of the cubes [kg]."""
CASE = f"""
scene:
  duration: 0.8
  dt: {DT}
  substeps: {SUBSTEPS}
  pbd: {{bounds: {{min: [-0.6, -0.5, -0.2], max: [0.6, 0.5, 0.6]}}}}
  statics: {{floor: {{shape: {{kind: plane}}}}}}
bodies:
  rug: {{kind: cloth, cell: {CELL}, shape: {{kind: sheet, size: [0.6, 0.3]}}, material: {{area_density: {DENSITY}, friction: 0.4}}, pose: {{pos: [0, 0, {CELL / 2}]}}}}
""" + "\n".join(
    f"  {name}: {{kind: rigid, shape: {{kind: box, size: [{SIDE}, {SIDE}, {SIDE}]}}, material: {{mass: {mass}, friction: 0.4}},"
    f" pose: {{pos: [{0.3 * k - 0.15}, 0, {SIDE / 2 + CELL + 0.01}]}}}}"
    for k, (name, mass) in enumerate(MASSES.items())
)


def test_cloth_on_the_ground_carries_what_stands_on_it(simulate):
    """Particles of mass m push with `m d / h^2`, so a weight W on the area A compresses cloth by `W h^2 / (density A)`.

    Of the particles below an edge it is open which are under the cube: up to a whole row of the six on each side.
    """
    trial = simulate(CASE)
    for name, mass in MASSES.items():
        height = trial.pos(name)[trial.time > 0.5][:, 2]
        depth = CELL + SIDE / 2 - height.mean()
        weighed = mass * G * (DT / SUBSTEPS) ** 2 / (DENSITY * SIDE**2)
        assert weighed / 1.5 < depth < weighed * 1.5, f"{name}: {depth * 1000:.2f} mm, not {weighed * 1000:.2f} mm"
        assert np.ptp(height) < 2e-4, f"{name} goes on hopping"


STICK = """
scene:
  duration: 0.8
  dt: 0.004
  substeps: 4
  statics: {{floor: {{shape: {{kind: plane}}, material: {{friction: 0.25}}}}}}
bodies:
  rug:
    kind: cloth
    shape: {{kind: sheet, size: [0.42, 0.36]}}
    cell: {cell}
    material: {{area_density: 2, friction: 0.1, damping: 4}}
    pose: {{pos: [0, 0, {middle}]}}
  stick:
    kind: rigid
    shape:
      kind: compound
      parts:
        foot: {{shape: {{kind: cylinder, radius: 0.04, height: 0.014}}, pose: {{pos: [0, 0, 0.007]}}}}
        stem: {{shape: {{kind: cylinder, radius: 0.011, height: 0.18}}, pose: {{pos: [0, 0, 0.104]}}}}
        candle: {{shape: {{kind: cylinder, radius: 0.012, height: 0.05}}, pose: {{pos: [0, 0, 0.229]}}}}
    material: {{mass: 0.4, friction: 0.9}}
    pose: {{pos: [0.02, 0, {start}]}}
waive: {{foot-on-cloth: the limit is what is tried}}
"""


@pytest.mark.slow
@pytest.mark.parametrize(("cell", "stands"), [(0.03, False), (0.015, True)])
def test_what_stands_on_cloth_needs_a_foot_of_four_cells(simulate, cell, stands):
    trial = simulate(STICK.format(cell=cell, middle=cell / 2, start=cell + 0.002))
    lean = np.degrees(np.arccos(np.clip(trial.turn("stick")[:, 2, 2], -1, 1))).max()
    assert (lean < 1) if stands else (lean > 8)
