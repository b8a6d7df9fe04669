"""Springs are in the picture, between their ends and while they act."""

import json
from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming

pytestmark = pytest.mark.usefixtures("tracer")

CAMERA = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0.0, -4.0, 0.0), "look_at": (0, 0, 0)}


def red(make_run: MakeRun, **spring: Any) -> float:
    """Return how much redder than blue the middle of the picture is, with a spring from the left to the right."""
    box = {"half": 0.2, "pos": (0, 0, -0.8), "color": (0.5, 0.5, 0.5)}
    looks = {"pull": {"form": "cord", "radius": 0.15, "color": (1.0, 0.0, 0.0)}}
    run = make_run({"box": box}, cameras={"main": CAMERA}, springs=looks)
    layout = run / "states" / "layout.json"
    row = {"control": "pull", "links": [0, 0], "points": [[-1, 0, 0.8], [1, 0, 0.8]], "length": None}
    row |= {"start": 0.0, "end": 9.0} | spring
    layout.write_text(json.dumps(json.loads(layout.read_text()) | {"springs": [row]}))
    filming = Filming(read_recording(run), "draft", size=(96, 54))
    pixels = filming.trace(filming.reels()[0].frames[0]).radiance[26:28, 46:50]
    return float(np.median(pixels[..., 0] - pixels[..., 2]))


def test_a_cord_is_drawn_in_its_colour_while_it_acts(make_run: MakeRun) -> None:
    assert red(make_run) > 0.2
    assert abs(red(make_run, start=1.0)) < 0.05
