"""Expectations before the first cause of motion: impulses, forces, drives and driven bodies."""

from pathlib import Path

import pytest
from lint_support import facts_of, findings

from text2sim.lint.motion.initial_rest import all_still

BALL = """
scene: {duration: 4, statics: {wall: {shape: {kind: box, size: [0.1, 2, 2]}, pose: {pos: [2, 0, 1]}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 1}, place: {on: floor}}
actions:
  measures: {x: {kind: position, of: ball, axis: x}, shift: {kind: displacement, of: ball}}
  events: {hit: {kind: contact, between: [ball, wall]}, in: {kind: enters, of: ball, region: {kind: sphere, center: [1, 0, 0], radius: 0.2}}}
"""
KICK = "actions: {controls: {kick: {kind: impulse, body: ball, impulse: [3, 0, 0], at: 1}}}"
PUSH = "actions: {controls: {push: {kind: force, body: ball, force: [1, 0, 0], during: [1, 3]}}}"
RAM = """
bodies:
  ram:
    kind: driven
    shape: {kind: box, size: [0.1, 0.5, 0.5]}
    pose: {pos: [-0.3, 0, 0.4]}
    motion: {kind: waypoints, times: [0, 1, 2], positions: [[0, 0, 0], [0, 0, 0], [1, 0, 0]]}
"""
CART = """
bodies:
  cart:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.5, 0.5]}
    pose: {pos: [-0.3, 0, 0.4]}
    mount: {kind: slider, axis: x, actuator: {stiffness: 900, damping: 60}}
actions: {controls: {drive: {kind: drive, joint: cart, position: {kind: ramp, to: 1, start: 1, end: 2}}}}
"""


def expecting(expect: str) -> str:
    return f"actions: {{expect: {{e: {{{expect}}}}}}}"


@pytest.mark.parametrize("act", [KICK, PUSH, RAM, CART])
def test_nothing_happens_before_the_first_cause(assets: Path, act: str) -> None:
    name = next(name for name in ("kick", "push", "ram", "drive") if f"{name}:" in act)
    for early in ("event: hit, within: [0, 0.9]", "event: in, within: [0.5, 1]", "measure: x, at: 0.8, above: 0.5"):
        (found,) = findings(assets, "too-soon", BALL, act, expecting(early))
        assert f"everything is at rest: `{name}` acts first, at 1 s" in found.message
    for late in ("event: hit, within: [0, 3]", "event: hit, within: [2, 3]", "measure: x, at: 0.8, below: 0.5"):
        assert findings(assets, "too-soon", BALL, act, expecting(late)) == []


@pytest.mark.parametrize(
    ("act", "expect", "wanted"),
    [
        # A ball of 1 kg gets 3 m/s at 1 s: 2 x 3 t + 9.81 t2 = 1.85 m at t = 0.23 s.
        (KICK, "event: hit, within: [0, 1.2]", True),
        (KICK, "event: hit, within: [0, 1.25]", False),
        # Off its middle, its far side may be four times as fast: 0.075 s.
        (KICK.replace("at: 1", "at: 1, point: [0, 0, 0.1]"), "event: hit, within: [0, 1.2]", False),
        (KICK.replace("at: 1", "at: 1, point: [0, 0, 0.1]"), "event: hit, within: [0, 1.06]", True),
        # A force of 1 N gives 0.4 m/s in 0.4 s; without gravity that is at most 0.32 m.
        (PUSH, "measure: x, at: 1.4, above: 4", True),
        (PUSH, "measure: x, at: 1.4, above: 1.7", False),
        (PUSH + "\nscene: {gravity: [0, 0, 0]}", "measure: x, at: 1.4, above: 0.5", True),
        # Once a motor or a driven body is at work anything may come, soon after.
        (RAM, "event: hit, within: [0, 1.05]", False),
        (CART, "event: hit, within: [0, 1.05]", False),
        # A spring or a bounce may give back more than the blow.
        (KICK + "\nbodies: {ball: {material: {restitution: 0.9}}}", "event: hit, within: [0, 1.1]", False),
        (KICK + "\nbodies: {ball: {material: {restitution: 0.9}}}", "event: hit, within: [0, 0.9]", True),
        # A torque is not reckoned with.
        ("actions: {controls: {turn: {kind: torque, body: ball, torque: [0, 1, 0]}}}", "event: hit, within: [0, 0.1]", False),
    ],
)  # fmt: skip
def test_how_soon_after_a_push(assets: Path, act: str, expect: str, wanted: bool) -> None:
    parts = act.split("\n") if act.startswith("actions") else [act]
    assert bool(findings(assets, "too-soon", BALL, *parts, expecting(expect))) == wanted


