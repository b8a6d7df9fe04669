"""What the Planner may change, what it may not, and that nothing of it is without effect."""

from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import Scripted
from tests.agents.test_conversation import chat
from tests.agents.test_loop import HIGH, PLAN, REPLIES, begin, scripted
from text2sim.agents import revising
from text2sim.agents import session as sessions
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import examine
from text2sim.agents.attempts import DURATION_RULE, Attempt, Attempts
from text2sim.agents.dealt_cards import DealtCards
from text2sim.agents.deciding import AttemptReport, Choices, decision_faults
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopLimits
from text2sim.agents.planning import Request
from text2sim.agents.replies import CasePlan, Decision
from text2sim.agents.session import Session, SessionWish
from text2sim.lint.rules import RULES
from text2sim.spec_schema.errors import Problem
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
    agreement.expect(plan, plan.checks.expect)
    agreement.record_examined(examine(CASE, Path("case.yaml")))
    return agreement, told


def faults(answer: str, *, anew: bool = True, trials: int = 0, **report: Any) -> list[str]:
    decision = Decision.model_validate({"action": "repair", "why": "x"} | data(answer))
    dealt = DealtCards(None, lambda event, /, *, live=False, **what: None)
    agreement = agreed()[0]
    choices = Choices(anew, trials, {1: (CASE.replace("height: 1.0", "height: 1.5"), agreement)})
    return decision_faults(decision, agreement, CASE, AttemptReport(**report), dealt, Path("case.yaml"), choices)


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
        ("params: {height: 1.0}", "it is 1.0 already"),
        ('params: {height: "${hight}"}', "did you mean `height`"),
        ("patch: [{op: remove, path: /params/bound}]", "unknown name `bound`"),
        ("patch: [{op: replace, path: /bodies/ball/shape/radius, value: 1}]", "is a Writer's: route it"),
        ("patch: [{op: remove, path: /variants/low}]", "/patch"),
        ("plan: {rename: {height: layer}}", "`layer` is taken"),
        ("plan: {rename: {hight: h}}", "there is no such parameter"),
        ("plan: {checks: {expect: {low: {measure: z, at: end, below: 0.9}}}}", "say it anew by `restate`"),
        ("plan: {checks: {expect: {new: {measure: z, at: end, below: 0.2}}}}", "/plan/says/new"),
        ("plan: {says: {new: x}, checks: {expect: {new: {measure: zz, at: end, below: 0.2}}}}", "did you mean `z`"),
        ("plan: {says: {new: x}, checks: {measures: {v: {kind: speed, of: ball}}, expect: {new: {measure: v, at: end, above: -1}}}}", "cannot fail"),
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


def test_a_waiver_of_what_is_no_rule_of_the_lint_is_refused() -> None:
    assert "no rule `unknown-body`" in "\n".join(
        faults("waive: {unknown-body: it is meant so}", rules=frozenset({"unknown-body"}))
    )


def test_it_plans_anew_only_once() -> None:
    assert "planned anew already" in faults("action: plan_anew", anew=False)[0]


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
    agreement.see(CASE.replace("duration: 1,", "duration: 2.5,").replace("bound: 0.3", "bound: 0.25"))
    assert agreement.plan.duration == 2.5
    assert agreement.plan.params["bound"] == 0.25


