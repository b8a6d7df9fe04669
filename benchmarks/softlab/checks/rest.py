"""Cubes that lie on a table and on each other: the gap that they keep.

Bodies that touch have none. On a grid what meets does so at the nodes that it shares, and these reach farther than the
bodies; so the gap is given in cells. Cubes without a damper keep bouncing a little:
the mean over half a second counts.
"""

from benchmarks.softlab.lab import Lab
from benchmarks.softlab.row import Row

CELL, SIDE = 0.02, 0.1

STACK = """
scene:
  duration: 1.0
  dt: 0.004
  mpm: {bounds: {min: [-0.2, -0.2, -0.1], max: [0.2, 0.2, 0.4]}}
  statics: {table: {shape: {kind: box, size: [0.4, 0.4, 0.1]}, pose: {pos: [0, 0, -0.05]}}}
bodies:
  cube:
    kind: soft
    solver: mpm
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    cell: 0.02
    material: {youngs_modulus: 2e5}
    pose: {pos: [0, 0, "${0.065 + 0.14 * i}"]}
    repeat: {kind: line, count: 2, step: [0, 0, 0]}
"""


def check(lab: Lab) -> list[Row]:
    """Run it."""
    run = lab.run(STACK, "rest")
    late = run.time > 0.5
    ends = []
    for name, middle in (("cube[0]", 0.065), ("cube[1]", 0.205)):
        rest, points = run.rest(name)["rest"][:, 2], run.points(name)[late, :, 2]
        # Particles lie inside the surface of their body, by as much as at rest.
        low = points.min(axis=1).mean() - (rest.min() - middle + SIDE / 2)
        high = points.max(axis=1).mean() + (middle + SIDE / 2 - rest.max())
        ends.append((low, high))
    return [
        Row("cube at rest on a rigid table: gap [cells]", "mpm, 5 cells thick", 0.0, ends[0][0] / CELL, 1.0),
        Row("cube at rest on another: gap [cells]", "mpm, 5 cells thick", 0.0, (ends[1][0] - ends[0][1]) / CELL, 1.0),
    ]
