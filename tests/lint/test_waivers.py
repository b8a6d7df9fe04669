"""Waivers: waived problems are listed with their reasons, and useless waivers are reported."""

from pathlib import Path

from lint_support import report_on

from text2sim.lint import waiver_of

SUNK = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, -0.3]}}}"
REASON = "it is to fall for ever as this is about that"


def test_an_error_that_is_waived_does_not_stop_a_run(tmp_path: Path) -> None:
    assert not report_on(tmp_path, SUNK).ok
    report = report_on(tmp_path, SUNK, f"waive: {{under-floor: {REASON}}}")
    assert report.ok
    (waived,) = report.waived
    assert (waived.problem.rule, waived.problem.path, waived.reason) == ("under-floor", "/bodies/ball/pose", REASON)
    assert waived.as_dict()["reason"] == REASON
    assert waived.as_dict()["severity"] == "error"


def test_a_waiver_of_one_place_leaves_the_others(tmp_path: Path) -> None:
    two = (
        "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, -0.3]}}, "
        "ball_2: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, -0.3]}}}"
    )
    for place in ("bodies.ball", "bodies.ball.pose"):
        report = report_on(tmp_path, two, f"waive: {{under-floor@{place}: {REASON}}}")
        assert [one.problem.path for one in report.waived] == ["/bodies/ball/pose"]
        assert [one.path for one in report.problems if one.rule == "under-floor"] == ["/bodies/ball_2/pose"]
        assert waiver_of(report.waived[0].problem) == "under-floor@bodies.ball"
    report = report_on(tmp_path, two, f"waive: {{under-floor: all of {REASON}, under-floor@bodies.ball: {REASON}}}")
    assert [one.reason for one in report.waived] == [REASON, f"all of {REASON}"], "the nearer reason counts"
    assert not [one for one in report.problems if one.rule == "unused-waiver"]


def test_a_waiver_of_a_place_without_findings_and_of_no_rule(tmp_path: Path) -> None:
    report = report_on(tmp_path, SUNK, f"waive: {{under-floor@bodies.bal: {REASON}, under-flor@bodies.ball: {REASON}}}")
    found = {problem.path: problem for problem in report.problems if problem.path.startswith("/waive")}
    assert "reports nothing at `bodies.bal`" in found["/waive/under-floor@bodies.bal"].message
    assert found["/waive/under-flor@bodies.ball"].hint == "under-floor"
    assert not report.ok


def test_a_rule_that_does_not_exist(tmp_path: Path) -> None:
    problems = report_on(tmp_path, SUNK, f"waive: {{under-flor: {REASON}}}").problems
    (found,) = (problem for problem in problems if problem.rule == "unknown-rule")
    assert (found.path, found.severity, found.hint) == ("/waive/under-flor", "error", "under-floor")
    assert any(problem.rule == "under-floor" for problem in problems), "a slip waives nothing"


def test_a_waiver_that_finds_nothing(tmp_path: Path) -> None:
    report = report_on(tmp_path, SUNK, f"waive: {{under-floor: {REASON}, overlap: {REASON}}}")
    (found,) = (problem for problem in report.problems if problem.rule == "unused-waiver")
    assert (found.path, found.severity) == ("/waive/overlap", "warning")


def test_warnings_of_earlier_stages_can_be_waived(tmp_path: Path) -> None:
    late = "scene: {statics: {floor: {shape: {kind: plane}}}}\nbodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor}}}\n"
    push = "actions: {controls: {push: {kind: force, body: ball, force: [1, 0, 0], during: [5, 6]}}}"
    assert "after-end" in {problem.rule for problem in report_on(tmp_path, late, push).problems}
    report = report_on(tmp_path, late, push, f"waive: {{after-end: {REASON}}}")
    assert "after-end" not in {problem.rule for problem in report.problems}
    assert [one.problem.rule for one in report.waived] == ["after-end"]


def test_a_waiver_of_a_rule_that_there_was_is_only_idle(tmp_path: Path) -> None:
    report = report_on(tmp_path, SUNK, f"waive: {{under-floor: {REASON}, weak-press: {REASON}}}")
    (found,) = (problem for problem in report.problems if problem.path == "/waive/weak-press")
    assert (found.rule, found.severity) == ("unused-waiver", "warning")
