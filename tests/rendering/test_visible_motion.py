"""What counts as motion in the pictures of a film: bodies that move in space and in the picture."""

from math import radians, tan
from typing import Any

import numpy as np
import pytest
from filmed import FILM, MakeRun

from text2sim.legibility.visible_motion import visible_motion
from text2sim.recording.film_record import read_recording
from text2sim.templates.cadence import MAIN, frames, reels

STILL: dict[str, Any] = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4.0, 0.4), "look_at": (0, 0, 0.4)}
FOLLOW: dict[str, Any] = {
    "kind": "follow", "up": (0, 0, 1), "fov": 40.0, "offset": (0, -4.0, 0), "body": "truck", "link": None, "smooth": 0.0,
}  # fmt: skip
PAST: dict[str, Any] = STILL | {"kind": "dolly", "to": (1.0, -4.0, 0.4)}
HEIGHT = 2 * 4.0 * tan(radians(20))
"""Height of the picture where the bodies are, four metres away [m]."""
TRUCK: dict[str, Any] = {"half": 0.2, "pos": (0, 0, 0.4), "velocity": (1.0, 0, 0)}
LOAD: dict[str, Any] = TRUCK | {"velocity": (1.0, 0, 0), "during": (0.0, 0.2)}
WALL: dict[str, Any] = {"half": 0.2, "pos": (0, 0, 0.4)}


def motion(make_run: MakeRun, camera: dict[str, Any], boxes: dict[str, Any], **film: Any) -> np.ndarray:
    recording = read_recording(make_run(boxes, cameras={"main": camera}, **film))
    shown = frames(recording.film, reels(recording.film)[MAIN], recording.last)
    assert len(shown) == 4
    return visible_motion(recording, shown)


def test_a_body_that_passes_moves_by_its_way_in_heights_of_the_picture(make_run: MakeRun) -> None:
    found = motion(make_run, STILL, {"truck": TRUCK, "wall": WALL})
    np.testing.assert_allclose(found, np.arange(4) * 0.1 / HEIGHT, rtol=1e-4)


def test_a_camera_that_follows_shows_only_what_goes_another_way(make_run: MakeRun) -> None:
    """The load stays behind the truck from 0.2 s on, though it is the truck that moves in space from there on."""
    away = LOAD | {"velocity": (2.0, 0, 0)}
    found = motion(make_run, FOLLOW, {"truck": TRUCK, "load": TRUCK, "tall": away})
    np.testing.assert_allclose(found[:3], np.arange(3) * 0.1 / HEIGHT, rtol=1e-3)
    assert found[3] == pytest.approx(found[2]), "the tall one rests in space, and the others in the picture"


def test_a_camera_that_travels_past_moves_nothing(make_run: MakeRun) -> None:
    waits = TRUCK | {"velocity": (0.0, 0, 0)}
    assert not motion(make_run, PAST, {"truck": waits, "wall": WALL}).any()


def test_what_spins_in_place_or_is_out_of_the_picture_shows_no_motion(make_run: MakeRun) -> None:
    spins = TRUCK | {"velocity": (0.0, 0, 0), "spin": 3.0}
    assert not motion(make_run, STILL, {"wheel": spins, "far": TRUCK | {"pos": (9.0, 0, 0.4)}}).any()


def test_links_of_a_body_count_in_proportion_and_replays_and_cuts_do_not(make_run: MakeRun) -> None:
    still = {"half": 0.1, "pos": (0, 0, 0.1), "velocity": (0.0, 0, 0), "of": "arm"}
    boxes = {"arm": TRUCK, "hand": still}
    np.testing.assert_allclose(motion(make_run, STILL, boxes), np.arange(4) * 0.05 / HEIGHT, rtol=1e-4)
    shots = [{"camera": "main", "from": a, "to": b, "speed": 0.5, "hold": 0.0} for a, b in ((0.2, 0.3), (0.0, 0.1))]
    found = motion(make_run, STILL, boxes, shots=shots, fps=FILM["fps"])
    np.testing.assert_allclose(found, [0, 0.025 / HEIGHT, 0.025 / HEIGHT, 0.025 / HEIGHT], rtol=1e-4)
