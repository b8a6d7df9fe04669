"""Motors that are too weak, too slow, too soft, too stiff or idle, with numbers computed by hand."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

G = 9.81

LIFT = """
actions: {{controls: {{go: {{kind: drive, joint: lift, {target}}}}}}}
bodies:
  lift:
    kind: rigid
    shape: {{kind: box, size: [0.2, 0.2, 0.1]}}
    material: {{mass: 4}}
    pose: {{pos: [0, 0, 1]}}
    mount: {{kind: slider, axis: {axis}, {joint} actuator: {{{motor}}}}}
"""
ARM = """
scene: {{duration: 3}}
bodies:
  arm:
    kind: articulated
    pose: {{pos: [0, 0, 1]}}
    links:
      base: {{shape: {{kind: box, size: [0.1, 0.1, 0.1]}}}}
      upper:
        parent: base
        shape: {{kind: box, size: [0.4, 0.05, 0.05]}}
        material: {{mass: 2}}
        pose: {{pos: [0.2, 0, 0]}}
        joint: {{kind: hinge, axis: y, anchor: [-0.2, 0, 0], actuator: {{stiffness: 5000, damping: 300, max_force: {upper}}}}}
      lower:
        parent: upper
        shape: {{kind: box, size: [0.4, 0.05, 0.05]}}
        material: {{mass: 1}}
        pose: {{pos: [0.4, 0, 0]}}
        joint: {{kind: hinge, axis: y, anchor: [-0.2, 0, 0], actuator: {{stiffness: 5000, damping: 200, max_force: {lower}}}}}
    {more}
  load: {{kind: rigid, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, material: {{mass: 3}}, pose: {{pos: [0.86, 0, 1]}}}}
actions:
  controls:
    a: {{kind: drive, joint: arm.upper, position: {position}}}
    b: {{kind: drive, joint: arm.lower, position: 0}}
    {control}
"""


CRATE = """
  crate: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 1}, place: {on: lift}}
"""


def lift(axis: str = "z", joint: str = "", motor: str = "", target: str = "position: 0") -> str:
    return LIFT.format(axis=axis, joint=joint, motor=motor, target=target)


def arm(upper: float = 100, lower: float = 100, more: str = "", position: str = "0", control: str = "") -> str:
    return ARM.format(upper=upper, lower=lower, more=more, position=position, control=control)


@pytest.mark.parametrize(
    ("case", "says"),
    [
        (lift(motor="stiffness: 8000, damping: 300, max_force: 35"), "takes 39.2 N, and its motor gives at most 35 N"),
        (lift(motor="stiffness: 8000, damping: 300, max_force: 45"), ""),
        (lift(motor="stiffness: 8000, damping: 300"), ""),
        (lift("x", motor="stiffness: 8000, damping: 300, max_force: 5"), ""),  # gravity does not pull along x
        (lift(joint="friction: 10,", motor="stiffness: 8000, damping: 300, max_force: 35"), ""),  # friction helps
        # What is put on it is part of the load: 9.81 x 5 kg = 49.1 N.
        (lift(motor="stiffness: 8000, damping: 300, max_force: 45") + CRATE, "(5 kg) takes 49.1 N"),
        (lift(motor="damping: 100", target="velocity: 0.2"), "with damping 100 its motor stalls at 20 N"),
        (lift(motor="damping: 100", target="velocity: 0.6"), ""),
        (lift("x", "friction: 10,", "damping: 1", "force: 8"), "dry friction of `lift` (10 N) is larger than this"),
        (lift("x", "friction: 10,", "damping: 1", "force: 12"), ""),
        # 9.81 (2 x 0.2 + 1 x 0.6) = 9.81 N m at the upper joint, 9.81 x 1 x 0.2 = 1.96 at the lower one.
        (arm(upper=9), "holding the load of `arm.upper` (3 kg) takes 9.81 N m at 0 rad"),
        (arm(upper=11), ""),
        (arm(lower=1.5), "holding the load of `arm.lower` (1 kg) takes 1.96 N m"),
        # Straight down it carries nothing, but on the way there it passes the horizontal.
        (arm(upper=9, position="{kind: ramp, from: 1.5, to: 1.5708, end: 1}"), ""),
        (arm(upper=9, position="{kind: ramp, from: -0.5, to: 1.5708, end: 1}"), "at 0 rad"),
        # The load adds 3 x 9.81 x 0.86 = 25.3 N m.
        (arm(upper=30, control="grip: {kind: attach, body: load, to: arm.lower}"), "takes 35.1 N m"),
        (arm(upper=40, control="grip: {kind: attach, body: load, to: arm.lower}"), ""),
        (arm(upper=30, control="grip: {kind: attach, body: load, to: arm.base}"), ""),
        # Something else may carry: nothing is said.
        (arm(upper=9, more="loops: {hold: {kind: connect, between: [lower, world]}}"), ""),
        (arm(upper=9, more="base: free"), ""),
    ],
)
def test_what_a_motor_has_to_hold(assets: Path, case: str, says: str) -> None:
    expect_words(assets, "weak-motor", says, case)


CRANE = """
scene: {{duration: 4}}
bodies:
  hook:
    kind: rigid
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    material: {{mass: 1}}
    pose: {{pos: [0, 0, 1]}}
    mount: {{kind: slider, axis: z, actuator: {{{motor}}}}}
  crate: {{kind: rigid, shape: {{kind: box, size: [0.3, 0.3, 0.3]}}, material: {{mass: 20}}, pose: {{pos: [0, 0, {height}]}}}}
  lid: {{kind: rigid, shape: {{kind: box, size: [0.3, 0.3, 0.1]}}, material: {{mass: 5}}, pose: {{pos: [0, 0, 0.35]}}}}
