"""Measures, events and expectations whose outcome is certain before the run."""

from pathlib import Path

import pytest
from lint_support import findings

SCENE = """
scene: {duration: 2, statics: {wall: {shape: {kind: box, size: [0.1, 2, 2]}, pose: {pos: [4, 0, 1]}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
  dice:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    place: {on: floor, at: [2, 0]}
    repeat: {kind: line, count: 3, step: [0, 0.3, 0]}
  brick:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    place: {on: floor, at: [2, -3]}
    repeat: {kind: line, count: 4, step: [0.1, 0, 0]}
  shelf: {kind: rigid, shape: {kind: box, size: [0.5, 0.5, 0.1]}, mount: {kind: fixed}, pose: {pos: [-2, 0, 1]}}
  gate:
    kind: rigid
    shape: {kind: box, size: [0.4, 0.05, 0.4]}
    pose: {pos: [-1, 2, 0.5]}
    mount: {kind: hinge, axis: z, anchor: [-0.2, 0, 0], range_deg: [-30, 30], actuator: {stiffness: 300, damping: 60, max_force: 20}}
actions:
  controls:
    launch: {kind: initial_velocity, body: ball, linear: [2, 0, 0]}
    turn: {kind: drive, joint: gate, position: {kind: ramp, to: 0.4, end: 1}}
    hold: {kind: attach, body: "dice[0]", to: "dice[1]"}
    let_go: {kind: release, attach: hold, at: 0.5}
    glue: {kind: bond, of: "brick[0:2]", strength: 1.0e+5}
"""


def script(measure: str = "", event: str = "", expect: str = "") -> str:
    parts = [("measures", f"m: {{{measure}}}" if measure else ""), ("events", event), ("expect", expect)]
    return "actions:\n" + "".join(f"  {key}: {{{text}}}\n" for key, text in parts if text)


def expecting(measure: str, expect: str) -> str:
    return script(measure, expect=f"e: {{measure: m, {expect}}}")


def test_a_difference_says_why_it_is_bounded(tmp_path: Path) -> None:
    scale = """\
bodies:
  pan: {kind: rigid, shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [0, 0, 1]},
    mount: {kind: slider, axis: z, actuator: {stiffness: 1000, damping: 10}}}
actions:
  measures:
    load: {kind: joint_force, of: pan, so_far: max}
    least: {kind: joint_force, of: pan, so_far: min}
    more: {kind: difference, measures: [load, least]}
  expect: {loaded: {measure: more, at: end, above: 5}}
"""
    (found,) = findings(tmp_path, "cannot-hold", scale)
    assert "`load` (no control drives this joint, so its motor gives no force)" in found.message


@pytest.mark.parametrize(
    ("measure", "expect"),
    [
        ("kind: count_in, of: dice, region: {kind: box, min: [0, 0, 0], max: [9, 9, 9]}", "at: end, above: 3"),
        ("kind: tilt, of: ball", "at: end, above: 200"),
        ("kind: tilt, of: dice, stat: count, above: 45", "at: end, equals: 4, tolerance: 0.5"),
        ("kind: tilt, of: dice, stat: sum", "at: end, above: 600"),
        ("kind: speed, of: ball", "during: [0.5, 1], below: -1"),
        ("kind: speed, of: ball", "during: [0.5, 1], stat: max, above: 1500"),
        ("kind: displacement, of: ball", "at: 1, equals: -1, tolerance: 0.1"),
        ("kind: joint_position, of: gate", "at: end, above: 0.8"),
        ("kind: joint_position, of: gate", "at: end, equals: 20, tolerance: 1"),
        ("kind: joint_force, of: gate", "during: [0.5, 1], stat: max, above: 25"),
        ("kind: distance, between: [ball, wall]", "at: end, below: 0"),
        ("kind: joint_position, of: gate", "during: all, stat: period, swing: 0.1, below: 0"),
        ("kind: contact_count, of: ball, by: wall", "during: all, stat: max, above: 1"),
        ("kind: pieces, of: brick", "at: end, below: 1"),  # two of four are bonded
        ("kind: pieces, of: brick", "at: end, above: 4"),
        ("kind: position, of: gate, axis: x", "at: end, above: 0.5"),  # it hangs at x = -1.2
        # By the value at the start.
        ("kind: speed, of: ball", "at: start, above: 2.5"),
        ("kind: speed, of: ball", "at: 0, below: 1.5"),
        ("kind: speed, of: dice, stat: max", "during: all, above: 0.5"),
        ("kind: position, of: ball, axis: z", "during: all, below: 0.9"),
        ("kind: position, of: ball, axis: z", "during: [0, 1], stat: max, below: 0.9"),
        ("kind: position, of: ball, axis: z", "during: [0, 1], stat: min, above: 1.1"),
        ("kind: extent, of: ball, axis: z, stat: max", "at: start, above: 1.2"),
        ("kind: distance, between: [ball, wall]", "at: start, below: 3"),
        ("kind: velocity, of: ball, axis: y", "at: start, above: 1"),
        ("kind: displacement, of: dice, stat: count, above: 0.1", "at: start, above: 0.5"),
        ("kind: joint_position, of: gate", "during: all, above: 0.1"),
        ("kind: joint_velocity, of: gate", "at: start, above: 0.1"),
        ("kind: momentum, of: ball, axis: x", "at: start, above: 50"),
    ],
)
def test_what_cannot_hold(assets: Path, measure: str, expect: str) -> None:
    (found,) = findings(assets, "cannot-hold", SCENE, expecting(measure, expect))
    assert found.severity == "error"
    assert found.path.startswith("/actions/expect/e/")
    assert not findings(assets, "cannot-fail", SCENE, expecting(measure, expect))


