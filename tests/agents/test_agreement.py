"""The plan and its expectations through the changes of a decision."""

from pathlib import Path

from tests.agents.test_decision_faults import CASE, agreed, data, faults
from text2sim.agents import revising
from text2sim.agents.assembly import examine
from text2sim.agents.replies import Decision


def test_a_parameter_is_renamed_everywhere() -> None:
    agreement, told = agreed()
    text = agreement.apply(
        CASE, Decision.model_validate(data("{action: repair, why: x, plan: {rename: {height: start, bound: most}}}"))
    )
    case = revising.data_of(text)
    assert case["params"] == {"start": 1.0, "most": 0.3, "spare": 2}
    assert case["bodies"]["ball"]["pose"]["pos"][2] == "${start}"
    assert case["actions"]["expect"]["low"]["below"] == "${most}"
    assert agreement.plan.params == case["params"]
    assert agreement.plan.shared == ["It starts ${start} up."]
    assert agreement.plan.bodies["ball"].what == "at ${start}"
    examined = examine(text, Path("case.yaml"))
    assert not examined.errors
    assert agreement.breaches(examined) == []
    agreement.record_examined(examined)
    assert told == [], "nothing was restated"


def test_further_expectations_stand_from_then_on_and_are_not_called_restated() -> None:
    agreement, told = agreed()
    answer = "{action: repair, why: x, plan: {says: {fast: It gets fast.}, checks: {measures: {v: {kind: speed, of: ball}}, expect: {fast: {measure: v, during: [0, 1], stat: max, above: 1}}}}}"
    text = agreement.apply(CASE, Decision.model_validate(data(answer)))
    assert agreement.names == ("low", "fast")
    examined = examine(text, Path("case.yaml"))
    agreement.record_examined(examined)
    assert agreement.restated == []
    assert [event for event, _ in told] == ["expected"]
    easier = text.replace("above: 1", "above: 0.1")
    assert agreement.breaches(examine(easier, Path("case.yaml")))


def test_a_measure_that_nothing_asks_for_any_more_is_not_called_restated() -> None:
    agreement, _ = agreed()
    checks = {
        "measures": {"x": {"kind": "extent", "of": "ball", "axis": "z", "stat": "max"}},
        "expect": {"low": {"measure": "x", "at": "end", "below": 0.3}},
    }
    decision = Decision.model_validate(
        {"action": "repair", "why": "x", "restate": {"why": "its top is meant", "checks": checks}}
    )
    agreement.record_examined(examine(agreement.apply(CASE, decision), Path("case.yaml")))
    (row,) = agreement.restated
    assert row.startswith("expect `low` was ")
    assert "its top is meant" in row


def test_later_letters_show_the_present_numbers() -> None:
    agreement, _ = agreed()
    agreement.adopt_values(CASE.replace("duration: 1,", "duration: 2.5,").replace("bound: 0.3", "bound: 0.25"))
    assert agreement.plan.duration == 2.5
    assert agreement.plan.params["bound"] == 0.25


def test_the_plan_and_the_case_get_another_duration_together() -> None:
    agreement, _ = agreed()
    decision = Decision.model_validate({"action": "repair", "why": "x", "plan": {"duration": 2.5}})
    assert "duration: 2.5" in agreement.apply(CASE, decision)
    assert agreement.plan.duration == 2.5
    assert faults("plan: {duration: 2.5}") == []


def test_a_duration_that_is_a_parameter_is_changed_as_one() -> None:
    agreement, _ = agreed()
    case = CASE.replace("params: {", "params: {t_end: 1, ", 1).replace("duration: 1", 'duration: "${t_end}"', 1)
    assert "t_end" in case
    decision = Decision.model_validate({"action": "repair", "why": "x", "plan": {"duration": 2.5}})
    after = agreement.apply(case, decision)
    assert "t_end: 2.5" in after
    assert 'duration: "${t_end}"' in after