@pytest.mark.parametrize("start", ["[0, 0, 2]", "[0, 0, 0.15]"])
def test_what_falls_is_a_cause(assets: Path, start: str) -> None:
    falling = f"bodies: {{ball: {{place: null, pose: {{pos: {start}}}}}}}"
    assert findings(assets, "too-soon", BALL, KICK, falling, expecting("event: hit, within: [0, 0.9]")) == []
    assert findings(assets, "too-soon", BALL, KICK, falling, expecting("event: hit, within: [0, 0.3]"))


BOX = "{kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, %s}"


@pytest.mark.parametrize(
    ("case", "still"),
    [
        ("bodies: {a: %s}" % (BOX % "place: {on: floor}"), True),
        ("bodies: {{a: {}, b: {}}}".format(BOX % "place: {on: floor}", BOX % "place: {on: a}"), True),
        ("bodies: {{a: {}, b: {}}}".format(BOX % "place: {on: floor}", BOX % "place: {on: a, offset: [0.12, 0, 0]}"), False),
        ("bodies: {a: %s}" % (BOX % "place: {on: floor, euler_deg: [0, 20, 0]}"), False),
        ("bodies: {a: %s}" % (BOX % "pose: {pos: [0, 0, 1]}"), False),
        ("bodies: {a: %s}" % (BOX % "place: {on: floor}, repeat: {kind: running_bond, rows: 4, columns: 3, gap: 0.001}"), True),
        ("bodies: {a: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor}}}", True),
        ("bodies: {a: {kind: rigid, shape: {kind: capsule, radius: 0.1, length: 0.5}, place: {on: floor, euler_deg: [0, 90, 0]}}}", True),
        ("bodies: {a: {kind: rigid, shape: {kind: capsule, radius: 0.1, length: 0.5}, place: {on: floor, euler_deg: [0, 60, 0]}}}", False),
        ("bodies: {a: {use: table, place: {on: floor}}, b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: a}}}", True),
        ("scene: {statics: {ramp: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [0, 0, 0.5], euler_deg: [0, 20, 0]}}}}\nbodies: {a: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: ramp}}}", False),
        # Mounted: about a vertical axis, hanging straight down, hanging to the side.
        ("bodies: {a: %s}" % (BOX % "pose: {pos: [0, 0, 1]}, mount: {kind: hinge, axis: z, anchor: [1, 0, 0]}"), True),
        ("bodies: {a: %s}" % (BOX % "pose: {pos: [0, 0, 1]}, mount: {kind: hinge, axis: y, anchor: [0, 0, 0.5]}"), True),
        ("bodies: {a: %s}" % (BOX % "pose: {pos: [0, 0, 1]}, mount: {kind: hinge, axis: y, anchor: [0.5, 0, 0]}"), False),
        ("bodies: {a: %s}" % (BOX % "pose: {pos: [0, 0, 1]}, mount: {kind: ball}"), False),
        ("bodies: {c: {kind: chain, links: 5, link_length: 0.1, radius: 0.01, pose: {pos: [0, 0, 2]}}}", False),
    ],
)  # fmt: skip
def test_what_stands_still(assets: Path, case: str, still: bool) -> None:
    assert all_still(facts_of(*case.split("\n"), folder=assets)) == still


@pytest.mark.parametrize("speed", [0, 6])
def test_a_flywheel_that_turns_from_the_start(tmp_path: Path, speed: float) -> None:
    wheel = f"""
    bodies:
      wheel:
        kind: rigid
        shape: {{kind: cylinder, radius: 0.3, height: 0.1}}
        pose: {{pos: [0, 0, 1]}}
        mount: {{kind: hinge, axis: z, initial_velocity: {speed}}}
    actions:
      measures: {{spin: {{kind: joint_velocity, of: wheel}}, rim: {{kind: angular_speed, of: wheel}}}}
    """
    spins = "actions: {expect: {e: {measure: spin, at: start, above: 5}}}"
    still = "actions: {expect: {e: {measure: rim, at: end, below: 1}}}"
    assert bool(findings(tmp_path, "cannot-hold", wheel, spins)) is not bool(speed)
    assert bool(findings(tmp_path, "passes-at-rest", wheel, still)) is bool(speed)
    assert all_still(facts_of(wheel, folder=tmp_path)) is not bool(speed)
