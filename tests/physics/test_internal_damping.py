"""Internal friction of cloth and soft bodies: flutter dies away, and the motion of the whole is left alone."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

CASE = """
scene: {gravity: [0, 0, 0], duration: 0.3, dt: 0.005, record: {rate: 200}}
bodies:
  damped: {kind: cloth, cell: 0.03, shape: {kind: sheet, size: [0.3, 0.3]}, material: {area_density: 0.3, air_resistance: 0, damping: 8}, pose: {pos: [0, 0, 1]}}
  plain: {kind: cloth, cell: 0.03, shape: {kind: sheet, size: [0.3, 0.3]}, material: {area_density: 0.3, air_resistance: 0}, pose: {pos: [0, 1, 1]}}
  turning: {kind: cloth, cell: 0.03, shape: {kind: sheet, size: [0.3, 0.3]}, material: {area_density: 0.3, air_resistance: 0, damping: 8}, pose: {pos: [0, 2, 1]}}
actions:
  controls:
    shake: {kind: force, body: damped, force: [0, 0, 0.2], region: {edge: left}, during: [0, 0.01]}
    shake_plain: {kind: force, body: plain, force: [0, 0, 0.2], region: {edge: left}, during: [0, 0.01]}
    go: {kind: initial_velocity, body: turning, linear: [0.5, 0, 0.2], angular: [0, 0, 1]}
"""


def test_flutter_dies_away_and_the_whole_goes_on(simulate, agree):
    """An oscillator with `x'' = -rate x' - w^2 x` swings with an amplitude that falls as `exp(-rate t / 2)`."""
    trial = simulate(CASE)
    points, speed = rows(trial.states, "turning")
    agree("a turning sheet keeps its velocity [m/s]", speed[1:], np.array([0.5, 0, 0.2]), within=0.01)
    away = points - points.mean(axis=1, keepdims=True)
    angle = np.unwrap(np.arctan2(away[:, 0, 1], away[:, 0, 0]))
    agree("and its turning [rad]", angle[-1] - angle[0], trial.time[-1] * 1.0, within=0.02)
    points, speed = rows(trial.states, "damped")
    agree("a shaken sheet keeps its momentum [m/s]", speed[4:], speed[4], within=0.01)
    late = (trial.time[1:] > 0.15) & (trial.time[1:] < 0.28)
    left = [np.sqrt(np.square(flutter(rows(trial.states, body)[0])[late]).mean()) for body in ("damped", "plain")]
    wanted = np.sqrt(np.exp(-8.0 * trial.time[1:][late]).mean())
    agree("flutter beside that of a plain sheet", left[0] / left[1], wanted, within=0.05)


SWAYING = """
scene: {duration: 1.4, record: {rate: 50}}
bodies:
  damped: {kind: cloth, cell: 0.05, shape: {kind: sheet, size: [0.15, 0.6]}, material: {bending_compliance: 1.0e4, damping: 5}, pose: {pos: [0, 0, 1], euler_deg: [105, 0, 0]}}
  plain: {kind: cloth, cell: 0.05, shape: {kind: sheet, size: [0.15, 0.6]}, material: {bending_compliance: 1.0e4}, pose: {pos: [1, 0, 1], euler_deg: [105, 0, 0]}}
actions:
  controls:
    hold: {kind: attach, body: damped, region: {edge: back}, to: world}
    hold_plain: {kind: attach, body: plain, region: {edge: back}, to: world}
"""


def test_what_hangs_sways_on(simulate, agree):
    """A towel is a pendulum of the period `2 pi sqrt(2 L / (3 g))`, which internal friction leaves alone."""
    trial = simulate(SWAYING)
    late = trial.time > np.pi * np.sqrt(0.4 / 9.81)
    damped, plain = (np.ptp(rows(trial.states, body)[0].mean(axis=1)[late, 1]) for body in ("damped", "plain"))
    agree("sway from side to side [m]", damped, plain, within=0.1 * plain)
    assert plain > 0.08, "they do sway"


SOFT = """
scene: {gravity: [0, 0, 0], duration: 0.6, dt: 0.004, record: {rate: 125}}
bodies:
  damped: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.3, 0.08, 0.08]}, material: {youngs_modulus: 2.0e4, damping: 8}, pose: {pos: [0, 0, 1]}}
  plain: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.3, 0.08, 0.08]}, material: {youngs_modulus: 2.0e4}, pose: {pos: [0, 0.4, 1]}}
  turning: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.3, 0.08, 0.08]}, material: {youngs_modulus: 2.0e5, damping: 8}, pose: {pos: [0, 0.8, 1]}}
actions:
  controls:
    shake: {kind: force, body: damped, force: [0, 0, 6], region: {face: left}, during: [0, 0.04]}
    shake_plain: {kind: force, body: plain, force: [0, 0, 6], region: {face: left}, during: [0, 0.04]}
    go: {kind: initial_velocity, body: turning, linear: [0.2, 0, 0.1], angular: [0, 1, 0]}
"""


def test_a_soft_body_wobbles_less_and_goes_on(simulate, agree):
    """As cloth does: the amplitude falls as `exp(-rate t / 2)`, and the motion of the whole stays."""
    trial = simulate(SOFT)
    points, speed = rows(trial.states, "turning")
    agree("a turning bar keeps its velocity [m/s]", speed[1:], np.array([0.2, 0, 0.1]), within=0.005)
    away = points - points.mean(axis=1, keepdims=True)
    end = away[..., 0].argmax(axis=1)[0]
    angle = np.unwrap(np.arctan2(-away[:, end, 2], away[:, end, 0]))
    agree("and its turning [rad]", angle[-1] - angle[0], trial.time[-1] * 1.0, within=0.03)
    late = trial.time[1:] > 0.3
    left = [np.sqrt(np.square(flutter(rows(trial.states, body)[0])[late]).mean()) for body in ("damped", "plain")]
    wanted = np.sqrt(np.exp(-8.0 * trial.time[1:][late]).mean())
    agree("wobble beside that of a plain bar", left[0] / left[1], wanted, within=0.05)


def flutter(points):
    """Motion of points (F, n, 3) between records, without that of a rigid body, (F - 1, n, 3)."""
    moved, found = np.diff(points, axis=0), []
    for step, places in zip(moved, points[:-1], strict=True):
        away, relative = places - places.mean(axis=0), step - step.mean(axis=0)
        inertia = np.eye(3) * np.square(away).sum() - away.T @ away
        found.append(relative - np.cross(np.linalg.solve(inertia, np.cross(away, relative).sum(axis=0)), away))
    return np.array(found)
