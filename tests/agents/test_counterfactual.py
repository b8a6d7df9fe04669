"""What is said to be brought about by something must not come about without it."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from text2sim.agents.attempt import Attempt
from text2sim.agents.attempts import Attempts
from text2sim.agents.counterfactual import TITLE, case_without, causes_text, compare_causes
from text2sim.agents.replies import CasePlan
from text2sim.agents.revising import data_of
from text2sim.harness import run
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.canonical import format_text

TEXT = (Path(__file__).parent / "recorded" / "edit_colour" / "base.yaml").read_text("utf-8")
FILE = Path("tin/case.yaml")


def plan(**more: Any) -> CasePlan:
    return CasePlan(name="tin", event="The ball pushes the tin away.", **more)


def test_all_that_refers_to_a_cause_goes_with_it_and_the_rest_stays_a_case() -> None:
    case = case_without(data_of(TEXT), ["ball"])
    assert list(case["bodies"]) == ["tin"]
    assert list(case["actions"]["measures"]) == ["away"]
    assert case["actions"]["events"] == {}
    assert list(case["actions"]["expect"]) == ["pushed"], "what is about the event is gone with it"
    assert "render" not in case
    assert "ball" in data_of(TEXT)["bodies"], "the case itself is as it was"


@pytest.mark.parametrize(
    ("span", "times", "made"),
    [
        (
            {"during": [0.1, "${p + 1}"], "above": 0.1},
            {"hit": 0.5},
            {"during": [0.6, "${(p + 1) + 0.5}"], "above": 0.1},
        ),
        ({"during": [0.1, "end"], "above": 0.1}, {"hit": 0.5}, {"during": [0.6, "end"], "above": 0.1}),
        ({"at": 0.25, "above": 0.1}, {"hit": 0.5}, {"at": 0.75, "above": 0.1}),
        ({"at": 0.25, "above": 0.1}, None, {"at": 0.25, "above": 0.1}),
        ({"at": 0.25, "above": 0.1}, {"hit": None}, None),
    ],
)
def test_times_after_an_event_of_the_cause_are_those_of_the_run(span: Any, times: Any, made: Any) -> None:
    case = data_of(TEXT)
    case["actions"]["expect"]["pushed"] = {"measure": "away", "on": "hit", **span}
    expected = case_without(case, ["ball"], times)["actions"]["expect"].get("pushed")
    assert expected == (made and {"measure": "away"} | made)


def test_pairs_of_friction_go_with_their_bodies() -> None:
    case = data_of(TEXT)
    case["scene"]["contact"] = {"pairs": {"slick": {"between": ["ball", "tin"], "friction": 0.1}}}
    assert case_without(case, ["ball"])["scene"]["contact"]["pairs"] == {}


def test_air_goes_on_blowing_on_what_is_left_of_its_list() -> None:
    case = data_of(TEXT)
    case["actions"]["controls"] = {
        "breeze": {"kind": "airflow", "body": ["ball", "tin[0]", "tin[1]"], "velocity": [1, 0, 0]},
        "gust": {"kind": "airflow", "body": ["ball"], "velocity": [1, 0, 0]},
    }
    controls = case_without(case, ["ball"])["actions"]["controls"]
    assert {name: row["body"] for name, row in controls.items()} == {"breeze": ["tin[0]", "tin[1]"]}


def test_a_joint_that_is_not_driven_is_held() -> None:
    case = data_of(TEXT)
    case["actions"]["controls"] = {
        "lower": {"kind": "drive", "joint": "tin", "on": "hit", "position": {"kind": "ramp", "to": -0.1, "end": 1}},
        "push": {"kind": "drive", "joint": "tin", "force": 3},
    }
    never = {"kind": "constant", "value": 0, "start": case["scene"]["duration"]}
    left = case_without(case, ["lower", "push"])
    assert left["actions"]["controls"] == {"lower": {"kind": "drive", "joint": "tin", "position": never}}


def test_what_a_repeat_makes_goes_with_its_cause_and_a_namesake_stays() -> None:
    case = data_of(TEXT)
    case["actions"]["controls"] = {
        "hold": {"kind": "attach", "body": "ball", "to": "world", "repeat": 2},
        "let_go": {"kind": "release", "attach": "hold_${k}", "at": 0.1, "repeat": 2},
        "early": {"kind": "release", "attach": "hold_1", "at": 0.05},
        "tin_1": {"kind": "attach", "body": "tin", "to": "world"},
        "tin_free": {"kind": "release", "attach": "tin_1", "at": 0.2},
    }
    assert list(case_without(case, ["ball"])["actions"]["controls"]) == ["tin_1", "tin_free"]


def test_an_effect_that_comes_without_its_cause_is_said() -> None:
    made = plan(meets={"knocked": ["strikes", "pushed"]}, causes={"knocked": ["ball"]})
    seen: list[Any] = []

    def simulate(loaded: Any) -> tuple[str, dict[str, Any]]:
        seen.append(loaded.case)
        return "finished", {"pushed": {"ok": pushed, "why": "0.4 m at 1.8 s"}}

    pushed = False
    told = causes_text(compare_causes(made, TEXT, FILE, simulate))
    assert told.startswith(TITLE)
    assert "without `ball` `pushed` does not come true, as it must be (0.4 m at 1.8 s)" in told
    assert list(seen[0].bodies) == ["tin"]
    pushed = True
    assert "`pushed` COMES TRUE AS WELL: no cause" in causes_text(compare_causes(made, TEXT, FILE, simulate))


def test_equal_causes_share_a_run_and_those_beyond_two_are_named() -> None:
    causes = {"knocked": ["ball"], "rolled": ["ball"], "stood": ["ball", "floor"], "fell": ["floor"]}
    made = plan(meets={name: ["pushed"] for name in causes}, causes=causes)
    runs = []

    def simulate(loaded: Any) -> tuple[str, dict[str, Any]]:
        runs.append(loaded)
        return "finished", {"pushed": {"ok": False, "why": "0.0 m"}}

    rows = causes_text(compare_causes(made, TEXT, FILE, simulate)).splitlines()
    assert len(runs) == 2
    assert all("does not come true" in row for row in rows[-4:-1])
    assert rows[-1] == "- `fell`: not run without `floor`: 2 causes are tested at most"


def test_what_has_to_stay_needs_no_cause() -> None:
    made = plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]}, keeps=["pushed"])
    told = causes_text(
        compare_causes(made, TEXT, FILE, lambda loaded: ("finished", {"pushed": {"ok": True, "why": "so"}}))
    )
    assert "COMES TRUE" not in told


@pytest.mark.parametrize(
    ("causes", "bound", "said"),
    [
        (["ball"], ["strikes"], "without `ball` nothing that is measured of it is left"),
        (["tin"], ["pushed"], "nothing that is measured of it is left"),
    ],
)
def test_what_cannot_be_compared_is_said(causes: list[str], bound: list[str], said: str) -> None:
    made = plan(meets={"knocked": bound}, causes={"knocked": causes})
    assert said in causes_text(compare_causes(made, TEXT, FILE, lambda loaded: ("finished", {})))


@pytest.mark.parametrize(("state", "ok"), [("finished", None), ("diverged", False), ("timeout", False)])
def test_a_run_without_the_cause_that_shows_nothing_is_no_proof(state: str, ok: bool | None) -> None:
    made = plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]})
    told = causes_text(
        compare_causes(made, TEXT, FILE, lambda loaded: (state, {"pushed": {"ok": ok, "why": "not reached"}}))
    )
    assert f"`pushed` could not be told (the run ended as: {state})" in told


def test_an_effect_with_repeat_is_looked_up_by_its_numbers() -> None:
    text = TEXT.replace("    pushed: {", "    pushed: {repeat: 2, ")
    assert text != TEXT
    made = plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]})
    found = {f"pushed_{k}": {"ok": k == 1, "why": "0.4 m"} for k in (0, 1)}
    told = causes_text(compare_causes(made, text, FILE, lambda loaded: ("finished", found)))
    assert "`pushed_0` does not come true" in told
    assert "`pushed_1` COMES TRUE AS WELL" in told


def test_what_was_stopped_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = SimpleNamespace(stopped=True, state="incomplete", expectations={})
    monkeypatch.setattr(run, "run_case", lambda *given, **more: stopped)
    attempt, made = Attempt(1, TEXT, "x"), plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]})
    with pytest.raises(KeyboardInterrupt):
        Attempts(tmp_path).rerun_without_causes(attempt, made, 1.0, lambda progress: None)
    assert TITLE not in attempt.evidence


@pytest.mark.parametrize(
    ("wall", "slowest", "now", "runs"),
    [(200.0, 0.0, 12.0, 0), (100.0, 100.0, 12.0, 1), (3.0, 200.0, 12.0, 0), (200.0, 200.0, None, 1)],
    ids=["slow", "quick", "only filmed again", "no clock"],
)
def test_a_run_that_would_take_too_much_of_the_time_left_is_not_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wall: float, slowest: float, now: float | None, runs: int
) -> None:
    seen: list[Any] = []
    done = SimpleNamespace(stopped=False, state="finished", expectations={})
    monkeypatch.setattr(run, "run_case", lambda *given, **more: seen.append(given) or done)
    monkeypatch.setattr("text2sim.agents.attempts.monotonic", lambda: 90.0 * len(seen))
    attempt, made = (
        Attempt(1, TEXT, "x", wall=wall, took=250.0),
        plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]}),
    )
    before = [Attempt(0, TEXT, "y", run="other", wall=slowest)]
    Attempts(tmp_path).rerun_without_causes(attempt, made, 1.0, lambda progress: None, now, before)
    assert len(seen) == runs
    assert attempt.took == 250 + 90 * runs, "the next letter waits for it, too"
    assert ("not run without its causes, since a run takes 3 min" in attempt.evidence) == (not runs)


def test_runs_without_causes_that_are_there_are_judged_again_whatever_time_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The run is that of the first attempt, but the Planner may have made an expectation tighter since."""
    pushed: dict[str, Any] = {"ok": True, "why": "0.1 m"}
    done = SimpleNamespace(stopped=False, state="finished", expectations={"pushed": pushed})
    monkeypatch.setattr(run, "run_case", lambda *given, **more: done)
    made = plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["ball"]})
    first, filmed, other = (Attempt(k, TEXT, "x", run=where) for k, where in enumerate(("runs/a", "runs/a", "runs/b")))
    attempts, again = Attempts(tmp_path), Attempt(4, TEXT, "x", run="runs/a")
    first.wall = 300.0
    attempts.rerun_without_causes(first, made, 1.0, lambda progress: None, None)
    assert "COMES TRUE AS WELL" in first.evidence
    pushed["ok"] = False
    for attempt, causes in (
        (filmed, made),
        (other, made),
        (again, plan(meets=made.meets, causes={"knocked": ["floor"]})),
    ):
        attempts.rerun_without_causes(attempt, causes, 1.0, lambda progress: None, 10.0, [first])
    assert "does not come true" in filmed.evidence
    assert [row["ok"] for row in filmed.facts] == [True]
    assert "not run without its causes" in other.evidence
    assert "not run without its causes" in again.evidence, "another cause"


