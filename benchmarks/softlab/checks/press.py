"""A cube between two smooth plates: stress and bulge.

Between frictionless plates it is under plain uniaxial stress: F = E A e, and its sides go out by nu e (Hooke), so that
with nu near 0.5 the volume stays. Strain is that of the points of its inside, force that of the plate's motor. The
strain that the plate's way stands for is compared with it apart: a grid feels a plate where its nodes are, up to half a
cell from where it is, on either side, so that a short way is not followed.

An elasto-plastic cube carries no more than its yield stress (von Mises: in uniaxial stress, that stress itself).
"""

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

E, SIDE, WAY = 1e5, 0.1, 0.02

PRESS = """
scene:
  duration: 0.3
  dt: "${dt}"
  gravity: [0, 0, 0]
  statics: {table: {shape: {kind: box, size: [0.3, 0.3, 0.1]}, material: {friction: 0.01}, pose: {pos: [0, 0, -0.05]}}}
bodies:
  plate:
    kind: rigid
    shape: {kind: box, size: [0.3, 0.3, 0.1]}
    material: {density: 100, friction: 0.01}
    pose: {pos: [0, 0, "${side + 0.05}"]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 5e4, damping: 200}}
  cube:
    kind: soft
    solver: mpm
    shape: {kind: box, size: ["${side}", "${side}", "${side}"]}
    cell: "${cell}"
    material: {youngs_modulus: "${e}", poisson_ratio: "${nu}", density: 1000, friction: 0.01}
    pose: {pos: [0, 0, "${side / 2}"]}
actions:
  controls: {press: {kind: drive, joint: plate, position: {kind: ramp, from: 0, to: "${-way}", start: 0, end: 0.3}}}
"""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver."""
    rows = []
    for solver, through, dt in (("mpm", 6, 0.0025), ("fem", 3, 0.01)):
        text = PRESS.replace("solver: mpm", f"solver: {solver}")
        fine = f"{solver}, {through} {'cells' if solver == 'mpm' else 'edges'} thick"
        for nu in (0.0, 0.3, 0.45, 0.49):
            run = lab.run(text, f"press_{solver}", side=SIDE, cell=SIDE / through, dt=dt, e=E, nu=nu, way=WAY)
            what = f"cube pressed between smooth plates, nu {nu:g}"
            way, force = run.joint("plate")
            sideways, upright = _strains(run)
            # The engine's corotated law: in uniaxial stress the nominal stress is E e up to second order.
            part = (upright < -0.02) & (upright > -0.1)
            modulus = np.polyfit(upright[part], force[part] / SIDE**2, 1)[0]
            small = (upright < -0.005) & (upright > -0.04)
            bulge = -np.polyfit(upright[small], sideways[small], 1)[0]
            rows.append(Row(f"{what}: stress / strain [kPa]", fine, E / 1e3, float(modulus) / 1e3))
            rows.append(Row(f"{what}: bulge / strain", fine, nu, float(bulge), max(nu, 0.3)))
        rows.append(
            Row(f"{what}: strain of the inside / way of the plate", fine, 1.0, float(upright[-1] * SIDE / way[-1]))
        )
    flow = 4e3
    text = PRESS.replace("density: 1000,", f"density: 1000, model: elasto_plastic, yield_stress: {flow:g},")
    run = lab.run(text, "press_plastic", side=SIDE, cell=SIDE / 6, dt=0.0025, e=E, nu=0.3, way=WAY)
    _, force = run.joint("plate")
    _, upright = _strains(run)
    # Volume stays while it flows: the area grows as the height shrinks.
    stress = -force[-1] * (1 + upright[-1]) / SIDE**2
    rows.append(Row("cube pressed until it flows: stress [kPa]", "mpm, 6 cells thick", flow / 1e3, float(stress) / 1e3))
    return rows


def _strains(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Mean strain of the inside sideways and upright, each (F,): slopes of the points' places over those at rest."""
    points, rest = run.points("cube"), run.rest("cube")["rest"]
    strains = []
    for axis in range(3):
        x = rest[:, axis] - rest[:, axis].mean()
        strains.append(np.einsum("p,fp->f", x, points[:, :, axis]) / (x @ x) - 1.0)
    return (strains[0] + strains[1]) / 2, strains[2]