@pytest.mark.parametrize(
    ("measure", "expect"),
    [
        ("kind: count_in, of: dice, region: {kind: box, min: [0, 0, 0], max: [9, 9, 9]}", "at: end, below: 3.5"),
        ("kind: tilt, of: ball", "at: end, below: 181"),
        ("kind: speed, of: ball", "at: end, above: -0.1"),
        ("kind: speed, of: ball", "at: end, equals: 0, tolerance: 2000"),
        ("kind: displacement, of: ball", "at: end, above: -1"),
        ("kind: penetration, of: ball", "during: all, above: -0.001"),
        ("kind: position, of: gate, axis: x", "at: end, below: 3"),
        ("kind: joint_force, of: gate", "during: all, below: 25"),
        ("kind: joint_position, of: gate", "during: all, stat: reversals, swing: 0.1, above: -1"),
        # By the value at the start.
        ("kind: speed, of: ball", "at: start, above: 1.9"),
        ("kind: position, of: ball, axis: z", "during: all, stat: max, above: 0.9"),
        ("kind: position, of: ball, axis: z", "during: [0, 0.5], stat: min, below: 1.1"),
        ("kind: joint_position, of: gate", "at: start, equals: 0, tolerance: 0.1"),
    ],
)
def test_what_cannot_fail(assets: Path, measure: str, expect: str) -> None:
    (found,) = findings(assets, "cannot-fail", SCENE, expecting(measure, expect))
    assert found.severity == "warning"
    assert found.message.startswith("`m` always satisfies `e`, which therefore tests nothing: ")
    assert found.message.count(": ") == 1
    assert not findings(assets, "cannot-hold", SCENE, expecting(measure, expect))


@pytest.mark.parametrize(
    ("measure", "expect"),
    [
        ("kind: count_in, of: dice, region: {kind: box, min: [0, 0, 0], max: [9, 9, 9]}", "at: end, above: 2.5"),
        ("kind: speed, of: ball", "at: end, above: 0"),
        ("kind: speed, of: dice, stat: max", "during: [0.2, 1], above: 0.5"),
        ("kind: speed, of: dice, stat: max", "during: all, stat: max, above: 0.5"),
        ("kind: position, of: ball, axis: z", "during: all, above: 0.05"),
        ("kind: position, of: ball, axis: z", "during: all, stat: min, above: 0.05, below: 0.2"),
        ("kind: position, of: ball, axis: z", "during: all, stat: range, above: 0.2"),
        ("kind: position, of: ball, axis: z", "during: all, stat: mean, below: 0.9"),
        ("kind: position, of: ball, axis: z", "during: all, stat: change, below: -0.2"),
        ("kind: position, of: ball, axis: z", "at: start, above: 1"),  # to the last digit: nothing is said
        ("kind: joint_position, of: gate", "at: end, equals: 0.4, tolerance: 0.05"),
        ("kind: joint_position, of: gate", "during: all, below: 0.53"),  # its limit is 0.5236, and soft
        ("kind: joint_force, of: gate", "during: all, below: 10"),
        ("kind: contact_force, of: ball", "during: all, stat: max, above: 5"),
        ("kind: contact_force, of: ball, axis: x", "during: all, below: 0"),
        ("kind: energy, of: ball", "at: end, below: 1"),
        ("kind: tilt, of: dice, stat: max", "at: end, above: 45"),
        ("kind: joint_position, of: gate", "during: all, stat: reversals, swing: 0.1, above: 5"),
        ("kind: pieces, of: brick", "at: end, equals: 3, tolerance: 0.1"),
        ("kind: joint_position, of: gate", "during: all, stat: decrement, swing: 0.1, below: 0.1"),
    ],
)
def test_what_may_go_either_way(assets: Path, measure: str, expect: str) -> None:
    for rule in ("cannot-hold", "cannot-fail", "dead-measure"):
        assert not findings(assets, rule, SCENE, expecting(measure, expect))


