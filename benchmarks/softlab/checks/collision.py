"""A soft cube and a rigid one meet head on, without gravity: momentum.

m1 v1 + m2 v2 stays what it was, whatever the blow does to the bodies (Newton), and they part no faster than they met.
"""

from benchmarks.softlab.lab import Lab
from benchmarks.softlab.row import Row

SPEED = 1.0

BLOW = """
scene: {duration: 0.4, dt: 0.0025, gravity: [0, 0, 0]}
bodies:
  hard:
    {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {density: "${density}"}, pose: {pos: [0, 0, 0]}}
  soft:
    kind: soft
    solver: mpm
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    cell: "${cell}"
    material: {youngs_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    pose: {pos: [-0.16, 0, 0]}
actions: {controls: {go: {kind: initial_velocity, body: soft, linear: [1, 0, 0]}}}
"""

SHEET = """
scene: {duration: 0.4, dt: 0.0025, gravity: [0, 0, 0]}
bodies:
  hard:
    {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {density: "${density}"}, pose: {pos: [0, 0, 0]}}
  soft:
    kind: cloth
    solver: pbd
    cell: "${cell}"
    shape: {kind: sheet, size: [0.2, 0.2]}
    material: {area_density: 10}
    pose: {pos: [-0.1, 0, 0], euler_deg: [0, 90, 0]}
actions: {controls: {go: {kind: initial_velocity, body: soft, linear: [1, 0, 0]}}}
"""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver."""
    rows = []
    for solver, text, cell in (("mpm", BLOW, 0.0125), ("fem", BLOW.replace("mpm", "fem"), 0.04), ("pbd", SHEET, 0.02)):
        for density in (500, 2000):
            run = lab.run(text, f"blow_{solver}", cell=cell, density=density)
            before, after = (sum(run.momentum(b)[k, 0] for b in ("hard", "soft")) for k in (0, -1))
            label = f"{solver}, {100 * cell:g} cm"
            ratio = run.mass("hard") / run.mass("soft")
            rows.append(
                Row(f"blow on a rigid cube of {ratio:.2g} times its mass: momentum [kg m/s]", label, before, after)
            )
    return rows
