"""A request of which a part is impossible: the rest is built, accepted, and said to be a part."""

import json
from pathlib import Path
from typing import Any

import pytest
import typer

from tests.agents.scripted import Scripted, chat, fenced
from tests.agents.test_decision_faults import data
from tests.agents.test_loop import HIGH, PLAN, REPLIES, begin, scripted
from text2sim.agents.contract import Contract
from text2sim.agents.criticism import Exhibit, criticise
from text2sim.agents.loop_result import impossible_parts
from text2sim.agents.planning import Request, limit_faults
from text2sim.agents.replies import CasePlan
from text2sim.agents.requirements import Requirement
from text2sim.cli.generate import _run_session

REQUIRED = {"lands": Requirement(what="it lands"), "burns": Requirement(what="it burns", importance=1)}
PARTLY = "possible: partly\ncannot: {burns: there is no fire}\n"


def plan(text: str) -> CasePlan:
    return CasePlan.model_validate({"name": "p", "event": "It lands.", **data(text)})


@pytest.mark.parametrize(
    ("text", "known", "about"),
    [
        (PARTLY, REQUIRED, ""),
        ("possible: partly\nwhy: there is no fire\n", REQUIRED, "name the requirements"),
        ("possible: partly\nwhy: there is no fire\n", {}, ""),
        ("possible: partly\n", {}, "/why"),
        (PARTLY.replace("burns", "burn"), REQUIRED, "there is no requirement `burn`"),
        (PARTLY.replace("partly", "yes"), REQUIRED, "it goes with `possible: partly`"),
    ],
)
def test_what_is_impossible_is_named(text: str, known: dict[str, Requirement], about: str) -> None:
    wrong = limit_faults(plan(text), known)
    assert about in "".join(wrong)
    assert bool(wrong) is bool(about)


def test_what_is_missing_is_said() -> None:
    assert impossible_parts(plan(PARTLY), REQUIRED) == ["not possible: it burns (there is no fire)"]
    assert impossible_parts(plan("possible: partly\nwhy: there is no fire"), {}) == ["not possible: there is no fire"]
    assert impossible_parts(plan("possible: yes"), REQUIRED) == []


@pytest.mark.parametrize(("marks", "score"), [("lands: 1", 75.0), ("lands: 1, burns: 1/2", 87.5)])
def test_what_is_impossible_is_not_needed_but_counts_in_the_score(tmp_path: Path, marks: str, score: float) -> None:
    model = Scripted({"critic": [fenced(f"seen: It lands.\nverdict: pass\nrequirements: {{{marks}}}")]})
    exhibit, contract = Exhibit(1, "", "-", frozenset({"run"}), (), ()), Contract((), {}, frozenset())
    request = Request("It lands and burns.", requirements=REQUIRED)
    found = criticise(chat(tmp_path, model), request, plan(PARTLY), exhibit, contract, [], Path("case.yaml"))
    assert (found.verdict, found.score, found.failures) == ("pass", score, [])
    assert "cannot be built: there is no fire" in model.questions("critic")[0]
    assert len(model.asked) == 1, "nobody is asked for a mark"


@pytest.mark.usefixtures("engine", "tracer")
def test_a_case_with_all_that_is_possible_ends_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    partly = PLAN + "possible: partly\ncannot: {one: two balls are needed}\n"
    passed = "seen: It falls.\nrequirements: {falls: [1, 'frame:1'], one: [0, run]}\nverdict: pass\n"
    low: dict[str, Any] = {"bodies": [HIGH.replace("1.7", "0.1")], "planner": [partly], "critic": [passed]}
    session = begin(tmp_path / "part", monkeypatch, scripted(REPLIES | low))
    with pytest.raises(typer.Exit) as ended:
        _run_session(session, True, "none", None)
    told = json.loads(capsys.readouterr().out)
    assert (ended.value.exit_code, told["ok"], told["state"]) == (0, True, "accepted_in_part")
    assert told["unresolved"] == ["not possible: there is one ball (two balls are needed)"]
    assert told["attempt"] == 1
