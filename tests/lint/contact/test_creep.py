"""Creep of bodies that friction holds on a slope, and the friction cone that the compiler chooses."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_case

RAMP = """
scene:
  duration: {duration}
  {scene}
  statics:
    floor: {{shape: {{kind: plane}}}}
    ramp: {{shape: {{kind: box, size: [2, 1, 0.05]}}, material: {{friction: {friction}}}, pose: {{pos: [0, 0, 1], euler_deg: [0, {deg}, 0]}}}}
bodies:
  crate: {{kind: rigid, shape: {{kind: box, size: [0.3, 0.3, 0.2]}}, material: {{friction: 0.1}}, place: {place}}}
  {more}
"""
ON = "{on: ramp, at: [0, 0], euler_deg: [0, 15, 0]}"
PYRAMID = "contact: {friction_cone: pyramidal}"


def ramp(
    scene: str = PYRAMID, place: str = ON, duration: float = 5.0, friction: float = 0.6, deg: int = 15, more: str = ""
) -> str:
    return RAMP.format(scene=scene, place=place, duration=duration, friction=friction, deg=deg, more=more)


ROPE = "tie: {kind: chain, links: 8, link_length: 0.1, radius: 0.01, pose: {pos: [3, 0, 3]}}"


@pytest.mark.parametrize(
    ("case", "says"),
    [
        (ramp(), "friction holds `crate` on `ramp` (15 deg, friction 0.6), but it creeps at about 0."),
        (ramp(friction=1.0), "noslip_iterations: 10"),
        (ramp(f"{PYRAMID}\n  solver: {{noslip_iterations: 10}}", friction=1.0), ""),
        (
            ramp(f"{PYRAMID}\n  solver: {{noslip_iterations: 10}}", friction=0.5),
            "creeps",
        ),  # tan 15 deg is more than half
        (ramp(friction=0.28), "at least"),
        (ramp(friction=0.2), ""),  # it slides
        (ramp(duration=1.0), ""),  # too little to be seen
        (ramp(scene="contact: {friction_cone: elliptic}"), ""),
        (ramp(scene=""), ""),  # the cone is chosen by the slope
        (ramp(scene="solver: {kind: cg}"), "creeps"),
        (ramp(place="{on: floor, at: [5, 0]}"), ""),
        (ramp(place="{above: ramp, at: [0, 0], clearance: 0.2, euler_deg: [0, 15, 0]}"), ""),
    ],
)
def test_what_creeps(tmp_path: Path, case: str, says: str) -> None:
    expect_words(tmp_path, "creeps", says, case, path="/bodies/crate")


@pytest.mark.parametrize(
    ("cone", "x", "z", "more", "wanted"),
    [
        ("pyramidal", 0.0164, 0.0427, "", 1),
        ("elliptic", 0.0164, 0.0427, "", 0),
        ("pyramidal", 0.05, 0.0427, "", 0),
        ("pyramidal", 0.0164, 0.3, "", 0),  # both fall
        (
            "pyramidal",
            0.0164,
            0.0427,
            "actions: {controls: {toss: {kind: initial_velocity, body: left, linear: [0, 0, 2]}}}",
            0,
        ),  # both are thrown
    ],
)
def test_cards_that_lean_on_each_other(tmp_path: Path, cone: str, x: float, z: float, more: str, wanted: int) -> None:
    shape = "shape: {kind: box, size: [0.002, 0.06, 0.09]}"
    left, right = (
        f"{{kind: rigid, {shape}, pose: {{pos: [{side}, 0, {z}], euler_deg: [0, {deg}, 0]}}}}"
        for side, deg in ((-x, 20), (x, -20))
    )
    floor = "statics: {floor: {shape: {kind: plane}}}"
    text = f"scene: {{contact: {{friction_cone: {cone}}}, {floor}}}\nbodies: {{left: {left}, right: {right}}}\n{more}"
    assert len(findings(tmp_path, "creeps", text)) == wanted


def test_bodies_on_a_slope_that_stand_apart_do_not_lean_on_each_other(tmp_path: Path) -> None:
    """Upright boxes around two barrels on a slope overlap; the barrels are 2 cm apart."""
    barrel = "{kind: rigid, shape: {kind: cylinder, radius: 0.1, height: 0.6}, pose: {pos: [%s, 0, 1], euler_deg: [0, 15, 0]}}"
    text = f"scene: {{contact: {{friction_cone: pyramidal}}}}\nbodies: {{a: {barrel % 0}, b: {barrel % 0.228}}}"
    assert findings(tmp_path, "creeps", text) == []


GRIPPED = """
scene: {%s, statics: {floor: {shape: {kind: plane}}}}
bodies:
  clamp: {use: clamp, pose: {pos: [0, 0, 0.06]}}
  block: {kind: rigid, shape: {kind: box, size: [0.08, 0.08, 0.1]}, material: {friction: 0.9}, place: {on: floor, at: [0, 0]}}
  %s
