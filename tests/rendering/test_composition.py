"""Cameras that cut something off are turned and widened slightly; what does not fit is left."""

import math
from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.legibility.film import Watcher
from text2sim.recording.film_record import FilmRecord, read_recording
from text2sim.rendering.composition import EDGE, WIDEST, composed

LOW, FIRST = (0, 0, 0.3), {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0.0, -4.0, 0.5)}
BOX: dict[str, Any] = {"half": 0.3, "pos": LOW, "velocity": (0.1, 0, 0)}
LAMP: dict[str, Any] = {"half": 0.1, "pos": (0, 0, 2.8), "velocity": (0.01, 0, 0)}
SLOPE = math.tan(math.radians(20))
WRITTEN = {"cameras": {"main": {"kind": "still"}}}


def filmed(make_run: MakeRun, boxes: dict[str, Any], **camera: Any) -> FilmRecord:
    return read_recording(make_run(boxes, cameras={"main": FIRST | camera}))


def changed(recording: FilmRecord) -> dict[str, Any]:
    """The fields of the camera that a patch sets."""
    return {row["path"].rsplit("/", 1)[1]: row.get("value") for row in composed(recording, WRITTEN)}


def inside(recording: FilmRecord, name: str, **camera: Any) -> float:
    """The least fraction of a body's points in the pictures of a camera."""
    recording.film["cameras"]["main"].update(camera)
    watcher = Watcher(recording)
    k = watcher.recorded.names.index(name)
    return min(
        float(watcher.recorded.sight(t, watcher.cameras.view("main", t), watcher.size).inside[k]) for t in (0.0, 0.4)
    )


def test_a_box_whose_corner_is_cut_comes_whole_into_the_picture(make_run: MakeRun) -> None:
    # The camera points atan(1 / 4) = 14.0 deg up and sees 20 deg down from there; the lower front edge of the box, 3.7 m
    # away and 0.5 m below the camera, lies 14.0 + 7.7 deg down: tan 21.7 / tan 20 = 1.095 half heights from the middle.
    shot = filmed(make_run, {"box": BOX}, look_at=(0, 0, 1.5))
    assert inside(shot, "box") < 1
    patch = changed(shot)
    assert set(patch) == {"look_at"}, "there is room above: nothing becomes smaller"
    x, y, z = patch["look_at"]
    lowered = math.degrees(math.atan2(1, 4) - math.atan2(z - 0.5, y + 4))
    assert math.tan(math.radians(lowered)) / SLOPE == pytest.approx(1.095 + EDGE - 1, abs=0.02)
    assert abs(x) < 0.01
    assert inside(shot, "box", look_at=(x, y, z)) == 1


def test_what_was_whole_stays_whole(make_run: MakeRun) -> None:
    shot = filmed(make_run, {"box": BOX, "lamp": LAMP}, look_at=(0, 0, 1.5))
    assert inside(shot, "lamp") == 1
    patch = changed(shot)
    assert SLOPE < math.tan(math.radians(patch["fov_deg"] / 2)) <= WIDEST * SLOPE + 1e-3
    new = {"fov": patch["fov_deg"], "look_at": patch["look_at"]}
    assert inside(shot, "box", **new) == inside(shot, "lamp", **new) == 1


@pytest.mark.parametrize("half", [(3, 3, 0.3), (0.3, 0.3, 2.5)], ids=["wider than the picture", "taller"])
def test_what_does_not_fit_is_left_as_it_is(make_run: MakeRun, half: tuple[float, ...]) -> None:
    assert not changed(filmed(make_run, {"box": BOX | {"half": np.array(half)}}, look_at=(0, 0, 0.3)))


def test_a_film_that_cuts_nothing_stays_as_it_is(make_run: MakeRun) -> None:
    assert not changed(filmed(make_run, {"box": BOX}, look_at=(0, 0, 0.5)))


def test_a_written_lens_gives_way_to_a_field_of_view(make_run: MakeRun) -> None:
    shot = filmed(make_run, {"box": BOX, "lamp": LAMP}, look_at=(0, 0, 1.5))
    patch = composed(shot, {"cameras": {"main": {"kind": "still", "lens_mm": 33}}})
    assert [(row["op"], row["path"]) for row in patch][:2] == [
        ("remove", "/render/cameras/main/lens_mm"),
        ("add", "/render/cameras/main/fov_deg"),
    ]
    assert not composed(shot, {"cameras": {"other": {"kind": "still"}}}), "a camera that the case does not write"