ARM = """
bodies:
  arm:
    kind: articulated
    pose: {pos: [0, -3, 0.5]}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      hand:
        parent: base
        shape: {kind: box, size: [0.1, 0.1, 0.1]}
        pose: {pos: [0.3, 0, 0]}
        joint: {kind: hinge, axis: y, anchor: [-0.3, 0, 0], actuator: {stiffness: 500, damping: 50}}
"""
WATER = "bodies: {water: {kind: liquid, shape: {kind: box, size: [1, 1, 0.3]}, pose: {pos: [-2, 0, 2]}}}"


@pytest.mark.parametrize(
    ("measure", "dead"),
    [
        ("kind: displacement, of: shelf", True),
        ("kind: speed, of: shelf", True),
        ("kind: contact_force, of: shelf", False),
        ("kind: position, of: wall, axis: x", False),  # of a static: may stand for a reference
        ("kind: distance, between: [shelf, wall]", True),
        ("kind: distance, between: [shelf, ball]", False),
        ("kind: displacement, of: [shelf, arm.base], stat: max", True),
        ("kind: displacement, of: [shelf, ball], stat: max", False),
        ("kind: tilt, of: arm", True),
        ("kind: displacement, of: arm.base", True),
        ("kind: displacement, of: arm.hand", False),
        ("kind: speed, of: arm", False),  # of the common centre of mass
        ("kind: extent, of: arm, axis: z, stat: max", False),
        ("kind: joint_force, of: arm.hand", True),
        ("kind: joint_force, of: gate", False),
        ("kind: joint_position, of: arm.hand", False),
        ("kind: submerged, of: shelf, by: water", False),  # the water moves
    ],
)
def test_measures_of_what_never_moves(assets: Path, measure: str, dead: bool) -> None:
    layers = [SCENE, ARM, *([WATER] if "water" in measure else []), script(measure)]
    assert bool(findings(assets, "dead-measure", *layers)) == dead


@pytest.mark.parametrize(
    ("event", "says"),
    [
        ("kind: contact, between: [gate, wall]", " apart"),
        ("kind: contact, between: [gate, ball]", ""),
        ("kind: contact, between: [arm.hand, shelf]", " apart"),
        ("kind: contact, between: [arm.hand, arm.base]", "pass through each other"),
        ("kind: separation, between: [ball, floor], for: 3", "3 s without contact"),
        ("kind: rest, of: ball, for: 2.5", "2.5 s of rest"),
        ("kind: rest, of: ball, for: 1.5", ""),
        ("kind: enters, of: arm.hand, region: {kind: sphere, center: [3, 0, 0], radius: 0.5}", "let it neither"),
        ("kind: enters, of: arm.hand, region: {kind: sphere, center: [0, -3, 0.3], radius: 0.1}", ""),
        ("kind: enters, of: ball, region: {kind: sphere, center: [3, 0, 0], radius: 0.5}", ""),
        ("kind: enters, of: [arm.hand, ball], region: {kind: sphere, center: [3, 0, 0], radius: 0.5}", ""),
        ("kind: threshold, measure: m, above: 190", "is never above 190"),
        ("kind: threshold, measure: m, below: -1", "is never below -1"),
        ("kind: threshold, measure: m, above: -1", "is always above -1"),
        ("kind: threshold, measure: m, above: 90", ""),
    ],
)
def test_events_that_never_happen(assets: Path, event: str, says: str) -> None:
    found = findings(assets, "dead-event", SCENE, ARM, script("kind: tilt, of: ball", f"v: {{{event}}}"))
    assert bool(found) == bool(says), found
    assert all(says in problem.message and problem.severity == "warning" for problem in found)
    wanted = script("kind: tilt, of: ball", f"v: {{{event}}}", "e: {event: v}")
    assert [p.severity for p in findings(assets, "dead-event", SCENE, ARM, wanted)] == (["error"] if says else [])
    never = script("kind: tilt, of: ball", f"v: {{{event}}}", "e: {event: v, never: true}")
    assert [p.severity for p in findings(assets, "dead-event", SCENE, ARM, never)] == (["warning"] if says else [])


