"""Contacts by part of a compound, in measures and events."""

from typing import Any

import numpy as np
import pytest

from text2sim.evidence.events import find_events
from text2sim.evidence.recorded_case import RecordedCase

BOX = {"shape": {"kind": "box", "size": [0.1, 0.1, 0.1]}}
CHAIR = {"kind": "rigid", "shape": {"kind": "compound", "parts": {name: BOX for name in ("seat", "leg_0", "leg_1")}}}
BALL = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}
BODIES = {"chair": CHAIR, "ball": BALL}


@pytest.fixture
def chair(new_run):
    """A chair that stands on its legs, on the second one from 0.5 s on, and that a ball hits at its seat at 0.8 s."""
    run = new_run()
    floor, chair, ball = run.add_link("floor", fixed=True), run.add_link("chair"), run.add_link("ball")
    run.touch(floor, chair, range(1, 101), (0, 0, 10.0), parts=("", "leg_0"), depth=0.002)
    run.touch(floor, chair, range(50, 101), (0, 0, 4.0), parts=("", "leg_1"), depth=0.003)
    run.touch(chair, ball, range(80, 84), (0, 0, 7.0), parts=("seat", ""))
    return run


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        ({"kind": "contact_force", "of": "chair.leg_0"}, lambda step: 10.0 + 0 * step),
        ({"kind": "contact_force", "of": "chair.leg_*"}, lambda step: 10.0 + 4.0 * (step >= 50)),
        ({"kind": "contact_force", "of": "floor", "by": "chair.leg_1"}, lambda step: 4.0 * (step >= 50)),
        ({"kind": "contact_force", "of": "chair", "by": "floor"}, lambda step: 10.0 + 4.0 * (step >= 50)),
        ({"kind": "contact_count", "of": "chair.seat"}, lambda step: 1.0 * ((step >= 80) & (step < 84))),
        ({"kind": "contact_count", "of": "chair"}, lambda step: 1.0 + ((step >= 80) & (step < 84))),
        ({"kind": "penetration", "of": "chair.leg_0"}, lambda step: 0.002 + 0 * step),
        ({"kind": "penetration", "of": "chair"}, lambda step: 0.002 + 0.001 * (step >= 50)),
        ({"kind": "contact_force", "of": "chair.seat", "by": "floor"}, lambda step: 0.0 * step),
    ],
)
def test_measures_tell_parts_apart(chair, measure, wanted, expected):
    series = measure(chair, bodies=BODIES, **wanted)
    assert not series.problem
    np.testing.assert_allclose(series.values, expected(chair.step), rtol=1e-6)


def find(folder: Any, make_case: Any, **event: Any) -> Any:
    case = make_case(bodies=BODIES, events={"e": event})
    return find_events(RecordedCase.load(folder, case), {})


def test_events_tell_parts_apart(chair, make_case):
    folder = chair.write()
    (second,) = find(folder, make_case, kind="contact", between=["chair.leg_1", "floor"]).occurrences["e"]
    assert (second["time"], second["between"]) == (0.5, ["chair.leg_1", "floor"])
    (hit,) = find(folder, make_case, kind="contact", between=["ball", "chair.seat"]).occurrences["e"]
    assert hit["time"] == pytest.approx(0.8)
    legs = find(folder, make_case, kind="contact", between=["chair.leg_*", "floor"]).occurrences["e"]
    assert [row["between"][0] for row in legs] == ["chair.leg_0", "chair.leg_1"]
    (whole,) = find(folder, make_case, kind="contact", between=["chair", "floor"]).occurrences["e"]
    assert whole["normal_impulse"] == pytest.approx(0.01 * (10 * 100 + 4 * 51), rel=1e-6)
    assert not find(folder, make_case, kind="contact", between=["chair.leg_0", "ball"]).occurrences["e"]
    (end,) = find(folder, make_case, kind="separation", between=["chair.seat", "ball"]).occurrences["e"]
    assert end["time"] == pytest.approx(0.83)


def test_a_recording_of_an_older_version_has_whole_bodies_only(new_run, measure):
    run = new_run(duration=0.1)
    floor, chair = run.add_link("floor", fixed=True), run.add_link("chair")
    run.touch(floor, chair, range(1, 11), (0, 0, 10.0))
    folder = run.write()
    np.testing.assert_allclose(measure(folder, bodies=BODIES, kind="contact_force", of="chair").values, 10.0)
    assert "run the case again" in measure(folder, bodies=BODIES, kind="contact_force", of="chair.seat").problem
