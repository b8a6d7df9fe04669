"""Rotations, schedules, pushes and bounces that are too fast for the time step."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

BALL = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 1}, pose: {pos: [0, 0, 1]}}}"
STATIC = "scene: {duration: 1, dt: 0.01, substeps: 1}"


def control(text: str) -> str:
    return f"actions: {{controls: {{act: {{{text}}}}}}}"


@pytest.mark.parametrize(
    ("act", "path"),
    [
        ("kind: initial_velocity, body: ball, angular: [0, 60, 0]", "/actions/controls/act/angular"),
        ("kind: initial_velocity, body: ball, angular: [0, 40, 0]", ""),
    ],
)
def test_a_body_that_spins_too_fast(assets: Path, act: str, path: str) -> None:
    assert [p.path for p in findings(assets, "fast-spin", BALL, STATIC, control(act))] == ([path] if path else [])


def test_driven_and_motorised_turns_count(assets: Path) -> None:
    driven = "bodies: {fan: {kind: driven, shape: {kind: box, size: [1, 0.1, 0.1]}, motion: {kind: spin, speed: 80}}}"
    assert [p.path for p in findings(assets, "fast-spin", driven, STATIC)] == ["/bodies/fan/motion/speed"]
    mount = "mount: {kind: hinge, axis: y, actuator: {damping: 1}}"
    motor = f"bodies: {{fan: {{kind: rigid, shape: {{kind: box, size: [1, 0.1, 0.1]}}, {mount}}}}}"
    act = control("kind: drive, joint: fan, velocity: {kind: ramp, to: 80, end: 0.5}")
    assert [p.path for p in findings(assets, "fast-spin", motor, STATIC, act)] == ["/actions/controls/act/velocity"]
    assert not findings(assets, "fast-spin", motor, "scene: {dt: 0.005, substeps: 1}", act)
    started = motor.replace("axis: y", "axis: y, initial_velocity: -80")
    assert [p.path for p in findings(assets, "fast-spin", started, STATIC)] == ["/bodies/fan/mount/initial_velocity"]
    blade = "{parent: hub, shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0, 0, 1]}, joint: {kind: %s, initial_velocity: 80}}"
    for kind, path in (("hinge", ["/bodies/fan/links/blade/joint/initial_velocity"]), ("slider, axis: x", [])):
        links = f"{{hub: {{shape: {{kind: sphere, radius: 0.1}}}}, blade: {blade % kind}}}"
        fan = f"bodies: {{fan: {{kind: articulated, base: fixed, links: {links}}}}}"
        assert [p.path for p in findings(assets, "fast-spin", fan, STATIC)] == path


@pytest.mark.parametrize(
    ("scale", "says"),
    [
        ("{kind: sine, amplitude: 1, frequency: 60}", "aliases to a slower"),
        ("{kind: sine, amplitude: 1, frequency: 20}", "is coarse"),
        ("{kind: sine, amplitude: 1, frequency: 10}", ""),
        ("{kind: ramp, from: 0, to: 1, start: 0.5, end: 0.502}", "is a jump"),
        ("{kind: ramp, from: 0, to: 1, start: 0.5, end: 0.51}", ""),
        ("{kind: steps, times: [0, 0.5, 0.503], values: [0, 1, 2]}", "within one time step"),
        ("{kind: piecewise, times: [0, 0.5, 0.51], values: [0, 1, 2]}", ""),
        ("2.0", ""),
    ],
)
def test_schedules_that_change_within_a_step(assets: Path, scale: str, says: str) -> None:
    act = control(f"kind: force, body: ball, force: [1, 0, 0], scale: {scale}")
    expect_words(assets, "fast-schedule", says, BALL, STATIC, act)


def test_gusts_of_a_wind_count(assets: Path) -> None:
    sheet = "bodies: {sheet: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.4]}, pose: {pos: [0, 0, 1]}}}"
    wind = "kind: wind, direction: [1, 0, 0], acceleration: 2, scale: {kind: sine, amplitude: 1, frequency: %s}"
    expect_words(assets, "fast-schedule", "aliases to a slower", sheet, STATIC, control(wind % 60))
    expect_words(assets, "fast-schedule", "", sheet, STATIC, control(wind % 10))


@pytest.mark.parametrize(
    ("act", "severity"),
    [
        ("kind: impulse, body: ball, impulse: [3, 0, 0], at: 0.1", ""),
        ("kind: impulse, body: ball, impulse: [30, 0, 0], at: 0.1", "warning"),  # 30 m/s: 0.3 m in a step
        ("kind: impulse, body: ball, impulse: [3000, 0, 0], at: 0.1", "error"),  # faster than max_speed
        ("kind: initial_velocity, body: ball, linear: [0, 2000, 0]", "error"),
        ("kind: initial_velocity, body: ball, linear: [0, 900, 0]", ""),  # what it passes is another rule's
        ("kind: force, body: ball, force: [50, 0, 0]", ""),
        ("kind: force, body: ball, force: [5000, 0, 0]", "warning"),
        ("kind: force, body: ball, force: [1200, 0, 0], during: [0, 0.9]", "warning"),  # 1080 m/s
        ("kind: force, body: ball, force: [1200, 0, 0], during: [0, 0.1]", ""),
    ],
)
def test_pushes_out_of_proportion(assets: Path, act: str, severity: str) -> None:
    found = findings(assets, "violent-push", BALL, STATIC, control(act))
    assert [problem.severity for problem in found] == ([severity] if severity else [])


@pytest.mark.parametrize(
    ("more", "rules"),
    [
        ("scene: {substeps: 1, contact: {timeconst: 0.02}}", ["restitution-step"]),
        ("scene: {dt: 0.001, substeps: 1, contact: {timeconst: 0.02}}", []),
        ("scene: {substeps: 2}", ["soft-bounce"]),
        ("scene: {}", []),
        ("bodies: {ball: {material: {restitution: 0}}}", []),
    ],
)
def test_bounces_against_the_time_step(assets: Path, more: str, rules: list[str]) -> None:
    bouncy = "bodies: {ball: {material: {restitution: 0.8}}}"
    every = ("restitution-step", "soft-bounce")
    assert [rule for rule in every if findings(assets, rule, BALL, bouncy, more)] == rules


@pytest.mark.parametrize(
    ("point", "off"), [("[0, 0, 0.25]", "230 mm away from `domino`"), ("[0, 0, 0.02]", ""), ("{face: top}", "")]
)
def test_a_point_beside_its_body(tmp_path: Path, point: str, off: str) -> None:
    case = f"""\
