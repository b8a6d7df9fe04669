"""A dam break in a tank: what gets into its walls, and how fast the front runs, by their reach and thickness.

On a dry smooth floor the front of the ideal solution runs at 2 sqrt(g h) (Ritter 1892). It runs for 0.4 m, strikes the
far wall and sways in the closed tank. The front's speed is that from 0.1 m on to the wall.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.softlab.lab import Lab

SCENE = """
scene:
  duration: 1.0
  dt: 0.005
  mpm: {cell: "${cell}", bounds: {min: [-0.2, -0.28, -0.2], max: [0.86, 0.28, 0.6]}}
  statics:
    floor: {shape: {kind: box, size: [1.4, 0.8, 0.1]}, pose: {pos: [0.3, 0, -0.05]}, WALL}
    back: {shape: {kind: box, size: ["${wall}", 0.8, 1]}, pose: {pos: ["${-wall / 2}", 0, 0.5]}, WALL}
    front: {shape: {kind: box, size: ["${wall}", 0.8, 1]}, pose: {pos: ["${0.66 + wall / 2}", 0, 0.5]}, WALL}
    near: {shape: {kind: box, size: [1.4, "${wall}", 1]}, pose: {pos: [0.3, "${-0.08 - wall / 2}", 0.5]}, WALL}
    far: {shape: {kind: box, size: [1.4, "${wall}", 1]}, pose: {pos: [0.3, "${0.08 + wall / 2}", 0.5]}, WALL}
bodies:
  stuff:
    kind: "${kind}"
    shape: {kind: box, size: ["${height}", 0.14, "${height}"]}
    pose: {pos: ["${height / 2 + 0.01}", 0, "${height / 2 + 0.01}"]}
""".replace("WALL", "material: {friction: 0.01, soft_reach: '${r}'}")
HEIGHT, LENGTH, HALF_WIDTH = 0.24, 0.66, 0.08


@dataclass(frozen=True)
class Tank:
    """One row of the table; lengths in m."""

    kind: str
    cell: float
    reach: float
    """In cells."""
    wall: float
    """Thickness of the walls, in cells."""
    speed: float
    """Of the front [m/s]."""
    leaked: float
    """Part of the particles that came deeper than a quarter of a cell into a wall or the floor."""
    deepest: float
    """How deep the deepest of 999 of 1000 was."""
    level: float
    """Mean height of the upper surface of what is left in the tank at the end, less that of an even filling."""


TRIALS = (
    *(("liquid", 0.02, reach, 5.0) for reach in (0.1, 0.25, 0.5, 1.0)),
    ("liquid", 0.02, 0.25, 0.3),
    ("granular", 0.02, 0.1, 5.0),
    ("granular", 0.02, 0.1, 0.3),
)
"""Kind, cell [m], reach and thickness [cells]. A quarter is the default of liquids, a tenth of 20 mm that of grains."""


def measure(lab: Lab, kind: str, cell: float, reach: float, wall: float) -> Tank:
    """Run one trial."""
    run = lab.run(SCENE, "tank", cell=cell, kind=kind, height=HEIGHT, r=reach * cell, wall=wall * cell)
    points = run.points("stuff")
    x, y, z = (points[..., k] for k in range(3))
    depth = np.max([-x, x - LENGTH, np.abs(y) - HALF_WIDTH, -z], axis=0).max(axis=0)
    front = np.quantile(x, 0.995, axis=1)
    running = (front > HEIGHT + 0.1) & (front < LENGTH - 0.03) & (run.time < run.time[front.argmax()])
    speed = float(np.polyfit(run.time[running], front[running], 1)[0]) if running.sum() > 2 else 0.0
    last = points[-1]
    within = (last > [0, -HALF_WIDTH, 0]).all(axis=1) & (last < [LENGTH, HALF_WIDTH, 9]).all(axis=1)
    level = 2 * float(last[within, 2].mean()) - HEIGHT**2 * 0.14 / (LENGTH * 2 * HALF_WIDTH)
    return Tank(
        kind, cell, reach, wall, speed, float((depth > cell / 4).mean()), float(np.quantile(depth, 0.999)), level
    )


def table(rows: list[Tank]) -> str:
    """Return the rows as Markdown."""
    ideal = 2 * np.sqrt(9.81 * HEIGHT)
    lines = [
        "| what | cell | `soft_reach` | walls | speed of the front, of the ideal one | leaked | deepest | level |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for one in rows:
        front = f"{one.speed:.2f} m/s, {one.speed / ideal:.0%}" if one.speed else "does not get there"
        lines.append(
            f"| {one.kind} | {1e3 * one.cell:g} mm | {one.reach:.3g} cells | {one.wall:g} cells | {front} | "
            f"{one.leaked:.1%} | "
            f"{1e3 * one.deepest:+.0f} mm, {one.deepest / one.cell:+.1f} cells | {1e3 * one.level:+.0f} mm |"
        )
    return "\n".join(lines)
