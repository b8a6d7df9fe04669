"""Bodies that are through, or in, others: the recording says so, asked or not."""

import time
from typing import Any

import numpy as np
import pytest

from text2sim.evidence.gone_through import gone_through
from text2sim.evidence.recorded_case import RecordedCase

UP = np.array([0.0, 0.0, 1.0])


def said(new_run: Any, make_case: Any, ways: dict[str, Any], *, controls: Any = None, **solids: Any) -> list[str]:
    """What is said of boxes that go along ways; half their sides by name, 0.05 m if left out."""
    run = new_run()
    for name, way in {"floor": np.zeros(3), **ways}.items():
        link = run.add_link(name, fixed=name in ("floor", "plate", "peg"), pos=way(run.time) if callable(way) else way)
        run.add_box(link, solids.get(name, [0.05, 0.05, 0.05]))
    case = make_case(
        bodies=tuple(name for name in ways if name != "plate"), statics=("floor",), controls=controls or {},
        scene={"statics": {
            "floor": {"shape": {"kind": "plane"}}, "plate": {"shape": {"kind": "box", "size": [1, 1, 0.002]}}
        }},
    )  # fmt: skip
    return gone_through(RecordedCase.load(run.write(), case))


def falls(speed: float, start: float) -> Any:
    return lambda t: np.outer(start - speed * t, UP)


def test_what_lies_slides_and_bounces_is_not_suspicious(new_run, make_case) -> None:
    ways = {
        "plate": [0, 0, 1.0],
        "lies": [0.4, 0, 0.04],
        "bounces": lambda t: np.outer(1.03 + np.abs(t - 0.51), UP),
        "slides_off": lambda t: np.outer(-0.6 + 3 * t, [1, 0, 0]) + np.outer(1.05 - np.maximum(t - 0.4, 0), UP),
        "stacked": [0.4, 0, 0.13],
    }
    assert said(new_run, make_case, ways, plate=[0.5, 0.5, 0.001]) == []


def test_a_ball_below_the_floor_and_one_that_starts_there_are_told(new_run, make_case) -> None:
    through, under = said(new_run, make_case, {"ball": falls(2.0, 0.5), "mole": [1.0, 0, -1.0]})[::-1]
    assert through.startswith("`ball` is through `floor` at 0.28 s")  # 0.5 - 2 t = -0.05 between two frames
    assert under == "`mole` is under `floor` from the start"


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_a_bullet_that_passes_a_plate_between_two_frames_is_told(new_run, make_case, tilt) -> None:
    slanted = lambda t: np.outer(1.5 - 43.0 * t, UP) + np.outer(tilt * t, [1, 0, 0])  # noqa: E731
    (words,) = [
        row
        for row in said(new_run, make_case, {"plate": [0, 0, 1.0], "ball": slanted}, plate=[0.5, 0.5, 0.001])
        if "plate" in row
    ]
    assert words.startswith("`ball` is through `plate` at 0.02 s")


def test_what_passes_beside_a_plate_is_not_told(new_run, make_case) -> None:
    beside = lambda t: np.outer(1.5 - 20.0 * np.minimum(t, 0.06), UP) + [0.51, 0, 0]  # noqa: E731
    assert said(new_run, make_case, {"plate": [0, 0, 1.0], "ball": beside}, plate=[0.5, 0.5, 0.001]) == []


def test_a_heavy_box_that_sinks_into_a_light_one_is_told_unless_they_are_welded(new_run, make_case) -> None:
    ways = {"heavy": lambda t: np.outer(0.2 - 0.15 * t, UP), "light": [0, 0, 0.05]}
    (words,) = said(new_run, make_case, ways)
    assert words.startswith("`heavy` is inside `light` at 0.67 s")
    weld = {"hold": {"kind": "attach", "body": "heavy", "to": "light"}}
    assert said(new_run, make_case, ways, controls=weld) == []


def test_what_is_fixed_astride_something_fixed_is_meant_so(new_run, make_case) -> None:
    assert said(new_run, make_case, {"plate": [0, 0, 1.0], "peg": [0.1, 0, 1.0]}, plate=[0.5, 0.5, 0.02]) == []


def test_a_heap_of_five_hundred_takes_a_moment(new_run, make_case) -> None:
    run = new_run()
    places = np.stack(np.unravel_index(np.arange(500), (10, 10, 5)), 1) * 0.11
    for k, place in enumerate(places):
        way = place + np.outer(0.3 * np.sin(9 * run.time + k), [0.2, 0.1, 1])
        run.add_box(run.add_link(f"ball[{k}]", pos=way), [0.05, 0.05, 0.05])
    case = make_case(bodies=("ball",), statics=())
    recording = RecordedCase.load(run.write(), case)
    began = time.process_time()
    gone_through(recording)
    assert time.process_time() - began < 6.0
