"""Parts of compounds in contacts and on rods, as the engine records them."""

import numpy as np
import pytest

from text2sim.evidence.events import find_events

G, MASS = 9.81, 1.2
SCENE = f"""
scene:
  duration: 0.4
  statics:
    floor: {{shape: {{kind: plane}}}}
    stair: {{shape: {{kind: box, size: [0.1, 0.3, 0.05]}}, pose: {{pos: [0.1, 0, 0.025]}}}}
bodies:
  bench:
    kind: rigid
    shape:
      kind: compound
      parts:
        seat: {{shape: {{kind: box, size: [0.24, 0.2, 0.02]}}, pose: {{pos: [0, 0, 0.11]}}}}
        leg: {{shape: {{kind: box, size: [0.03, 0.2, 0.2]}}, pose: {{pos: ["${{0.2 * k - 0.1}}", 0, 0]}}, repeat: 2}}
        foot: {{shape: {{kind: box, size: [0.03, 0.2, 0.05]}}, pose: {{pos: [-0.1, 0, -0.125]}}}}
    material: {{mass: {MASS}}}
    pose: {{pos: [0, 0, 0.16]}}
  stand:
    kind: rigid
    shape:
      kind: compound
      parts:
        foot: {{shape: {{kind: cylinder, radius: 0.1, height: 0.02}}, pose: {{pos: [0, 0, 0.01]}}}}
        pole: {{shape: {{kind: cylinder, radius: 0.01, height: 0.3}}, pose: {{pos: [0, 0, 0.17]}}}}
    mount: {{kind: fixed}}
    pose: {{pos: [1, 0, 0]}}
  ring:
    kind: rigid
    shape: {{kind: torus, radius: "${{0.06 - 0.02 * i}}", bar_radius: 0.01}}
    pose: {{pos: ["${{1 + 0.5 * i}}", 0, 0.34]}}
    repeat: {{kind: line, count: 2, step: [0, 0, 0]}}
actions:
  measures:
    on_pole: {{kind: threaded, of: ring, by: stand.pole}}
    high: {{kind: contact_force, of: bench.leg_1, by: stair}}
    low: {{kind: contact_force, of: bench.foot, by: floor}}
  events:
    steps: {{kind: contact, between: [bench.leg_*, stair]}}
    sits: {{kind: contact, between: [bench.seat, stair]}}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(SCENE)


def test_each_leg_of_a_bench_carries_its_share(trial, agree):
    """About the foot's line: F x d = m g x (x of the centre of mass), by the balance of moments."""
    late = trial.time > 0.3
    high, low = (trial.measure(name)[late].mean() for name in ("high", "low"))
    middle = trial.com("bench")[-1, 0]
    agree("load of both feet [N]", high + low, MASS * G, within=0.02 * MASS * G)
    agree("load of the foot on the stair [N]", high, MASS * G * (middle + 0.1) / 0.2, within=0.05 * MASS * G)


def test_the_ring_above_the_pole_falls_onto_it_and_the_other_beside_it(trial):
    """Their fall by 2 cm, to the end of the pole, takes sqrt(2 h / g) = 64 ms."""
    count, fall = trial.measure("on_pole"), np.sqrt(2 * 0.02 / G)
    assert (count[trial.time < fall - 0.02] == 0).all()
    assert (count[trial.time > fall + 0.02] == 1).all()


def test_only_the_leg_above_the_stair_touches_it(trial):
    found = find_events(trial.recording, {}).occurrences
    assert {row["between"][0] for row in found["steps"]} == {"bench.leg_1"}
    assert not found["sits"]
    assert {name for _, name in trial.states.parts} == {"seat", "leg_0", "leg_1", "foot", "pole"}
    assert np.isin(trial.states.contact_surfaces, range(len(trial.states.surface_links))).all()
