"""When a loop goes on: roles that give no usable answer, attempts that bring nothing."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from text2sim.agents.attempt import Attempt, unbettered
from text2sim.agents.attempts import Attempts
from text2sim.agents.conversation import RoleFailed
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopLimits, LoopOutcome
from text2sim.agents.replies import Decision

SECTIONS = {"scene": {"duration": 1.0}, "bodies": {"ball": {"kind": "rigid"}}}


def stub(drafts: list[Any], plans: list[Any], **more: Any) -> Any:
    """A loop of which only what is asked for is there; lists say what comes of drafts and of planning anew."""

    def taken(rows: list[Any]) -> Any:
        row = rows.pop(0)
        if isinstance(row, Exception):
            raise row
        return row

    def planned(why: str) -> Any:
        asked.append(why)
        found = taken(plans)
        loop.agreement.planned_anew = True
        return found

    asked: list[str] = []
    plan = SimpleNamespace(
        name="x", params={}, possible="yes", checks=SimpleNamespace(measures={}, events={}, expect={})
    )
    loop = SimpleNamespace(
        agreement=SimpleNamespace(planned_anew=False, plan=plan, names=()),
        workshop=SimpleNamespace(draft_sections=lambda: taken(drafts), referred=[]),
        request=SimpleNamespace(text="a ball"), _planned_anew=planned, asked=asked, plan=plan, **more,
    )  # fmt: skip
    return loop


def test_what_cannot_be_written_is_planned_in_a_simpler_way() -> None:
    loop = stub([RoleFailed("bodies", ["/bodies/ball: no shape"]), SECTIONS], [SimpleNamespace(possible="yes")])
    assert "ball" in AgentLoop._draft_sections(loop)
    assert "the bodies gave no usable answer" in loop.asked[0]
    assert "simpler" in loop.asked[0]


def test_the_end_of_two_plans_says_all_reasons() -> None:
    failed = [RoleFailed("bodies", ["/bodies/ball: no shape"]), RoleFailed("planner", ["/event: missing"])]
    with pytest.raises(RoleFailed) as raised:
        AgentLoop._draft_sections(stub(failed[:1], failed[1:]))
    assert "no shape" in raised.value.reasons[0]
    assert "/event: missing" in raised.value.reasons[1]
    with pytest.raises(RoleFailed):
        AgentLoop._draft_sections(stub([failed[0], failed[0]], [SimpleNamespace(possible="yes")]))


def test_a_loop_that_fails_says_why_under_what_is_unresolved() -> None:
    closed: list[bool] = []
    attempts = SimpleNamespace(close=lambda: closed.append(True))
    loop = SimpleNamespace(outcome=lambda state, why: LoopOutcome(state, why), attempts=attempts)

    def way() -> LoopOutcome:
        raise RoleFailed("planner", ["a", "b"])

    ended = AgentLoop.ending(loop, way)  # type: ignore[arg-type]
    assert (ended.state, ended.unresolved) == ("failed", ["a", "b"])
    assert closed, "its engine is ended"


def test_a_second_plan_that_fails_leaves_the_first_to_be_mended() -> None:
    decisions = [
        Decision(action="plan_anew", why="a hinge is wrong"),
        Decision(action="repair", why="a slider"),
        Decision(action="give_up", why="enough"),
    ]
    texts: list[str] = []
    loop = stub(
        [], [RoleFailed("planner", ["/event: missing"])], made=[], chat=SimpleNamespace(attempt=0),
        _try_attempt=lambda attempt: texts.append(attempt.text), limits=LoopLimits(),
        _decide=lambda attempt, report: decisions.pop(0), _revised=lambda attempt, decision: ("name: b\n", []),
        outcome=lambda state, why: LoopOutcome(state, why), attempts=Attempts(Path("none")),
    )  # fmt: skip
    ended = AgentLoop.work(loop, "name: a\n", "first version")
    assert (ended.state, ended.why) == ("gave_up", "enough")
    assert texts == ["name: a\n", "name: b\n"]
    assert "Planning anew came to nothing" in loop.workshop.referred[0]


def test_the_best_version_is_filmed_well_although_it_was_not_accepted(monkeypatch: pytest.MonkeyPatch) -> None:
    styled: list[int] = []
    monkeypatch.setattr("text2sim.agents.loop.unbettered", lambda made, names: made[0])
    loop: Any = SimpleNamespace(
        made=[], chat=SimpleNamespace(attempt=0), limits=LoopLimits(), only_if_accepted=False,
        _try_attempt=lambda attempt: None, _styled=lambda attempt: styled.append(attempt.number),
        agreement=SimpleNamespace(names=()),
        outcome=lambda state, why: LoopOutcome(state, why),
    )  # fmt: skip
    assert AgentLoop.work(loop, "name: a\n", "first version").state == "gave_up"
    loop.only_if_accepted, loop.made = True, []
    AgentLoop.work(loop, "name: a\n", "an edit of somebody's case")
    assert styled == [1]


@pytest.mark.parametrize(("state", "filmed"), [("finished", [1]), ("diverged", [])])
def test_the_best_version_is_filmed_well_when_attempts_run_out(state: str, filmed: list[int], tmp_path: Path) -> None:
    styled: list[int] = []

    def try_attempt(attempt: Attempt) -> None:
        attempt.state = state

    loop: Any = SimpleNamespace(
        made=[], chat=SimpleNamespace(attempt=0), limits=LoopLimits(attempts=1), only_if_accepted=False, style=True,
        _try_attempt=try_attempt, _styled=lambda attempt: styled.append(attempt.number),
        agreement=SimpleNamespace(names=()), attempts=Attempts(tmp_path),
        outcome=lambda state, why: LoopOutcome(state, why),
    )  # fmt: skip
    ended = AgentLoop.work(loop, "name: a\n", "first version")
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
    best = unbettered(made, ())
    assert (best and best.number) == ended
