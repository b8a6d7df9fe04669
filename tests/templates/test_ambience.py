"""Shade in hollows, and grounds that fade: from depths that are worked out by hand."""

import numpy as np

from text2sim.templates.ambience import faded, shaded
from text2sim.templates.cameras import View
from text2sim.templates.viewpoints import basis

SIZE = TALL, WIDE = 90, 160
VIEW = View(np.array([0.0, -3.0, 1.0]), np.array([0.0, 0.0, 0.2]), np.array([0.0, 0.0, 1.0]), 40.0, 3.0, 0.0)
GREY, SKY = np.full((*SIZE, 3), 120, np.uint8), (0.8, 0.9, 1.0)


def rays() -> np.ndarray:
    unit = 2 * np.tan(np.radians(VIEW.fov) / 2) / TALL
    right, up, ahead = (np.array(way) for way in basis(VIEW.pos, VIEW.look_at, VIEW.up))
    across, upward = unit * (np.arange(WIDE) + 0.5 - WIDE / 2), -unit * (np.arange(TALL) + 0.5 - TALL / 2)
    return ahead + across[:, None] * right + upward[:, None, None] * up


def depths(wall: float = np.inf) -> np.ndarray:
    """Of the ground z = 0, and of a wall that stands on it, across the view, at y = `wall`."""
    ways = rays()
    with np.errstate(divide="ignore"):
        ground, upright = -VIEW.pos[2] / ways[..., 2], (wall - VIEW.pos[1]) / ways[..., 1]
    return np.minimum(np.where(ground > 0, ground, np.inf), np.where(upright > 0, upright, np.inf))


def test_what_is_flat_is_not_shaded_and_the_foot_of_a_wall_is() -> None:
    flat = depths()
    assert np.array_equal(shaded(GREY, flat, VIEW.fov)[20:], GREY[20:])
    depth = depths(wall=0.5)
    picture = shaded(GREY, depth, VIEW.fov)[..., 0].astype(int)
    foot = int(np.argmin(picture[:, WIDE // 2]))
    height = (VIEW.pos[2] + depth * rays()[..., 2])[foot, WIDE // 2]
    assert abs(height) < 0.05
    assert picture[foot, WIDE // 2] < 100
    assert picture[5, WIDE // 2] == picture[-5, WIDE // 2] == 120
    assert np.abs(picture[foot] - picture[foot, ::-1]).max() <= 1, "left and right are alike"


def test_what_hides_something_far_behind_it_casts_no_shade_there() -> None:
    depth = np.full(SIZE, 50.0)
    depth[30:60, 60:100] = 2.0
    picture = shaded(GREY, depth, VIEW.fov)
    assert (picture == GREY).all()


def test_a_ground_is_the_background_where_it_ends_and_bodies_on_it_stay() -> None:
    depth = depths()
    x, y = (VIEW.pos[k] + depth * rays()[..., k] for k in (0, 1))
    away = np.hypot(x, y)
    depth[away > 6] = np.inf
    body = np.zeros(SIZE, bool)
    body[30:50, 20:40] = True
    depth[body] *= 0.9
    depth *= 1.002  # as the rasteriser has it: of a place beside the middle of the pixel
    picture = faded(GREY, depth.astype(np.float32), VIEW, [((0.0, 0.0, 0.0), 6.0)], SKY)
    background = (np.array(SKY) * 255).astype(int)
    rim = (away > 5.8) & (away < 6) & ~body
    assert rim.any()
    assert np.abs(picture[rim].astype(int) - background).max() <= 1
    assert (picture[(away < 2) | body] == 120).all()
