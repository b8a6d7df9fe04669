"""Bodies that hang in the air as the film begins, and those that something holds, throws or hides."""

from pathlib import Path

import pytest
from lint_support import expect_words

BALL = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1.5]}}}"
CAMERA = "render: {cameras: {main: {kind: still, from: [0, -6, 1], look_at: [0, 0, 0.8]}}}"
SHELF = "scene: {statics: {shelf: {shape: {kind: box, size: [0.4, 0.02, 0.4]}, pose: {pos: [0, 0.13, 1.5]}%s}}}"


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (
            "bodies: {}",
            "`ball` hangs in the air when the film begins, and nothing is seen that holds it: it falls 1.4 m",
        ),
        ("scene: {gravity: [0, 0, 0]}", ""),
        ("bodies: {ball: {pose: {pos: [0, 0, 0.3]}}}", ""),  # it falls 0.2 m, less than the diagonal 0.35 m
        ("bodies: {ball: {pose: {pos: [0, 0, 4]}}}", ""),  # above the picture
        ("bodies: {ball: {look: {visible: false}}}", ""),
        ("bodies: {ball: {mount: {kind: slider, axis: z}}}", ""),
        ("render: {cameras: null}", ""),
        ("render: {during: [0.15, 1]}", ""),
        ("render: {shots: {a: {camera: main, from: 0.2}}}", ""),
        ("actions: {controls: {toss: {kind: initial_velocity, body: ball, linear: [1, 0, 0]}}}", ""),
        ("actions: {controls: {lift: {kind: force, body: ball, force: [0, 0, 60]}}}", ""),
        (SHELF % "", ""),
        (SHELF % ", look: {visible: false}", "hangs in the air"),
    ],
)
def test_what_hangs_in_the_air(tmp_path: Path, more: str, says: str) -> None:
    expect_words(tmp_path, "hangs-in-air", says, BALL, CAMERA, more, path="/render/cameras/main" if says else None)
