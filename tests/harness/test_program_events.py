"""What the program detects during a run, against what is found in the recording of the same motion."""

from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from program_modules import load_module

from text2sim.evidence.events import find_events
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.spec_schema.models.base import listed

DT = 0.01


@pytest.fixture(scope="module")
def triggers():
    """The module of the program, without the engine."""
    points = SimpleNamespace(Points=None, array=None, choose=None)
    return load_module("triggers", genesis=ModuleType("genesis"), points=points)


class Replay:
    """Shows the speeds of a recording to the watches of a program, step by step."""

    def __init__(self, speeds):
        self.speeds, self.step = speeds, 0

    def speed(self, body):
        return lambda: self.speeds[body][self.step]

    def run(self, watching):
        for step in range(len(next(iter(self.speeds.values())))):
            self.step = step
            watching(step * DT)
        return watching


def wander(seed, count=201):
    """Return speeds that rise and fall, and are small for 0.1 to 0.5 s at a time [m/s]."""
    rng = np.random.default_rng(seed)
    return np.abs(np.interp(np.arange(count), np.arange(0, count + 12, 12), rng.choice([0.0, 0.01, 0.03, 1.0], 18)))


def test_both_find_the_same_rest(triggers, new_run, make_case):
    """A rest, one that comes after a threshold, one after that rest, and a threshold after a rest, which is known late."""
    fast = {"kind": "threshold", "measure": "speed", "above": 0.5}
    rest = {"kind": "rest", "speed": 0.02, "for": 0.15}
    events = {
        "calm": rest | {"of": "ball"},
        "push": fast,
        "calm_after": rest | {"of": "ball", "after": "push"},
        "both": rest | {"of": ["ball", "other"], "for": 0.1},
        "other_after": rest | {"of": "other", "after": "calm_after"},
        "push_after": fast | {"after": "other_after"},
        "let_go": {"kind": "released", "attach": "hold"},
        "other_let_go": rest | {"of": "other", "after": "let_go"},
    }
    controls = {
        "hold": {"kind": "attach", "body": "other", "to": "world"},
        "drop": {"kind": "release", "attach": "hold", "on": "calm_after"},
    }
    case = make_case(
        bodies=("ball", "other"), measures={"speed": {"kind": "speed", "of": "ball"}}, controls=controls, events=events
    )
    lasts = {name: event.get("for", 0.0) for name, event in events.items()}
    happened = []
    for seed in range(12):
        speeds = {"ball": wander(seed), "other": wander(seed + 100)}
        run = new_run(duration=2.0)
        for body, speed in speeds.items():
            run.add_link(body, vel=np.outer(speed, [1, 0, 0]))
        recording = RecordedCase.load(run.write(), case)
        log = find_events(recording, evaluate(recording))
        assert log.problems == {}
        found = {name: first for name in events if (first := log.first(name)) is not None}

        replay, watches = Replay(speeds), []
        for name, event in events.items():
            if event["kind"] == "rest":
                rows = [(body, replay.speed(body)) for body in listed(event["of"])]
                watch = triggers.Rest(rows, event["speed"], event["for"])
            elif event["kind"] == "released":
                watch = triggers.Deed([controls["drop"]["on"]])
            else:
                watch = triggers.Crossing([triggers.above(replay.speed("ball"), event["above"])])
            watches.append((name, watch, event.get("after")))
        seen = replay.run(triggers.Triggers(DT, watches))
        assert seen.began == pytest.approx(found, abs=1e-5)  # speeds are recorded in single precision
        assert seen.happened == pytest.approx({name: t + lasts[name] for name, t in found.items()}, abs=1e-5)
        happened += found
    assert all(2 < happened.count(name) for name in events), "else it says little about some of them"


def test_what_is_gone_does_not_rest(triggers):
    """A removed body stands still, but it is nowhere; of several, those that are left count."""
    replay, gone = Replay({"ball": np.zeros(101), "other": np.where(np.arange(101) < 50, 1.0, 0.0)}), {"ball": 0.0}
    rows = [(body, replay.speed(body)) for body in replay.speeds]
    watches = [
        ("none", triggers.Rest(rows[:1], 0.02, 0.2, gone), None),
        ("one", triggers.Rest(rows, 0.02, 0.2, gone), None),
    ]
    assert replay.run(triggers.Triggers(DT, watches)).began == {"one": pytest.approx(0.49 + 0.98 * DT)}


def test_a_release_on_rest_comes_when_the_rest_has_lasted(new_run, make_case):
    run = new_run(duration=1.0)
    run.add_link("ball", vel=np.outer(np.where(run.time < 0.5, 1.0, 0.0), [1, 0, 0]))
    run.add_link("other")
    controls = {
        "hold": {"kind": "attach", "body": "other", "to": "world"},
        "drop": {"kind": "release", "attach": "hold", "on": "calm"},
    }
    events = {"calm": {"kind": "rest", "of": "ball"}, "falls": {"kind": "released", "attach": "hold"}}
    recording = RecordedCase.load(
        run.write(), make_case(bodies=("ball", "other"), measures={}, controls=controls, events=events)
    )
    log = find_events(recording, evaluate(recording))
    calm = 0.49 + 0.98 * DT
    assert log.first("calm") == pytest.approx(calm)
    assert log.first("falls") == pytest.approx(calm + 0.2)