actions:
  controls:
    close_left: {kind: drive, joint: clamp.left, position: {kind: ramp, to: 0.06, end: 0.4}}
    close_right: {kind: drive, joint: clamp.right, position: {kind: ramp, to: 0.06, end: 0.4}}
"""


@pytest.mark.parametrize(
    ("scene", "more", "says"),
    [
        ("dt: 0.005", "", ""),  # the cone is chosen by the grip
        ("dt: 0.005, contact: {friction_cone: pyramidal}", "", "close a grip; what friction holds in it creeps out"),
        ("dt: 0.005, contact: {friction_cone: pyramidal}", "", "a box at about 1.3 mm/s"),  # 2 g / 8 k, k = 0.53 ms
        ("dt: 0.005, duration: 0.5, contact: {friction_cone: pyramidal}", "", ""),
        ("dt: 0.005, solver: {noslip_iterations: 10}", "", ""),
        ("dt: 0.005, gravity: [0, 0, 0], contact: {friction_cone: pyramidal}", "", ""),
        ("dt: 0.005, duration: 5", ROPE, "`noslip_iterations: 10` in scene.solver"),
        # They may hold the towel:
        ("dt: 0.005, duration: 5", "towel: {kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.3, 0.3]}, pose: {pos: [2, 0, 1]}}", ""),
    ],
)  # fmt: skip
def test_what_creeps_out_of_a_grip(tmp_path: Path, scene: str, more: str, says: str) -> None:
    expect_words(tmp_path, "creeps", says, GRIPPED % (scene, more), path="/bodies/clamp")


@pytest.mark.parametrize(
    ("scene", "more", "deg", "cone"),
    [
        ("", "", 15, "elliptic"),
        ("", "", 0, "pyramidal"),
        ("", "", 90, "pyramidal"),
        ("solver: {kind: cg}", "", 15, "pyramidal"),
        ("solver: {noslip_iterations: 5}", "", 15, "pyramidal"),
        ("gravity: [0, 0, 0]", "", 15, "pyramidal"),
        ("", "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {restitution: 0.5}, pose: {pos: [5, 0, 1]}}", 15, "pyramidal"),
        ("", "card: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.01]}, pose: {pos: [5, 0, 1], euler_deg: [70, 0, 0]}}", 0, "elliptic"),
        ("", "dice: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, repeat: {kind: packing, count: 5, region: {kind: box, min: [4, 0, 0.2], max: [5, 1, 1]}}}", 0, "pyramidal"),
        ("", ROPE, 15, "pyramidal"),
    ],
)  # fmt: skip
def test_the_cone_follows_from_the_scene(tmp_path: Path, scene: str, more: str, deg: int, cone: str) -> None:
    (tmp_path / "case.yaml").write_text(
        "text2sim: 2\nname: probe\n" + ramp(scene, "{on: floor, at: [3, 0]}", deg=deg, more=more)
    )
    assert resolve_case(load_case(tmp_path)).settings.cone == cone
