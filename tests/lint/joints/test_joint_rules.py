"""Targets outside ranges, degrees and radians, mass ratios, unused parameters, undamped chains, anchors."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

DOOR = """
scene: {{duration: 2}}
bodies:
  door:
    kind: rigid
    shape: {{kind: box, size: [0.8, 0.04, 1.0]}}
    pose: {{pos: [0, 0, 0.6]}}
    mount: {{kind: hinge, axis: z, anchor: [-0.4, 0, 0], {limits} actuator: {{stiffness: 800, damping: 160}}}}
actions: {{controls: {{open: {{kind: drive, joint: door, position: {target}}}}}}}
"""


def door(target: str, limits: str = "") -> str:
    return DOOR.format(target=target, limits=limits)


@pytest.mark.parametrize(
    ("target", "limits", "says"),
    [
        ("1.5", "range_deg: [0, 90],", ""),
        ("1.6", "range_deg: [0, 90],", ""),  # pressed shut
        ("2.5", "range_deg: [0, 90],", "moves from 0 to 1.571 rad (0 to 90 deg)"),
        ("45", "range_deg: [0, 90],", "45 deg is ${radians(45)}"),
        ("{kind: ramp, from: 0, to: -0.5, end: 1}", "range_deg: [0, 90],", "stop at 0 rad"),
        ("{kind: ramp, to: 3, start: 5, end: 6}", "range_deg: [0, 90],", ""),  # after the end of the run
        ("{kind: sine, amplitude: 1, frequency: 1}", "range_deg: [-30, 30],", "1 rad, and `door` moves"),
        ("{kind: sine, amplitude: 0.5, frequency: 1}", "range_deg: [-30, 30],", ""),
        ("{kind: piecewise, times: [0, 1, 3], values: [0, 1, 9]}", "range_deg: [0, 360],", ""),  # 5 at its end
    ],
)
def test_a_target_beyond_the_range(assets: Path, target: str, limits: str, says: str) -> None:
    expect_words(assets, "target-out-of-range", says, door(target, limits))


@pytest.mark.parametrize(("target", "wanted"), [(1.5, False), (2.5, True)])
def test_a_file_may_start_outside_its_range(assets: Path, target: float, wanted: bool) -> None:
    (assets / "arm.xml").write_text(
        "<mujoco><worldbody><body name='rod'><joint name='turn' type='hinge' axis='0 1 0' limited='true' range='30 120'/>"
        "<geom type='box' size='.2 .02 .02'/></body></worldbody></mujoco>"
    )
    arm = f"""
bodies: {{arm: {{kind: articulated, file: arm.xml, joints: {{turn: {{actuator: {{stiffness: 50, damping: 5}}}}}}}}}}
actions: {{controls: {{go: {{kind: drive, joint: arm.turn, position: {{kind: ramp, to: {target}, end: 1}}}}}}}}
"""
    assert bool(findings(assets, "target-out-of-range", arm)) == wanted


@pytest.mark.parametrize(
    ("target", "wanted"),
    [
        ("90", True),
        ("{kind: ramp, to: -45, end: 1}", True),
        ("9.42477", False),
        ("12.5", False),
        ('"${14 * pi}"', False),
    ],
)
def test_angles_that_look_like_degrees(assets: Path, target: str, wanted: bool) -> None:
    assert bool(findings(assets, "looks-like-degrees", door(target))) == wanted


def test_a_start_position_that_looks_like_degrees(assets: Path) -> None:
    arm = """
bodies:
  arm:
    kind: articulated
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      hand: {parent: base, shape: {kind: sphere, radius: 0.05}, joint: {kind: hinge, axis: y}}
    initial: {hand: %s}
"""
    (found,) = findings(assets, "looks-like-degrees", arm % 30)
    assert found.path == "/bodies/arm/initial/hand"
    assert not findings(assets, "looks-like-degrees", arm % 0.5)


@pytest.mark.parametrize(("bound", "wanted"), [("above: 40", True), ("above: 0.7", False), ("above: 3", False)])
def test_an_expectation_that_looks_like_degrees(assets: Path, bound: str, wanted: bool) -> None:
    wish = f"expect: {{e: {{measure: q, at: end, {bound}}}}}"
    script = f"actions: {{measures: {{q: {{kind: joint_position, of: door}}}}, {wish}}}"
    assert bool(findings(assets, "looks-like-degrees", door("0.8"), script)) == wanted


STACK = """
scene: {{substeps: {substeps}}}
bodies:
  tray: {{kind: rigid, shape: {{kind: box, size: [0.3, 0.3, 0.02]}}, material: {{mass: {light}}}, place: {{on: floor}}}}
  iron: {{kind: rigid, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, material: {{mass: 100}}, {place}}}
