"""What several Writers answer in one round: what holds is kept, and only what does not goes back to its author."""

from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import Scripted, chat, fenced, quiet_loop
from tests.agents.test_decision_faults import CASE, agreed
from text2sim.agents import revising
from text2sim.agents.assembly import examine
from text2sim.agents.attempt import Attempt
from text2sim.agents.loop import AgentLoop
from text2sim.agents.replies import Decision, Fragments
from text2sim.spec_schema.errors import Problem

FILM = "patch: [{op: add, path: /render/fps, value: 12}]"
LOST = "patch: [{op: add, path: /bodies/ball/place, value: {on: desk}}, {op: remove, path: /bodies/ball/pose}]"
SMALL = "patch: [{op: replace, path: /bodies/ball/shape/radius, value: 0.2}]"
PATH = Path("case.yaml")


def team(folder: Path, replies: dict[str, list[str]]) -> tuple[AgentLoop, Scripted]:
    """A loop whose Writers answer from a script."""
    made, model = quiet_loop(folder), Scripted({role: [fenced(row) for row in rows] for role, rows in replies.items()})
    made.workshop.agreement, made.workshop.chat = agreed()[0], chat(folder, model)
    return made, model


def warned(made: AgentLoop) -> dict[str, Any]:
    """The case after two Writers have been told of a warning each."""
    attempt, examined = Attempt(1, CASE, "x"), examine(CASE, made.path)
    examined.warnings = [
        Problem(f"/{place}", "it looks odd", 1, 1, rule=f"odd-{place}") for place in ("bodies", "render")
    ]
    found, _ = made.mending.consider_warnings(attempt, examined, ())
    assert not found.errors
    assert found.text == attempt.text
    return revising.data_of(attempt.text)


def test_a_good_change_stays_and_the_bad_one_beside_it_is_made_again(tmp_path: Path) -> None:
    made, model = team(tmp_path, {"render": [FILM], "bodies": [LOST, SMALL]})
    case = warned(made)
    assert case["render"]["fps"] == 12
    assert case["bodies"]["ball"]["shape"]["radius"] == 0.2
    assert "`desk`" in model.questions("bodies")[1], "the reason"
    assert "place" in model.questions("bodies")[1], "what was changed"
    assert len(model.asked) == 3


def test_a_change_that_is_wrong_twice_is_left_out_and_the_planner_hears_of_it(tmp_path: Path) -> None:
    made, _ = team(tmp_path, {"render": [FILM], "bodies": [LOST, LOST]})
    case = warned(made)
    assert case["render"]["fps"] == 12
    assert "place" not in case["bodies"]["ball"]
    assert "`desk`" in made.workshop.referred[0]


def test_a_foreign_operation_goes_back_in_the_same_conversation_and_leaves_the_others_their_work(
    tmp_path: Path,
) -> None:
    foreign = SMALL.replace("}]", "}, {op: add, path: /scene/substeps, value: 40}]")
    routes = [{"section": name, "instruction": "do it"} for name in ("render", "bodies")]
    decision = Decision.model_validate({"action": "repair", "why": "x", "routes": routes})
    for last, radius in ((SMALL, 0.2), (foreign, 0.1)):
        made, model = team(tmp_path / str(radius), {"render": [FILM], "bodies": [foreign, foreign, last]})
        case = revising.data_of(made.workshop.follow_routes(CASE, decision.routes))
        assert "`/scene/substeps` is not below /bodies" in model.questions("bodies")[1]
        assert (case["render"]["fps"], case["bodies"]["ball"]["shape"]["radius"]) == (12, radius)
    assert "substeps" in made.workshop.referred[0], "the Planner hears what was refused"


def test_before_a_run_the_work_of_one_writer_is_not_lost_with_that_of_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, _ = team(tmp_path, {"render": [FILM], "bodies": [LOST, "patch: []\nwhy: it has to lie there"]})
    routes = [{"section": name, "instruction": "do it"} for name in ("render", "bodies")]
    decision = Decision.model_validate({"action": "repair", "why": "x", "params": {"height": 1.5}, "routes": routes})
    monkeypatch.setattr(made.deciding, "decide", lambda *given, **more: decision)
    attempt = Attempt(1, CASE, "x")
    assert not made._settle_doubts(attempt, examine(CASE, made.path), ["doubt"]).errors
    case = revising.data_of(attempt.text)
    assert (case["params"]["height"], case["render"]["fps"], "pose" in case["bodies"]["ball"]) == (1.5, 12, True)


