"""What the Critic is shown: little where nothing but looks can have changed."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.agents.scripted import quiet_loop
from text2sim.agents import loop
from text2sim.agents.assembly import Examination
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempts import _judged_warnings
from text2sim.agents.critic_view import critic_exhibit, only_looks, what_holds
from text2sim.agents.judgement import Critique
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import load_text

TEXT = (Path(__file__).parent / "recorded" / "edit_colour" / "base.yaml").read_text("utf-8")
FILE = Path("tin/case.yaml")


@pytest.mark.parametrize(
    ("old", "new", "looks"),
    [
        ("color: gold", "color: green", True),
        ("finish: painted", "finish: metal", True),
        ("color: gainsboro", "color: white", True),
        ("fps: 25", "fps: 30", True),
        ("density: 1200", "density: 1300", False),
        ("slope_deg: 15", "slope_deg: 16", False),
        ("pos: [-0.85, 0, 0.36]", "pos: [-0.8, 0, 0.36]", False),
    ],
)
def test_what_physics_could_feel_is_no_change_of_looks(old: str, new: str, looks: bool) -> None:
    assert old in TEXT
    assert only_looks(TEXT, TEXT.replace(old, new), FILE) is looks


def test_a_body_called_look_is_a_body() -> None:
    named = TEXT.replace("tin:", "look:").replace("of: tin", "of: look").replace("tin]", "look]")
    assert load_text(named, FILE).case.bodies["look"]
    assert not only_looks(named, named.replace("mass: 0.15", "mass: 0.25"), FILE)


def test_a_change_of_looks_is_shown_without_the_case() -> None:
    attempt = Attempt(1, TEXT.replace("color: gold", "color: green"), "as was wished", state="finished")
    attempt.expect = {"pushed": {"ok": True, "wanted": "w", "why": "0.3 m at 1.8 s"}}
    shown = critic_exhibit([attempt], "all the evidence", (), TEXT, FILE)
    assert shown.case == ""
    assert "green" in shown.evidence
    assert "all the evidence" not in shown.evidence
    assert critic_exhibit([attempt], "all the evidence", (), "", FILE).case == attempt.text
    attempt.expect["pushed"]["ok"] = False
    assert critic_exhibit([attempt], "all the evidence", (), TEXT, FILE).case == attempt.text, "something went wrong"


def test_numbers_of_a_motion_that_was_judged_are_not_told_again() -> None:
    def made(number: int, text: str) -> Attempt:
        attempt = Attempt(number, text, "x", state="finished", run="runs/tin-1")
        attempt.expect = {"pushed": {"ok": True, "wanted": "w", "why": "0.3 m at 1.8 s"}}
        return attempt

    first, second = made(1, TEXT), made(2, TEXT.replace("color: gold", "color: green"))
    first.critique = {"verdict": "repair", "score": 75.0, "summary": "Paler.", "failures": [], "patches": []}
    first.critique["requirements"] = {"rolls": {"mark": 1, "why": ""}, "seen": {"mark": 0.5, "why": "dark"}}
    evidence = "Run: finished\n\n## Measures\n\n- `away`\n\n## Events\n\n- `hit`\n\n## Diagnostics\n\n- energy"
    shown = critic_exhibit([first, second], evidence, (), "", FILE)
    assert shown.case == second.text, "it may be patched"
    assert shown.evidence.startswith(
        "Run: finished\n\n## Events\n\n- `hit`\n\nOnly looks and film differ from attempt 1"
    )
    assert shown.evidence.endswith("unless the film hides it: `rolls`.")
    heavier = made(2, TEXT.replace("density: 1200", "density: 1300"))
    assert critic_exhibit([first, heavier], evidence, (), "", FILE).evidence == evidence
    second.run = "runs/tin-2"
    assert critic_exhibit([first, second], evidence, (), "", FILE).evidence == evidence


def test_owners_are_told_what_holds() -> None:
    attempt = Attempt(1, TEXT, "x")
    attempt.expect = {"pushed": {"ok": True, "why": "0.3 m"}, "late": {"ok": False, "why": "never"}}
    attempt.critique = {"requirements": {"red": {"mark": 1}, "fast": {"mark": 0.5}}}
    rows = what_holds(attempt)
    assert rows[:2] == ["pushed: 0.3 m", "requirement red is met"]
    assert not any("late" in row or "fast" in row for row in rows)


def test_restatements_are_told_until_the_critic_has_nothing_against_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, told = quiet_loop(tmp_path), list[list[str]]()
    monkeypatch.setattr(made.attempts, "images", lambda attempt: ())
    judgements = [
        Critique(seen="It rolls.", verdict="repair", unfaithful=["low"]),
        Critique(seen="It rolls.", verdict="repair"),
        Critique(seen="It rolls.", verdict="repair"),
    ]

    def judged(chat: Any, request: Any, plan: Any, shown: Any, contract: Any, restated: list[str], path: Any) -> Any:
        told.append(restated)
        return judgements.pop(0)

    monkeypatch.setattr(loop, "criticise", judged)
    for rows in (["`low` was 1"], ["`low` was 1", "`high` was 2"], ["`low` was 1", "`high` was 2", "`low` was 3"]):
        made.agreement.restated = rows
        attempt = made.history.begin(TEXT, "x")
        made._judge(attempt, "the evidence", SimpleNamespace())  # type: ignore[arg-type]
    assert told == [["`low` was 1"], ["`low` was 1", "`high` was 2"], ["`low` was 3"]]


def test_a_warning_that_is_meant_is_told_once() -> None:
    rows = [Problem("/bodies/tin", "it counts twice", rule="counted-twice"), Problem("/scene", "odd", rule="rough")]
    examined = Examination(TEXT, warnings=rows, intended={("counted-twice", "/bodies/tin"): "the lid is apart"})
    assert _judged_warnings(examined, set()) == rows
    assert _judged_warnings(examined, {("counted-twice", "/bodies/tin"), ("rough", "/scene")}) == rows[1:]
