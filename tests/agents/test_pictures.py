"""The sheet that the Critic sees shows what happened, not only what was filmed at even distances."""

import json
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from text2sim.agents import pictures
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempts import Attempts
from text2sim.agents.frame_choice import (
    MIN_INTERVAL,
    after_strikes,
    choose_frames,
    moments,
    named_bodies,
    with_attached,
)
from text2sim.agents.pictures import FEWEST_TRACED, MAX_FRAMES, frame_sheet, moments_of
from text2sim.legibility import visible_motion
from text2sim.templates.cadence import MAIN, frames, read_film, reels
from text2sim.templates.video import Video

FILM = """
START, END, SPEED, FPS, MOTION_BLUR = 0.0, 2.0, 1.0, 25.0, 0.0
CAMERAS = {"main": {}}
SHOTS = []
"""
SIZE = (160, 90)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run with a film that gets brighter by two of 255 from picture to picture, and three kept pictures."""
    (tmp_path / "program").mkdir()
    (tmp_path / "frames").mkdir()
    (tmp_path / "program" / "render.py").write_text(FILM)
    video = Video(tmp_path / "video.mp4", SIZE, 25.0)
    for k in range(50):
        video.write(np.full((SIZE[1], SIZE[0], 3), 2 * k + 40, np.uint8))
    video.close()
    for k in range(3):
        Image.new("RGB", SIZE, "white").save(tmp_path / "frames" / f"main_{k}.png")
    (tmp_path / "visibility.json").write_text(json.dumps({"main": [{"t": t, "shares": {}} for t in (0.0, 1.0, 1.96)]}))
    return tmp_path


def tell(run: Path, **first: float | None) -> None:
    events = {name: {"count": 1, "first": t, "last": t, "problem": None} for name, t in first.items()}
    (run / "evidence.json").write_text(json.dumps({"events": events, "time": {"reached": 2.0}}))


def shown(run: Path) -> dict[float, list[str]]:
    """What is said of each picture of the film that is chosen, by its time."""
    evidence = json.loads((run / "evidence.json").read_text())
    film = read_film((run / "program" / "render.py").read_text())
    pictures = frames(film, reels(film)[MAIN], 2.0)
    return {
        round(one.frame.t, 2): one.reasons
        for one in choose_frames(list(moments(evidence, ACTIONS)), pictures, MAX_FRAMES)
    }


ACTIONS = {
    "events": {"hit": {"between": ["ball[2]", "arm.hand"]}},
    "measures": {"high": {"of": "ball"}, "idle": {"of": "ball"}},
    "expect": {"up": {"measure": "high", "above": 1}},
}


def test_events_stand_with_what_is_just_before_and_after_and_neighbours_are_dropped(run: Path) -> None:
    tell(run, hit=0.81, late=0.85, never=None)
    found = shown(run)
    assert found[0.8] == ["hit", "late"], "0.04 s later nothing else is to be seen"
    assert "before hit" in found[0.64]
    assert any("after hit" in said for said in found.values())
    times = sorted(found)
    assert len(times) == MAX_FRAMES
    assert times[0] == 0
    assert times[-1] >= 1.9
    assert all(after - before >= MIN_INTERVAL - 1e-9 for before, after in zip(times, times[1:], strict=False))


def test_extremes_are_shown_of_what_is_expected_and_the_deepest_overlap(run: Path) -> None:
    row = {"max": 1.0, "max_at": 1.2, "min": 0.0, "min_at": 0.0, "problem": None}
    evidence = {
        "events": {}, "time": {"reached": 2.0}, "measures": {"high": row, "idle": row | {"max_at": 0.5}},
        "penetration": {"value": 0.004, "time": 1.6, "between": ["ball[0]", "floor"]},
    }  # fmt: skip
    (run / "evidence.json").write_text(json.dumps(evidence))
    found = shown(run)
    assert found[1.2] == ["max of high"]
    assert found[1.6] == ["deepest overlap"]
    assert not any("idle" in word for said in found.values() for word in said)
    told = list(moments(evidence, ACTIONS))
    assert [one.bodies for one in told] == [("ball",), ("ball", "floor")]


def test_the_moments_that_decide_are_shown_with_what_is_just_before_and_after(run: Path) -> None:
    """A squash from 0.28 to 0.43 s lies between the events: its expectation says when it was greatest."""
    evidence = {
        "events": {"hit": {"first": 0.05}, "end": {"first": 1.8}}, "time": {"reached": 2.0},
        "expect": {"up": {"ok": False, "at": 0.36}, "hits": {"ok": True, "at": 0.05}, "open": {"ok": None, "at": None}},
    }  # fmt: skip
    (run / "evidence.json").write_text(json.dumps(evidence))
    found = shown(run)
    assert found[0.36] == ["expect:up"]
    assert "before expect:up" in found[0.2]
    assert found[0.52] == ["after expect:up"]
    assert next(iter(moments(evidence, ACTIONS))).bodies == ("ball",)


def touch(t: float, one: str, other: str, impulse: float, name: str | None = None) -> dict:
    return {"kind": "contact", "name": name, "time": t, "between": [one, other], "impact_impulse": impulse}


def test_the_moment_after_a_strike_is_shown_however_much_else_happens(run: Path) -> None:
    """A ball strikes the second domino at 0.9 s, which strikes a third softly; the rest lies, or falls on the floor."""
    events = {f"e{k}": {"first": t} for k, t in enumerate((0.12, 0.3, 0.44, 0.6))}
    expect = {f"x{k}": {"ok": True, "at": t} for k, t in enumerate((0.2, 0.52, 1.2, 1.4))}
    (run / "evidence.json").write_text(json.dumps({"events": events, "expect": expect, "time": {"reached": 2.0}}))
    rows = [
        touch(0.01, "domino[1]", "tray", 9.0), touch(0.5, "ball", "floor", 5.0), touch(0.9, "ball", "domino[2]", 0.3),
        touch(1.1, "domino[2]", "domino[3]", 0.2), touch(1.7, "ball", "domino[3]", 4.0), touch(1.72, "ball", "tray", 0.1),
    ]  # fmt: skip
    (run / "events.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    (run / "expanded.yaml").write_text("scene:\n  statics:\n    floor: {shape: {kind: plane}}\n")
    found = {round(one.t, 3): one.bodies for one in moments_of(run)}
    assert found[1.05] == ("ball", "domino"), "not at 1.7 s, when they meet again"
    assert 0.65 not in found and 0.16 not in found, "the floor cannot move, and the tray is touched from the start"
    film = read_film((run / "program" / "render.py").read_text())
    pictures = frames(film, reels(film)[MAIN], 2.0)
    chosen = choose_frames(moments_of(run), pictures, MAX_FRAMES)
    assert len(chosen) == MAX_FRAMES
    assert any(0.94 <= one.frame.t <= 1.08 for one in chosen)


def test_touches_that_the_case_declares_come_before_harder_ones() -> None:
    rows = [
        touch(0.3, "a", "b", 7.0), touch(0.4, "c", "d", 8.0), touch(0.6, "e", "f", 0.1), touch(0.6, "e", "f", 0.1, "tap"),
    ]  # fmt: skip
    assert [one.bodies for one in after_strikes(rows, ())] == [("e", "f"), ("c", "d")]


def test_the_greatest_deformation_is_shown_and_a_slight_one_is_not(run: Path) -> None:
    evidence = {
        "events": {}, "time": {"reached": 2.0},
        "deformables": {
            "jelly": {"volume": {"value": 0.8, "at": 0.4}, "stretch": {"value": 1.3, "at": 1.4}},
            "stiff": {"strain": {"value": 0.001, "at": 0.9}, "volume": {"value": 0.9, "at": 1.0}},
            "calm": {"strain": {"value": 0.01, "at": 0.7}},
        },
    }  # fmt: skip
    (run / "evidence.json").write_text(json.dumps(evidence))
    found = shown(run)
    assert (found[1.4], found[1.0]) == (["greatest stretch of jelly"], ["greatest volume of stiff"])
    assert not any("calm" in word for said in found.values() for word in said)


def test_what_the_preview_leaves_out_is_said(run: Path) -> None:
    tell(run, hit=0.41)
    (run / "program" / "looks.json").write_text(
        json.dumps(
            {"box": {"finish": "wood", "label": {"text": "A"}}, "gel": {"finish": "jelly"}, "ball": {"finish": "rough"}}
        )
    )
    told = frame_sheet(run)[2]
    assert (
        "how clear a liquid is, so also wood and the label of `box`; jelly of `gel`: judge such looks by the case"
        in told
    )


def test_pictures_come_from_the_film_at_those_times(run: Path) -> None:
    tell(run, hit=0.41)
    sheet, count, _ = frame_sheet(run)
    assert count == MAX_FRAMES
    assert sheet is not None
    first = np.asarray(sheet)[4 + SIZE[1] * 3 // 4, 4 + SIZE[0] // 2, 0]
    assert abs(int(first) - 40) <= 2, "the film's first picture, not one that was kept"


def test_a_sheet_that_is_too_large_for_a_model_is_reduced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (1200, 1200, 3), np.uint8)  # 4.3 MB as PNG
    monkeypatch.setattr("text2sim.agents.attempts.frame_sheet", lambda run, preview: (Image.fromarray(noise), 1, ""))
    attempts, attempt = Attempts(tmp_path), Attempt(1, "text", "x")
    attempt.pictures = attempts._pictures(attempt, tmp_path, lambda: None)[0]
    (image,) = attempts.images(attempt)
    with Image.open(BytesIO(image.data)) as picture:
        assert picture.size == (900, 900)


def test_a_run_of_another_kind_shows_what_it_has(run: Path) -> None:
    assert frame_sheet(run)[1] == 3
    tell(run, hit=0.41)
    (run / "program" / "render.py").write_text("FPS = 1 / 0")
    assert frame_sheet(run)[1] == 3
    (run / "program" / "render.py").write_text(FILM)
    (run / "video.mp4").write_bytes(b"no film")
    assert frame_sheet(run)[1] == 3


def test_a_close_view_shows_what_is_attached_to_a_body_as_well() -> None:
    hold = {"kind": "attach", "body": "foam", "to": "car.chassis"}
    actions = {"controls": {"hold": hold, "push": {"kind": "force", "body": "car"}, "odd": None}}
    assert with_attached(("car", "floor"), actions) == ("car", "floor", "foam")
    assert with_attached(("ball",), actions) == ("ball",)


def test_the_sheet_takes_account_of_motion_that_was_recorded(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tell(run, hit=0.12)
    recorded: Any = SimpleNamespace(recording=None)
    monkeypatch.setattr(pictures, "_locator", lambda run: (recorded, None))
    monkeypatch.setattr(pictures, "MAX_FRAMES", 6)
    monkeypatch.setattr(
        visible_motion, "visible_motion", lambda _, shown: np.clip([2 * one.t - 2.8 for one in shown], 0, 1)
    )
    said = [float(caption.split(" s")[0]) for _, caption, *_ in pictures._filmed(run)]
    assert len(said) == 6 and sum(1.4 < t < 1.9 for t in said) >= 3


def test_the_bodies_of_a_measure_or_event_are_those_of_its_lists_too():
    assert named_bodies({"kind": "speed", "of": ["trunk_1", "brick[2]", "arm.hand"]}) == ("trunk_1", "brick", "arm")
    assert named_bodies({"kind": "contact_force", "of": "cup", "by": ["ball", "box"]}) == ("cup", "ball", "box")
    assert named_bodies({"kind": "contact", "between": ["cup", "ball"]}) == ("cup", "ball")
    assert named_bodies({"kind": "energy"}) == named_bodies(None) == ()


def traced_frames(monkeypatch: pytest.MonkeyPatch, first: dict[str, float], each: float, more: float) -> int:
    """The number of frames, of 12, that are traced in 90 s and `more`, each after the first in the same time [s]."""
    now, done = 0.0, list[int]()
    monkeypatch.setattr(pictures, "monotonic", lambda: now)

    def render(reel: list[int], tell: Any, until: float) -> None:
        nonlocal now
        for k in reel:
            if k not in done and now <= until:
                seconds = {"trace": each} if done else first
                now += sum(seconds.values())
                done.append(k)
                tell(SimpleNamespace(done=len(done), seconds=seconds))

    filming: Any = SimpleNamespace(render=render)
    reel: Any = list(range(12))
    pictures._trace(filming, reel, FEWEST_TRACED, 90.0, more)
    return len(done)


@pytest.mark.parametrize(("each", "traced"), [(2, 12), (13, 10), (18, 8), (25, 3)])
def test_frames_that_are_about_to_be_enough_are_waited_for(
    monkeypatch: pytest.MonkeyPatch, each: int, traced: int
) -> None:
    """A first frame of 30 s more than the others, as a background takes on a busy machine, and an engine of 60 s."""
    assert traced_frames(monkeypatch, {"trace": each, "background": 30}, each, 60.0) == traced


def test_a_slow_first_frame_does_not_decide_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a busy machine the tracer takes 95 s for its first frame, most of which compiles its kernels."""
    assert traced_frames(monkeypatch, {"trace": 95}, 20, 100.0) >= FEWEST_TRACED


