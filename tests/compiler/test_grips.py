"""Grips: what motors close on each other, and the friction cone that follows."""

from pathlib import Path

import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.compiler.grips import grips
from text2sim.spec_schema.load import load_case

CLAMP = "clamp: {use: clamp, pose: {pos: [0, 0, 0.06]}}"
BLOCK = "block: {kind: rigid, shape: {kind: box, size: [0.08, 0.08, 0.1]}, place: {on: floor, at: [0, 0]}}"
CLOSE = """
    left: {kind: drive, joint: clamp.left, position: {kind: ramp, to: 0.06, end: 0.4}}
    right: {kind: drive, joint: clamp.right, position: {kind: ramp, to: 0.06, end: 0.4}}
    lift: {kind: drive, joint: clamp.lift, position: {kind: ramp, to: 0.2, start: 0.5, end: 1}}"""
FINGER = """
      {name}:
        parent: palm
        shape: {{kind: box, size: [0.01, 0.03, 0.1]}}
        pose: {{pos: [{x}, 0, -0.08]}}
        joint: {{kind: hinge, axis: y, anchor: [0, 0, 0.05], actuator: {{stiffness: 50, damping: 1, max_force: 5}}}}"""
HAND = "hand:\n    kind: articulated\n    base: fixed\n    pose: {pos: [0, 0, 0.5]}\n    links:\n      palm: {shape: {kind: box, size: [0.2, 0.05, 0.02]}}" + "".join(
    FINGER.format(name=name, x=x) for name, x in (("thumb", -0.06), ("finger", 0.06))
)  # fmt: skip
JAW = "{{kind: rigid, shape: {{kind: box, size: [0.04, 0.1, 0.1]}}, pose: {{pos: [{x}, 0, 0.1]}}, mount: {{kind: slider, axis: x, actuator: {{stiffness: 5000, damping: 200, max_force: 20}}}}}}"
JAWS = f"a: {JAW.format(x=-0.1)}\n  b: {JAW.format(x=0.1)}"
ROPE = "{kind: chain, links: 5, link_length: 0.1, radius: 0.01, pose: {pos: [3, 0, 3]}}"


def resolved(folder: Path, bodies: str, controls: str, scene: str = "") -> Resolution:
    (folder / "case.yaml").write_text(
        f"text2sim: 2\nname: probe\nscene:\n  duration: 2\n  dt: 0.005\n  {scene}\n"
        f"  statics: {{floor: {{shape: {{kind: plane}}}}}}\n"
        f"bodies:\n  {bodies}\nactions:\n  controls: {controls}\n"
    )
    return resolve_case(load_case(folder))


def drives(a: str, to_a: str, b: str, to_b: str) -> str:
    return f"\n    a: {{kind: drive, joint: {a}, {to_a}}}\n    b: {{kind: drive, joint: {b}, {to_b}}}"


@pytest.mark.parametrize(
    ("bodies", "controls", "pairs"),
    [
        (f"{CLAMP}\n  {BLOCK}", CLOSE, [("left", "right")]),
        (CLAMP, CLOSE, []),  # nothing to grip
        (f"{CLAMP}\n  {BLOCK.replace('place', 'mount: {kind: fixed}, place')}", CLOSE, []),
        (f"{CLAMP}\n  {BLOCK}", drives("clamp.left", "position: 0.06", "clamp.right", "position: 0"), []),  # one stays
        (f"{CLAMP}\n  {BLOCK}", drives("clamp.left", "force: 20", "clamp.right", "force: 20"), [("left", "right")]),
        (f"{CLAMP}\n  {BLOCK}", drives("clamp.left", "force: 20", "clamp.right", "force: -20"), []),  # both to the right
        (f"{HAND}\n  {BLOCK}", drives("hand.thumb", "position: -0.5", "hand.finger", "position: 0.5"), [("thumb", "finger")]),
        (f"{HAND}\n  {BLOCK}", drives("hand.thumb", "position: 0.5", "hand.finger", "position: -0.5"), []),  # they open
        (f"{HAND}\n  {BLOCK}", drives("hand.thumb", "position: -0.5", "hand.finger", "position: -0.5"), []),
        (f"{JAWS}\n  {BLOCK}", drives("a", "position: 0.05", "b", "position: -0.05"), [("a", "b")]),
    ],
)  # fmt: skip
def test_jaws_close_on_each_other(tmp_path: Path, bodies: str, controls: str, pairs: list[tuple[str, str]]) -> None:
    made = resolved(tmp_path, bodies, controls)
    moving = [copy for name in made.loaded.case.bodies for copy in made.placed[name]]
    assert [(a.joint, b.joint) for a, b in grips(moving, made.lowering.trees, made.rows)] == pairs
    assert made.settings.cone == ("elliptic" if pairs else "pyramidal")


def test_jaws_that_close_at_an_event_count(tmp_path: Path) -> None:
    late = CLOSE.replace("kind: drive, joint: clamp.left", "kind: drive, on: up, joint: clamp.left")
    events = "\n  measures: {z: {kind: position, of: block, axis: z}}\n  events: {up: {kind: threshold, measure: z, above: 1}}"
    made = resolved(tmp_path, f"{CLAMP}\n  {BLOCK}", late + events)
    assert made.settings.cone == "elliptic"


@pytest.mark.parametrize(
    ("scene", "more"),
    [
        ("solver: {kind: cg}", ""),
        ("solver: {noslip_iterations: 10}", ""),
        ("contact: {friction_cone: pyramidal}", ""),
        ("", f"rope: {ROPE}"),
        ("", "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {restitution: 0.5}, pose: {pos: [5, 0, 1]}}"),
    ],
)  # fmt: skip
def test_the_exact_cone_is_not_for_all_grips(tmp_path: Path, scene: str, more: str) -> None:
    assert resolved(tmp_path, f"{CLAMP}\n  {BLOCK}\n  {more}", CLOSE, scene).settings.cone == "pyramidal"
