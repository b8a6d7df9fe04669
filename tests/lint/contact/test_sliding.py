"""Bodies that start to slide: the lift by the pyramidal cone, as measured in the engine."""

import re
from pathlib import Path

import pytest
from lint_support import findings

BODY = "bodies: {{b: {{kind: rigid, shape: {0}, material: {{friction: {1}}}, pose: {{pos: [0, 0, {2}]}}}}}}"
BOX, SPHERE = "{kind: box, size: [0.2, 0.2, 0.2]}", "{kind: sphere, radius: 0.1}"
FLOOR = "scene: {duration: 2, statics: {floor: {material: {friction: 0.01}}}}"
PUSH = "actions: {{controls: {{go: {{kind: initial_velocity, body: b, linear: {0}, angular: {1}}}}}}}"


def slides(folder: Path, *parts: str) -> list[str]:
    return [problem.message for problem in findings(folder, "sliding-start", FLOOR, *parts)]


@pytest.mark.parametrize(
    ("shape", "friction", "speed", "lift"),
    # Runs of the engine, substeps of 2.5 ms: largest speed upwards.
    [
        (BOX, 0.2, 5, 0.97),
        (BOX, 0.5, 5, 2.02),
        (BOX, 0.5, 12, 4.91),
        (BOX, 0.8, 12, 5.76),
        (SPHERE, 0.2, 12, 2.15),
        (SPHERE, 0.5, 12, 3.18),
        (SPHERE, 0.8, 5, 1.13),
    ],
)
def test_the_lift_is_what_the_engine_gave(
    tmp_path: Path, shape: str, friction: float, speed: float, lift: float
) -> None:
    (text,) = slides(tmp_path, BODY.format(shape, friction, 0.1), PUSH.format(f"[{speed}, 0, 0]", "[0, 0, 0]"))
    found = re.search(r"throws it up at ([\d.]+) m/s", text)
    assert found
    assert float(found[1]) == pytest.approx(lift, rel=0.08)


@pytest.mark.parametrize(
    ("part", "height", "linear", "angular"),
    [
        ("{}", 0.1, "[0.3, 0, 0]", "[0, 0, 0]"),
        ("scene: {contact: {friction_cone: elliptic}}", 0.1, "[5, 0, 0]", "[0, 0, 0]"),
        ("scene: {gravity: [0, 0, 0]}", 0.1, "[5, 0, 0]", "[0, 0, 0]"),
        ("{}", 0.11, "[5, 0, 0]", "[0, 0, 0]"),
        ("{}", 0.1, "[5, 0, 1]", "[0, 0, 0]"),
    ],
)
def test_what_is_slow_or_in_the_air_is_fine(
    tmp_path: Path, part: str, height: float, linear: str, angular: str
) -> None:
    assert slides(tmp_path, BODY.format(BOX, 0.5, height), PUSH.format(linear, angular), part) == []


def test_a_ball_that_rolls_is_fine(tmp_path: Path) -> None:
    ball = BODY.format(SPHERE, 0.5, 0.1)
    (text,) = slides(tmp_path, ball, PUSH.format("[3, 4, 0]", "[0, 0, 0]"))
    found = re.search(r"`angular: (\[.*?\])`", text)
    assert found
    assert slides(tmp_path, ball, PUSH.format("[3, 4, 0]", found[1])) == []


def test_on_something_else_than_the_ground(tmp_path: Path) -> None:
    table = "scene: {statics: {table: {shape: {kind: box, size: [2, 2, 0.1]}, pose: {pos: [0, 0, 0.95]}, material: {friction: 0.7}}}}"
    (text,) = slides(tmp_path, table, BODY.format(BOX, 0.5, 1.1), PUSH.format("[5, 0, 0]", "[0, 0, 0]"))
    assert "along `table` at 5 m/s (friction 0.7)" in text


def test_a_load_on_a_driven_cart_is_fine(tmp_path: Path) -> None:
    cart = """
    bodies:
      cart:
        kind: rigid
        shape: {kind: box, size: [2, 2, 0.1]}
        pose: {pos: [0, 0, 0.95]}
        mount: {kind: slider, axis: x, actuator: {damping: 1e6}}
    """
    load, push = BODY.format(BOX, 0.5, 1.1), PUSH.format("[5, 0, 0]", "[0, 0, 0]")
    (text,) = slides(tmp_path, cart, load, push)
    assert "along `cart`" in text
    drive = "actions: {controls: {cruise: {kind: drive, joint: cart, velocity: 5}}}"
    assert slides(tmp_path, cart, load, push, drive) == []
    assert slides(tmp_path, cart.replace("axis: x,", "axis: x, initial_velocity: 5,"), load, push) == []


def test_only_flat_nets_are_named(tmp_path: Path) -> None:
    net = "bodies: {net: {kind: net, cells: [4, 4], size: [1, 2], radius: 0.01, sag: %s, pose: {pos: [0, 0, 1]}}}"
    (found,) = findings(tmp_path, "flat-net", net % 0)
    assert "`sag: 0.1`" in found.message
    assert findings(tmp_path, "flat-net", net % 0.02) == []
