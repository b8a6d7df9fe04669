"""A cube between two smooth plates: stress and bulge.

Between frictionless plates it is under plain uniaxial stress: F = E A u / L, and its sides go out by nu u / L, so that
its volume is (1 - e) (1 + nu e)^2 of what it was (Hooke). Stiffness is read from the slope of force over way, which
knows nothing of where contact began. With nu near 0.5 the volume must stay: 1 - (1 - 2 nu) e.

An elasto-plastic cube carries no more than its yield stress (von Mises: in uniaxial stress, that stress itself).
"""

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

E, SIDE, WAY = 1e5, 0.1, 0.012

PRESS = """
scene:
  duration: 1.0
  dt: "${dt}"
  gravity: [0, 0, 0]
  statics: {table: {shape: {kind: box, size: [0.3, 0.3, 0.1]}, material: {friction: 0.01}, pose: {pos: [0, 0, -0.05]}}}
bodies:
  plate:
    kind: rigid
    shape: {kind: box, size: [0.3, 0.3, 0.1]}
    material: {density: 100, friction: 0.01}
    pose: {pos: [0, 0, "${side + 0.05 + gap}"]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 4e5, damping: 4e3}}
  cube:
    kind: soft
    solver: mpm
    shape: {kind: box, size: ["${side}", "${side}", "${side}"]}
    cell: "${cell}"
    material: {youngs_modulus: "${e}", poisson_ratio: "${nu}", density: 1000, friction: 0.01}
    pose: {pos: [0, 0, "${side / 2}"]}
actions:
  controls: {press: {kind: drive, joint: plate, position: {kind: ramp, from: 0, to: "${-way}", start: 0, end: 1.0, ease: linear}}}
"""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver."""
    rows = []
    for solver, cell, dt in (("mpm", SIDE / 8, 0.002), ("fem", SIDE / 3, 0.01)):
        text = PRESS.replace("solver: mpm", f"solver: {solver}")
        fine = f"{solver}, {SIDE / cell:.0f} {'cells' if solver == 'mpm' else 'edges'} thick"
        for nu in (0.0, 0.3, 0.45, 0.49):
            run = lab.run(text, f"press_{solver}", side=SIDE, cell=cell, dt=dt, e=E, nu=nu, way=WAY, gap=0.0)
            modulus, bulge = _stiffness(run), _bulge(run)
            rows.append(Row(f"cube pressed by a tenth, nu {nu:g}: stress over strain [kPa]", fine, E / 1e3, modulus / 1e3))
            rows.append(Row(f"cube pressed by a tenth, nu {nu:g}: bulge over strain", fine, nu, bulge, max(nu, 0.3)))
    flow = 4e3
    text = PRESS.replace("density: 1000,", f"density: 1000, model: elasto_plastic, yield_stress: {flow:g},")
    run = lab.run(text, "press_plastic", side=SIDE, cell=SIDE / 8, dt=0.002, e=E, nu=0.3, way=0.015, gap=0.0)
    way, force = run.joint("plate")
    strain = -np.log(1 + way[-1] / SIDE)
    rows.append(Row("cube pressed until it flows: stress [kPa]", "mpm, 8 cells thick", flow / 1e3, -force[-1] / (SIDE**2 * np.exp(strain)) / 1e3))
    return rows


def _stiffness(run: Run) -> float:
    """E [Pa] from the slope of force over way in the second half of the way."""
    way, force = run.joint("plate")
    half = run.time > 0.5
    slope = np.polyfit(way[half], force[half], 1)[0]
    return float(slope * SIDE / SIDE**2)


def _bulge(run: Run) -> float:
    """How much the sides go out, over how much the height goes down, both from the points, in the second half."""
    points = run.points("cube")
    rest = run.rest("cube")["rest"]
    # The slope of positions over rest positions is a mean strain that needs no surface.
    strains = []
    for axis in range(3):
        x = rest[:, axis] - rest[:, axis].mean()
        strains.append(np.einsum("p,fp->f", x, points[:, :, axis]) / (x @ x) - 1.0)
    half = run.time > 0.5
    return float(-np.polyfit(strains[2][half], (strains[0] + strains[1])[half] / 2, 1)[0])
