"""What the Planner may change and what it may not."""

from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import quiet
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import examine
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.decision_faults import decision_faults
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.replies import CasePlan, Decision
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

CASE = """\
text2sim: 2
name: drop
params: {height: 1.0, bound: 0.3, spare: 2}
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, "${height}"]}}
actions:
  measures: {z: {kind: position, of: ball, axis: z}}
  expect: {low: {measure: z, at: end, below: "${bound}"}}
variants: {high: {bodies: {ball: {pose: {pos: [0, 0, 2]}}}}}
"""


PLANNED = """
name: drop
event: A ball falls.
duration: 1
params: {height: 1.0, bound: 0.3, spare: 2}
bodies: {floor: {kind: static, shape: plane}, ball: {kind: rigid, shape: sphere, what: "at ${height}"}}
shared: ["It starts ${height} up."]
says: {low: It is down.}
checks:
  measures: {z: {kind: position, of: ball, axis: z}}
  expect: {low: {measure: z, at: end, below: "${bound}"}}
"""


def data(text: str) -> Any:
    return parse_document(Source(text, "answer")).data


def agreed() -> tuple[Agreement, list[tuple[str, Any]]]:
    told: list[tuple[str, Any]] = []
    agreement = Agreement(
        CasePlan.model_construct(), lambda event, /, *, live=False, **what: told.append((event, what))
    )
    plan = CasePlan.model_validate(data(PLANNED))
    agreement.adopt_plan(plan, plan.checks.expect)
    agreement.record_examined(examine(CASE, Path("case.yaml")))
    return agreement, told


def faults(answer: str, *, anew: bool = True, trials: int = 0, **report: Any) -> list[str]:
    decision = Decision.model_validate({"action": "repair", "why": "x"} | data(answer))
    offered = OfferedCards(None, quiet)
    agreement = agreed()[0]
    choices = Choices(anew, trials, {1: (CASE.replace("height: 1.0", "height: 1.5"), agreement)})
    return decision_faults(decision, agreement, CASE, AttemptReport(**report), offered, Path("case.yaml"), choices)


@pytest.mark.parametrize(
    "answer",
    [
        "params: {height: 2.0}",
        "params: {height: 2.0, bound: 0.3}",
        "params: {push: 3}",
        "patch: [{op: remove, path: /params/spare}]",
        "patch: [{op: remove, path: /variants/high}]",
        "plan: {rename: {height: start_height}}",
        "plan: {says: {moves: It gets fast.}, checks: {measures: {v: {kind: speed, of: ball}}, expect: {moves: {measure: v, during: [0, 1], stat: max, above: 1}}}}",
        "{plan: {bodies: {post: {kind: static, shape: box}}, shared: [The post stands at x = 1.]}, routes: [{section: scene, instruction: Add the post.}]}",
        "plan: {briefs: {bodies: Make it smaller.}}",
        "routes: [{section: bodies, instruction: The ball starts 2 cm above the floor. Lay floor and ball apart.}]",
        "{plan: {shared: {1: null, 2: Nothing else moves.}}, params: {height: 2.0}}",
        "plan: {keeps: [low]}",
        "plan: {assets: [{kind: mesh, body: ball, what: a walnut}]}",
        "action: plan_anew",
        "restate: {why: mm, checks: {expect: {low: {measure: z, at: end, below: 0.25}}}}",
        "{back_to: 1, params: {bound: 0.2}}",
        "{waive: {overlap: the new height causes it}, params: {height: 0.05}}",
    ],
)  # fmt: skip
def test_what_the_planner_may_do(answer: str) -> None:
    assert faults(answer) == []


