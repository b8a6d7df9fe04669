"""Statics outside all pictures are not drawn: their shadows would have no cause."""

from typing import Any

import pytest
from filmed import FILM, MakeRun

from text2sim.recording.film_record import FilmRecord, read_recording
from text2sim.rendering.offstage import offstage, views_of
from text2sim.rendering.scene import FilmStage

BALL: dict[str, Any] = {"half": 0.3, "pos": (0, 0, 0.3), "velocity": (0.1, 0, 0)}
BEHIND: dict[str, Any] = {"half": (2.0, 0.1, 2.0), "pos": (0, -5.0, 2.0)}
"""A wall behind the camera, which stands at y = -4 m and looks at the origin."""


def hidden(recording: FilmRecord) -> set[str]:
    return set(offstage(recording, views_of(recording)))


@pytest.mark.usefixtures("tracer")
def test_a_wall_behind_the_camera_is_not_drawn(make_run: MakeRun) -> None:
    shot = read_recording(make_run({"ball": BALL, "wall": BEHIND, "table": {"half": 0.2, "pos": (1, 0, 0.2)}}))
    assert hidden(shot) == {"wall"}
    drawn = {part.body for batch in FilmStage(shot)._rigid for part in batch._parts}
    assert drawn == {"ball", "table"}


@pytest.mark.parametrize(
    "place",
    [
        {"half": (5.0, 5.0, 0.05), "pos": (0, 0, -0.05)},  # a floor on which the camera stands
        {"half": (0.1, 6.0, 2.0), "pos": (1.2, 0, 2.0)},  # a wall from before the camera to behind it
        {"half": 0.2, "pos": (0, 9.0, 0.2)},
    ],
    ids=["floor", "along", "far"],
)
def test_what_is_in_a_picture_is_drawn(make_run: MakeRun, place: dict[str, Any]) -> None:
    assert hidden(read_recording(make_run({"ball": BALL, "thing": place}))) == set()


def test_bodies_and_what_has_lights_of_its_own_are_always_drawn(make_run: MakeRun) -> None:
    moving = {"ball": BALL, "wall": BEHIND | {"velocity": (0, -0.1, 0)}}
    assert hidden(read_recording(make_run(moving))) == set()
    lit = {"backdrop": FILM["backdrop"] | {"own_lights": True}}
    assert hidden(read_recording(make_run({"ball": BALL, "wall": BEHIND}, "lit", **lit))) == set()
