"""A case whose form is wrong in places: the references of the rest are checked all the same."""

import pytest
from small_case import only_problem, problems_of

CASE = """\
text2sim: 2
name: broken
params: {{speed: 3}}
scene: {{duration: {duration}, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: {radius}}}, place: {{on: {on}}}}}
  drum:
    kind: rigid
    shape: {{kind: box, size: [1, 1, 1]}}
    mount: {{kind: hinge, axis: y, {actuator}}}
    pose: {{pos: [0, 0, 3]}}
actions:
  controls:
    push: {{kind: force, body: {body}, force: {force}}}
    turn: {{kind: drive, joint: drum, velocity: 1}}
  measures:
    height: {{kind: {kind}, of: ball, axis: z}}
  events:
    hit: {{kind: contact, between: [ball, {other}]}}
  expect:
    comes: {{event: {event}}}
    high: {{measure: height, at: end, above: 1}}
"""
SOUND = {
    "duration": "2",
    "radius": "0.1",
    "on": "floor",
    "actuator": "actuator: {damping: 5}",
    "body": "ball",
    "force": "[1, 0, 0]",
    "kind": "position",
    "other": "floor",
    "event": "hit",
}


def found(**edits: str) -> list[tuple[str, str]]:
    """Rule and place of all that is wrong."""
    return [(problem.rule, problem.path) for problem in problems_of(CASE.format(**(SOUND | edits)))]


PLACE, BODY, EVENT = "/bodies/ball/place/on", "/actions/controls/push/body", "/actions/expect/comes/event"


@pytest.mark.parametrize(
    ("edits", "form", "references"),
    [
        # A wrong value somewhere else hides no wrong name.
        ({"radius": "-1", "event": "hti"}, "/bodies/ball/shape/radius", [EVENT]),
        ({"radius": "-1", "body": "bal", "other": "flor"}, "/bodies/ball/shape/radius", [BODY, "/actions/events/hit/between/1"]),
        ({"radius": "${speed / 0}", "event": "hti"}, "/bodies/ball/shape/radius", [EVENT]),
        ({"duration": "-2", "event": "hti"}, "/scene/duration", [EVENT]),
        ({"kind": "hight", "event": "hti"}, "/actions/measures/height/kind", [EVENT]),
        # Not even in the same entry.
        ({"radius": "-1", "on": "flor"}, "/bodies/ball/shape/radius", [PLACE]),
        ({"force": "[1, 0]", "body": "bal"}, "/actions/controls/push/force", []),
        ({"force": "[1, 0, 0], durin: [0, 1]", "body": "bal"}, "/actions/controls/push/durin", [BODY]),
        # What refers to something wrong is not blamed for it.
        ({"kind": "hight"}, "/actions/measures/height/kind", []),
        ({"actuator": "actuator: {damping: much}"}, "/bodies/drum/mount/actuator/damping", []),
        ({"radius": "-1"}, "/bodies/ball/shape/radius", []),
    ],
)  # fmt: skip
def test_names_are_looked_at_beside_wrong_values(edits: dict[str, str], form: str, references: list[str]) -> None:
    problems = found(**edits)
    assert [path for rule, path in problems if not rule.startswith("unknown-") or path == form] == [form]
    assert [path for rule, path in problems if path != form] == references


@pytest.mark.parametrize("text", ["scene: 5", "scene: {duration: 1, statics: 3}\nbodies: {a: 1}", "bodies: []", "a: 1"])
def test_what_cannot_be_mended_is_left(text: str) -> None:
    problems = problems_of(f"text2sim: 2\nname: a\n{text}\n")
    assert problems
    assert not any(problem.rule == "unknown-body" for problem in problems)


def test_a_release_that_is_wrong_may_be_the_one_that_an_event_waits_for() -> None:
    controls = "    hold: {kind: attach, body: ball, to: drum}\n    let_go: {kind: release, attach: hold}\n"
    text = CASE.format(**SOUND).replace("  controls:\n", "  controls:\n" + controls)
    text = text.replace("  events:\n", "  events:\n    freed: {kind: released, attach: hold}\n")
    assert only_problem(text).path == "/actions/controls/let_go"