@pytest.mark.parametrize(
    ("answer", "about"),
    [
        ("params: {layer: 3}", "choose another"),
        ("routes: [{section: bodies, instruction: '1. floor: a bevelled edge. 2. ball: red.'}]", "written by the `scene` Writer"),
        ("routes: [{section: scene, instruction: Larger; ball lower on the floor.}]", "written by the `bodies` Writer"),
        ("plan: {briefs: {bodies: floor gets rougher.}}", "/plan/briefs/bodies: `floor` is written by"),
        ("params: {height: 1.0}", "it is 1.0 already"),
        ('params: {height: "${hight}"}', "did you mean `height`"),
        ("patch: [{op: remove, path: /params/bound}]", "unknown name `bound`"),
        ("patch: [{op: replace, path: /bodies/ball/shape/radius, value: 1}]", "is a Writer's: route it"),
        ("patch: [{op: remove, path: /variants/low}]", "/patch"),
        ("patch: [{op: remove, path: [variants, low]}]", "is a Writer's: route it"),
        ("plan: {rename: {height: layer}}", "`layer` is taken"),
        ("plan: {rename: {hight: h}}", "there is no such parameter"),
        ("plan: {checks: {expect: {low: {measure: z, at: end, below: 0.9}}}}", "say it anew by `restate`"),
        ("plan: {checks: {expect: {new: {measure: z, at: end, below: 0.2}}}}", "/plan/says/new"),
        ("plan: {says: {new: x}, checks: {expect: {new: {measure: zz, at: end, below: 0.2}}}}", "did you mean `z`"),
        ("plan: {says: {new: x}, checks: {measures: {v: {kind: speed, of: ball}}, expect: {new: {measure: v, at: end, above: -1}}}}", "always satisfies `new`"),
        ("plan: {drop_bodies: [ball]}", "otherwise the next attempt is this one"),
        ("{plan: {drop_bodies: [ball]}, params: {height: 3}}", "there is no body or static `ball`"),
        ("plan: {shared: [nothing new]}", "otherwise the next attempt is this one"),
        ("restate: {why: mm, checks: {expect: {low: {measure: z, at: end, below: '${bound}'}}}}", "what stands there already"),
        ("restate: {why: mm, checks: {expect: {low: {measure: z, at: end, above: 0.1}}}}", "keeps its below"),
        ("waive: {unknown-body: it is meant so}", "the lint did not find this here"),
        ("waive: {overlap: it is meant so}", "the lint did not find this here"),
        ("{waive: {overlab: it is meant so}, params: {height: 2}}", "no rule `overlab`"),
        ("{action: plan_anew, take: [1]}", "/take: with `plan_anew` nothing else is done"),
        ("{}", "otherwise the next attempt is this one"),
        ("{back_to: 2, params: {height: 2.0}}", "/back_to: it can be 1"),
        ("{back_to: 1}", "otherwise the next attempt is this one"),
        ("{trials: [{height: 2}], params: {height: 2}}", "they need `action: try`"),
        ("{action: try, trials: [{height: 2}]}", "no trials now"),
    ],
)  # fmt: skip
def test_what_it_may_not_and_why(answer: str, about: str) -> None:
    assert about in "\n".join(faults(answer))


@pytest.mark.parametrize(
    ("answer", "about"),
    [
        ("trials: [{height: 2}, {height: 3, bound: 0.2}]", ""),
        ("trials: [{height: 2}], back_to: 1", ""),
        ("trials: [{hight: 2}]", "/trials/0/hight: there is no such parameter"),
        ("trials: [{height: 2}, {}]", "/trials/1: give the parameters that differ"),
        ("trials: [{height: tall}]", "/trials/0: /bodies/ball/pose/pos/2"),
        ("trials: []", "give 1 to 3 of them (got 0)"),
        ("trials: [{height: 2}], params: {height: 2}", "/params: leave it out"),
        ("trials: [{height: 2}], take: [1]", "there is no patch 1"),
    ],
)
def test_trials_are_checked_before_they_are_run(answer: str, about: str) -> None:
    found = "\n".join(faults(f"{{action: try, {answer}}}", trials=3))
    assert about in found if about else not found