def test_a_camera_that_follows_becomes_wider_and_keeps_its_target(make_run: MakeRun) -> None:
    # The front of the box, 3.7 m away, spans 2 atan(0.3 / 3.7) = 9.3 deg, its back 2 atan(0.3 / 4.3) = 8.0 deg.
    follow = {"kind": "follow", "body": "box", "link": None, "smooth": 0.0, "offset": (0, -4.0, 0), "fov": 8.5}
    shot = filmed(make_run, {"box": BOX}, **follow)
    assert 0.5 < inside(shot, "box") < 0.9
    patch = changed(shot)
    assert set(patch) == {"fov_deg"}
    assert inside(shot, "box", fov=patch["fov_deg"]) == 1


def test_the_last_shot_ends_when_all_has_come_to_rest(make_run: MakeRun) -> None:
    still = {"box": BOX | {"velocity": (0, 0, 0)}}
    shots = [
        {"name": "one", "camera": "main", "from": 0.0, "to": 0.1, "speed": 0.1, "hold": 0.0},
        {"name": "rest", "camera": "main", "from": 0.1, "to": 0.4, "speed": 0.1, "hold": 0.5},
    ]
    cameras = {"main": FIRST | {"look_at": (0, 0, 0.5)}}
    written = WRITTEN | {"shots": {"one": {}, "rest": {}}}
    # It is at rest from the start: 1.5 s of film at a tenth of the speed are 0.15 s.
    ended = composed(read_recording(make_run(still, cameras=cameras, shots=shots)), written)
    assert ended == [{"op": "add", "path": "/render/shots/rest/to", "value": 0.25}]
    quick = {"box": BOX | {"velocity": (0.5, 0, 0)}}
    moving = read_recording(make_run(quick, "moving", cameras=cameras, shots=shots))
    assert composed(moving, written) == [], "it moves to the end"


@pytest.mark.parametrize("camera", ["still", "keyframed"])
def test_rest_at_both_ends_is_cut_to_less_than_a_second_of_film(make_run: MakeRun, camera: str) -> None:
    """A box that moves from 0.2 s to 0.3 s of 0.4 s, at a twentieth of its speed: 4 s and 2 s of film at rest."""
    path = {"kind": "keyframed", "times": (0.0, 0.4), "positions": ((0, -4, 0.5),) * 2, "look_at": [(0, 0, 0.5)] * 2}
    views = {"still": FIRST | {"look_at": (0, 0, 0.5)}, "keyframed": {"up": (0, 0, 1), "fov": 40.0} | path}
    shots = [
        {"name": "a", "camera": "main", "from": 0.0, "to": 0.25, "speed": 0.05, "hold": 0.0},
        {"name": "b", "camera": "main", "from": 0.25, "to": 0.4, "speed": 0.05, "hold": 0.0},
    ]
    paused = {"box": BOX | {"velocity": (3, 0, 0), "during": (0.2, 0.3)}}
    run = make_run(paused, cameras={"main": views[camera]}, shots=shots)
    written = WRITTEN | {"shots": {"a": {}, "b": {}}}
    assert composed(read_recording(run), written, "From the front, eight seconds.") == [], "it is as long as was asked"
    patch = composed(read_recording(run), written, "It slides after 0.2 s and stops within three seconds.")
    found: dict[str, Any] = {row["path"].removeprefix("/render/shots/"): row.get("value") for row in patch}
    assert set(found) == {"a/from", "b/to"}
    assert 0.2 - 1.0 * 0.05 <= found["a/from"] <= 0.2
    assert 0.3 <= found["b/to"] <= 0.3 + 1.0 * 0.05


@pytest.mark.parametrize(("speed", "fits"), [(3.5, True), (12.0, False)])
def test_a_keyframed_camera_draws_back_from_a_body_that_rises(make_run: MakeRun, speed: float, *, fits: bool) -> None:
    """The picture ends 1.86 m above the ground at the box: its top rises from 0.6 m to 2 m, or to 5.4 m."""
    path = {"kind": "keyframed", "times": [0.0, 0.4], "positions": [(0, -4, 0.5)] * 2, "look_at": [(0, 0, 0.5)] * 2}
    cameras = {"main": {"up": (0, 0, 1), "fov": 40.0} | path}
    shots = [{"name": "a", "camera": "main", "from": 0.0, "to": 0.4, "speed": 0.1, "hold": 0.0}]
    shot = read_recording(make_run({"box": BOX | {"velocity": (0, 0, speed)}}, cameras=cameras, shots=shots))
    assert inside(shot, "box") < 1
    patch: dict[str, Any] = changed(shot)
    assert (set(patch) == {"times", "positions", "look_at"}) == fits
    if fits:
        assert patch["positions"][0] == [0, -4, 0.5], "it begins where it was"
        assert max(z for _, _, z in patch["positions"]) > 0.55
        assert inside(shot, "box", **patch) == 1