bodies:
  domino: {{kind: rigid, shape: {{kind: box, size: [0.01, 0.02, 0.04]}}, pose: {{pos: [1, 2, 0.5], euler_deg: [0, 90, 0]}}}}
actions: {{controls: {{hit: {{kind: impulse, body: domino, impulse: [0.001, 0, 0], at: 0.1, point: {point}}}}}}}
"""
    found = findings(tmp_path, "point-off-body", case)
    assert [off in problem.message for problem in found] == [True] * bool(off)


def test_a_point_beside_a_link(tmp_path: Path) -> None:
    case = """\
bodies:
  arm:
    kind: articulated
    pose: {pos: [0, 0, 1]}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      rod:
        parent: base
        shape: {kind: box, size: [0.4, 0.04, 0.04]}
        pose: {pos: [0.3, 0, 0]}
        joint: {kind: hinge, axis: y, anchor: [-0.2, 0, 0]}
actions: {controls: {hit: {kind: impulse, body: arm.rod, impulse: [0, 0, 1], at: 0.1, point: [%s, 0, 0]}}}
"""
    assert not findings(tmp_path, "point-off-body", case % 0.2)
    (found,) = findings(tmp_path, "point-off-body", case % 0.5)
    assert "300 mm away from `arm.rod`" in found.message


def test_a_first_waypoint_away_from_the_start_is_a_jump(assets: Path) -> None:
    pusher = """\
bodies:
  pusher:
    kind: driven
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    motion: {kind: waypoints, times: [0, 1], positions: [[0, 0, %s], [0, 0, 0.5]]}
    pose: {pos: [0, 0, 0.3]}
"""
    assert findings(assets, "fast-schedule", pusher % 0) == []
    expect_words(assets, "fast-schedule", "the first one is a jump of 300 mm", pusher % 0.3)


BEAM = "scene: {dt: 0.01, statics: {beam: {shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0, 0, 2]}}}}"


@pytest.mark.parametrize(
    ("stiffness", "damping", "severity"),
    # k T^2 + 2 c T on 1 kg, with T = 0.01: a warning from 1 on, an error from 4 on.
    [(9e3, 0, []), (1.1e4, 0, ["warning"]), (4.1e4, 0, ["error"]), (9e3, 6, ["warning"])],
)
def test_springs_between_bodies_that_are_too_stiff(
    assets: Path, stiffness: float, damping: float, severity: list[str]
) -> None:
    act = control(f"kind: spring, body: ball, to: beam, stiffness: {stiffness}, damping: {damping}")
    found = findings(assets, "stiff-spring", BALL, BEAM, act)
    assert [(p.severity, p.path) for p in found] == [(each, "/actions/controls/act/stiffness") for each in severity]


def test_springs_at_one_body_add_up(assets: Path) -> None:
    acts = "actions: {controls: {%s}}" % ", ".join(  # noqa: UP031 - braces
        f"s{k}: {{kind: spring, body: ball, to: beam, stiffness: 4.0e3}}" for k in range(3)
    )
    expect_words(assets, "stiff-spring", "`ball` (1 kg) is too stiff for steps of 10 ms", BALL, BEAM, acts)
    expect_words(assets, "stiff-spring", "use scene.dt of 0.0091 or less (substeps do not help)", BALL, BEAM, acts)


def test_what_hangs_on_a_spring_is_not_taken_to_fall(assets: Path) -> None:
    act = control("kind: spring, body: ball, to: beam, stiffness: 50")
    scene = BEAM.replace("statics: {", "duration: 3, statics: {floor: null, ")
    assert findings(assets, "falls-for-ever", BALL, scene)
    assert not findings(assets, "falls-for-ever", BALL, scene, act)
