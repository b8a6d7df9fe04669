"""What is done with a judgement: marks for requirements, slips of form, what follows from the marks."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import Scripted, chat, fenced
from text2sim.agents.contract import Contract
from text2sim.agents.conversation import typed_parser
from text2sim.agents.criticism import Exhibit, criticise, decision_to_film
from text2sim.agents.facts import Fact
from text2sim.agents.judgement import Critique, Mark
from text2sim.agents.planning import Request
from text2sim.agents.replies import MAX_LINE_LENGTH, CasePlan
from text2sim.agents.requirements import Requirement, extract_requirements, requirements_of_change, weighted_score
from text2sim.agents.run_summary import attempts_table, evidence_text, judgement_text, to_decide_by

REQUIRED = {
    "red": Requirement(what="the lid is red", importance=1),
    "opens": Requirement(what="the lid opens by itself", importance=3),
}
TIN = (Path(__file__).parent / "recorded" / "edit_colour" / "base.yaml").read_text("utf-8")
REQUEST = Request("A red lid opens by itself.", requirements=REQUIRED)
PLAN = CasePlan(name="lid", event="The lid opens.", meets={"opens": ["open"]})


def judged(
    tmp_path: Path,
    *replies: str,
    missed: tuple[str, ...] = (),
    facts: tuple[Fact, ...] = (),
    request: Request = REQUEST,
) -> tuple[Critique, Scripted]:
    model = Scripted({"critic": [fenced(reply) for reply in replies]})
    exhibit = Exhibit(1, "", "the evidence", frozenset({"run", "frame:1", "expect:open"}), (), missed, facts)
    contract = Contract((), {"expect": {}, "measures": {}, "events": {}}, frozenset())
    return criticise(chat(tmp_path, model), request, PLAN, exhibit, contract, [], Path("c/case.yaml")), model


def test_a_case_passes_only_with_every_requirement_met(tmp_path: Path) -> None:
    reply = "seen: It opens.\nverdict: pass\nrequirements: {red: [1, 'frame:1'], opens: [%s, 'frame:1', it is pushed]}"
    half, _ = judged(tmp_path / "half", reply % "1/2")
    assert (half.verdict, half.score) == ("repair", 62.5)
    assert half.failures[0].what == "only half met: the lid opens by itself (it is pushed)"
    assert half.failures[0].cites == ["frame:1"]
    whole, model = judged(tmp_path / "whole", reply % "1")
    assert (whole.verdict, whole.score, whole.failures) == ("pass", 100, [])
    assert "- `opens` (3): the lid opens by itself [expect:open]" in model.questions("critic")[0]


def test_requirements_of_any_form_are_judged(tmp_path: Path) -> None:
    two_lines = Requirement(what="the lid is red\nand shines")
    request = Request("A red lid.", requirements={"red": two_lines, "opens": Requirement(what="long " * 799)})
    reply = f"seen: It opens.\nverdict: pass\nrequirements: {{opens: [0, 'frame:1', {'why ' * 100}]}}"
    found, model = judged(tmp_path, reply, "requirements: {}", request=request)
    assert "- `red` (3): the lid is red\nand shines\n- `opens` (3): long" in model.questions("critic")[0]
    assert [failure.what[:14] for failure in found.failures] == ["not met: long ", "not marked: th"]
    assert len(found.failures[0].what) == MAX_LINE_LENGTH


def test_what_is_half_met_belongs_to_the_section_that_is_patched(tmp_path: Path) -> None:
    reply = "seen: It opens.\nverdict: repair\nrequirements: {red: [1/2, 'frame:1', hidden], opens: 1}\npatches: "
    patch = "[{section: render, why: from the left, operations: [{op: add, path: /render/fps, value: 30}]}]"
    found, _ = judged(tmp_path / "patched", reply + patch)
    assert [failure.section for failure in found.failures] == ["render"]
    found, _ = judged(tmp_path / "not", reply + "[]")
    assert [failure.section for failure in found.failures] == ["plan"]


def test_what_is_wished_only_if_possible_may_be_half_met(tmp_path: Path) -> None:
    optional = Requirement(what="if possible, it shines", importance=1, optional=True)
    request = replace(REQUEST, requirements=REQUIRED | {"shines": optional})
    reply = "seen: It opens.\nverdict: pass\nrequirements: {red: 1, opens: 1, shines: [%s, 'frame:1', hardly]}"
    half, model = judged(tmp_path / "half", reply % "1/2", request=request)
    assert (half.verdict, half.score, half.failures) == ("pass", 90, [])
    assert "- `shines` (1, optional): if possible, it shines" in model.questions("critic")[0]
    assert judged(tmp_path / "none", reply % "0", request=request)[0].verdict == "repair"


def test_a_pass_with_something_that_did_not_come_true_is_none(tmp_path: Path) -> None:
    reply = "seen: It opens.\nverdict: passed\nresponsible: nobody\nrequirements: {red: 1, opens: 1}"
    found, model = judged(tmp_path, reply, missed=("open",))
    assert found.verdict == "repair"
    assert found.failures[0].cites == ["expect:open"]
    assert found.responsible is None
    assert len(model.asked) == 1, "what can be settled is not asked"


def test_what_a_stopped_run_did_not_reach_is_no_failure_beside_its_cause(tmp_path: Path) -> None:
    reply = (
        "seen: It bursts.\nverdict: repair\nrequirements: {red: 1, opens: [0, 'frame:1', it bursts]}\n"
        "failures: [{what: it bursts, cites: [run, 'frame:1'], section: bodies}]"
    )
    for finished, count in ((True, 2), (False, 1)):
        model = Scripted({"critic": [fenced(reply)]})
        exhibit = Exhibit(1, "", "-", frozenset({"run", "frame:1"}), (), ("open",), finished=finished)
        contract = Contract((), {"expect": {}, "measures": {}, "events": {}}, frozenset())
        found = criticise(
            chat(tmp_path / str(finished), model), REQUEST, PLAN, exhibit, contract, [], Path("c/case.yaml")
        )
        assert len(found.failures) == count
        assert found.verdict == "repair"


def test_what_is_left_out_is_asked_for_alone(tmp_path: Path) -> None:
    first = "seen: It opens.\nverdict: pass\nrequirements: {red: 1}\nfailures: []"
    found, model = judged(tmp_path, first, "requirements: {opens: 1}")
    assert found.verdict == "pass"
    again = model.asked[1].messages
    assert len(again) == 2
    assert "no mark for opens" in again[-1].text
    assert "the evidence" not in again[-1].text
    still, _ = judged(tmp_path / "still", first, "Nothing.")
    assert still.verdict == "repair", "a requirement without a mark is not met"
    assert [failure.what for failure in still.failures] == ["not marked: the lid opens by itself"]


def test_citations_of_nothing_do_not_cost_a_letter(tmp_path: Path) -> None:
    reply = "seen: s\nverdict: repair\nrequirements: {red: 1, opens: 0}\nfailures: [{what: shut, cites: ['frame:99'], section: actions}]"
    found, model = judged(tmp_path, reply)
    assert found.failures[0].cites == ["run"]
    assert len(model.asked) == 1


@pytest.mark.parametrize(
    ("told", "mark"), [(1, 1), ("½", 0.5), ([0.5, "frame:1"], 0.5), ({"mark": "half"}, 0.5), (True, 1)]
)
def test_marks_in_any_spelling(told: Any, mark: float) -> None:
    assert typed_parser(Mark)(told).mark == mark


def test_a_request_is_taken_apart_and_looked_through_again(tmp_path: Path) -> None:
    model = Scripted(
        {"reader": [fenced("requirements: {a: {what: x, importance: 5}}"), fenced("missing: {a: {what: y}}")]}
    )
    found = extract_requirements(chat(tmp_path, model), "x and y")
    assert {name: one.what for name, one in found.items()} == {"a": "x", "a_too": "y"}
    assert "- `a` (5): x" in model.questions("reader")[1]
    assert extract_requirements(chat(tmp_path / "mute", Scripted({})), "x") == {}


def test_a_short_wish_is_its_own_requirement() -> None:
    assert list(requirements_of_change("make the lid blue", lambda: {})) == ["wish"]
    assert requirements_of_change("word " * 30, lambda: REQUIRED) == REQUIRED
    wish = "蓋を青くして、箱を二倍の大きさにし、球は赤い縞模様にして、" * 4  # no spaces
    assert requirements_of_change(wish, lambda: REQUIRED) == REQUIRED
    assert requirements_of_change("盒子的盖子是红色的" * 300, lambda: REQUIRED) == REQUIRED


def test_the_score_weighs_by_importance() -> None:
    assert weighted_score(REQUIRED, {"red": 1, "opens": 0}) == 25
    assert weighted_score(REQUIRED, {"red": 1}) == 25


def test_earlier_judgements_and_the_way_of_expectations_are_told() -> None:
    critique = {
        "verdict": "repair", "score": 40, "summary": "Stronger.", "requirements": {"opens": {"mark": 0.5, "why": "half way"}},
        "failures": [{"what": "it stops"}], "patches": [{"section": "actions", "why": "2 N"}], "refused": ["on bodies: no"],
    }  # fmt: skip
    told = judgement_text(1, "first version", critique, ["not taken: too strong"])
    assert "`opens` 0.5: half way" in told
    assert "your patch on actions (2 N): not taken: too strong" in told
    assert "could not be applied: on bodies: no" in told
    rows = attempts_table([(1, {"open": {"ok": False, "why": "12 deg"}}), (2, {"open": {"ok": True, "why": "90 deg"}})])
    assert "| `open` | MISSED: 12 deg | true: 90 deg |" in rows
    still = {"red": {"ok": True, "why": "#c00000"}}
    assert attempts_table([(1, still), (2, still)]) == "True in each attempt: `red`"


def test_the_critic_reads_who_did_work_and_nothing_that_is_within_bounds(tmp_path: Path) -> None:
    energy = {
        "start": 1.0, "max": 9.0, "max_at": 0.5, "end": 7.0, "not_counted": [], "work_until_max": 8.0,
        "works": {"motors": {"drum": 6.5, "idle": 0.0}, "controls": {"shove": -0.25}},
    }  # fmt: skip
    small = {"between": ["a", "b"], "time": 0.1, "unit": "m"}
    rest = {"expect": {}, "measures": {}, "events": {}, "contacts": {"episodes": 4}, "driven": ["sled"]}
    evidence: dict[str, Any] = rest | {
        "energy": energy,
        "penetration": small | {"value": 1e-4},
        "joint_limits": [{"joint": "lid", "end": "upper", "by": 1e-3, "unit": "rad"}],
        "off_path": [{"copy": "sled", "value": 1e-5, "unit": "m"}],
        "speeds": {"a": {"linear": {"max": 0.0, "at": 0.0}}},
    }
    record = {"state": "finished", "time": 2.0, "duration": 2.0, "timings": {"simulate": 3.0}}
    told = evidence_text(tmp_path, evidence, record, ())
    assert "2 of 2 s simulated, 1.5 s of wall time per simulated second" in told
    assert "work in all: motor `drum` 6.5 J, control `shove` -0.25 J; motors until then 8 J" in told
    assert "driven" in told
    for word in ("penetration", "joint_limits", "off_path", "speeds", "contacts", "idle"):
        assert word not in told
    worse = evidence | {
        "penetration": small | {"value": 0.02},
        "off_path": [{"copy": "sled", "value": 0.3, "unit": "m"}],
        "motors_at_limit": [
            {
                "joint": "arm.elbow",
                "control": "lift",
                "share": 0.9,
                "start": 0,
                "end": 2,
                "off": 0.4,
                "unit": "rad",
                "max_force": 5,
                "force_unit": "N m",
                "against": ["table.leg"],
            }
        ],
    }
    told = evidence_text(tmp_path, worse, {"state": "finished"}, ())
    assert "penetration: at most 0.02 m, `a` and `b`, at 0.1 s" in told
    assert "off_path: [{copy: sled, value: 0.3" in told
    assert (
        "motors_at_limit: `arm.elbow` at its max_force of 5 N m for 90% of `lift`, 0 to 2 s, 0.4 rad from its target at "
        "the end, pressed against `table.leg`"
    ) in told


def test_of_a_repeat_the_ends_are_told_and_what_has_a_problem(tmp_path: Path) -> None:
    def measure(k: int) -> dict[str, Any]:
        return {"unit": "m", "problem": None, "min": k, "min_at": 0.0, "max": k + 10, "max_at": 1.0}

    evidence: dict[str, Any] = {
        "expect": {f"low_{k}": {"ok": True, "wanted": f"below {k} m", "why": f"was {k - 1} m"} for k in range(5)},
        "measures": {f"z_{k}": measure(k) for k in range(6)},
        "events": {},
    }
    evidence["measures"]["z_3"] = {"unit": "m", "problem": "no such body", "min": None, "max": None}
    evidence["measures"]["z_4"] |= dict.fromkeys(("min", "min_at", "max", "max_at"))  # it never has a value
    told = evidence_text(tmp_path, evidence, {"state": "finished"}, ())
    assert "true `low_0` to `low_4`: wanted below 0 m; …; below 4 m; found: was -1 m; …; was 3 m" in told
    assert "between `z_0` and `z_5` 2 more: min 1 to 2, max 11 to 12" in told
    assert "`z_3`: no such body" in told
    assert "`z_2`" not in told


def test_values_over_time_share_their_times_and_are_for_the_critic_alone(tmp_path: Path) -> None:
    rows = [f"{k / 10},{k * k / 100},-1e-17" for k in range(21)]
    (tmp_path / "measures.csv").write_text("\n".join(["t,way,drift", *rows]))
    ends = {"min": 0.0, "min_at": 0.0, "max": 4.0, "max_at": 2.0, "unit": "m"}
    events = {"hit": {"count": 1, "first": 0.5, "last": 0.5}, "bounce": {"count": 2, "first": 0.5, "last": 0.9}}
    evidence = {"expect": {}, "events": events | {"rest": {"count": 0}}, "measures": {"way": ends, "drift": ends}}
    told = evidence_text(tmp_path, evidence, {"state": "finished"}, ())
    assert "- over time: at 0, 0.3, 0.7, 1, 1.3, 1.7, 2 s" in told
    assert "max 4 at 2 s; over time 0, 0.09, 0.49, 1, 1.69, 2.89, 4\n" in told
    assert "over time 0, 0, 0, 0, 0, 0, 0" in told, "no digits of rounding errors"
    assert "- `hit`: once, at 0.5 s\n- `bounce`: 2 times, first at 0.5 s, last at 0.9 s\n- `rest`: never" in told
    assert "max 4 at 2 s" in to_decide_by(told)
    assert "over time" not in to_decide_by(told)


def test_a_critique_of_film_and_looks_alone_needs_no_planner() -> None:
    ball = {"section": "bodies", "why": "paler", "operations": [_replace("/bodies/ball/look/color", "ivory")]}
    heavy = {"section": "bodies", "why": "heavier", "operations": [_replace("/bodies/ball/material/density", 9000)]}
    film = {"section": "render", "why": "nearer", "operations": [_replace("/render/fps", 24)]}

    def decided(failed: list[str], *patches: dict[str, Any], **more: Any) -> Any:
        failures = [{"what": "small", "cites": ["frame:1"], "section": section} for section in failed]
        critique = Critique.model_validate(
            {"seen": "It opens.", "verdict": "repair", "failures": failures, "patches": patches} | more
        )
        return decision_to_film(critique.model_dump(mode="json"), TIN, Path("tin/case.yaml"))

    decision = decided(["render"], film, film)
    assert (decision.action, decision.take, decision.why) == ("repair", [1, 2], "nearer")
    assert decided(["render", "bodies"], film, ball).take == [1, 2], "looks are filmed again, too"
    assert decided(["render"], ball).take == [1]
    for failed, patches, more in (
        (["bodies"], [film], {}),
        (["bodies", "bodies"], [ball, film], {}),  # one of them may be about the motion
        (["plan"], [ball], {}),
        (["bodies"], [ball, heavy], {}),
        (["render"], [], {}),
        (["render"], [film], {"refused": ["on render: it has no x"]}),
        (["render"], [film], {"unfaithful": ["opens"]}),
    ):
        assert decided(failed, *patches, **more) is None
    assert decision_to_film(None, TIN, Path("tin/case.yaml")) is None


def _replace(path: str, value: Any) -> dict[str, Any]:
    return {"op": "replace", "path": path, "value": value}
