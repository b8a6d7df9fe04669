"""Events whose condition holds when the run begins, and expectations that would hold if nothing moved."""

import pytest
from lint_support import facts_of, findings, report_on

from text2sim.lint.script.at_rest import beginning
from text2sim.lint.script.event_bounds import _BOUNDS_BY_KIND
from text2sim.lint.script.events_at_start import _TRUE_AT_START
from text2sim.spec_schema.models.events import Event
from text2sim.spec_schema.published.language_reference import section_kinds

CASE = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, %s]}}
  post: {kind: rigid, shape: {kind: cylinder, radius: 0.1, height: 0.4}, place: {on: floor, at: [0.5, 0]}}
  stool:
    kind: rigid
    shape: {kind: compound, parts: {leg: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}}}
    place: {on: floor, at: [-0.5, 0]}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  events:
    it: %s
    other: {kind: contact, between: [ball, post]}
  expect:
    it_comes: {event: it}
    stays: {measure: height, during: all, above: 0}
    lands: {measure: height, at: end, below: 0.11}
"""


@pytest.mark.parametrize(
    ("height", "event", "said"),
    [
        ("0.1", "{kind: contact, between: [ball, floor]}", "touch from the start"),
        ("0.1", "{kind: contact, between: [stool.leg, floor]}", ""),
        ("0.11", "{kind: contact, between: [ball, floor]}", ""),
        ("0.1", "{kind: contact, between: [ball, floor], after: other}", ""),
        ("0.2", "{kind: contact, between: [ball, post]}", ""),
        ("1", "{kind: threshold, measure: height, above: 0.5}", "is 1 m at the start, already above 0.5 m"),
        ("1", "{kind: threshold, measure: height, above: 1.5}", ""),
        ("1", "{kind: threshold, measure: height, below: 1.5}", "already below 1.5 m"),
        (
            "1",
            "{kind: enters, of: ball, region: {kind: sphere, center: [0, 0, 1], radius: 0.3}}",
            "enters it only after",
        ),
        ("1", "{kind: leaves, of: ball, region: {kind: sphere, center: [0, 0, 1], radius: 0.3}}", ""),
        (
            "1",
            "{kind: leaves, of: ball, region: {kind: sphere, center: [0, 0, 2], radius: 0.3}}",
            "leaves it only after",
        ),
        ("0.1", "{kind: rest, of: post}", "is at rest from the start"),
        ("0.5", "{kind: rest, of: post}", ""),
        ("0.1", "{kind: rest, of: [post, ball]}", "`post`, `ball` are at rest from the start"),
        (
            "1",
            "{kind: leaves, of: [ball, post], region: {kind: sphere, center: [0, 0, 2], radius: 0.3}}",
            "`ball`, `post` are outside the region at the start",
        ),
        ("1", "{kind: leaves, of: [ball, post], region: {kind: sphere, center: [0, 0, 1], radius: 0.3}}", ""),
    ],
)
def test_an_event_that_is_true_at_the_start(tmp_path, height, event, said):
    found = findings(tmp_path, "true-at-start", CASE % (height, event))
    assert [problem.path for problem in found] == ["/actions/events/it"] * bool(said)
    assert all(said in problem.message for problem in found)


@pytest.mark.parametrize(("bound", "doubted"), [("above: 1.5", False), ("above: 0.5", True), ("below: 0.2", True)])
def test_a_threshold_to_which_a_measure_returns_is_meant(tmp_path, bound, doubted):
    low = "{kind: threshold, measure: height, below: 1.2}"
    case = CASE % ("1", low) + "    high_comes: {event: high}\n"
    case = case.replace("    other:", f"    high: {{kind: threshold, measure: height, {bound}}}\n    other:")
    paths = [problem.path for problem in findings(tmp_path, "true-at-start", case)]
    assert ("/actions/events/it" in paths) == doubted


def test_expectations_that_are_true_at_the_start_are_named(tmp_path):
    event = "{kind: threshold, measure: height, below: 0.5}"
    assert report_on(tmp_path, CASE % ("1", event)).held == ["stays"]
    assert report_on(tmp_path, CASE % ("0.1", event)).held == ["stays", "lands"]


@pytest.mark.parametrize(
    ("table", "apart"),
    [
        (_BOUNDS_BY_KIND, {"broken", "joint_limit"}),
        (_TRUE_AT_START, {"broken", "joint_limit", "left_domain", "released", "removed", "separation"}),
    ],
    ids=["event_bounds.py", "events_at_start.py"],
)
def test_every_kind_of_event_is_judged_or_set_apart(table, apart):
    assert {*table, *apart} ^ {*section_kinds(Event)} == set(), "a row in the table, or set apart here"


@pytest.mark.parametrize(
    ("controls", "begins"),
    [
        ("{kick: {kind: impulse, body: ball, impulse: [1, 0, 0], at: 0.8}}", 0.8),
        ("{hold: {kind: attach, body: ball, to: floor}, free: {kind: release, attach: hold, at: 0.6}}", 0.6),
        (
            "{push: {kind: force, body: ball, force: [1, 0, 0], during: [0.5, 1]}, k: {kind: remove, body: post, on: other}}",
            0.5,
        ),
        ("{throw: {kind: initial_velocity, body: ball, linear: [1, 0, 0]}}", 0.0),
        ("{push: {kind: force, body: ball, force: [1, 0, 0]}}", 0.0),
    ],
)
def test_before_the_first_control_nothing_happens(controls, begins):
    case = CASE.replace("actions:\n", f"actions:\n  controls: {controls}\n")
    event = "{kind: rest, of: post}"
    assert beginning(facts_of(case % ("0.1", event))) == begins
    assert beginning(facts_of(case % ("1", event))) == 0.0, "it falls from the start"