actions:
  controls:
    hoist: {{kind: drive, joint: hook, {target}}}
    grab: {{kind: attach, body: {body}, to: hook, at: {at}}}
    {more}
"""
SERVO, RAMP = (
    "stiffness: 50000, damping: 2000, max_force: {}",
    "position: {{kind: ramp, from: 0, to: {}, start: 1, end: 3}}",
)


def crane(
    force: float, *, to: float = 0.5, at: float = 0.5, more: str = "", body: str = "crate", height: float = 0.15
) -> str:
    return CRANE.format(motor=SERVO.format(force), target=RAMP.format(to), at=at, more=more, body=body, height=height)


@pytest.mark.parametrize(
    ("case", "says"),
    [
        # 9.81 x 21 kg = 206 N; the hook alone takes 9.81 N.
        (crane(150), "with `crate`, which `grab` attaches at 0.5 s, (21 kg) takes 206 N"),
        (crane(230), ""),
        (crane(150, body="hook").replace("to: hook", "to: crate"), "takes 206 N"),
        # What is welded to the crate is lifted with it.
        (crane(230, more="join: {kind: attach, body: lid, to: crate}"), "(26 kg) takes 255 N"),
        (crane(230, more="join: {kind: attach, body: lid, to: crate, at: 0.2}"), "(26 kg) takes 255 N"),
        (crane(230, more="join: {kind: attach, body: lid, to: crate, at: 2}"), ""),
        # The ground carries what is not lifted, and what is let go before.
        (crane(150, to=-0.2), ""),
        (crane(150, to=0), ""),
        (crane(150, more="drop: {kind: release, attach: grab, at: 0.9}"), ""),
        (crane(150, more="drop: {kind: release, attach: grab, at: 2}"), "takes 206 N"),
        (crane(150, at=3.5), ""),
        # A velocity motor gives its damping times the speed: 0.2 m/s x 500.
        (
            CRANE.format(motor="damping: 500", target="velocity: 0.2", at=1, more="", body="crate", height=0.15),
            "stalls at 100 N",
        ),
        (CRANE.format(motor="damping: 2000", target="velocity: 0.2", at=1, more="", body="crate", height=0.15), ""),
        (CRANE.format(motor="damping: 500", target="velocity: -0.2", at=1, more="", body="crate", height=0.15), ""),
    ],
)
def test_a_load_that_is_attached_later(assets: Path, case: str, says: str) -> None:
    expect_words(assets, "weak-motor", says, case)


def gripping(force: float, swing: str, at: float = 1.5) -> str:
    """An arm of 0.8 m whose load of 3 kg is 0.86 m from its hinge, or beside it at another angle."""
    return arm(upper=force, position=swing, control=f"grip: {{kind: attach, body: load, to: arm.lower, at: {at}}}")


@pytest.mark.parametrize(
    ("case", "says"),
    [
        # Lifted from the horizontal: 9.81 x (1 + 3 x 0.86) = 35.1 N m.
        (gripping(30, "{kind: ramp, from: 0, to: -1, start: 2, end: 3}"), "takes 35.1 N m at 0 rad"),
        (gripping(40, "{kind: ramp, from: 0, to: -1, start: 2, end: 3}"), ""),
        # Let down, it need not be lifted.
        (gripping(30, "{kind: ramp, from: 0, to: 1, start: 2, end: 3}"), ""),
        # The arm comes up from below to fetch it, and lowers it again.
        (gripping(30, "{kind: ramp, from: 1, to: 0, start: 0, end: 1}"), ""),
    ],
)
def test_a_load_on_an_arm_is_lifted(assets: Path, case: str, says: str) -> None:
    expect_words(assets, "weak-motor", says, case)


def test_one_of_many_that_is_loaded(assets: Path) -> None:
    case = (
        crane(150)
        .replace("mount: {", "repeat: {kind: line, count: 3, step: [2, 0, 0]}\n    mount: {")
        .replace("joint: hook", "joint: 'hook[*]'")
    )
    (found,) = findings(assets, "weak-motor", case.replace("to: hook", "to: 'hook[1]'"))
    assert "`hook[1]`" in found.message


def test_a_weak_motor_is_blamed_where_the_number_stands(assets: Path) -> None:
    (found,) = findings(assets, "weak-motor", lift(motor="stiffness: 8000, damping: 300, max_force: 35"))
    assert found.path == "/bodies/lift/mount/actuator/max_force"
    assert found.severity == "warning"
    (found,) = findings(assets, "weak-motor", arm(upper=9))
    assert found.path == "/bodies/arm/links/upper/joint/actuator/max_force"


def test_copies_that_are_alike_make_one_finding(assets: Path) -> None:
    more = "bodies: {lift: {repeat: {kind: line, count: 5, step: [1, 0, 0]}}}"
    (found,) = findings(assets, "weak-motor", lift(motor="stiffness: 8000, damping: 300, max_force: 35"), more)
    assert "`lift[0]`" in found.message


def test_a_servo_is_held_to_the_tolerance_of_an_expectation(assets: Path) -> None:
    case = lift(motor="stiffness: 5000, damping: 280", target="position: {kind: ramp, to: 0.3, end: 1}")  # 7.8 mm
    asked = "measures: {{q: {{kind: joint_position, of: lift}}}}, expect: {{e: {{measure: q, at: end, {}}}}}"
    exact, rough = (f"actions: {{{asked.format(f'equals: 0.3, tolerance: {t}')}}}" for t in (0.005, 0.01))
    assert findings(assets, "servo-droop", case, exact.replace("of: lift", "of: [lift]"))
    assert not findings(assets, "servo-droop", case)
    assert not findings(assets, "servo-droop", case, rough)
    assert findings(assets, "servo-droop", case, exact)


@pytest.mark.parametrize(
    ("motor", "target", "says"),
    [
        # 39.24 N on 400 N/m
        ("stiffness: 400, damping: 80", "{kind: ramp, to: 0.3, end: 1}", "stays 0.0981 m, 33% of its travel"),
        ("stiffness: 8000, damping: 300", "{kind: ramp, to: 0.3, end: 1}", ""),
        ("stiffness: 400, damping: 80", "0", "stays 0.0981 m away"),
        ("stiffness: 5000, damping: 80", "0", ""),
    ],
)
def test_how_far_a_servo_droops(assets: Path, motor: str, target: str, says: str) -> None:
    expect_words(assets, "servo-droop", says, lift(motor=motor, target=f"position: {target}"))


@pytest.mark.parametrize(
    ("motor", "target", "says"),
    [
        # 4 kg over 0.5 m within 0.5 s: 4 d / T2 = 8 m/s2, 32 N.
        (
            "stiffness: 9000, damping: 100, max_force: 10",
            "position: {kind: ramp, to: 0.5, end: 0.5}",
            "takes 40 N (32 N",
        ),
        ("stiffness: 9000, damping: 100, max_force: 40", "position: {kind: ramp, to: 0.5, end: 0.5}", ""),
        # 2 kg m/s within 0.1 s: 20 N; damping x substep = 2000 x 0.01 counts as 20 kg more.
        ("damping: 100, max_force: 5", "velocity: {kind: ramp, to: 0.5, end: 0.1}", "takes 25 N (20 N for its inertia"),
        (
            "damping: 2000, max_force: 60",
            "velocity: {kind: ramp, to: 0.5, end: 0.1}",
            "for the motor's damping (x substep)",
        ),
        ("damping: 100, max_force: 60", "velocity: {kind: ramp, to: 0.5, end: 0.1}", ""),
        # A w2 = 0.1 (2 pi 2)2 = 15.8 m/s2
        (
            "stiffness: 9000, damping: 100, max_force: 20",
            "position: {kind: sine, amplitude: 0.1, frequency: 2}",
            "takes 79",
        ),
        ("stiffness: 9000, damping: 100, max_force: 90", "position: {kind: sine, amplitude: 0.1, frequency: 2}", ""),
        (
            "stiffness: 9000, damping: 100, max_force: 20",
            "position: {kind: steps, times: [0, 0.5], values: [0, 0.4]}",
            "",
        ),
        (
            "stiffness: 9000, damping: 100, max_force: 10",
            "position: {kind: steps, times: [0, 0.5, 0.6], values: [0, 0.4, 0]}",
            "cannot keep up: 0 to 0.4 m",
        ),
        (
            "stiffness: 9000, damping: 100, max_force: 2",
            "position: {kind: piecewise, times: [0, 0.4, 0.6], values: [0, 0, 0.3]}",
            "cannot keep up: 0 to 0.3 m",
        ),
    ],
)
def test_what_a_schedule_asks_of_a_motor(assets: Path, motor: str, target: str, says: str) -> None:
    expect_words(assets, "slow-motor", says, lift("x", motor=motor, target=target), "scene: {substeps: 1}")


@pytest.mark.parametrize(
    ("joint", "motor", "says"),
    [
        ("damping: 20,", "damping: 20", "will run at 0.25 m/s instead of 0.5"),
        ("damping: 20,", "damping: 2000", ""),
        ("friction: 5,", "damping: 20", "will run at 0.25 m/s"),
        ("damping: 20,", "damping: 2000, max_force: 6", "give it a max_force of 12"),
    ],
)
def test_the_speed_that_a_motor_reaches(assets: Path, joint: str, motor: str, says: str) -> None:
    expect_words(assets, "short-speed", says, lift("x", joint, motor, "velocity: 0.5"))


def test_a_servo_without_damping_swings(assets: Path) -> None:
    (found,) = findings(assets, "swinging-servo", lift("x", motor="stiffness: 400", target="position: 0.1"))
    assert "every 0.628 s" in found.message  # 2 pi sqrt(4 / 400)
    assert "damping 80 " in found.message  # 2 sqrt(4 x 400)
    assert not findings(assets, "swinging-servo", lift("x", motor="stiffness: 400, damping: 8", target="position: 0.1"))
    assert not findings(assets, "swinging-servo", lift("x", "damping: 8,", "stiffness: 400", "position: 0.1"))


def test_a_motor_that_nobody_drives_is_idle(assets: Path) -> None:
    (found,) = findings(assets, "idle-motor", arm(), "actions: {controls: {b: null}}")
    assert "`arm.lower`" in found.message
    assert not findings(assets, "idle-motor", arm())
    more = "bodies: {lift: {repeat: {kind: line, count: 3, step: [1, 0, 0]}}}"
    one = lift(motor="stiffness: 8000, damping: 300").replace("joint: lift,", 'joint: "lift[1]",')
    assert not findings(assets, "idle-motor", one, more)  # some of them are driven: that may be meant


@pytest.mark.parametrize(
    ("stiffness", "damping", "severity"),
    [
        # h = 0.01 s, 4 kg: stable below 4 x 4 / 1e-4 = 160000 N/m + 200 x damping.
        (150_000, 1, "warning"),
        (170_000, 1, "error"),
        (170_000, 100, "warning"),
        (1_000_000, 5000, ""),
        (20_000, 1, ""),
    ],
)
def test_how_stiff_a_servo_may_be(assets: Path, stiffness: float, damping: float, severity: str) -> None:
    case = lift("x", motor=f"stiffness: {stiffness}, damping: {damping}", target="position: 0.1")
    found = findings(assets, "stiff-joint", case, "scene: {substeps: 1}")
    assert [problem.severity for problem in found] == ([severity] if severity else [])
    assert not findings(assets, "stiff-joint", case, "scene: {substeps: 20}")


def test_a_limited_servo_chatters_instead_of_diverging(assets: Path) -> None:
    case = lift("x", motor="stiffness: 500000, max_force: 100", target="position: 0.1")
    (found,) = findings(assets, "stiff-joint", case, "scene: {substeps: 1}")
    assert found.severity == "warning"
    assert "chatters" in found.message


def test_a_joint_spring_counts_as_well(assets: Path) -> None:
    case = "bodies: {a: {kind: rigid, shape: {kind: sphere, radius: 0.05}, mount: {kind: slider, axis: x, spring: 1.0e+6}}}"
    (found,) = findings(assets, "stiff-joint", case)
    assert found.severity == "error"
    assert found.path == "/bodies/a/mount/spring"


@pytest.mark.parametrize(("force", "wanted"), [(0.02, True), (3, False)])
def test_wheels_of_a_car_that_moves_freely(tmp_path: Path, force: float, wanted: bool) -> None:
    """The motor's own damping takes 2 x 0.005 x 10 = 0.1 N m at least (in Genesis 0.02 N m made 0.2 rad/s of 10)."""
    car = f"""\
scene: {{dt: 0.005}}
bodies:
  car:
    kind: articulated
    base: free
    pose: {{pos: [0, 0, 0.5]}}
    links:
      chassis: {{shape: {{kind: box, size: [0.6, 0.24, 0.08]}}}}
      wheel:
        parent: chassis
        shape: {{kind: cylinder, radius: 0.1, height: 0.05}}
        pose: {{pos: [0.2, 0.16, 0], euler_deg: [90, 0, 0]}}
        joint: {{kind: hinge, axis: z, actuator: {{damping: 2, max_force: {force}}}}}
actions: {{controls: {{go: {{kind: drive, joint: car.wheel, velocity: {{kind: ramp, from: 0, to: -10, end: 1}}}}}}}}
"""
    assert bool(findings(tmp_path, "slow-motor", car)) == wanted
