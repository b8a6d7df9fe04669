"""Trials: runs with other parameters before a decision; and attempts that are gone back to."""

import json
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.agents.test_decision_faults import CASE, agreed
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.attempts import Attempts
from text2sim.agents.deciding import Deciding, _sound_part
from text2sim.agents.history import History
from text2sim.agents.loop_result import LoopLimits
from text2sim.agents.replies import Decision
from text2sim.agents.trials import MAX_TRIALS, Outcome, affordable, trials_text
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.loaded import LoadedCase


def simulate(loaded: LoadedCase, seconds: float) -> Outcome:
    """A run of a ball, whose case says how high it starts."""
    height = loaded.case.bodies["ball"].pose.pos[2]  # type: ignore[union-attr]
    if height > 9:
        raise RunError("no memory")
    row = {"problem": None, "min": 0.1, "max": height, "last": 0.1 * height, "unit": "m"}
    expect = {"low": {"ok": height < 2, "why": f"{0.1 * height:g} m at 1 s"}}
    events = {"lands": {"first": 0.45}, "bounces": {"first": None}}
    evidence = {"expect": expect, "measures": {"z": row}, "events": events, "suspicions": []}
    return Outcome("finished", evidence, [f"`ball`: start (0, 0, {height:g}); end (0, 0, 0.1)"])


def test_a_trial_tells_what_was_missed_and_measured_and_is_not_run_twice(tmp_path: Path) -> None:
    store, ran = tmp_path / "01" / "trials.json", []

    def counted(loaded: LoadedCase, seconds: float) -> Outcome:
        ran.append(loaded)
        return simulate(loaded, seconds)

    settings = [{"height": 1.5}, {"height": 3}, {"height": 10}]
    told = trials_text(CASE, settings, tmp_path / "case.yaml", store, 60.0, counted)
    assert told.splitlines() == [
        "- {height: 1.5}: finished; all expectations true; `z` 0.1 to 1.5, at the end 0.15 m; `lands` at 0.45 s; "
        "`ball`: start (0, 0, 1.5); end (0, 0, 0.1)",
        "- {height: 3}: finished; MISSED `low` (0.3 m at 1 s); `z` 0.1 to 3, at the end 0.3 m; `lands` at 0.45 s; "
        "`ball`: start (0, 0, 3); end (0, 0, 0.1)",
        "- {height: 10}: failed: no memory",
    ]
    assert trials_text(CASE, settings, tmp_path / "case.yaml", store, 60.0, counted) == told
    assert len(ran) == 3
    late = trials_text(CASE, [{"height": 4}], tmp_path / "case.yaml", store, 0.0, counted)
    assert late == "- {height: 4}: not run: no time was left"
    store.write_text(json.dumps(["not", "a", "mapping"]))
    assert trials_text(CASE, settings[:1], tmp_path / "case.yaml", store, 60.0, counted) == told.splitlines()[0]


@pytest.mark.parametrize(
    ("wall", "minutes", "count"),
    [(60, None, MAX_TRIALS), (60, 20, 6), (60, 10, 3), (600, 20, 0), (0, 1, 0), (0, None, 0)],
)
def test_trials_take_a_share_of_the_time_left(wall: float, minutes: float | None, count: int) -> None:
    assert affordable(wall, minutes) == count


def test_after_two_rounds_of_trials_the_planner_has_to_decide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = [
        Decision(action="try", why="how high", trials=[{"height": 2}]),
        Decision(action="try", why="closer", trials=[{"height": 1.8}]),
        Decision(action="repair", why="2 m", params={"height": 2}),
    ]
    asked: list[tuple[str, int]] = []

    def ask(attempt: Attempt, report: AttemptReport, offer: str, choices: Choices) -> Decision:
        asked.append((report.trials, choices.trials))
        return answers.pop(0)

    attempt = Attempt(1, CASE, "first version", state="finished", wall=10.0)
    workshop: Any = SimpleNamespace(
        agreement=agreed()[0], referred=[], offered=SimpleNamespace(offer=lambda *given: ""), path=Path("case.yaml"),
        emit=lambda *given, **what: None,
    )  # fmt: skip
    attempts, limits = Attempts(tmp_path), LoopLimits(minutes_left=lambda: 1.0)
    monkeypatch.setattr(attempts, "trials", lambda attempt, text, trials, *more: f"- {trials[0]}: finished")
    history = History(attempts, limits)
    history.made.append(attempt)
    deciding = Deciding(workshop, history, attempts, limits, lambda now: None)
    monkeypatch.setattr(deciding, "_ask_planner", ask)
    decision = deciding.decide(attempt, AttemptReport())
    assert decision.params == {"height": 2}
    first, second = "- {'height': 2}: finished", "- {'height': 1.8}: finished"
    assert asked == [("", 1), (first, 1), (f"{first}\n{second}", 0)]


def test_an_earlier_attempt_is_changed_with_its_own_parameters() -> None:
    agreement, _ = agreed()
    earlier, _ = agreed()
    agreement.plan = agreement.plan.model_copy(update={"params": {"height": 5.0}, "keeps": ["low"]})
    agreement.restated = ["a bound"]
    assert agreement.same_checks(earlier)
    agreement.go_back_to(earlier)
    assert agreement.plan.params == earlier.plan.params
    assert agreement.plan.keeps == ["low"]
    assert agreement.restated == ["a bound"]


def test_only_attempts_with_the_same_checks_can_be_gone_back_to() -> None:
    history = History(Attempts(Path("none")), LoopLimits())
    made = [history.begin(f"name: {number}\n", "") for number in (1, 2, 3)]
    same, other = agreed()[0], agreed()[0]
    other.names = ("low", "further")
    for attempt, agreement in zip(made, (agreed()[0], other, same), strict=True):
        history.record_agreement(attempt, agreement)
    assert list(history.earlier(made[2], same)) == [1]
    assert Choices().earlier == {}


def test_the_planner_is_told_which_attempts_it_can_go_back_to() -> None:
    earlier, now = agreed()[0], {"height": 2.0, "bound": 0.3, "spare": 2}
    assert Choices(trials=2).text(now) == "At most 2 trials can be run."
    assert Choices(earlier={1: (CASE, earlier)}).text(now).endswith("`back_to` can be 1 {height: 1.0}.")


def test_trials_that_can_be_run_are_run_although_others_cannot() -> None:
    wanted = Decision(action="try", why="how high", trials=[{"height": 2}, {"hight": 3}])

    def faults(decision: Decision) -> list[str]:
        return ["/trials: no such parameter"] if any("hight" in one for one in decision.trials) else []

    sound = _sound_part(wanted, faults)
    assert sound is not None
    assert (sound.action, sound.trials) == ("try", [{"height": 2}])


def test_a_first_run_is_not_to_take_nearly_all_the_time_left() -> None:
    history = History(Attempts(Path("none")), LoopLimits(minutes_left=lambda: 20.0))
    assert history.patience() == pytest.approx(0.45 * 1200)
    history.begin("name: a\n", "").state = "timeout"
    assert history.patience() == pytest.approx(0.6 * 1200), "the same case in fewer cells may take a little longer"
    history.begin("name: b\n", "").state = "timeout"
    assert history.patience() == pytest.approx(4 / 3 * 1200), "rather one run than none, if it may end in time"
    finished = History(Attempts(Path("none")), LoopLimits(minutes_left=lambda: 20.0))
    finished.begin("name: a\n", "").state = "finished"
    assert finished.patience() == pytest.approx(4 / 3 * 1200)
    assert History(Attempts(Path("none")), LoopLimits()).patience() == inf
