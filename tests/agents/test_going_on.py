"""When a loop goes on: roles that give no usable answer, attempts that bring nothing."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.agents.scripted import quiet_loop
from text2sim.agents.attempt import Attempt, best_of, stalled_best
from text2sim.agents.conversation import RoleFailed
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopOutcome
from text2sim.agents.replies import Decision
from text2sim.agents.session import Session, SessionWish
from text2sim.spec_schema.errors import RunError

SECTIONS = {"scene": {"duration": 1.0}, "bodies": {"ball": {"kind": "rigid"}}}


def stub(folder: Path, drafts: list[Any], plans: list[Any]) -> tuple[AgentLoop, list[str]]:
    """A loop whose Writers and Planner answer with what is in the lists, and why it was planned anew."""

    def taken(rows: list[Any]) -> Any:
        row = rows.pop(0)
        if isinstance(row, Exception):
            raise row
        return row

    def planned(why: str) -> Any:
        asked.append(why)
        found = taken(plans)
        loop.agreement.replanned = True
        return found

    asked: list[str] = []
    loop: Any = quiet_loop(folder)
    loop.workshop.draft_sections, loop._planned_anew = lambda: taken(drafts), planned
    return loop, asked


def test_what_cannot_be_written_is_planned_in_a_simpler_way(tmp_path: Path) -> None:
    failed = RoleFailed("bodies", ["/bodies/ball: no shape"])
    loop, asked = stub(tmp_path, [failed, SECTIONS], [SimpleNamespace(possible="yes")])
    assert "ball" in loop._draft_sections()
    assert "the bodies gave no usable answer" in asked[0]
    assert "simpler" in asked[0]


def test_the_end_of_two_plans_says_all_reasons(tmp_path: Path) -> None:
    failed = [RoleFailed("bodies", ["/bodies/ball: no shape"]), RoleFailed("planner", ["/event: missing"])]
    with pytest.raises(RoleFailed) as raised:
        stub(tmp_path, failed[:1], failed[1:])[0]._draft_sections()
    assert "no shape" in raised.value.reasons[0]
    assert "/event: missing" in raised.value.reasons[1]
    with pytest.raises(RoleFailed):
        stub(tmp_path, [failed[0], failed[0]], [SimpleNamespace(possible="yes")])[0]._draft_sections()


def test_a_loop_that_fails_says_why_under_what_is_unresolved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []
    loop = quiet_loop(tmp_path)
    monkeypatch.setattr(loop.attempts, "close", lambda: closed.append(True))

    def way() -> LoopOutcome:
        raise RoleFailed("planner", ["a", "b"])

    ended = loop.ending(way)
    assert (ended.state, ended.unresolved) == ("failed", ["a", "b"])
    assert closed, "its engine is ended"


def test_a_second_plan_that_fails_leaves_the_first_to_be_mended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    decisions = [
        Decision(action="plan_anew", why="a hinge is wrong"),
        Decision(action="repair", why="a slider"),
        Decision(action="give_up", why="enough"),
    ]
    texts: list[str] = []
    loop, _ = stub(tmp_path, [], [RoleFailed("planner", ["/event: missing"])])
    monkeypatch.setattr(loop, "_try_attempt", lambda attempt: texts.append(attempt.text))
    monkeypatch.setattr(loop.deciding, "decide", lambda attempt, report: decisions.pop(0))
    monkeypatch.setattr(loop.deciding, "carry_out", lambda attempt, decision: ("name: b\n", []))
    ended = loop.work("name: a\n", "first version")
    assert (ended.state, ended.why) == ("gave_up", "enough")
    assert texts == ["name: a\n", "name: b\n"]
    assert "Planning anew came to nothing" in loop.workshop.referred[0]


@pytest.mark.parametrize(("base", "filmed"), [("", [1]), ("name: somebody's\n", [])])
def test_the_best_version_is_filmed_well_although_it_was_not_accepted(
    base: str, filmed: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    styled: list[int] = []
    monkeypatch.setattr("text2sim.agents.loop.stalled_best", lambda made, names: (made[0], "why"))
    loop = quiet_loop(tmp_path)
    loop.history.base = base
    monkeypatch.setattr(loop, "_try_attempt", lambda attempt: None)
    monkeypatch.setattr(loop, "_choose_film", lambda attempt: styled.append(attempt.number))
    assert loop.work("name: a\n", "first version").state == "gave_up"
    assert styled == filmed


@pytest.mark.parametrize(("state", "filmed"), [("finished", [1]), ("diverged", [])])
def test_the_best_version_is_filmed_well_when_attempts_run_out(
    state: str, filmed: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    styled: list[int] = []
    loop = quiet_loop(tmp_path, attempts=1)
    loop.style = True
    monkeypatch.setattr(loop, "_try_attempt", lambda attempt: setattr(attempt, "state", state))
    monkeypatch.setattr(loop, "_choose_film", lambda attempt: styled.append(attempt.number))
    ended = loop.work("name: a\n", "first version")
    assert (ended.state, ended.why) == ("spent", "1 attempts were made")
    assert styled == filmed


@pytest.mark.parametrize(
    ("runs", "ended"),
    [
        (["b", "c"], 1),
        (["a", "a"], None),
        (["a", "b", "b"], None),
        (["a", "b", "c"], 1),
        (["", ""], 1),
        (["a"] * 5, 1),
        (["a"] * 4, None),
    ],
)
def test_attempts_that_only_film_again_are_cheap(runs: list[str], ended: int | None) -> None:
    made = [Attempt(k, "", "", state="finished", run=run) for k, run in enumerate(["a", *runs], 1)]
    made[0].critique = {"verdict": "repair", "score": 90}
    stalled = stalled_best(made, ())
    assert (stalled and stalled[0].number) == ended


@pytest.mark.parametrize(
    ("states", "why"),
    [
        (["diverged", "diverged"], ""),
        (["finished", "unsound", "diverged"], ""),
        (
            ["diverged", "finished", "finished"],
            "attempts 2 (diverged), 3 (finished), 4 (finished) brought nothing better than attempt 1",
        ),
        (
            ["diverged", "timeout", "unsound"],
            "attempts 2 (diverged), 3 (timeout), 4 (unsound), one after the other, did not finish; "
            "attempt 1 is the best",
        ),
    ],
)
def test_attempts_that_did_not_finish_do_not_show_that_nothing_is_better(states: list[str], why: str) -> None:
    made = [Attempt(k, "", "", state=state, run=f"{k}") for k, state in enumerate(["finished", *states], 1)]
    made[0].critique = {"verdict": "pass", "score": 90}
    stalled = stalled_best(made, ())
    assert (stalled[1] if stalled else "") == why


def test_a_first_run_gets_a_part_of_the_time_left(tmp_path: Path) -> None:
    loop, given = quiet_loop(tmp_path, minutes_left=lambda: 20.0), list[Any]()

    def run(attempt: Any, *more: Any) -> None:
        given.append(more)
        attempt.state, attempt.problems = "failed", ["not run"]

    loop.attempts.run = run  # type: ignore[method-assign]
    case = "text2sim: 2\nname: a\nscene: {duration: 1}\nbodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}}\n"
    loop._try_attempt(loop.history.begin(case, "first version"))
    ((*_, timeout, _, patience, finer_within),) = given
    assert (timeout, patience, finer_within) == (1200, pytest.approx(0.45 * 1200), pytest.approx(0.1 * 1200))


def test_between_equals_the_one_with_fewer_false_facts_is_better() -> None:
    false = {"requirement": "waves", "ok": False, "told": "it waves without wind, too"}
    one, other = Attempt(1, "a", "first", facts=[false], state="finished"), Attempt(2, "b", "second", state="finished")
    assert best_of([one, other], []) is other
    other.facts = [false | {"requirement": "lifts"}]
    assert best_of([one, other], []) is one, "the earlier of two that are alike"


def test_a_loop_that_nobody_answers_ends_with_its_time_and_says_so_in_the_mailbox(tmp_path: Path) -> None:
    wish = SessionWish("generate", "A ball falls.", {"": "mailbox:{case}/mail"}, minutes=0.01, cards=False)
    outcome = Session.begin(tmp_path / "case", wish, [], []).run(lambda event, what: None)
    assert outcome.state == "spent"
    why = r"0\.01 minutes are over, and no reply to reader-01 came within [01](\.\d)? s"
    assert re.fullmatch(why, outcome.why)
    assert {path.name for path in (tmp_path / "case" / "mail").iterdir()} == {"reader-01.request.md", "finished.md"}
    told = (tmp_path / "case" / "mail" / "finished.md").read_text().splitlines()
    assert re.fullmatch(f"Not accepted: {why}; no version was made.", told[0])


def test_the_last_line_of_a_loop_tells_success_from_what_only_ended() -> None:
    best = Attempt(3, "", "")
    kept = LoopOutcome("spent", "20 minutes are over", best, ["falls: the ball hits the floor"]).sentence()
    assert kept == (
        "Not accepted: 20 minutes are over; version 3 is kept as the best; unresolved: falls: the ball hits the floor."
    )
    assert LoopOutcome("accepted", "all came true", best).sentence().startswith("Accepted: all came true; version 3")
    assert LoopOutcome("failed", "no answer").sentence() == "Ended by an error: no answer; no version was made."
    assert LoopOutcome("impossible", "no gravity").sentence() == "Not possible: no gravity."


def test_a_loop_that_breaks_down_says_so_in_the_mailbox(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(loop: AgentLoop) -> LoopOutcome:
        raise RunError("the disk is full")

    monkeypatch.setattr(AgentLoop, "generate", broken)
    wish = SessionWish("generate", "A ball falls.", {"": "mailbox:{case}/mail"}, cards=False)
    with pytest.raises(RunError):
        Session.begin(tmp_path / "case", wish, [], []).run(lambda event, what: None)
    assert (tmp_path / "case" / "mail" / "finished.md").read_text().startswith("Ended by an error: the disk is full\n")
