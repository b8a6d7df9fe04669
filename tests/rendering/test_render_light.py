"""Lights give what the language says they give: a white sheet that faces them is as bright as their strength."""

import numpy as np
import pytest
import yaml

from text2sim.compiler.build import plan_case
from text2sim.compiler.looks import oklab
from text2sim.rendering import tone
from text2sim.rendering.lights import emitters
from text2sim.rendering.renderer import mitsuba
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.colors import rgb

pytestmark = pytest.mark.usefixtures("tracer")

WHITE = (1.0, 1.0, 1.0)
DOWN = (0.0, 0.0, -1.0)
AT = (0.0, 0.0, 0.0)
LIGHTS = {
    "sun": {"kind": "sun", "direction": DOWN, "color": WHITE, "strength": 2.0, "angle": 0.02},
    "softbox": {
        "kind": "softbox",
        "direction": DOWN,
        "color": WHITE,
        "strength": 2.0,
        "at": AT,
        "distance": 2.0,
        "size": 1.5,
    },
    "lamp": {"kind": "lamp", "pos": (0, 0, 2.0), "color": WHITE, "strength": 8.0, "radius": 0.1},
    "spot": {
        "kind": "spot",
        "pos": (0, 0, 2.0),
        "look_at": AT,
        "angle": 0.5,
        "blur": 0.2,
        "color": WHITE,
        "strength": 8.0,
    },
    "sky": {"kind": "sky", "direction": (0.5, 0.3, -1.0), "turbidity": 3.0, "strength": 2.0},
    "environment": {"kind": "environment", "color": WHITE, "horizon": WHITE, "strength": 2.0 / np.pi},
}


@pytest.mark.parametrize("kind", LIGHTS)
def test_a_sheet_gets_the_irradiance_that_is_told(kind: str) -> None:
    mi = mitsuba()
    sheet = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().scale([0.02, 0.02, 1]),
        "bsdf": {"type": "diffuse", "reflectance": 1.0},
    }
    above = mi.ScalarTransform4f().look_at([0, -0.2, 0.2], [0, 0, 0], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 2.0, "to_world": above, "film": film}
    scene = mi.load_dict(
        {"type": "scene", "sheet": sheet, "camera": camera, "integrator": {"type": "path"}}
        | emitters({"it": LIGHTS[kind]}, np.zeros(3), 1.0)
    )
    seen = float(np.array(mi.render(scene, spp=256, seed=1))[..., :3].mean())
    assert seen * np.pi == pytest.approx(2.0, rel=0.08)


def test_programs_write_these_lights() -> None:
    places = {
        "softbox": {"direction": [0, 0, -1]},
        "sun": {"direction": [0, 0, -1]},
        "lamp": {"pos": [0, 0, 2]},
        "spot": {"pos": [0, 0, 2], "look_at": [0, 0, 0]},
    }
    lights = {kind: {"kind": kind, **places.get(kind, {})} for kind in LIGHTS}
    case = {
        "text2sim": 2,
        "name": "lit",
        "scene": {"duration": 1, "dt": 0.01},
        "bodies": {"ball": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}},
        "render": {"lights": lights},
    }
    made = plan_case(load_text(yaml.safe_dump(case))).render["lights"]
    assert {kind: set(light) for kind, light in made.items()} == {kind: set(one) for kind, one in LIGHTS.items()}


@pytest.mark.parametrize("curve", ["agx", "aces", "standard"])
def test_curves_keep_black_grey_and_order(curve: str) -> None:
    light = np.array([0.0, 0.02, 0.18, 0.5, 1.0, 4.0])
    shown = tone.developed(np.repeat(light[None, :, None], 3, axis=2), 1.0, curve)[0]
    assert shown[0].max() < 0.01
    assert np.ptp(shown, axis=-1).max() < 0.01, "grey stays grey"
    assert np.all(np.diff(shown[:, 0]) >= 0)
    assert 0.3 < shown[2, 0] < 0.6
    assert 0.75 < shown[4, 0] <= 1.0


@pytest.mark.parametrize("shade", [0.5, 0.25, 0.1])
@pytest.mark.parametrize("color", ["#8f562b", "#1e7d36", "#3d5238", "#6a5440", "#7d9a5b", "#b01c2e", "#f0c8a0"])
def test_colors_in_shade_keep_hue_and_chroma(color: str, shade: float) -> None:
    """Chroma and hue in Oklab against those of the same light at the displayed luminance, which has no tone curve."""
    light = tone.linear(np.array(rgb(color))) * shade
    shown = tone.developed(light[None, None], 1.0, "agx")[0, 0]
    plain = tone.encoded(light * (tone.linear(shown) @ tone.LUMA) / (light @ tone.LUMA))
    (_, *seen), (_, *true) = oklab(tuple(shown)), oklab(tuple(plain))
    assert 0.85 < np.hypot(*seen) / np.hypot(*true) < 1.2
    assert abs(np.degrees(np.arctan2(*seen) - np.arctan2(*true))) < 4
