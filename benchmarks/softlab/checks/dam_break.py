"""A column of water is let go beside a wall: how fast its front runs, and where a float settles.

On a dry smooth floor the front of the ideal solution runs at 2 sqrt(g h) (Ritter 1892); experiments with a column as
high as it is long reach 0.8 to 0.9 of that (Martin and Moyce 1952, table for n^2 = 1). A body floats with as much of it
under water as its density is of the water's (Archimedes). It is watched twice, since it creeps.
benchmarks/soft_leaks.py has other reaches of walls.
"""

import numpy as np

from benchmarks.softlab.lab import Lab
from benchmarks.softlab.row import Row

G, HEIGHT, CELL = 9.81, 0.15, 0.0125

DAM = """
scene:
  duration: 0.3
  dt: 0.0025
  mpm: {bounds: {min: [-0.06, -0.12, -0.06], max: [0.9, 0.12, 0.3]}}
  statics:
    ground: {shape: {kind: box, size: [2, 0.6, 0.1]}, material: {SMOOTH}, pose: {pos: [0.5, 0, -0.05]}}
    back: {shape: {kind: box, size: [0.1, 0.6, 0.6]}, material: {SMOOTH}, pose: {pos: [-0.05, 0, 0.3]}}
    near: {shape: {kind: box, size: [2, 0.1, 0.6]}, material: {SMOOTH}, pose: {pos: [0.5, -0.095, 0.3]}}
    far: {shape: {kind: box, size: [2, 0.1, 0.6]}, material: {SMOOTH}, pose: {pos: [0.5, 0.095, 0.3]}}
bodies:
  water:
    kind: liquid
    shape: {kind: box, size: [0.15, 0.08, 0.15]}
    cell: "${cell}"
    material: {stiffness: 1e5}
    pose: {pos: [0.079, 0, 0.079]}
""".replace("SMOOTH", "friction: 0.01")

POOL = """
scene:
  duration: 2.0
  dt: 0.0025
  mpm: {bounds: {min: [-0.2, -0.2, -0.08], max: [0.2, 0.2, 0.3]}}
  statics:
    ground: {shape: {kind: box, size: [0.6, 0.6, 0.1]}, material: {SMOOTH}, pose: {pos: [0, 0, -0.05]}}
    left: {shape: {kind: box, size: [0.1, 0.6, 0.6]}, material: {SMOOTH}, pose: {pos: [-0.15, 0, 0.3]}}
    right: {shape: {kind: box, size: [0.1, 0.6, 0.6]}, material: {SMOOTH}, pose: {pos: [0.15, 0, 0.3]}}
    near: {shape: {kind: box, size: [0.6, 0.1, 0.6]}, material: {SMOOTH}, pose: {pos: [0, -0.15, 0.3]}}
    far: {shape: {kind: box, size: [0.6, 0.1, 0.6]}, material: {SMOOTH}, pose: {pos: [0, 0.15, 0.3]}}
bodies:
  water:
    kind: liquid
    shape: {kind: box, size: [0.192, 0.192, 0.12]}
    cell: 0.016
    material: {stiffness: 1e5}
    pose: {pos: [0, 0, 0.062]}
  float:
    kind: rigid
    shape: {kind: box, size: [0.096, 0.096, 0.096]}
    material: {density: 500, friction: 0.01}
    pose: {pos: [0, 0, 0.18]}
    mount: {kind: slider, axis: z}
""".replace("SMOOTH", "friction: 0.01")


def check(lab: Lab) -> list[Row]:
    """Run both."""
    run = lab.run(DAM, "dam", cell=CELL)
    front = np.quantile(run.points("water")[:, :, 0], 0.995, axis=1)
    running = (front > 0.3) & (front < 0.7)
    speed = float(np.polyfit(run.time[running], front[running], 1)[0])
    what, ideal = "dam break: speed of the front [m/s]", 2 * np.sqrt(G * HEIGHT)
    rows = [Row(what, f"mpm, {HEIGHT / CELL:.0f} cells high", float(ideal), speed)]
    run = lab.run(POOL, "pool")
    for began, ended in ((0.5, 0.8), (1.7, 2.0)):
        late = (run.time > began) & (run.time <= ended)
        level = float(np.quantile(run.points("water")[late][:, :, 2], 0.99, axis=1).mean()) + 0.005
        bottom = float(run.center("float")[late, 2].mean()) - 0.048
        what = f"float of half the density: part under water by {ended} s"
        rows.append(Row(what, "mpm, 6 cells wide", 0.5, (level - bottom) / 0.096))
    return rows
