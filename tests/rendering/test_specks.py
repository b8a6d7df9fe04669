"""No black specks: every pixel has a value, and a thin thing its colour."""

import numpy as np
import pytest

from text2sim.rendering.finishes import COLOR, _bitmap, material, rippled
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.shapes import mesh_shape
from text2sim.rendering.trace import VEILED, dimmed, healed


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


def test_wide_reflections_of_glass_fade_and_narrow_ones_stay() -> None:
    gloss = np.zeros((100, 160, 3))
    gloss[20:80, 20:100] = 0.2
    gloss[20:80, 130] = 0.2
    shown = dimmed(gloss, 1.0)
    assert np.allclose(shown[30:70, 30:90], 0.2 * VEILED)
    assert np.allclose(shown[20:80, 130], 0.2)
    assert not shown[gloss == 0].any()


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


@pytest.mark.usefixtures("tracer")
@pytest.mark.parametrize("level", [False, True])
def test_a_level_relief_on_an_upright_wall_is_not_black(level: bool) -> None:
    """Mitsuba's bump maps are undefined there, where the texture runs along z: rippled reliefs are nowhere level."""
    mi = mitsuba()
    relief = np.ones((64, 64)) if level else rippled(np.ones((64, 64)))
    bump = {
        "type": "bumpmap", "texture": _bitmap(relief, raw=True), "scale": 1e-3,
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
    }  # fmt: skip
    corners = np.array([[0, 0, 0], [0, 2, 0], [0, 2, 2], [0, 0, 2]], float)
    wall = mesh_shape(
        "wall", mi.load_dict(bump), corners, np.array([[0, 1, 2], [0, 2, 3]]), np.tile([1.0, 0.0, 0.0], (4, 1)),
        uvs=corners[:, [2, 1]],
    )  # fmt: skip
    scene = mi.load_dict({"type": "scene", "wall": wall, "sky": {"type": "constant"}, "paths": {"type": "path"}})
    pose = mi.ScalarTransform4f().look_at([3, 1, 1], [0, 1, 1], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": "box"}}
    camera = mi.load_dict({"type": "perspective", "fov": 30, "to_world": pose, "film": film})
    seen = np.nan_to_num(np.array(mi.render(scene, sensor=camera, spp=16))[..., :3])
    if level:
        if seen.min() > 0.25:
            pytest.fail("Mitsuba has mended it: `rippled` can go")
    else:
        assert seen.min() > 0.25
