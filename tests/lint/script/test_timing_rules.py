"""Expectations that come too soon, or hold if nothing moves."""

from pathlib import Path

import pytest
from lint_support import findings

THROW = """
scene: {duration: 3, statics: {wall: {shape: {kind: box, size: [0.1, 2, 2]}, pose: {pos: [4, 0, 1]}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 1}, pose: {pos: [0, 0, 1.1]}}
actions:
  controls: {throw: {kind: initial_velocity, body: ball, linear: [4, 0, 0]}}
  measures: {x: {kind: position, of: ball, axis: x}, z: {kind: position, of: ball, axis: z}, v: {kind: speed, of: ball}}
  events: {hit: {kind: contact, between: [ball, wall]}, in: {kind: enters, of: ball, region: {kind: sphere, center: [9, 0, 1], radius: 1}},
    far: {kind: threshold, measure: x, above: 4}, left: {kind: threshold, measure: x, below: -1},
    back: {kind: threshold, measure: x, below: 1}, quick: {kind: threshold, measure: v, above: 40}}
"""
MOTOR = """
bodies:
  cart:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    pose: {pos: [0, 3, 1]}
    mount: {kind: slider, axis: x, actuator: {stiffness: 900, damping: 60}}
actions: {controls: {push: {kind: drive, joint: cart, position: {kind: ramp, to: 0.5, end: 1}}}}
"""


def expecting(expect: str) -> str:
    return f"actions: {{expect: {{e: {{{expect}}}}}}}"


@pytest.mark.parametrize(
    ("expect", "wanted"),
    [
        # 3.85 m at 4 m/s take about a second; what is certain is 2 v t + g t2, which is 0.36 s.
        ("event: hit, within: [0, 0.3]", True),
        ("event: hit, within: [0, 0.5]", False),
        ("event: hit, within: [0, 0.3], count: 0", False),
        ("event: hit, never: true, within: [0, 0.3]", False),
        ("event: in, within: [0, 0.4]", True),
        ("event: in, within: [0, 1.9]", False),
        ("event: far, within: [0, 0.3]", True),
        ("event: far, within: [0, 1.2]", False),
        ("event: left, within: [0, 0.1]", True),
        ("event: back, within: [0, 0.1]", False),  # it may leave first
        ("event: quick, within: [0, 0.1]", False),  # a speed is no distance
        ("measure: x, at: 0.3, above: 4", True),
        ("measure: x, at: 1.2, above: 4", False),
        ("measure: x, during: [0, 0.3], stat: max, above: 4", True),
        ("measure: x, during: [0, 0.3], stat: min, below: -4", True),
        ("measure: x, during: [0, 2], stat: max, above: 4", False),
        ("measure: x, during: [0.3, 2], above: 4", True),
    ],
)
def test_what_comes_too_soon(assets: Path, expect: str, wanted: bool) -> None:
    assert bool(findings(assets, "too-soon", THROW, expecting(expect))) == wanted
    assert not findings(assets, "too-soon", THROW, MOTOR, expecting(expect))  # a motor may throw anything


@pytest.mark.parametrize(
    ("expect", "wanted"),
    [
        ("a: {measure: z, during: all, above: -1}", True),
        ("a: {measure: v, at: end, below: 0.5}", True),
        ("a: {measure: v, at: end, below: 0.5}, b: {event: hit, never: true}", True),
        ("a: {measure: z, during: all, above: -1}, b: {event: hit, within: [0.5, 2]}", False),
        ("a: {measure: z, at: end, below: 0.5}", False),
        ("a: {event: hit}", False),
    ],
)
def test_what_holds_if_nothing_moves(assets: Path, expect: str, wanted: bool) -> None:
    case = f"actions: {{expect: {{{expect}}}}}"
    assert bool(findings(assets, "passes-at-rest", THROW, case)) == wanted


def test_a_tower_may_stand_still(assets: Path) -> None:
    tower = """
bodies:
  block:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    place: {on: floor}
    repeat: {kind: stack, count: 5}
actions:
  measures: {lean: {kind: tilt, of: block, stat: max}}
  expect: {stands: {measure: lean, during: all, below: 1}}
"""
    assert not findings(assets, "passes-at-rest", tower)
    in_the_air = "bodies: {block: {place: null, pose: {pos: [0, 0, 1]}}}"
    assert findings(assets, "passes-at-rest", tower, in_the_air)


def test_a_case_without_expectations_is_not_named(assets: Path) -> None:
    assert not findings(assets, "passes-at-rest", THROW)


def test_a_drive_after_the_end(assets: Path) -> None:
    late = "actions: {controls: {push: {position: {kind: ramp, to: 0.5, start: 4, end: 5}}}}"
    assert findings(assets, "after-end", MOTOR, late)
    (unfinished,) = findings(assets, "after-end", MOTOR, late, "scene: {duration: 4.5}")
    assert "gets to its last value at 5 s, after the end of the run (4.5 s)" in unfinished.message
    assert not findings(assets, "after-end", MOTOR, late, "scene: {duration: 5}")


def test_where_a_region_is_carried_to_nobody_knows(assets: Path) -> None:
    early = expecting("event: in, within: [0, 0.4]")
    held = "bodies: {ball: {mount: {kind: hinge, axis: z}}}\nactions: {controls: null}"
    carried = "actions: {events: {in: {region: {moves_with: wall}}}}"
    assert findings(assets, "too-soon", THROW, early)
    assert not findings(assets, "too-soon", THROW, early, carried)
    dead = [[one.path for one in findings(assets, "dead-event", THROW, held, more)] for more in ("bodies: {}", carried)]
    assert ["/actions/events/in" in paths for paths in dead] == [True, False]
