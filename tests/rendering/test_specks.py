"""No black specks: every pixel has a value, and a thin thing its colour."""

import numpy as np
import pytest

from text2sim.rendering.finishes import COLOR, material
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.shapes import mesh_shape
from text2sim.rendering.trace import healed


def test_a_pixel_without_a_value_is_like_those_around_it() -> None:
    picture = np.random.default_rng(0).uniform(1, 2, (12, 16, 3)).astype(np.float32)
    broken = picture.copy()
    broken[3, 4] = np.nan
    broken[7:10, 7:12, 1] = np.inf
    mended = healed(broken)
    lost = ~np.isfinite(broken).all(axis=-1)
    assert np.array_equal(mended[~lost], picture[~lost])
    assert mended[lost].min() >= 1
    assert mended[lost].max() <= 2
    around = np.delete(picture[2:5, 3:6].reshape(9, 3), 4, axis=0).mean(axis=0)
    assert np.allclose(mended[3, 4], around, rtol=1e-5)


def test_a_picture_without_any_value_is_black() -> None:
    assert not healed(np.full((4, 4, 3), np.nan, np.float32)).any()


@pytest.mark.usefixtures("tracer")
def test_a_thread_has_its_color_everywhere() -> None:
    """In single precision the weights of the corners of such triangles are 0 / 0."""
    mi, color = mitsuba(), (0.3, 0.2, 0.1)
    corners = np.array([[0, 0, 0], [0, 0, 0.45], [1e-5, 0, 0], [1e-5, 0, 0.45]]) + (0.3, 0.1, 0.4)
    thread = mesh_shape(
        "thread", material("rough"), corners, np.array([[0, 2, 1], [2, 3, 1]]), np.tile([0.0, -1.0, 0.0], (4, 1)),
        colors=np.tile(color, (4, 1)),
    )  # fmt: skip
    found = mi.SurfaceInteraction3f()
    found.prim_index, found.p = 0, mi.Point3f(0.3000003, 0.1, 0.61)
    assert np.allclose(np.array(thread.eval_attribute_3(COLOR, found)).ravel(), color)
