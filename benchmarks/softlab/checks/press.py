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

HEAD = """
scene:
  duration: 0.3
  dt: {dt}
  gravity: [0, 0, 0]
  statics:
    table: {{shape: {{kind: box, size: [0.3, 2, 0.1]}}, material: {{friction: 0.01}}, pose: {{pos: [0, 0, -0.05]}}}}
bodies:
"""
PAIR = """
  plate_{k}:
    kind: rigid
    shape: {{kind: box, size: [0.2, 0.2, 0.1]}}
    material: {{density: 100, friction: 0.01}}
    pose: {{pos: [0, {y}, 0.15]}}
    mount: {{kind: slider, axis: z, actuator: {{stiffness: 5e4, damping: 200}}}}
  cube_{k}:
    kind: soft
    solver: {solver}
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    cell: {cell}
    material: {{youngs_modulus: {e}, density: 1000, friction: 0.01, {material}}}
    pose: {{pos: [0, {y}, 0.05]}}
"""
CONTROLS = "actions:\n  controls:\n"
DRIVE = (
    "    press_{k}: {{kind: drive, joint: plate_{k}, "
    "position: {{kind: ramp, from: 0, to: -{way}, start: 0, end: 0.3}}}}\n"
)
RATIOS = (0.0, 0.3, 0.45, 0.49)
YIELD = 4e3
"""Stress [Pa] from which the last of the mpm cubes flows."""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver: cubes of several materials side by side."""
    rows = []
    for solver, through, dt in (("mpm", 6, 0.0025), ("fem", 3, 0.01)):
        materials = [f"poisson_ratio: {nu}" for nu in RATIOS]
        if solver == "mpm":
            materials.append(f"poisson_ratio: 0.3, model: elasto_plastic, yield_stress: {YIELD}")
        values = {"solver": solver, "cell": SIDE / through, "e": E, "way": WAY}
        cubes = [PAIR.format(k=k, y=0.3 * (k - 2), material=m, **values) for k, m in enumerate(materials)]
        drives = [DRIVE.format(k=k, **values) for k in range(len(materials))]
        run = lab.run(HEAD.format(dt=dt) + "".join([*cubes, CONTROLS, *drives]), f"press_{solver}")
        fine = f"{solver}, {through} {'cells' if solver == 'mpm' else 'edges'} thick"
        for k, nu in enumerate(RATIOS):
            rows += _elastic(run, k, nu, fine)
        if solver == "mpm":
            rows.append(_plastic(run, len(RATIOS), fine))
    return rows


def _elastic(run: Run, k: int, nu: float, fine: str) -> list[Row]:
    what = f"cube pressed between smooth plates, nu {nu:g}"
    way, force = run.joint(f"plate_{k}")
    sideways, upright = _strains(run, k)
    # The engine's corotated law: in uniaxial stress the nominal stress is E e up to second order.
    part = (upright < -0.02) & (upright > -0.1)
    modulus = np.polyfit(upright[part], force[part] / SIDE**2, 1)[0]
    small = (upright < -0.005) & (upright > -0.04)
    bulge = -np.polyfit(upright[small], sideways[small], 1)[0]
    rows = [
        Row(f"{what}: stress / strain [kPa]", fine, E / 1e3, float(modulus) / 1e3),
        Row(f"{what}: bulge / strain", fine, nu, float(bulge), max(nu, 0.3)),
    ]
    if nu == max(RATIOS):
        volume = (1 + upright[-1]) * (1 + sideways[-1]) ** 2
        rows.append(Row(f"{what}: volume / volume at rest", fine, 1 + (1 - 2 * nu) * upright[-1], float(volume)))
        rows.append(
            Row(f"{what}: strain of the inside / way of the plate", fine, 1.0, float(upright[-1] * SIDE / way[-1]))
        )
    return rows


def _plastic(run: Run, k: int, fine: str) -> Row:
    _, force = run.joint(f"plate_{k}")
    _, upright = _strains(run, k)
    # Volume stays while it flows: the area grows as the height shrinks.
    stress = -force[-1] * (1 + upright[-1]) / SIDE**2
    return Row("cube pressed until it flows: stress [kPa]", fine, YIELD / 1e3, float(stress) / 1e3)


def _strains(run: Run, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean strain of the inside sideways and upright, each (F,): slopes of the points' places over those at rest."""
    points, rest = run.points(f"cube_{k}"), run.rest(f"cube_{k}")["rest"]
    strains = []
    for axis in range(3):
        x = rest[:, axis] - rest[:, axis].mean()
        strains.append(np.einsum("p,fp->f", x, points[:, :, axis]) / (x @ x) - 1.0)
    return (strains[0] + strains[1]) / 2, strains[2]
