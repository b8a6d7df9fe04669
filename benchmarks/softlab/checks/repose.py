"""Sand on a slope: the angle from which on it flows.

A layer on a rough slope stays where it is up to tan(angle) = mu, and runs off with g (sin - mu cos) beyond. The
engine's sand is Drucker and Prager's cone through the corners of compression of Mohr and Coulomb's (Klár et al. 2016),
and flows without changing its volume; in plane shear its strength is then mu = 2 sqrt(3) sin(phi) / (3 - sin(phi)), a
few degrees more than tan(phi).
"""

from math import cos, degrees, radians, sin, sqrt

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row

G = 9.81

SLOPE = """
scene:
  duration: 0.3
  dt: 0.0025
  gravity: ["${9.81 * sin(radians(slope))}", 0, "${-9.81 * cos(radians(slope))}"]
  mpm: {bounds: {min: [-0.3, -0.1, -0.06], max: [0.7, 0.1, 0.15]}}
  statics: {ground: {shape: {kind: box, size: [2, 0.4, 0.1]}, material: {friction: 5}, pose: {pos: [0, 0, -0.05]}}}
bodies:
  sand:
    kind: granular
    shape: {kind: box, size: [0.4, 0.12, 0.05]}
    cell: 0.0125
    material: {friction_angle_deg: "${phi}", youngs_modulus: 2e5}
    pose: {pos: [0, 0, 0.028]}
"""


def check(lab: Lab) -> list[Row]:
    """Find the strength from how fast a layer runs off."""
    rows = []
    for phi in (20.0, 30.0, 35.0):
        strength = 2 * sqrt(3) * sin(radians(phi)) / (3 - sin(radians(phi)))
        slope = degrees(np.arctan(strength)) + 15
        run = lab.run(SLOPE, "slope", phi=phi, slope=slope)
        rows.append(
            Row(f"sand, friction angle {phi:g} deg: slope on which it flows [deg]", "mpm, 4 cells deep",
                degrees(np.arctan(strength)), degrees(np.arctan(_strength(run, slope)))))  # fmt: skip
    return rows


def _strength(run: Run, slope: float) -> float:
    """Friction at the foot of the layer over its weight: (g sin - a) / (g cos), of the middle of the layer."""
    rest = run.rest("sand")["rest"]
    middle = np.abs(rest[:, 0]) < 0.08
    way = run.points("sand")[:, middle, 0].mean(axis=1)
    late = run.time > 0.05
    acceleration = 2 * np.polyfit(run.time[late], way[late], 2)[0]
    return float((G * sin(radians(slope)) - acceleration) / (G * cos(radians(slope))))