@pytest.mark.parametrize("needed", [False, True])
def test_before_a_run_what_is_promised_and_the_case_stay_together(
    needed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`needed`: the new expectation is about a body that only the Writer, whose text is wrong, would have added."""
    body, model = "post" if needed else "ball", Scripted({})
    answer = f"{{plan: {{says: {{fast: s}}, checks: {{measures: {{v: {{kind: speed, of: {body}}}}}, expect: {{fast: {{measure: v, during: [0, 1], stat: max, above: 1}}}}}}}}}}"
    decision = Decision.model_validate({"action": "repair", "why": "too little is asked"} | data(answer))
    quiet, path = lambda event, /, *, live=False, **what: None, tmp_path / "case.yaml"
    made = AgentLoop(
        tmp_path, Request("A ball falls."), chat(tmp_path, model), DealtCards(None, quiet), quiet, LoopLimits()
    )
    made.path, made.agreement = path, agreed()[0]
    made.mending.agreement = made.agreement
    monkeypatch.setattr(made, "_decide", lambda *given, **more: decision)
    monkeypatch.setattr(
        made.workshop, "follow_routes", lambda text, routes, keep=(): text.replace("radius: 0.1", "radius: -1")
    )
    attempt = Attempt(1, CASE, "first version")
    examined = made._settle_doubts(attempt, examine(CASE, path), ["it asks for little"])
    assert not examined.errors
    assert made.agreement.names == (("low",) if needed else ("low", "fast"))
    assert ("fast:" in attempt.text) is not needed
    assert made.agreement.breaches(examined) == []
    assert made.agreement.breaches(examine(attempt.text, path)) == []
    assert bool(made.workshop.referred) is needed, "the Planner hears of it"


def test_what_a_run_takes_is_told_as_it_was_measured_once_there_was_one(tmp_path: Path) -> None:
    asked: list[Any] = []
    quiet, path = lambda event, /, *, live=False, **what: None, tmp_path / "case.yaml"
    made = AgentLoop(
        tmp_path, Request("A ball."), chat(tmp_path, Scripted({})), DealtCards(None, quiet), quiet, LoopLimits()
    )
    made.path, made.agreement = path, agreed()[0]
    made.mending.agreement = made.agreement
    made.agreement.plan.keeps = ["low"]
    made.workshop.fix_sections = lambda text, owners, instruction: (asked.append(owners), (text, {}))[1]  # type: ignore
    assert DURATION_RULE in {rule.id for rule in RULES}
    guess = Problem("/bodies/ball", "about 9 s of wall time per simulated second", 1, 1, rule=DURATION_RULE)
    for pace in (0.0, 2.5):
        made._known_warnings.clear()
        made.mending._warned.clear()
        made.made = [Attempt(1, CASE, "first version", wall=31.0, pace=pace)]
        examined = examine(CASE, path)
        examined.warnings = [guess]
        made._considered(Attempt(2, CASE, "x"), examined)
    assert len(asked) == 1, "a guess is not told when it is known"
    assert "took 31 s of wall time, of which 2.5 s per simulated second" in made.left()


def test_a_warning_that_is_meant_is_not_told_again_whatever_the_camera_is_called(tmp_path: Path) -> None:
    letters: list[str] = []
    quiet, path = lambda event, /, *, live=False, **what: None, tmp_path / "case.yaml"
    made = AgentLoop(
        tmp_path, Request("A ball."), chat(tmp_path, Scripted({})), DealtCards(None, quiet), quiet,
        LoopLimits(minutes_left=lambda: 12.0),
    )  # fmt: skip
    made.path, made.agreement = path, agreed()[0]
    made.mending.agreement = made.agreement

    def fixed(text: str, owners: Any, instruction: str) -> Any:
        letters.extend([*owners["render"], instruction])
        made.workshop.unchanged = {"render": "it rolls in at 1 s"}
        return text, {}

    made.workshop.fix_sections = fixed  # type: ignore
    places = "/render/cameras/main", "/render/cameras/wide", "/render/cameras"
    examined = examine(CASE, path)
    for place, seen in zip(places, ("camera `main` does not", "camera `wide` does not", "no camera does"), strict=True):
        examined.warnings = [Problem(place, f"{seen} see `ball`", 1, 1, rule="unseen-subject", severity="warning")]
        made.mending.consider_warnings(Attempt(1, CASE, "x"), examined, ())
        assert made.mending.intended(examined.warnings) == {("unseen-subject", place): "it rolls in at 1 s"}
    assert len(letters) == 2, "it was said once that it is meant"
    assert "12 minutes are left for everything" in letters[1]
    other = Problem(places[0], "camera `main` does not see `post`", 1, 1, rule="unseen-subject", severity="warning")
    examined.warnings = [other]
    made.mending.consider_warnings(Attempt(1, CASE, "x"), examined, ())
    assert "`post`" in letters[2], "another subject is another matter"
    old = Problem(places[0], "camera `main` does not see `pole`", 1, 1, rule="unseen-subject", severity="warning")
    made.mending.inherit([old])
    examined.warnings = [old]
    made.mending.consider_warnings(Attempt(1, CASE, "x"), examined, ())
    assert len(letters) == 4, "what a case had before is nobody's to mend"


@pytest.mark.parametrize(
    ("left", "pace", "asked"), [(8.0, 0.0, True), (60.0, 0.0, False), (8.0, 2.0, False), (None, 0.0, False)]
)
def test_a_run_that_would_take_most_of_the_time_left_is_doubted_once(
    tmp_path: Path, left: float | None, pace: float, asked: bool
) -> None:
    quiet = lambda event, /, *, live=False, **what: None  # noqa: E731
    made = AgentLoop(
        tmp_path, Request("A ball."), chat(tmp_path, Scripted({})), DealtCards(None, quiet), quiet,
        LoopLimits(minutes_left=lambda: left),
    )  # fmt: skip
    made.path, made.agreement = tmp_path / "case.yaml", agreed()[0]
    made.agreement.plan.keeps = ["low"]
    made.made = [Attempt(1, CASE, "first version", pace=pace)]
    told: list[list[str]] = []
    give_up = Decision(action="give_up", why="x")
    made._decide = lambda attempt, report, **more: (told.append(list(report.doubts)), give_up)[1]  # type: ignore
    examined = examine(CASE, made.path)
    examined.seconds = 300.0
    for _ in range(2):
        made._settle_doubts(Attempt(2, CASE, "x"), examined, [])
    assert len(told) == asked
    assert not asked or "estimated at 5 minutes (within a factor of three) of the 8 that are left" in told[0][0]


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


# --- in the loop ---------------------------------------------------------------------------------------------------

LOST = HIGH.replace('pose: {pos: [0, 0, "${height + 1.7}"]}', "place: {on: table}")


def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, replies: dict[str, list[str]]) -> tuple[Scripted, Any, Any]:
    model, seen = scripted(REPLIES | replies), []
    outcome = begin(tmp_path / "case", monkeypatch, model).run(lambda event, what: seen.append((event, what)))
    return model, outcome, seen


def test_it_may_plan_anew_once_and_the_expectations_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = PLAN.replace("params: {height: 0.3}", "params: {height: 0.4}").replace(
        "bodies: One ball", "bodies: Another ball"
    )
    easier = other.replace("lands: {event: touch, within: [0.1, 0.5]}", "comes: {event: touch}").replace(
        "{lands:", "{comes:"
    )
    model, outcome, _ = loop(
        tmp_path,
        monkeypatch,
        {
            "planner": [PLAN, "action: plan_anew\nwhy: a table is missing\n", easier, other, "action: plan_anew\nwhy: again",
                        "action: give_up\nwhy: twice\n"],
            "scene": REPLIES["scene"] * 2,
            "bodies": [LOST, "patch: []", LOST, "patch: []"],
            "actions": REPLIES["actions"] * 2,
            "render": [REPLIES["render"][0]] * 2,
        },
    )  # fmt: skip
    assert (outcome.state, outcome.why) == ("gave_up", "twice")
    asked = model.questions("planner")
    assert "planned once, and the approach was wrong. a table is missing" in asked[2]
    assert "there is no body or static `table`" in asked[2], "what was tried"
    assert "lands: it comes from the request and must stay" in asked[3]
    assert "planned anew already" in asked[5]
    assert "height: 0.4" in asked[4]
    assert "Another ball" in model.questions("bodies")[2]


def test_what_a_writer_refers_reaches_its_addressee(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model, outcome, seen = loop(
        tmp_path,
        monkeypatch,
        {
            "planner": [PLAN, "action: repair\nwhy: no table\nroutes: [{section: scene, instruction: Add a table.}]",
                        "action: give_up\nwhy: enough"],
            "bodies": [LOST, "patch: []", "refer: {section: plan, why: the plan has a slab and no table}"],
            "scene": [*REPLIES["scene"], "refer: {section: bodies, why: put the ball on the floor instead}"],
        },
    )  # fmt: skip
    assert outcome.state == "gave_up"
    assert "The Writer of scene says: put the ball on the floor instead" in model.questions("bodies")[2]
    assert "The Writer of bodies says: the plan has a slab and no table" in model.questions("planner")[2]
    assert [event for event, _ in seen].count("referred") == 2


def test_what_holds_at_the_start_is_put_before_the_planner_before_the_first_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unfinished(self: Any, attempt: Attempt, *rest: Any) -> None:
        attempt.state, attempt.problems = "failed", ["stopped by the test"]

    monkeypatch.setattr(Attempts, "run", unfinished)
    vacuous = PLAN.replace("events: {touch", "measures: {z: {kind: position, of: ball, axis: z}}\n  events: {touch")
    vacuous = vacuous.replace("expect: {lands", "expect: {low: {measure: z, at: end, below: 9}, lands")
    vacuous = vacuous.replace("says: {", "says: {low: It has come down., ")
    stricter = "action: repair\nwhy: it starts at 2 m\nrestate: {why: 9 m was a slip, checks: {expect: {low: {measure: z, at: end, below: 0.2}}}}"
    model, outcome, seen = loop(
        tmp_path,
        monkeypatch,
        {"planner": [vacuous, stricter, "action: give_up\nwhy: enough"], "render": ["render: {}"]},
    )
    asked = model.questions("planner")
    assert "/actions/expect/low: it holds if nothing happens at all: `z` is so at the start already" in asked[1]
    assert "/actions/expect/lands: it holds" not in asked[1], "it has to come about"
    assert [what["doubts"][0][:20] for event, what in seen if event == "doubted"] == ["/actions/expect/low:"]
    assert outcome.why == "enough"
    assert outcome.best is not None
    assert "below: 0.2" in outcome.best.text, "it was mended before the first run, in the same attempt"
    assert outcome.best.number == 1


def test_the_planner_is_told_what_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model, _, _ = loop(
        tmp_path,
        monkeypatch,
        {"planner": [PLAN, "action: give_up\nwhy: x"], "bodies": [LOST, "patch: []"]},
    )
    assert "Left: 3 of 4 attempts are left." in model.questions("planner")[1]


def test_a_writer_that_gives_no_usable_answer_does_not_end_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, outcome, _ = loop(
        tmp_path,
        monkeypatch,
        {
            "planner": [PLAN, "action: give_up\nwhy: enough"],
            "bodies": [LOST, "nonsense: 1", "nonsense: 2", "nonsense: 3"],
        },
    )
    assert (outcome.state, outcome.why) == ("gave_up", "enough")
    assert "the bodies gave no usable answer in 3 tries" in model.questions("planner")[1]


def test_what_of_a_decision_can_be_done_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    half = "action: repair\nwhy: lower\nparams: {layer: 2, height: 0.5}\nroutes: [{section: scene, instruction: Add a table.}]"
    model, outcome, seen = loop(
        tmp_path,
        monkeypatch,
        {
            "planner": [PLAN, half, half + " ", half + "  ", "action: give_up\nwhy: enough"],
            "bodies": [LOST, "patch: []", "patch: []"],
            "scene": [*REPLIES["scene"], "patch: []"],
        },
    )
    assert (outcome.state, outcome.why) == ("gave_up", "enough")
    decided = [what for event, what in seen if event == "decided"]
    assert decided[0]["routes"] == {"scene": "Add a table."}
    assert "without what could not be done: /params/layer" in decided[0]["why"]
    assert "Add a table." in model.questions("scene")[1]


def test_a_loop_that_goes_on_tells_the_minutes_that_it_told(tmp_path: Path) -> None:
    first = Attempts(tmp_path)
    attempt = Attempt(1, "text", "x")
    assert [first.minutes_left(attempt, now) for now in (30.0, 20.0)] == [30.0, 20.0]
    again, second = Attempt(1, "other text", "x"), Attempts(tmp_path)
    second.keep(again)
    assert [second.minutes_left(again, now) for now in (9.0, 8.0, 7.0)] == [30.0, 20.0, 7.0]
    assert Attempts(tmp_path).minutes_left(Attempt(2, "text", "x"), None) is None


def test_a_loop_ends_when_no_run_fits_into_the_minutes_left(tmp_path: Path) -> None:
    ran, attempts = Attempt(1, "text", "x", wall=200.0), Attempts(tmp_path)
    assert [attempts.too_late(ran, now) for now in (1.6, 1.7, None)] == [True, False, False]
    attempts.minutes_left(ran, 30.0)
    assert not Attempts(tmp_path).too_late(ran, 1.0), "in a loop that goes on it was answered already"
    assert attempts.too_late(ran, 1.0)


def test_a_loop_that_goes_on_recalls_a_run_although_the_planner_was_asked_before_it(tmp_path: Path) -> None:
    ran = Attempt(1, "text", "x", state="finished", run="runs/a", wall=30.0)
    first = Attempts(tmp_path)
    first.minutes_left(ran, 30.0)
    first.keep(ran)
    again, second = Attempt(1, "text", "x"), Attempts(tmp_path)
    second.minutes_left(again, 9.0)
    assert second.recall(again)
    assert (again.state, again.run, again.wall) == ("finished", "runs/a", 30.0)


# --- existing cases ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("answer", "about"),
    [
        ("params: {layer: 3}", "/params/layer"),
        ("{routes: [{section: scene, instruction: x}], says: {a: b}, checks: {expect: {a: {event: hitt, within: [0, 1]}}}}",
         "there is no event `hitt`"),
        ("{routes: [{section: scene, instruction: x}], says: {a: b}, checks: {expect: {a: {measure: z, at: 3, below: 1}}}}",
         "is after the end of the run"),
        ("patch: [{op: remove, path: /bodies/ball}]", "is a Writer's: route it"),
        ("patch: [{op: remove, path: /params/bound}]", "unknown name `bound`"),
    ],
)  # fmt: skip
def test_a_wish_is_checked_when_it_comes_in(
    answer: str, about: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = scripted({"planner": [answer] * 3})
    monkeypatch.setattr(sessions, "endpoint_of", lambda spec, case: model)
    (tmp_path / "drop").mkdir()
    wish = SessionWish("edit", "Let it start higher.", {"": "x"}, cards=False, base=CASE)
    outcome = Session.begin(tmp_path / "drop", wish, [], []).run(lambda event, what: None)
    assert outcome.state == "failed"
    assert about in outcome.why + model.questions("planner")[-1]


def test_patches_that_need_each_other_are_applied_together() -> None:
    """A domain that the ball would be outside of, and the ball's new place in it."""
    path = Path("case.yaml")
    domain = {"min": [4, -1, -1], "max": [6, 1, 3]}
    patches = [
        {"section": "scene", "why": "x", "operations": [{"op": "add", "path": "/scene/domain", "value": domain}]},
        {"section": "bodies", "why": "x", "operations": [{"op": "replace", "path": "/bodies/ball/pose/pos/0", "value": 5}]},
    ]  # fmt: skip
    text, left_out = revising.with_patches(CASE, patches, path, None)
    assert left_out == ["", ""]
    assert revising.data_of(text)["bodies"]["ball"]["pose"]["pos"][0] == 5
    foreign = [{**patches[1], "section": "scene"}, patches[0]]
    assert revising.with_patches_together(CASE, foreign, path, None) is None, "each stays in its own section"
