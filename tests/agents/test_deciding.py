"""Decisions of the Planner within the loop: none of them is without effect."""

from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import Scripted, chat, quiet_loop
from tests.agents.test_decision_faults import CASE, agreed, data
from tests.agents.test_loop import HIGH, PLAN, REPLIES, begin, scripted
from text2sim.agents import revising
from text2sim.agents import session as sessions
from text2sim.agents.assembly import examine
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempt_report import AttemptReport
from text2sim.agents.attempts import DURATION_RULE, Attempts
from text2sim.agents.replies import Decision
from text2sim.agents.session import Session, SessionWish
from text2sim.lint.rules import RULES
from text2sim.spec_schema.errors import Problem


@pytest.mark.parametrize("needed", [False, True])
def test_before_a_run_what_is_promised_and_the_case_stay_together(
    needed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`needed`: the new expectation is about a body that only the Writer, whose text is wrong, would have added."""
    body = "post" if needed else "ball"
    answer = f"{{plan: {{says: {{fast: s}}, checks: {{measures: {{v: {{kind: speed, of: {body}}}}}, expect: {{fast: {{measure: v, during: [0, 1], stat: max, above: 1}}}}}}}}}}"
    decision = Decision.model_validate({"action": "repair", "why": "too little is asked"} | data(answer))
    made, path = quiet_loop(tmp_path), tmp_path / "case.yaml"
    made.workshop.agreement = agreed()[0]
    made.workshop.chat = chat(tmp_path, scripted({"bodies": ["patch: []\nwhy: it cannot be larger"]}))
    monkeypatch.setattr(made.deciding, "decide", lambda *given, **more: decision)
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
    made, path = quiet_loop(tmp_path), tmp_path / "case.yaml"
    made.workshop.agreement = agreed()[0]
    made.agreement.plan.keeps = ["low"]
    made.workshop.fix_sections = lambda text, owners, instruction: (asked.append(owners), (text, {}))[1]  # type: ignore
    assert DURATION_RULE in {rule.id for rule in RULES}
    guess = Problem("/bodies/ball", "about 9 s of wall time per simulated second", 1, 1, rule=DURATION_RULE)
    for pace in (0.0, 2.5):
        made._known_doubts.clear()
        made.mending._warned.clear()
        made.history.made = [Attempt(1, CASE, "first version", wall=31.0, took=58.0, pace=pace)]
        examined = examine(CASE, path)
        examined.warnings = [guess]
        made._considered(Attempt(2, CASE, "x"), examined)
    assert len(asked) == 1, "a guess is not told when it is known"
    assert (
        "attempt 1 took 58 s, with start, judging and pictures; it simulated a second in 2.5 s" in made.history.left()
    )


@pytest.mark.parametrize(("minutes", "told"), [(1.5, 0), (2.5, 1)])
def test_warnings_wait_where_time_is_short(tmp_path: Path, minutes: float, told: int) -> None:
    asked: list[Any] = []
    made = quiet_loop(tmp_path, minutes_left=lambda: minutes)
    made.workshop.agreement = agreed()[0]
    made.agreement.plan.keeps = ["low"]
    made.workshop.fix_sections = lambda text, owners, instruction: (asked.append(owners), (text, {}))[1]  # type: ignore
    made.history.made = [Attempt(1, CASE, "first version", wall=31.0, took=58.0)]
    examined = examine(CASE, tmp_path / "case.yaml")
    examined.warnings = [Problem("/bodies/ball", "it is thin", 1, 1, rule="thin-soft-body", severity="warning")]
    assert made._considered(Attempt(2, CASE, "x"), examined) is examined
    assert len(asked) == told


def test_a_warning_that_is_meant_is_not_told_again_whatever_the_camera_is_called(tmp_path: Path) -> None:
    letters: list[str] = []
    made, path = quiet_loop(tmp_path, minutes_left=lambda: 12.0), tmp_path / "case.yaml"
    made.workshop.agreement = agreed()[0]

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


def test_what_a_writer_refers_to_the_planner_is_told_before_the_run(tmp_path: Path) -> None:
    made = quiet_loop(tmp_path)
    made.workshop.agreement = agreed()[0]
    made.agreement.plan.keeps = ["low"]
    said, told = "The Writer of scene says: the mat is too thin, set `mat_t` to 0.03", list[list[str]]()
    made.workshop.fix_sections = lambda text, *rest: (text, {"plan": [said]})  # type: ignore
    give_up = Decision(action="give_up", why="x")
    made.deciding.decide = lambda attempt, report, **more: (told.append([*made.workshop.referred]), give_up)[1]  # type: ignore
    made.workshop.referred = ["an older matter, which waits"]
    examined = examine(CASE, made.path)
    made._considered(Attempt(1, CASE, "x"), examined)
    assert told == [], "nothing was referred"
    thin = Problem("/scene/mpm/cell", "1.3 cells thick", 1, 1, rule="thin-soft-body", severity="warning")
    examined.warnings = [thin]
    made._considered(Attempt(1, CASE, "x"), examined)
    assert told == [["an older matter, which waits", said]]


@pytest.mark.parametrize("keeps", [[], ["low"]])
def test_what_must_not_move_may_be_measured(tmp_path: Path, keeps: list[str]) -> None:
    made = quiet_loop(tmp_path)
    made.workshop.agreement = agreed()[0]
    made.agreement.plan.keeps = keeps
    examined = examine(CASE, made.path)
    examined.warnings = [Problem("/actions/measures/z/of", "`z` never changes", 1, 1, rule="dead-measure")]
    _, doubts = made.mending.consider_warnings(Attempt(1, CASE, "x"), examined, set())
    assert len(doubts) == (not keeps)


@pytest.mark.parametrize(
    ("left", "pace", "asked"),
    [(8.0, 0.0, True), (4.0, 0.0, False), (60.0, 0.0, False), (8.0, 2.0, False), (None, 0.0, False)],
)
def test_a_run_that_would_take_most_of_the_time_left_is_doubted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, left: float | None, pace: float, asked: bool
) -> None:
    monkeypatch.setattr("text2sim.runtime.machine.crowding", lambda: 1.0)
    made = quiet_loop(tmp_path, minutes_left=lambda: left)
    made.workshop.agreement = agreed()[0]
    made.agreement.plan.keeps = ["low"]
    made.history.made = [Attempt(1, CASE, "first version", pace=pace)]
    told: list[list[str]] = []
    give_up = Decision(action="give_up", why="x")
    made.deciding.decide = lambda attempt, report, **more: (told.append(list(report.doubts)), give_up)[1]  # type: ignore
    examined = examine(CASE, made.path)
    examined.seconds = 300.0
    for _ in range(2):
        made._settle_doubts(Attempt(2, CASE, "x"), examined, [])
    assert len(told) == asked
    assert not asked or "estimated at 5 minutes (within a factor of three) of the 8 that are left" in told[0][0]


def test_a_busy_machine_makes_a_run_dear(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("text2sim.runtime.machine.crowding", lambda: 3.0)
    made = quiet_loop(tmp_path, minutes_left=lambda: 36.0)
    attempt, examined = made.history.begin(CASE, "first version"), examine(CASE, made.path)
    examined.seconds, examined.cost = 420.0, "10,682 mpm particles in cells of 6 mm"
    (doubt,) = made._expensive_run(attempt, examined)
    assert "estimated at 12 minutes" in doubt, "7 minutes on an idle machine, 21 on one as busy as now"
    assert "3.0 times as much to do" in doubt
    assert examined.cost in doubt
    monkeypatch.setattr("text2sim.runtime.machine.crowding", lambda: 1.0)
    assert made.attempts.crowding(attempt) == 3.0, "a resumed loop asks the same again"


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
    assert [attempts.too_late(ran, now, reserve=4.0) for now in (3.9, 4.1, None)] == [True, False, False]
    attempts.minutes_left(ran, 30.0)
    assert not Attempts(tmp_path).too_late(ran, 1.0), "in a loop that goes on it was answered already"
    assert attempts.too_late(ran, 1.0)


def test_a_loop_that_goes_on_recalls_a_run_although_the_planner_was_asked_before_it(tmp_path: Path) -> None:
    ran = Attempt(1, "text", "x", state="finished", run="runs/a", wall=30.0, took=50.0)
    first = Attempts(tmp_path)
    first.minutes_left(ran, 30.0)
    first.keep(ran)
    again, second = Attempt(1, "text before the decision", "x"), Attempts(tmp_path)
    second.minutes_left(again, 9.0)
    second.keep(again)  # the decision is carried out on it
    again.text = "text"
    assert second.recall(again)
    assert (again.state, again.run, again.wall, again.took) == ("finished", "runs/a", 30.0, 50.0)


@pytest.mark.parametrize("damage", ["", "[]", "{}"])
def test_a_loop_that_goes_on_does_without_damaged_files(tmp_path: Path, damage: str) -> None:
    attempts, attempt = Attempts(tmp_path), Attempt(1, "text", "x", state="finished", run="runs/a")
    attempts.keep(attempt)
    for name in ("attempt.json", "crowding.json", "minutes.json"):
        (attempts.folder_of(1) / name).write_text(damage)
    assert not attempts.recall(attempt)
    assert attempts.crowding(attempt) >= 1.0
    assert attempts.minutes_left(attempt, 30.0) == 30.0


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


def test_of_a_judgement_the_planner_reads_what_is_not_met_and_of_the_rest_the_names() -> None:
    marks = {
        "falls": {"mark": 0.5, "cites": ["frame:1"], "why": "it leans"},
        "red": {"mark": 1.0, "cites": ["frame:1"], "why": ""},
    }
    critique = {"seen": "It leans.", "requirements": marks, "score": 0.0, "refused": [], "patches": [{"section": "x"}]}
    told = str(AttemptReport(critique=critique))
    assert "met: [red]" in told
    assert "why: it leans" in told
    assert "score: 0.0" in told
    assert "refused" not in told
    assert told.count("section: x") == 1
