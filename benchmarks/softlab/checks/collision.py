"""Momentum between a body that deforms and rigid ones, without gravity.

A blow: m1 v1 + m2 v2 stays what it was, whatever the blow does to the bodies (Newton). A tow: a free block holds a body
that is pushed by a force F for a time t; both together gain F t, and the block its part by mass, if they move as one.
"""

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

FORCE, DURATION = 2.0, 0.4
DENSITIES = (500, 2000)
"""Of the blocks that are struck [kg/m3]."""

SCENE = f"scene: {{duration: {DURATION}, dt: 0.0025, gravity: [0, 0, 0]}}\nbodies:\n"
BLOCK = """
  {name}:
    kind: rigid
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    material: {{density: {density}, touch_soft: {touch}}}
    pose: {{pos: [0, {y}, 0]}}
"""
SOLID = """
  {name}:
    kind: soft
    solver: {solver}
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    cell: {cell}
    pose: {{pos: [-0.16, {y}, 0]}}
"""
SHEET = """
  {name}:
    kind: cloth
    solver: {solver}
    shape: {{kind: sheet, size: [0.2, 0.2]}}
    cell: {cell}
    material: {{area_density: 10}}
    pose: {{pos: [-0.1, {y}, 0], euler_deg: [0, 90, 0]}}
"""
CONTROLS = f"""
actions:
  controls:
    go_0: {{kind: initial_velocity, body: soft_0, linear: [1, 0, 0]}}
    go_1: {{kind: initial_velocity, body: soft_1, linear: [1, 0, 0]}}
    hold: {{kind: attach, body: soft_2, region: {{REGION}}, to: hard_2}}
    push: {{kind: force, body: soft_2, force: [{FORCE}, 0, 0]}}
"""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver."""
    rows = []
    for solver, soft, cell, region in (
        ("mpm", SOLID, 0.0125, "face: right"),
        ("fem", SOLID, 0.04, "face: right"),
        ("pbd", SHEET, 0.02, "edge: left"),
    ):
        text = SCENE + "".join(
            block.format(name=f"{name}_{k}", y=0.3 * k, density=density, touch=touch, solver=solver, cell=cell)
            for k, (density, touch) in enumerate([(density, "true") for density in DENSITIES] + [(1000, "false")])
            for name, block in (("hard", BLOCK), ("soft", soft))
        )
        run = lab.run(text + CONTROLS.replace("REGION", region), f"momentum_{solver}")
        label = f"{solver}, {100 * cell:g} cm"
        for k in range(len(DENSITIES)):
            before, after = (_sum(run, k)[frame] for frame in (0, -1))
            ratio = run.mass(f"hard_{k}") / run.mass(f"soft_{k}")
            what = f"blow on a rigid cube of {ratio:.2g} times its mass: momentum [kg m/s]"
            rows.append(Row(what, label, float(before), float(after)))
        part = run.mass("hard_2") / (run.mass("hard_2") + run.mass("soft_2"))
        gained = float(run.momentum("hard_2")[-1, 0])
        what = "free block to which a pushed body is attached: its momentum [kg m/s]"
        rows.append(Row(what, label, FORCE * DURATION * part, gained))
    return rows


def _sum(run: Run, k: int) -> np.ndarray:
    """Momentum of both along the way [kg m/s], shape (F,)."""
    return run.momentum(f"hard_{k}")[:, 0] + run.momentum(f"soft_{k}")[:, 0]