"""


@pytest.mark.parametrize(
    ("light", "substeps", "place", "wanted"),
    [
        (0.2, 1, "place: {on: tray}", True),  # 500 to 1
        (5, 1, "place: {on: tray}", False),
        (0.2, 10, "place: {on: tray}", False),  # contacts are ten times as fast
        (0.2, 1, "pose: {pos: [1, 0, 0.1]}", False),  # beside it
    ],
)
def test_heavy_on_light(assets: Path, light: float, substeps: int, place: str, wanted: bool) -> None:
    found = findings(assets, "mass-ratio", STACK.format(light=light, substeps=substeps, place=place))
    assert [problem.path for problem in found] == (["/bodies/tray"] if wanted else [])


def test_heavy_welded_to_light(assets: Path) -> None:
    crane = """
scene: {substeps: 1}
bodies:
  hook:
    kind: rigid
    shape: {kind: sphere, radius: 0.02}
    material: {mass: 0.05}
    pose: {pos: [0, 0, 2]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 20000, damping: 800}}
  crate: {kind: rigid, shape: {kind: box, size: [0.3, 0.3, 0.3]}, material: {mass: %s}, pose: {pos: [0, 0, 1.8]}}
actions:
  controls:
    hang: {kind: attach, body: crate, to: hook}
    lift: {kind: drive, joint: hook, position: {kind: ramp, to: 0.3, end: 1}}
"""
    (found,) = findings(assets, "mass-ratio", crane % 40)  # 800 to 1
    assert found.path == "/actions/controls/hang"
    assert not findings(assets, "mass-ratio", crane % 0.5)


def test_a_remedy_is_not_there_already(assets: Path) -> None:
    """Welds are as stiff as two substeps allow; contacts are not stiffer than 2 ms unless the case says so."""
    rope = """
scene: {%s}
bodies:
  rope: {kind: rope, length: 1, radius: 0.004, segments: 20, material: {mass: 0.05}, pose: {pos: [0, 0, 2]}}
  load: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 50}, pose: {pos: [0, 0, 0.88]}}
actions: {controls: {tie: {kind: attach, body: rope.link_19, to: load}}}
"""
    assert not findings(assets, "mass-ratio", rope % "")
    (found,) = findings(assets, "mass-ratio", rope % "substeps: 8, dt: 0.01")
    assert "use scene.substeps of 18, or" in found.message
    assert not findings(assets, "mass-ratio", rope % "substeps: 18, dt: 0.01")
    stack = STACK.format(light=0.001, substeps=50, place="place: {on: tray}")
    (found,) = findings(assets, "mass-ratio", stack)
    assert "use contact.timeconst of" in found.message


def test_what_is_too_light_for_the_solver(assets: Path) -> None:
    case = """
scene: {solver: {kind: %s}}
bodies:
  block: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, material: {mass: 500}, place: {on: floor}}
  pea: {kind: rigid, shape: {kind: sphere, radius: 0.004}, material: {mass: %s}, pose: {pos: [2, 0, 1]}}
"""
    (found,) = findings(assets, "light-link", case % ("cg", 0.003))  # 1e-5 of 500 kg
    assert found.path == "/bodies/pea"
    assert not findings(assets, "light-link", case % ("cg", 0.01))
    assert not findings(assets, "light-link", case % ("newton", 0.003))
    assert findings(assets, "light-link", case % ("newton", 1e-6))


@pytest.mark.parametrize(
    ("use", "wanted"),
    [
        ('"${b}"', ["a"]),
        ('"${a + b}"', []),
        ('"${a * 2}"', ["b"]),
        ("0.1", ["a", "b"]),
    ],
)
def test_parameters_that_nothing_uses(assets: Path, use: str, wanted: list[str]) -> None:
    case = f"""
params: {{a: 0.1, b: 0.2}}
bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: {use}}}, pose: {{pos: [0, 0, 1]}}}}}}
"""
    assert [p.path.removeprefix("/params/") for p in findings(assets, "unused-param", case)] == wanted


def test_a_parameter_of_parameters_is_used(assets: Path) -> None:
    case = """
