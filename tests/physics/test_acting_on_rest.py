"""What is let go, removed and driven when a damped ball has come to rest."""

import numpy as np
import pytest

from text2sim.evidence.events import find_events
from text2sim.evidence.measures import evaluate

DT, H, RATE, SPEED, SLOW, LASTS, G = 0.01, 0.005, 3.0, 1.0, 0.05, 0.1, 9.81
CASE = f"""
scene: {{duration: 1.5, dt: {DT}, substeps: 2, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 0, 0.1]}}, mount: {{kind: free, damping: {RATE}}}}}
  next: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 2, 3]}}}}
  last: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 8, 3]}}}}
  mark: {{kind: rigid, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, pose: {{pos: [0, 4, 0.05]}}}}
  gate:
    kind: rigid
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    pose: {{pos: [0, 6, 1]}}
    mount: {{kind: slider, axis: x, actuator: {{stiffness: 4000, damping: 400}}}}
actions:
  controls:
    roll: {{kind: initial_velocity, body: ball, linear: [{SPEED}, 0, 0], angular: [0, {SPEED / 0.1}, 0]}}
    hold: {{kind: attach, body: next, to: world}}
    drop: {{kind: release, attach: hold, on: calm}}
    hold_last: {{kind: attach, body: last, to: world}}
    drop_last: {{kind: release, attach: hold_last, on: fallen}}
    no_mark: {{kind: remove, body: mark, on: calm}}
    open: {{kind: drive, joint: gate, on: calm, position: {{kind: ramp, from: 0, to: 0.2, start: 0, end: 0.2, ease: linear}}}}
  measures:
    fall: {{kind: displacement, of: next}}
  events:
    calm: {{kind: rest, of: ball, speed: {SLOW}, for: {LASTS}}}
    let_go: {{kind: released, attach: hold}}
    fallen: {{kind: threshold, measure: fall, above: 0.1, after: let_go}}
    gone: {{kind: removed, remove: no_mark}}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(CASE)


def test_the_ball_rolls_and_stops_as_it_would_in_a_viscous_medium(trial, agree):
    """It rolls, so v = r w; both decay at the same rate, and friction has nothing to do: x = v0 / c (1 - exp(-c t))."""
    t = trial.time
    least = RATE * H / (2 * np.e)  # of implicit steps, see test_free_motion.py
    speed, way = SPEED * np.exp(-RATE * t), SPEED / RATE * (1 - np.exp(-RATE * t))
    agree("damped rolling: v [m/s]", trial.vel("ball")[:, 0], speed, within=2 * SPEED * least)
    agree("damped rolling: r w [m/s]", 0.1 * trial.ang("ball")[:, 1], speed, within=2 * SPEED * least)
    agree("damped rolling: way [m]", trial.pos("ball")[:, 0], way, within=2 * SPEED / RATE * least)


def test_the_program_acts_when_the_rest_of_the_evidence_has_lasted(trial, agree):
    log = find_events(trial.recording, evaluate(trial.recording))
    calm, fallen = log.first("calm"), log.first("fallen")
    assert calm is not None
    assert fallen is not None
    agree("rest begins [s]", calm, np.log(SPEED / SLOW) / RATE, within=DT + RATE * H * calm)
    acts = calm + LASTS
    agree("removed when it has lasted [s]", trial.states.removed["mark"], acts + DT / 2, within=DT / 2 + 1e-6)
    assert log.first("gone") == trial.states.removed["mark"]
    agree("released, by the evidence [s]", log.first("let_go"), acts, within=1e-9)
    # Both begin with the first step after that moment.
    fall = trial.pos("next")[0, 2] - trial.pos("next")[:, 2]
    t = np.maximum(trial.time - acts, 0.0)
    agree("let go: fall [m]", fall, G * t * t / 2, within=G * t[-1] * (DT + H))
    agree("fallen by 0.1 m [s]", fallen, acts + np.sqrt(2 * 0.1 / G), within=DT + H)
    t_last = np.maximum(trial.time - fallen, 0.0)
    fall = trial.pos("last")[0, 2] - trial.pos("last")[:, 2]
    agree("the last one: fall [m]", fall, G * t_last * t_last / 2, within=G * t_last[-1] * (DT + H))
    agree("driven: way [m]", trial.joint("gate")[0], np.minimum(t, 0.2), within=0.01 + DT)
