"""Views of pictures against the cameras of the film."""

import math

import numpy as np
import pytest

from text2sim.drawing.view import look, parallel, perspective

POINTS = np.array([(0.0, 0.0, 0.0), (0.5, 0.3, 0.2), (-0.4, 1.0, 0.6), (0.2, -0.5, -0.3)])


def film_pixels(points, pos, target, up, fov, size):
    """Where the film has points: the engine's `pos_lookat_up_to_T`, and OpenGL's projection of a vertical angle."""
    z = np.array(pos, float) - np.array(target, float)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    if np.linalg.norm(x) < 1e-9:
        rotation = np.eye(3)
    else:
        x /= np.linalg.norm(x)
        rotation = np.stack([x, np.cross(z, x), z], axis=1)
    eye = (np.array(points) - pos) @ rotation
    f = 1 / math.tan(math.radians(fov) / 2)
    ndc_x = eye[:, 0] * f / (size[0] / size[1]) / -eye[:, 2]
    ndc_y = eye[:, 1] * f / -eye[:, 2]
    return np.stack([(ndc_x + 1) / 2 * size[0], (1 - ndc_y) / 2 * size[1]], axis=1)


@pytest.mark.parametrize(
    ("pos", "target", "up", "fov", "size"),
    [
        ((2.6, -2.8, 1.3), (0, 0, 0.35), (0, 0, 1), 35, (1280, 720)),
        ((-1.0, 4.0, 0.2), (0, 1, 0), (0, 0, 1), 70, (640, 640)),
        ((0.0, -3.0, 0.0), (0, 0, 0), (1, 0, 1), 20, (400, 800)),
        ((0.0, 0.0, 5.0), (0, 0, 0), (0, 0, 1), 40, (320, 240)),
    ],
)
def test_points_fall_on_the_pixels_of_the_film(pos, target, up, fov, size) -> None:
    mine = perspective(pos, target, up, fov, size).pixels(POINTS)
    assert mine == pytest.approx(film_pixels(POINTS, pos, target, up, fov, size), abs=0.01)


def test_looking_straight_down_has_y_up() -> None:
    axes = look((0, 0, 5), (0, 0, 0))
    assert axes == pytest.approx(np.eye(3))


def test_points_behind_the_eye_have_no_pixel() -> None:
    view = perspective((0, -1, 0), (0, 0, 0), (0, 0, 1), 40, (100, 100))
    assert np.isnan(view.pixels((0.0, -2.0, 0.0))).all()


def test_lines_of_sight_lead_back_to_the_points() -> None:
    for view in (
        perspective((2, -3, 1), (0, 0, 0), (0, 0, 1), 50, (300, 200)),
        parallel(look((2.0, -3.0, 1.0), (0.0, 0.0, 0.0)), (2.0, -3.0, 1.0), 40.0, (300, 200)),
    ):
        pixels, depth = view.pixels(POINTS), -view.local(POINTS)[:, 2]
        start, way = view.sight(pixels[:, 0], pixels[:, 1])
        assert (start + way * depth).T == pytest.approx(POINTS, abs=1e-5)