LET_GO = "gone: {kind: released, attach: hold}"


@pytest.mark.parametrize(
    ("event", "expect", "rule"),
    [
        (LET_GO, "e: {event: gone, within: [0.6, 1]}", "cannot-hold"),
        (LET_GO, "e: {event: gone, never: true}", "cannot-hold"),
        (LET_GO, "e: {event: gone, count: 2}", "cannot-hold"),
        (LET_GO, "e: {event: gone, within: [0.4, 1]}", "cannot-fail"),
        (LET_GO + ", hit: {kind: contact, between: [ball, wall]}", "e: {event: gone, before: hit}", ""),
        (
            LET_GO + ", hit: {kind: contact, between: [ball, wall], after: gone}",
            "e: {event: hit, within: [0, 0.4]}",
            "cannot-hold",
        ),
        (
            LET_GO + ", hit: {kind: contact, between: [ball, wall], after: gone}",
            "e: {event: hit, within: [0, 0.9]}",
            "",
        ),
        ("hit: {kind: contact, between: [ball, wall]}", "e: {event: hit, count: [0, 1000000]}", "cannot-fail"),
        ("hit: {kind: contact, between: [ball, wall]}", "e: {event: hit, count: [0, 3]}", ""),
    ],
)
def test_events_of_which_the_time_is_known(assets: Path, event: str, expect: str, rule: str) -> None:
    case = script(event=event, expect=expect)
    assert [r for r in ("cannot-hold", "cannot-fail") if findings(assets, r, SCENE, case)] == ([rule] if rule else [])


HIT = "hit: {kind: contact, between: [ball, wall]}, fall: {kind: contact, between: [ball, floor]}"
TWO = "measures: {m: {kind: position, of: ball, axis: z}}"


@pytest.mark.parametrize(
    ("expect", "wanted"),
    [
        ("a: {measure: m, at: 1, above: 2}, b: {measure: m, at: 1, below: 1.5}", True),
        ("a: {measure: m, at: 1, above: 2}, b: {measure: m, at: 1.1, below: 1.5}", False),
        ("a: {measure: m, during: [0.5, 1.5], above: 2}, b: {measure: m, at: 1.2, below: 1.5}", True),
        ("a: {measure: m, during: [0.5, 1], above: 2}, b: {measure: m, during: [1.5, 2], below: 1.5}", False),
        (
            "a: {measure: m, during: [0.5, 1.5], below: 2}, b: {measure: m, during: [0.6, 1], stat: max, above: 2.5}",
            True,
        ),
        (
            "a: {measure: m, during: [0.7, 1.5], below: 2}, b: {measure: m, during: [0.6, 1], stat: max, above: 2.5}",
            False,
        ),
        ("a: {measure: m, at: 0.8, above: 2}, b: {measure: m, during: [0.6, 1], stat: max, below: 1.5}", True),
        ("a: {measure: m, at: 0.8, above: 2}, b: {measure: m, during: [0.6, 1], stat: min, below: 1.5}", False),
        (
            "a: {measure: m, during: all, stat: mean, above: 2}, b: {measure: m, during: all, stat: mean, below: 1}",
            True,
        ),
        (
            "a: {measure: m, during: [1, 2], above: 0, below: 0.1}, b: {measure: m, during: [1, 2], stat: range, above: 0.2}",
            True,
        ),
        (
            "a: {measure: m, during: all, above: 1, below: 1.2}, b: {measure: m, during: [1, 2], stat: change, below: -0.3}",
            True,
        ),
        (
            "a: {measure: m, during: all, above: 1, below: 2}, b: {measure: m, during: [1, 2], stat: change, below: -0.3}",
            False,
        ),
        ("a: {measure: m, at: 1, above: 1}, b: {measure: m, at: 1, below: 1.5}", False),
        ("a: {event: hit, never: true}, b: {event: hit, within: [0, 1]}", True),
        ("a: {event: hit, never: true, within: [0, 0.5]}, b: {event: hit, within: [0.4, 1]}", False),
        ("a: {event: hit, within: [0, 0.5]}, b: {event: hit, within: [0.6, 1]}", True),
        ("a: {event: hit, count: 2}, b: {event: hit, count: [3, 4]}", True),
        ("a: {event: hit, count: 2}, b: {event: hit, within: [0.6, 1]}", False),
        ("a: {event: hit, within: [1, 2], before: fall}, b: {event: fall, within: [0, 0.8]}", True),
        ("a: {event: hit, within: [0.5, 2], before: fall}, b: {event: fall, within: [0, 0.8]}", False),
        ("a: {event: hit, before: fall}, b: {event: fall, never: true}", True),
        ("a: {event: hit, before: fall}, b: {event: fall, before: hit}", True),
    ],
)
def test_expectations_of_which_only_one_can_hold(assets: Path, expect: str, wanted: bool) -> None:
    case = f"actions: {{{TWO}, events: {{{HIT}}}, expect: {{{expect}}}}}"
    assert bool(findings(assets, "contradiction", SCENE, case)) == wanted


