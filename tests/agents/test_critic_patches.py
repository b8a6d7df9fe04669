"""Patches of the Critic: on one section or on parameters, and never at the cost of the judgement."""

from pathlib import Path

import pytest

from tests.agents.scripted import Scripted, chat, fenced, quiet_loop
from tests.agents.test_decision_faults import CASE, agreed
from text2sim.agents import revising
from text2sim.agents.attempt import Attempt
from text2sim.agents.criticism import Exhibit, criticise
from text2sim.agents.judgement import Critique
from text2sim.agents.planning import Request
from text2sim.agents.replies import Decision

PATH = Path("case.yaml")
SEEN = (
    "seen: It falls.\nverdict: repair\nscore: 50\nfailures: [{what: too high, cites: [run], section: plan}]\npatches:\n"
)
HIGHER = "- {section: plan, why: higher, operations: [{op: replace, path: /params/height, value: 0.5}]}\n"
FILM = "- {section: render, why: film, operations: [{op: add, path: /render, value: {fps: 12}}]}\n"


def judged(folder: Path, *replies: str) -> tuple[Critique, Scripted]:
    agreement, model = agreed()[0], Scripted({"critic": [fenced(row) for row in replies]})
    exhibit = Exhibit(1, CASE, "the evidence", frozenset({"run"}), (), ())
    assert agreement.contract is not None
    found = criticise(
        chat(folder, model), Request("A ball falls."), agreement.plan, exhibit, agreement.contract, [], PATH
    )
    return found, model


def test_a_parameter_gets_another_value_in_the_same_round(tmp_path: Path) -> None:
    found, model = judged(tmp_path, SEEN + HIGHER)
    assert [patch.section for patch in found.patches] == ["plan"]
    assert len(model.asked) == 1
    made = quiet_loop(tmp_path)
    made.workshop.agreement = agreed()[0]
    attempt = Attempt(1, CASE, "x", critique=found.model_dump(mode="json"))
    text, reasons = made.deciding.carry_out(attempt, Decision(action="repair", why="x", take=[1]))
    assert (revising.data_of(text)["params"]["height"], reasons, attempt.fates) == (0.5, [], ["taken"])
    both = Decision(action="repair", why="x", take=[1], params={"height": 0.7})
    assert revising.data_of(made.deciding.carry_out(attempt, both)[0])["params"]["height"] == 0.7, (
        "the Planner's counts"
    )


@pytest.mark.parametrize(
    ("operation", "reason"),
    [
        ("{op: replace, path: /params/hight, value: 1}", "there is no parameter `hight`"),
        ("{op: remove, path: /params/spare}", "sets /params/NAME"),
        ("{op: replace, path: /params, value: {}}", "sets /params/NAME"),
        ("{op: replace, path: params/height, value: 1}", "a path starts with `/`"),
        ("{op: replace, value: 1}", "a path is a text"),
        ("{op: replace, path: /bodies/ball/shape/radius, value: 1}", "sets /params/NAME"),
        ("{op: replace, path: /params/height, value: high}", "/bodies/ball/pose/pos/2"),
        ("{op: replace, path: /params/bound, value: 3}", "comes from the request and must stay"),
    ],
)
def test_what_it_may_not_change_there_goes_back_without_the_evidence(
    operation: str, reason: str, tmp_path: Path
) -> None:
    bad = f"- {{section: plan, why: x, operations: [{operation}]}}\n"
    found, model = judged(tmp_path, SEEN + bad + FILM, "patches:\n" + bad + FILM)
    assert reason in model.questions("critic")[1]
    assert "the evidence" not in model.questions("critic")[1]
    assert [patch.section for patch in found.patches] == ["render"], "the other one stays"
    assert len(found.refused) == 1


def test_it_is_told_which_parameters_expectations_fix_and_what_to_patch_instead(tmp_path: Path) -> None:
    bad = "- {section: plan, why: x, operations: [{op: replace, path: /params/bound, value: 3}]}\n"
    _, model = judged(tmp_path, SEEN + bad, "patches: []")
    assert "Fixed by the request's expectations: bound. Patch what else uses these" in model.questions("critic")[0]
    assert "patch the fields that use it, in their own sections, with numbers" in model.questions("critic")[1]


def test_parameters_are_fixed_through_others_and_by_copies_of_an_expectation() -> None:
    text = """
text2sim: 2
name: a
params: {push: 0.2, way: "${0.9 * push}", free: 1}
actions:
  controls: {push: {kind: drive, joint: ring, position: "${free}"}}
  expect:
    up: {measure: high, repeat: 2, at: end, above: "${way + k}"}
"""
    assert revising.params_used(text, ["/actions/expect/up_0", "/actions/expect/up_1"]) == ["push", "way"]
    assert revising.params_used(text, ["/actions/events/none"]) == []


@pytest.mark.parametrize(
    "bad", ["- {section: film, why: x, operations: [{op: test}]}\n", "- {section: scene, why: x}\n"]
)
def test_a_patch_without_form_costs_neither_the_judgement_nor_the_other_patches(bad: str, tmp_path: Path) -> None:
    found, model = judged(tmp_path / "twice", SEEN + bad + FILM, "patches:\n" + bad + FILM)
    assert [patch.section for patch in found.patches] == ["render"]
    assert len(model.asked) == 2
    assert "the evidence" not in model.questions("critic")[1]
    assert found.refused
    found, model = judged(tmp_path / "right", SEEN + bad + FILM, "patches:\n" + HIGHER + FILM)
    assert [patch.section for patch in found.patches] == ["plan", "render"]
    assert not found.refused