def test_what_is_reached_comes_before_what_only_stays_within_bounds() -> None:
    during = {"measure": "high", "during": [0, 9]}
    asked = {
        "clear": during | {"stat": "max", "below": 5}, "held": during | {"above": 0}, "failed": during | {"below": 1},
        "calm": during | {"stat": "min", "above": 1}, "leaps": during | {"stat": "max", "above": 2},
        "sinks": during | {"stat": "min", "below": 1}, "ends": {"measure": "high", "at": 8, "below": 1},
    }  # fmt: skip
    found = {name: {"ok": name != "failed", "at": float(t)} for t, name in enumerate(asked, 1)}
    told = list(moments({"events": {}, "time": {"reached": 9.0}, "expect": found}, ACTIONS | {"expect": asked}))
    decided = [(one.reason.removeprefix("expect:"), one.decisive) for one in told if one.reason.startswith("expect:")]
    assert decided == [("failed", True), ("leaps", True), ("sinks", True), ("ends", True)]
    del asked["sinks"], found["sinks"]
    told = list(moments({"events": {}, "time": {"reached": 9.0}, "expect": found}, ACTIONS | {"expect": asked}))
    assert [one.decisive for one in told if one.reason == "expect:clear"] == [False]


def test_of_an_event_that_is_counted_the_last_time_is_shown_too() -> None:
    evidence = {"events": {"hit": {"first": 0.5, "last": 1.5}}, "time": {"reached": 2.0}}
    counted = ACTIONS | {"expect": {"twice": {"event": "hit", "count": 2}}}
    assert [(one.t, one.reason) for one in moments(evidence, counted)][:2] == [(0.5, "hit"), (1.5, "last hit")]
    assert "last hit" not in [one.reason for one in moments(evidence, ACTIONS)]
