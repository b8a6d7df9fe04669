"""Polished metal mirrors a room where a film shows nothing: its radiance is reflectance times radiance of what it mirrors."""

from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming
from text2sim.rendering.scene import WALLS
from text2sim.rendering.tone import linear

pytestmark = pytest.mark.usefixtures("tracer")

SILVER = (0.8, 0.8, 0.8)
AHEAD = {"kind": "still", "up": (0, 0, 1), "fov": 4.0, "pos": (0.0, -4.0, 0.3), "look_at": (0, 0, 0.3)}
ASIDE = AHEAD | {"fov": 50.0, "pos": (-3.0, -3.3, 0.3), "look_at": (0, -0.3, 0.3)}
DIM = {"kind": "environment", "strength": 0.02, "color": (1, 1, 1), "horizon": (1, 1, 1)}
ABOUT = 0.2
"""Relative tolerance: a roughness of 0.1 spreads reflections by some degrees, and the room brightens upwards."""


def brightness(make_run: MakeRun, camera: Any, *, strength: float = 0.02, gain: float = 1.0, **others: Any) -> float:
    """Return the radiance in the middle of the face of a silver box, with other boxes beside it."""
    box = {"half": 0.3, "pos": (0, 0, 0.3), "finish": "polished_metal", "color": SILVER}
    lights = {"dome": DIM | {"strength": strength}}
    run = make_run({"box": box} | others, cameras={"main": camera}, lights=lights, gain=gain)
    filming = Filming(read_recording(run), "draft", size=(96, 54))
    return float(np.median(filming.trace(filming.reels()[0].frames[0]).radiance[25:29, 46:50]))


@pytest.mark.parametrize("gain", [1.0, 2.0])
def test_steel_in_a_dim_film_mirrors_a_room_of_the_brightness_of_its_exposure(make_run: MakeRun, gain: float) -> None:
    silver = float(linear(np.array(SILVER))[0])
    assert brightness(make_run, AHEAD, gain=gain) == pytest.approx(silver * WALLS / gain, rel=ABOUT)


def test_a_bright_sky_is_mirrored_as_it_is(make_run: MakeRun) -> None:
    silver = float(linear(np.array(SILVER))[0])
    assert brightness(make_run, AHEAD, strength=2.0) == pytest.approx(silver * 2.0, rel=ABOUT)


def test_a_screen_in_the_scene_hides_the_room(make_run: MakeRun) -> None:
    screen = {"half": 0.5, "pos": (1.5, -1.8, 0.3), "color": (0.0, 0.0, 0.0)}
    assert brightness(make_run, ASIDE, screen=screen) < 0.1 * WALLS < 0.3 * brightness(make_run, ASIDE)