params: {a: 0.1, b: "${2 * a}"}
bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: "${b}"}, pose: {pos: [0, 0, 1]}}}
"""
    assert not findings(assets, "unused-param", case)


def test_chains_without_damping(assets: Path) -> None:
    links = "\n".join(
        f"      l{k}: {{parent: {f'l{k - 1}' if k else 'top'}, shape: {{kind: sphere, radius: 0.02}}, pose: "
        "{pos: [0, 0, -0.1]}, joint: {kind: ball, anchor: [0, 0, 0.1]%s}}"
        for k in range(4)
    )
    rope = "bodies:\n  rope:\n    kind: articulated\n    pose: {pos: [0, 0, 2]}\n    links:\n"
    rope += "      top: {shape: {kind: sphere, radius: 0.02}}\n" + links
    bare, damped, rotors = (rope.replace("%s", more) for more in ("", ", damping: 0.01", ", armature: 0.001"))
    assert findings(assets, "undamped-joints", bare, "scene: {substeps: 1}")
    assert not findings(assets, "undamped-joints", bare)  # the compiler chooses substeps that hold it
    assert not findings(assets, "undamped-joints", damped, "scene: {substeps: 1}")
    assert not findings(assets, "undamped-joints", rotors, "scene: {substeps: 1}")
    chain = "bodies: {rope: {kind: chain, links: 9, link_length: 0.1, radius: 0.01, pose: {pos: [0, 0, 2]}%s}}"
    assert not findings(assets, "undamped-joints", chain % "", "scene: {substeps: 1}")
    none = ", joint: {damping: 0, armature: 0}"
    (found,) = findings(assets, "undamped-joints", chain % none, "scene: {substeps: 1}")
    assert found.path == "/bodies/rope/joint"


@pytest.mark.parametrize(
    ("angle", "wanted"),
    [("1.57", True), ("1.5708", True), ("-0.785", True), ("0.7854", True), ("${pi / 3}", True), ("6.28", True)]
    + [("90", False), ("0.17", False), ("1.5", False), ("0", False), ("0.79", False), ("2", False)],
)
def test_angles_that_look_like_radians(tmp_path: Path, angle: str, wanted: bool) -> None:
    plank = "bodies: {plank: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [0, 0, 2], euler_deg: [0, '%s', 0]}}}"
    data = plank % angle if "$" in angle else plank.replace("'%s'", angle)
    found = findings(tmp_path, "looks-like-radians", data)
    assert bool(found) == wanted
    assert all(problem.path == "/bodies/plank/pose/euler_deg" for problem in found)
    # The advice is what is typed: `90 deg` would be text.
    assert angle != "1.57" or found[0].message.endswith("; write 90")


@pytest.mark.parametrize(
    ("target", "wanted"), [("-10", True), ("10", False), ("{kind: steps, times: [0, 0.5], values: [-1, 1]}", False)]
)
def test_a_velocity_against_the_end_of_the_range(tmp_path: Path, target: str, wanted: bool) -> None:
    """In Genesis the arm stayed where it was."""
    arm = """\
bodies:
  arm:
    kind: rigid
    shape: {kind: box, size: [1, 0.08, 0.03]}
    pose: {pos: [0, 0, 0.5]}
    mount: {kind: hinge, axis: y, range_deg: [0, 60], actuator: {damping: 50}}
actions: {controls: {fling: {kind: drive, joint: arm, velocity: %s}}}
"""
    found = findings(tmp_path, "target-out-of-range", arm % target)
    assert bool(found) == wanted
    assert all("pushes against that limit and does not move" in problem.message for problem in found)


@pytest.mark.parametrize(
    ("anchor", "bound", "path"),
    [("[0, 0, 0.5]", -30, "/actions/expect/far/below"), ("[0, 0, 0.5]", -0.5, ""), ("[0, 0, 0]", -30, "")],
)
def test_degrees_in_what_a_pendulum_is_to_reach(tmp_path: Path, anchor: str, bound: float, path: str) -> None:
    """A wheel, which is hinged at its centre, may turn that far."""
    case = f"""\
bodies:
  bob:
    kind: rigid
    shape: {{kind: sphere, radius: 0.05}}
    pose: {{pos: [0, 0, 1], euler_deg: [0, 30, 0]}}
    mount: {{kind: hinge, axis: y, anchor: {anchor}}}
actions:
  measures: {{angle: {{kind: joint_position, of: bob}}}}
  events: {{passes: {{kind: threshold, measure: angle, below: {bound}}}}}
  expect: {{far: {{measure: angle, at: end, below: {bound}}}}}
"""
    found = [problem.path for problem in findings(tmp_path, "looks-like-degrees", case)]
    assert found == (["/actions/events/passes/below", path] if path else [])


@pytest.mark.parametrize(("anchor", "wanted"), [(2, False), (6, True)])
def test_an_anchor_far_away(tmp_path: Path, anchor: float, wanted: bool) -> None:
    bob = f"""\
bodies:
  bob:
    kind: rigid
    shape: {{kind: sphere, radius: 0.05}}
    pose: {{pos: [0, 0, 1]}}
    mount: {{kind: ball, anchor: [0, 0, {anchor}]}}
"""
    assert bool(findings(tmp_path, "far-anchor", bob)) == wanted