def test_an_event_that_is_looked_for_after_another_never_comes_before_it(assets: Path) -> None:
    events = HIT.replace("[ball, wall]}", "[ball, wall], after: fall}", 1)
    case = f"actions: {{events: {{{events}}}, expect: {{a: {{event: hit, before: fall}}}}}}"
    assert findings(assets, "contradiction", SCENE, case)


@pytest.mark.parametrize(
    ("post", "more", "meets"),
    [
        (0.55, "", True),  # its face is at 0.5, and the cart's comes to 0.55
        (0.9, "", False),
        (-0.9, "", False),
        (0.9, "bodies: {rail: {initial: {cart: 0.4}}}", False),  # the same place, counted from elsewhere
        (0.9, "bodies: {rail: {links: {cart: {joint: {range: null}}}}}", True),
        (0.9, "actions: {controls: {w: {kind: attach, body: ball, to: rail.cart}}}", True),  # welds give way
    ],
)
def test_how_far_a_slider_gets(assets: Path, post: float, more: str, meets: bool) -> None:
    rail = f"""
scene: {{statics: {{post: {{shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, pose: {{pos: [{post}, -3, 0.5]}}}}}}}}
bodies:
  rail:
    kind: articulated
    pose: {{pos: [0, -3, 0.5]}}
    links:
      base: {{shape: {{kind: sphere, radius: 0.02}}}}
      cart:
        parent: base
        shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
        joint: {{kind: slider, axis: x, range: [-0.3, 0.5]}}
actions: {{events: {{hit: {{kind: contact, between: [rail.cart, post]}}}}}}
"""
    parts = [SCENE, rail, *([more] if more else [])]
    assert bool(findings(assets, "dead-event", *parts)) != meets


@pytest.mark.parametrize(
    ("rule", "expects"),
    [
        ("contradiction", "a: {measure: m, at: 0.5, above: 2}, b: {measure: m, on: hit, at: 0.5, below: 1}"),
        ("contradiction", "a: {event: fall, on: hit, within: [0, 0.4]}, b: {event: fall, within: [1, 2]}"),
        ("cannot-hold", "a: {measure: m, on: hit, during: [0, end], above: 1.5}"),
    ],
)
def test_when_times_count_from_an_event_is_not_known(tmp_path: Path, rule: str, expects: str) -> None:
    words = "events: {hit: {kind: contact, between: [ball, wall]}, fall: {kind: contact, between: [ball, floor]}}"
    case = f"actions:\n  measures: {{m: {{kind: position, of: ball, axis: z}}}}\n  {words}\n  expect: {{{expects}}}\n"
    assert findings(tmp_path, rule, SCENE, case) == []
    assert findings(tmp_path, rule, SCENE, case.replace("on: hit, ", ""))
