"""Bodies that leave the scene in the middle of a run."""

import numpy as np
import pytest

G = 9.81
CASE = """
scene:
  duration: 1.0
  dt: 0.005
  statics:
    floor: {shape: {kind: plane}}
    shelf: {shape: {kind: box, size: [0.4, 0.4, 0.04]}, pose: {pos: [0, 0, 1]}}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, place: {on: shelf}}
  under: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [2, 0, 0.1]}}
  above: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [2, 0, 0.25]}}
  holder: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, mount: {kind: fixed}, pose: {pos: [4, 0, 2]}}
  held: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [4, 0, 1.8]}}
actions:
  controls:
    grip: {kind: attach, body: held, to: holder}
    blow: {kind: force, body: under, force: [0, 0, -50]}
    no_shelf: {kind: remove, body: shelf, at: 0.2}
    no_under: {kind: remove, body: under, on: dropped}
    no_holder: {kind: remove, body: holder, at: 0.5}
  measures:
    height: {kind: position, of: under, axis: z}
    fallen: {kind: displacement, of: crate}
    left: {kind: count_in, of: under, region: {kind: sphere, center: [2, 0, 0], radius: 100}}
    speed: {kind: speed, of: held}
    energy: {kind: energy, of: under, part: potential}
  events:
    dropped: {kind: threshold, measure: fallen, above: 0.05}
    gone: {kind: removed, remove: no_under}
    lands: {kind: contact, between: [crate, floor]}
    meets: {kind: contact, between: [above, floor], after: gone}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(CASE)


def test_what_rested_on_it_falls_freely(trial, agree):
    """From 0.2 s on, by the semi-implicit steps of the engine: z = -g t (t + dt) / 2."""
    t = np.maximum(trial.time - 0.2, 0.0)
    falls = trial.time < 0.6
    way = trial.pos("crate")[falls, 2] - trial.pos("crate")[0, 2]
    agree("removed shelf: fall of what lay on it [m]", way, -G * t[falls] * (t[falls] + 0.005) / 2, within=2e-4)


def test_it_goes_when_the_event_happens_and_stays_where_it_was(trial, agree):
    removed = trial.states.removed
    assert set(removed) == {"shelf", "under", "holder"}
    agree("removed at its time [s]", [removed["shelf"], removed["holder"]], [0.2, 0.5], within=1e-9)
    drop = 0.2 + np.sqrt(2 * 0.05 / G)
    agree("removed at the event [s]", removed["under"], drop, within=0.011)
    after = trial.time > removed["under"]
    agree(
        "what is gone does not move, although a force is asked for [m]",
        trial.pos("under")[after],
        trial.pos("under")[after][0],
        within=1e-6,
    )
    assert trial.pos("above")[-1, 2] == pytest.approx(0.05, abs=0.003), "what lay on it has fallen to the floor"


def test_what_was_attached_to_it_is_free(trial, agree):
    t = np.maximum(trial.time - 0.5, 0.0)
    agree("removed holder: speed of what hung on it [m/s]", trial.measure("speed"), G * t, within=0.06)


def test_its_measures_end_and_it_is_in_no_region(trial):
    there = trial.time <= trial.states.removed["under"] + 1e-9
    assert (np.isfinite(trial.measure("height")) == there).all()
    assert (trial.measure("left") == there).all()
    assert (trial.measure("energy")[~there] == 0).all()


def test_evidence_lists_when_it_went(trial):
    from text2sim.evidence.events import find_events
    from text2sim.evidence.measures import evaluate

    log = find_events(trial.recording, evaluate(trial.recording))
    (row,) = log.occurrences["gone"]
    assert (row["of"], row["time"]) == ("under", trial.states.removed["under"])
    assert log.first("lands") is not None
    assert log.first("meets") > row["time"]
    touches = log.occurrences["lands"] + log.occurrences["meets"]
    assert not any("under" in touch["between"] for touch in touches)


def test_what_goes_where_it_was_goes_through_nothing(trial):
    from text2sim.evidence.gone_through import gone_through

    assert gone_through(trial.recording) == []