def test_a_case_that_cannot_be_without_it_is_said() -> None:
    placed = TEXT.replace("pose: {pos: [0.3, 0, 0.0801]}", "place: {on: floor, at: [0.3, 0]}")
    load_text(placed, FILE)
    made = plan(meets={"knocked": ["pushed"]}, causes={"knocked": ["floor"]})
    assert "without `floor` the case cannot be run" in causes_text(
        compare_causes(made, placed, FILE, lambda loaded: ("finished", {}))
    )
    assert compare_causes(plan(), TEXT, FILE, lambda loaded: ("finished", {})) == []


@pytest.mark.parametrize("cause", ["slip", "clear", "glue", "grip", "ball"])
def test_events_of_a_control_that_is_left_out_never_happen(cause: str) -> None:
    case = data_of(TEXT)
    case["bodies"]["block"] = {
        "kind": "rigid",
        "shape": {"kind": "box", "size": [0.1, 0.1, 0.1]},
        "pose": {"pos": [2, 0, 0.05]},
    }
    case["bodies"]["twin"] = case["bodies"]["block"] | {"pose": {"pos": [2.1, 0, 0.05]}}
    case["actions"]["controls"] = case["actions"].get("controls", {}) | {
        "grip": {"kind": "attach", "body": "tin", "to": "world"},
        "slip": {"kind": "release", "attach": "grip", "on": "hit"},
        "clear": {"kind": "remove", "body": "block", "at": 0.5},
        "glue": {"kind": "bond", "of": ["block", "twin"], "strength": 1e5},
    }
    case["actions"]["events"] |= {
        "slipped": {"kind": "released", "attach": "grip"},
        "cleared": {"kind": "removed", "remove": "clear"},
        "broke": {"kind": "broken", "bond": "glue"},
    }
    case["actions"]["expect"] |= {name: {"event": name} for name in ("slipped", "cleared", "broke")}
    text = format_text(json.dumps(case))
    load_text(text, FILE)
    made = plan(meets={"knocked": ["pushed", "slipped", "cleared", "broke"]}, causes={"knocked": [cause]})
    seen: list[Any] = []

    def simulate(loaded: Any) -> tuple[str, dict[str, Any]]:
        seen.append(loaded.case.actions)
        return "finished", {"pushed": {"ok": False, "why": "0.0 m"}}

    (first, *_) = compare_causes(made, text, FILE, simulate)
    assert first.ok is True and "`pushed` does not come true" in first.told
    of = {"slip": {"slipped"}, "clear": {"cleared"}, "glue": {"broke"}, "grip": {"slipped"}, "ball": {"slipped", "hit"}}
    assert {"slipped", "cleared", "broke", "hit"} - set(seen[0].events) == of[cause]
