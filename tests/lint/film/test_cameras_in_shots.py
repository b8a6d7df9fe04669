"""Cameras with a frame, a dolly or keyframes: the rules follow them along their path."""

from pathlib import Path

from lint_support import findings

BALL = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}}"
THROW = "actions: {controls: {throw: {kind: initial_velocity, body: ball, linear: [8, 0, 4]}}}"
BLOCK = "scene: {statics: {block: {shape: {kind: box, size: [1, 1, 2]}, place: {on: floor, at: [3, 0]}}}}"


def cameras(**given: str) -> str:
    return "render: {cameras: {" + ", ".join(f"{name}: {{{text}}}" for name, text in given.items()) + "}, SHOTS}"


def test_a_frame_follows_what_is_thrown(tmp_path: Path) -> None:
    still = cameras(main="kind: still, from: [0, -4, 1], look_at: [0, 0, 0.5]").replace("SHOTS", "")
    assert len(findings(tmp_path, "leaves-picture", BALL, THROW, still)) == 1
    frame = cameras(main="kind: still, frame: [ball]").replace("SHOTS", "")
    assert findings(tmp_path, "leaves-picture", BALL, THROW, frame) == []


def test_a_way_through_a_block(tmp_path: Path) -> None:
    way = "kind: dolly, from: [2, -4, 1], to: [4, 4, 1], look_at: ball"
    (found,) = findings(tmp_path, "camera-inside", BALL, BLOCK, cameras(main=way).replace("SHOTS", ""))
    assert "`main` is inside `block` after" in found.message
    round_it = "kind: keyframed, times: [0, 1], positions: [[2, -4, 1], [1, -2, 1]], look_at: ball"
    assert findings(tmp_path, "camera-inside", BALL, BLOCK, cameras(main=round_it).replace("SHOTS", "")) == []


def test_keyframes_that_come_to_what_they_look_at(tmp_path: Path) -> None:
    way = "kind: keyframed, times: [0, 0.2], positions: [[0, -4, 1], [0, 0, 0.5]], look_at: ball"
    (found,) = findings(tmp_path, "camera-path", BALL, cameras(main=way).replace("SHOTS", ""))
    assert found.severity == "error"
