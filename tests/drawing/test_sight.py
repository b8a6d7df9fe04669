"""Poses of a case's cameras at its start, and what they see."""

import math

import pytest
from pictures import resolved

from text2sim.compiler.build import Resolution
from text2sim.drawing.views import camera_pose, cameras, film_view
from text2sim.legibility.layout import at_start

WALL = "wall: {kind: rigid, shape: {kind: box, size: [2, 0.1, 2]}, pose: {pos: [0, 1, 0]}}"
BALL = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.2}, pose: {pos: [0, 2, 0]}}"
RENDER = "{resolution: [320, 180], cameras: {main: {kind: still, from: [0, -3, 0], look_at: [0, 0, 0], fov_deg: 40}}}"


def test_hidden_bodies_are_not_seen() -> None:
    alone = at_start(resolved(BALL, render=RENDER), "main").shares
    behind = at_start(resolved(WALL, BALL, render=RENDER), "main").shares
    assert alone["ball"] > 0.004
    assert "ball" not in behind
    assert behind["wall"] > alone["ball"]


def test_share_is_that_of_the_picture() -> None:
    share = at_start(resolved(WALL, render=RENDER), "main", (640, 360)).shares["wall"]
    focal = 180 / math.tan(math.radians(20))
    assert share == pytest.approx((2 * focal / 3.95) ** 2 / (640 * 360), rel=0.01)


def test_glass_hides_nothing() -> None:
    pane = WALL.replace("pose:", "look: {opacity: 0.2}, pose:")
    seen = at_start(resolved(pane, BALL, render=RENDER), "main").shares
    assert seen["ball"] == pytest.approx(at_start(resolved(BALL, render=RENDER), "main").shares["ball"])
    assert seen["wall"] > seen["ball"]


def test_bodies_smaller_than_a_pixel_are_seen() -> None:
    pin = "pin: {kind: rigid, shape: {kind: sphere, radius: 0.0005}, pose: {pos: [0.303, 0, 0.307]}}"
    share = at_start(resolved(pin, render=RENDER), "main").shares["pin"]
    assert 0 < share < 1 / (160 * 90)
    assert "pin" not in at_start(resolved(pin, WALL.replace("[0, 1, 0]", "[0, -1, 0]"), render=RENDER), "main").shares


def test_bodies_behind_the_camera_or_beside_the_picture_are_not_seen() -> None:
    for pos in ("[0, -4, 0]", "[9, 0, 0]", "[0, 0, 8]"):
        assert "ball" not in at_start(resolved(BALL.replace("[0, 2, 0]", pos), render=RENDER), "main").shares


def test_cameras_move_as_in_the_film(zoo: Resolution) -> None:
    assert list(cameras(zoo)) == ["round", "with", "ride"]
    pos, target, _ = camera_pose(zoo, "round")
    assert pos == pytest.approx((0, -5, 3))
    assert camera_pose(zoo, "round", 2.0).pos == pytest.approx((5, 0, 3)), "a quarter of the way round"
    assert camera_pose(zoo, "with").target == pytest.approx((0, 0, 1))
    assert camera_pose(zoo, "with").pos == pytest.approx((1, -3, 2))
    assert camera_pose(zoo, "ride", 1.0).pos == pytest.approx((0, -4, 2))
    assert target == (0, 0, 0.5)


def test_camera_follows_a_link() -> None:
    case = resolved(
        "rope: {kind: chain, links: 4, link_length: 0.5, radius: 0.02, pose: {pos: [0, 0, 3]}}",
        render="{cameras: {main: {kind: follow, body: rope.link_2, offset: [0, -2, 0]}}}",
    )
    assert camera_pose(case, "main").target == pytest.approx((0, 0, 2))


def test_a_camera_is_derived_that_sees_everything() -> None:
    case = resolved(BALL, "far: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [6, 0, 3]}}")
    assert {"ball", "far"} <= at_start(case, "main").shares.keys()


def test_view_has_the_proportions_of_the_film() -> None:
    render = "{resolution: [400, 800], cameras: {main: {kind: still, from: [0, -3, 0], look_at: [0, 0, 0]}}}"
    view = film_view(resolved(BALL, render=render), "main", (300, 300))
    assert (view.width, view.height) == (150, 300)