def test_a_fact_about_a_part_that_cannot_be_measured_goes_back() -> None:
    decision = Decision.model_validate(
        {"action": "repair", "why": "x"} | data("plan: {facts: {wish: [{moved: ball.seam, by: floor}]}}")
    )
    offered, agreement = OfferedCards(None, quiet), agreed()[0]
    (wrong,) = decision_faults(
        decision, agreement, CASE, AttemptReport(), offered, Path("case.yaml"), Choices(), ["wish"]
    )
    assert wrong.startswith("/facts/wish: `ball` is one body without links") and "did you mean `ball`?" in wrong


def test_a_waiver_of_what_is_no_rule_of_the_lint_is_refused() -> None:
    assert "no rule `unknown-body`" in "\n".join(
        faults("waive: {unknown-body: it is meant so}", rules=frozenset({"unknown-body"}))
    )


def test_it_plans_anew_only_once() -> None:
    assert "planned anew already" in faults("action: plan_anew", anew=False)[0]


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        ("", True),
        ("take: [1]", False),
        ("routes: [{section: scene, instruction: longer}]", True),
        ("plan: {duration: 3, SAYS}", False),
    ],
)
def test_a_new_expectation_may_come_at_a_time_that_the_same_decision_makes_room_for(answer: str, wrong: bool) -> None:
    says = "says: {late: It lies.}, checks: {expect: {late: {measure: z, at: 2.5, below: 0.2}}}"
    whole = answer.replace("SAYS", says) if "plan" in answer else f"{answer}\nplan: {{{says}}}"
    longer = {"section": "scene", "operations": [{"op": "replace", "path": "/scene/duration", "value": 3}]}
    found = faults(whole, critique={"patches": [longer]})
    assert any("is after the end of the run (1 s)" in row for row in found) is wrong, found


def test_a_cause_whose_effect_is_its_own_goes_back() -> None:
    for plan, about in (
        ("{meets: {falls: [low]}, causes: {falls: [ball]}}", "/plan/causes/falls: a run without `ball` shows nothing"),
        ("{meets: {falls: [low]}, causes: {falls: [floor]}}", ""),
    ):
        decision = Decision.model_validate({"action": "repair", "why": "x", "plan": data(plan)})
        cards, path, choices = OfferedCards(None, quiet), Path("case.yaml"), Choices(True, 0, {})
        rows = decision_faults(decision, agreed()[0], CASE, AttemptReport(), cards, path, choices, ["falls"])
        assert len(rows) == bool(about)
        assert about in "".join(rows)


def test_what_a_requirement_is_bound_to_can_be_corrected_and_is_told() -> None:
    """A cause that does not concern every expectation of its requirement made its fact false for good."""
    assert any("no requirement `flies`" in row for row in faults("plan: {causes: {flies: [ball]}}"))
    assert any("no expectation `high`" in row for row in faults("plan: {meets: {falls: [high]}}"))
    agreement, told = agreed()
    agreement.plan.causes = {"falls": ["push"]}
    decision = Decision.model_validate(
        {"action": "repair", "why": "x"} | data("plan: {meets: {falls: [low]}, causes: {falls: []}}")
    )
    agreement.apply(CASE, decision)
    assert agreement.plan.meets == {"falls": ["low"]}
    assert agreement.plan.causes == {}
    assert "causes of `falls` was ['push'], is []" in [what["what"] for event, what in told if event == "restated"]


def test_single_lines_of_the_plan_change_by_number() -> None:
    agreement, _ = agreed()
    for lines, left in (
        ({2: "Nothing else moves.", 9: "It is red."}, ["It starts ${height} up.", "Nothing else moves.", "It is red."]),
        ({1: None, 3: "It is blue."}, ["Nothing else moves.", "It is blue."]),
        (["It is one line."], ["It is one line."]),
    ):
        answer = {"action": "repair", "why": "x", "plan": {"shared": lines}}
        agreement.apply(CASE, Decision.model_validate(answer))
        assert agreement.plan.shared == left
