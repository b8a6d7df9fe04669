"""Statics whose surfaces move, as conveyor belts: what lies on them is carried by Coulomb friction alone."""

import numpy as np
import pytest

G, DT, MU, V = 9.81, 0.005, 0.4, 0.6
TILT = np.radians(15)
BELTS = """
scene:
  duration: 2.0
  dt: 0.005
  substeps: "${substeps}"
  statics:
    floor: {shape: {kind: plane}, material: {friction: 0.4}}
    level:
      shape: {kind: box, size: [3, 0.4, 0.1]}
      pose: {pos: [0, 0, 0.95], euler_deg: [0, 0, 90]}
      material: {friction: 0.4}
      surface_velocity: [0.6, 0, 0]
    incline:
      shape: {kind: box, size: [4, 0.4, 0.1]}
      pose: {pos: [5, 0, 2], euler_deg: [0, -15, 0]}
      material: {friction: 0.4}
      surface_velocity: [0.6, 0, 0]
    legs: {shape: {kind: box, size: [0.3, 2.8, 0.95]}, pose: {pos: [0, 0, 0.475]}}
bodies:
  box:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.04]}
    material: {mass: "${[0.5, 5][i]}", friction: 0.1}
    pose: {pos: [0, "${-1.2 + 0.8 * i}", 1.0199]}
    repeat: {kind: line, count: 2, step: [0, 0, 0]}
  climber:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.04]}
    material: {friction: 0.1}
    pose: {pos: ["${5 - 0.0699 * sin(radians(15))}", 0, "${2 + 0.0699 * cos(radians(15))}"], euler_deg: [0, -15, 0]}
  faller:
    kind: rigid
    shape: {kind: sphere, radius: 0.05}
    material: {friction: 0.1}
    pose: {pos: [0, 1.3, 1.0499]}
"""


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_moving_surface_carries_by_friction(simulate, agree, substeps):
    """From rest, v = mu g t up to the speed of the surface, then v; up a slope, v = g (mu cos a - sin a) t.

    A ball that starts at rest slides at first, and its contact point has the velocity of the surface when
    mu g t + 5/2 mu g t = v: then it rolls at 2/7 v, until it leaves the end and falls freely.
    """
    trial = simulate(BELTS, substeps=substeps)
    t = trial.time
    name = f"moving surface, {substeps} substeps"
    for k in range(2):
        along = trial.vel(f"box[{k}]")[:, 1]
        until = t < 0.95 * V / (MU * G)
        agree(f"{name}: from rest [m/s]", along[until], MU * G * t[until], within=MU * G * DT)
        agree(f"{name}: carried along [m/s]", along[t > 0.3], V, within=1e-3 * V)
        assert np.abs(trial.vel(f"box[{k}]")[:, [0, 2]]).max() < 0.02 * V
    up = np.array([np.cos(TILT), 0, np.sin(TILT)])
    along, gain = trial.vel("climber") @ up, G * (MU * np.cos(TILT) - np.sin(TILT))
    until = t < 0.95 * V / gain
    agree(f"{name}: up a slope [m/s]", along[until], gain * t[until], within=gain * DT)
    agree(f"{name}: up the slope with it [m/s]", along[t > 1], V, within=1e-2 * V)
    ball, speed = trial.pos("faller"), trial.vel("faller")
    rolling = (t > 0.1) & (ball[:, 1] < 1.49)
    agree(f"{name}: a ball rolls [m/s]", speed[rolling, 1], 2 / 7 * V, within=0.01 * V)
    falls = np.flatnonzero((ball[:, 1] > 1.56) & (ball[:, 2] > 0.1))[:20]  # before it hits the floor
    assert len(falls) == 20
    fall = speed[falls[0]] - np.outer(t[falls] - t[falls[0]], (0, 0, G))
    agree(f"{name}: and falls off the end [m/s]", speed[falls], fall, within=1e-3)
    for belt in ("level", "incline"):
        assert np.abs(trial.pos(belt) - trial.pos(belt)[0]).max() < 1e-5
        assert trial.link(belt).fixed
