"""What hangs between two points: a rope, and a strip of cloth.

A chain or cloth that does not stretch hangs as z = a cosh(x / a): of a length S over a span d, a solves
S = 2 a sinh(d / (2 a)), and the sag is a (cosh(d / (2 a)) - 1) (Bernoulli, Huygens and Leibniz 1691).
"""

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

STRIP = """
scene: {duration: 3.0, dt: 0.005}
bodies:
  holder:
    kind: driven
    shape: {kind: box, size: [0.02, 0.1, 0.02]}
    material: {touch_soft: false}
    pose: {pos: [0.51, 0, 0]}
    motion: {kind: waypoints, times: [0, 1.2], positions: [[0, 0, 0], [-0.2, 0, 0]]}
  strip:
    {kind: cloth, solver: pbd, shape: {kind: sheet, size: [1.0, 0.1]}, cell: 0.02, material: {air_resistance: 0.01}}
actions:
  controls:
    left: {kind: attach, body: strip, region: {edge: left}, to: world}
    right: {kind: attach, body: strip, region: {edge: right}, to: holder}
"""

ROPE = """
scene: {duration: 4.0, dt: 0.005}
bodies:
  holder:
    kind: driven
    shape: {kind: sphere, radius: 0.02}
    pose: {pos: [1.03, 0, 0]}
    motion: {kind: waypoints, times: [0, 1.5], positions: [[0, 0, 0], [-0.2, 0, 0]]}
  rope: {kind: rope, length: 1.0, radius: 0.008, segments: 24, direction: [1, 0, 0], anchored: true, damping: 0.002}
actions: {controls: {hold: {kind: attach, body: rope.link_23, to: holder}}}
"""


def sag(length: float, span: float) -> float:
    """Sag [m] of a catenary of a length over a level span."""
    low, high = 1e-3 * span, 1e3 * span
    a = span
    for _ in range(200):
        a = (low * high) ** 0.5
        low, high = (low, a) if 2 * a * np.sinh(min(span / (2 * a), 700.0)) < length else (a, high)
    return float(a * (np.cosh(span / (2 * a)) - 1))


def check(lab: Lab) -> list[Row]:
    """Run both."""
    return [_strip(lab.run(STRIP, "catenary_strip")), _rope(lab.run(ROPE, "catenary_rope"))]


def _strip(run: Run) -> Row:
    points, rest = run.points("strip")[run.time > 2.0].mean(axis=0), run.rest("strip")["rest"]
    ends = [points[np.isclose(rest[:, 0], side, atol=1e-3)].mean(axis=0) for side in (-0.5, 0.5)]
    middle = points[np.abs(rest[:, 0]) < 0.012]
    found = (ends[0][2] + ends[1][2]) / 2 - middle[:, 2].mean()
    span = float(ends[1][0] - ends[0][0])
    return Row(f"cloth strip, 1 m over {span:.2f} m: sag [mm]", "pbd, 2 cm", 1e3 * sag(1.0, span), 1e3 * float(found))


def _rope(run: Run) -> Row:
    joints = run.arrays["links_pos"][:, run.links("rope")][run.time > 3.5].mean(axis=0)
    # A part of a catenary is one: the joints 2 to 22 hang free of how the ends are held.
    part = joints[2:23]
    length = 20 / 24
    # The ends of the part are level to a hair; the height of their middle counts.
    span = float(np.hypot(part[-1, 0] - part[0, 0], part[-1, 2] - part[0, 2]))
    found = (part[0, 2] + part[-1, 2]) / 2 - part[10, 2]
    return Row(
        f"rope of 24 links, {length:.2f} m over {span:.2f} m: sag [mm]",
        "capsules on ball joints",
        1e3 * sag(length, span),
        1e3 * float(found),
    )
