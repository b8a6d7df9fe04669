"""Cameras inside a body, below the ground, or at the point they look at, at rest and along their path."""

from pathlib import Path

from lint_support import findings

BALL = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}}"
BLOCK = "scene: {statics: {block: {shape: {kind: box, size: [1, 1, 2]}, place: {on: floor, at: [3, 0]}}}}"


def camera(text: str) -> str:
    return f"render: {{cameras: {{main: {{{text}}}}}}}"


def test_a_way_through_a_block(tmp_path: Path) -> None:
    way = "kind: dolly, from: [2, -4, 1], to: [4, 4, 1], look_at: ball"
    (found,) = findings(tmp_path, "camera-inside", BALL, BLOCK, camera(way))
    assert "`main` is inside `block` after" in found.message
    round_it = "kind: keyframed, times: [0, 1], positions: [[2, -4, 1], [1, -2, 1]], look_at: ball"
    assert findings(tmp_path, "camera-inside", BALL, BLOCK, camera(round_it)) == []


def test_keyframes_that_come_to_what_they_look_at(tmp_path: Path) -> None:
    way = "kind: keyframed, times: [0, 0.2], positions: [[0, -4, 1], [0, 0, 0.5]], look_at: ball"
    (found,) = findings(tmp_path, "camera-path", BALL, camera(way))
    assert found.severity == "error"


def test_below_the_ground(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "camera-inside", BALL, camera("kind: still, from: [0, -4, -1], look_at: [0, 0, 0.5]"))
    assert "1 m below `floor`" in found.message


def test_in_the_hollow_of_a_tube_is_not_inside(tmp_path: Path) -> None:
    tube = "scene: {statics: {tube: {shape: {kind: tube, outer_radius: 1, inner_radius: 0.8, height: 2}, pose: {pos: [0, 0, 1]}}}}"
    ball = BALL.replace("[0, 0, 0.5]", "[3, 0, 0.5]")
    for x, count in ((0, 0), (0.9, 1)):  # on the axis; in the wall
        inside = camera(f"kind: still, from: [{x}, 0, 1], look_at: [3, 0, 0.5]")
        assert len(findings(tmp_path, "camera-inside", tube, ball, inside)) == count


def test_a_camera_at_its_target_is_an_error(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "camera-path", BALL, camera("kind: still, from: [0, 0, 0.5], look_at: ball"))
    assert (found.path, found.severity) == ("/render/cameras/main/look_at", "error")
