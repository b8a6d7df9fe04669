"""Sand on a slope: the angle from which on it flows.

A layer on a rough slope stays where it is up to its friction angle, and runs off with g (sin - tan(angle) cos) beyond
(Coulomb). The engine's sand is Drucker and Prager's cone through the corners of compression of Mohr and Coulomb's (Klár
et al. 2016), and flows without changing its volume; in plane shear its strength is then not tan(angle) but
2 sqrt(3) sin(angle) / (3 - sin(angle)): 24.9 instead of 20 degrees, 34.7 instead of 30, 39.3 instead of 35. From 42.2
degrees on this is more than what plane shear can reach. What does not flow at all shows the angle of the slope.
"""

from math import cos, degrees, radians, sin

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

G = 9.81

SLOPE, ANGLES = 55.0, (20.0, 30.0, 35.0, 45.0)
"""Of the ground, and the friction angles of the layers on it [deg]."""

LAYERS = """
scene:
  duration: 0.3
  dt: 0.0025
  gravity: ["${9.81 * sin(radians(slope))}", 0, "${-9.81 * cos(radians(slope))}"]
  mpm: {bounds: {min: [-0.3, -0.1, -0.06], max: [0.8, 0.85, 0.15]}}
  statics: {ground: {shape: {kind: box, size: [3, 2, 0.1]}, material: {friction: 5}, pose: {pos: [0, 0, -0.05]}}}
bodies:
"""
LAYER = """
  sand_{k}:
    kind: granular
    shape: {{kind: box, size: [0.4, 0.12, 0.05]}}
    cell: 0.0125
    material: {{friction_angle_deg: {phi}, youngs_modulus: 2e5}}
    pose: {{pos: [0, {y}, 0.028]}}
"""


def check(lab: Lab) -> list[Row]:
    """Find the strength from how fast a layer runs off."""
    layers = [LAYER.format(k=k, phi=phi, y=0.25 * k) for k, phi in enumerate(ANGLES)]
    run = lab.run(LAYERS + "".join(layers), "slope", slope=SLOPE)
    rows = []
    for k, phi in enumerate(ANGLES):
        what = f"sand, friction angle {phi:g} deg: slope on which it flows [deg]"
        found = degrees(np.arctan(_strength(run, f"sand_{k}")))
        rows.append(Row(what, "mpm, 4 cells deep", phi, found))
    return rows


def _strength(run: Run, name: str) -> float:
    """Friction at the foot of a layer over its weight: (g sin - a) / (g cos), of the middle of the layer."""
    rest = run.rest(name)["rest"]
    middle = np.abs(rest[:, 0]) < 0.08
    way = run.points(name)[:, middle, 0].mean(axis=1)
    late = run.time > 0.05
    acceleration = 2 * np.polyfit(run.time[late], way[late], 2)[0]
    return float((G * sin(radians(SLOPE)) - acceleration) / (G * cos(radians(SLOPE))))