THIN = """
text2sim: 2
name: cut
scene: {duration: 1.0, dt: 0.002, statics: {floor: {shape: {kind: plane}}}}
bodies:
  dough: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0, 0, 0.06]}}
  knife:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.01]}
    pose: {pos: [0, 0, 0.2]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 100, damping: 10}}
actions: {controls: {down: {kind: drive, joint: knife, position: -0.2}}}
"""


@pytest.mark.parametrize("why", ["a blade is meant to go through", "meant", ""])
def test_an_owner_can_say_of_an_error_of_the_lint_that_it_is_meant(tmp_path: Path, why: str) -> None:
    """The reason waives the rule there, so that the version runs; without one it is refused, as an error."""
    answer = f"patch: []\nwhy: {why}" if why else "patch: []"
    made, model = team(tmp_path, {"bodies": [answer]})
    made.workshop.agreement.names, made.workshop.agreement.contract = (), None
    made.agreement.plan.checks = Fragments()
    attempt = Attempt(1, THIN, "x")
    _, problems = made.mending.check(attempt)
    assert "thin-wall" in model.questions("bodies")[0]
    assert "What is intended is waived" in model.questions("bodies")[0]
    assert (problems == []) == (len(why) > 10)
    assert revising.data_of(attempt.text).get("waive") == ({"thin-wall@bodies.knife": why} if len(why) > 10 else None)


def test_patches_that_need_each_other_are_not_lost_with_a_third() -> None:
    """A domain that the ball would be outside of, and the ball's new place in it; and a body that is not there."""
    domain = {"min": [4, -1, -1], "max": [6, 1, 3]}
    patches = [
        {"section": "scene", "why": "x", "operations": [{"op": "add", "path": "/scene/domain", "value": domain}]},
        {"section": "bodies", "why": "x", "operations": [{"op": "remove", "path": "/bodies/none"}]},
        {"section": "bodies", "why": "x", "operations": [{"op": "replace", "path": "/bodies/ball/pose/pos/0", "value": 5}]},
    ]  # fmt: skip
    text, left_out = revising.with_patches(CASE, patches, PATH, None)
    assert [bool(row) for row in left_out] == [False, True, False]
    assert revising.data_of(text)["bodies"]["ball"]["pose"]["pos"][0] == 5


@pytest.mark.parametrize(
    ("bad", "kept"), [((), "abcd"), (("c",), "abd"), (("a", "c"), "bd"), (tuple("abcd"), "")], ids=str
)
def test_the_most_that_hold(bad: tuple[str, ...], kept: str) -> None:
    """`b` needs `d`."""

    def attempt(few: Any) -> str | None:
        return None if set(few) & set(bad) or ("b" in few and "d" not in few) else "".join(few)

    held = revising.most_that_hold("abcd", attempt)
    assert "".join(sorted(held[0] if held is not None else ())) == kept


def test_a_loop_that_goes_on_without_time_repeats_what_it_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("text2sim.runtime.machine.crowding", lambda: 1.0)
    told: list[list[str]] = []
    give_up = Decision(action="give_up", why="x")
    for left in (8.0, 0.5):
        made = quiet_loop(tmp_path, minutes_left=lambda left=left: left)
        made.workshop.agreement = agreed()[0]
        made.agreement.plan.keeps = ["low"]
        made.deciding.decide = lambda attempt, report, **more: (told.append(list(report.doubts)), give_up)[1]  # type: ignore
        examined = examine(CASE, made.path)
        examined.seconds = 300.0
        made._settle_doubts(Attempt(1, CASE, "x"), examined, [])
    assert len(told) == 2
    assert told[0] == told[1], "otherwise the case would be another, and its run be lost"
