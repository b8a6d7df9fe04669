"""A still camera that frames what spreads stands close first, and travels back before anything leaves its picture."""

from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.legibility.film import Watcher
from text2sim.recording.film_record import FilmRecord, read_recording
from text2sim.rendering.composition import composed
from text2sim.rendering.reframing import CLOSEST, FIXED
from text2sim.templates.cadence import MAIN, frames, reels
from text2sim.templates.viewpoints import along

SPREAD: dict[str, Any] = {
    "left": {"half": 0.2, "pos": (-0.3, 0, 0.2), "velocity": (-30.0, 0, 0), "during": (0.3, 0.4)},
    "right": {"half": 0.2, "pos": (0.3, 0, 0.2), "velocity": (30.0, 0, 0), "during": (0.3, 0.4)},
}
"""Two boxes that lie side by side for 6 s of film, and 6 m apart 2 s later."""
WRITTEN = {"cameras": {"main": {"kind": "still", "lens_mm": 33}}}


def filmed(make_run: MakeRun, boxes: dict[str, Any], **camera: Any) -> FilmRecord:
    frame = {"bodies": list(boxes), "margin": 0.08, "within": None, "direction": (0, -1, 0.3)}
    main = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -4, 0.5), "look_at": (0, 0, 0.2), "frame": frame}
    shots = [{"name": "a", "camera": "main", "from": 0.0, "to": 0.4, "speed": 0.05, "hold": 0.0}]
    return read_recording(make_run(boxes, cameras={"main": main | camera}, shots=shots))


def pictures(recording: FilmRecord) -> list[Any]:
    return frames(recording.film, reels(recording.film)[MAIN], recording.last)


@pytest.mark.parametrize("gathers", [False, True])
def test_the_camera_is_close_while_all_is_near(make_run: MakeRun, *, gathers: bool) -> None:
    apart = {"left": (-3.3, 30.0), "right": (3.3, -30.0)}
    gathering = {
        name: SPREAD[name] | {"pos": (x, 0, 0.2), "velocity": (speed, 0, 0), "during": (0.0, 0.1)}
        for name, (x, speed) in apart.items()
    }
    shot = filmed(make_run, gathering if gathers else SPREAD)
    whole = Watcher(shot).cameras.view("main", 0.0)
    (patch,) = composed(shot, WRITTEN)
    camera: Any = patch["value"]
    assert (patch["op"], patch["path"]) == ("replace", "/render/cameras/main")
    assert (camera["kind"], camera["lens_mm"]) == ("keyframed", 33)
    far, close = float(np.linalg.norm(whole.pos - whole.look_at)), -1 if gathers else 0
    near = [float(np.linalg.norm(np.subtract(camera["positions"][k], camera["look_at"][k]))) for k in (0, -1)]
    assert near[close] == pytest.approx(far / CLOSEST, rel=1e-3), "as close as is allowed: their 1 m would fill it"
    assert near[-1 - close] == pytest.approx(far, rel=1e-3)
    shot.film["cameras"]["main"] = {"up": (0, 0, 1), "fov": 40.0} | camera
    watcher = Watcher(shot)
    assert all((watcher.sight(frame).inside > 0.999).all() for frame in pictures(shot)), "nothing is ever cut"
    still = np.diff([watcher.cameras.view("main", frame.t).pos for frame in pictures(shot)], axis=0)
    assert (still == 0).all(axis=1).sum() > len(still) / 2, "it stands exactly still, apart from one motion"


def test_a_camera_that_would_gain_little_stays(make_run: MakeRun) -> None:
    """The boxes are 1 m wide together at the start, and 1.06 m at the end."""
    slow = {name: box | {"velocity": (np.sign(box["velocity"][0]) * 0.3, 0, 0)} for name, box in SPREAD.items()}
    assert composed(filmed(make_run, slow), WRITTEN) == []


def test_what_is_whole_but_not_framed_stays_whole(make_run: MakeRun) -> None:
    bystander = {"half": 0.2, "pos": (1.8, 0, 0.2), "velocity": (0, 0, 0.3)}
    shot = filmed(make_run, SPREAD | {"bystander": bystander})
    shot.film["cameras"]["main"]["frame"]["bodies"] = list(SPREAD)
    (patch,) = composed(shot, WRITTEN)
    shot.film["cameras"]["main"] = {"up": (0, 0, 1), "fov": 40.0} | patch["value"]  # type: ignore[operator]
    watcher = Watcher(shot)
    assert all((watcher.sight(frame).inside > 0.999).all() for frame in pictures(shot))


@pytest.mark.parametrize(
    ("request_text", "stands"),
    [
        ("Film it with a fixed camera from the side.", True),
        ("one still wide shot, please", True),
        ("The camera does not move.", True),
        ("The camera must stay on a tripod", True),
        ("The still water is stirred; camera from above.", False),
        ("A static pile of bricks. The camera sees it from the front.", False),
    ],
)
def test_a_camera_that_is_to_stand_still_does(make_run: MakeRun, request_text: str, *, stands: bool) -> None:
    assert (FIXED.search(request_text) is not None) == stands
    assert (composed(filmed(make_run, SPREAD), WRITTEN, request_text) == []) == stands


def test_a_path_through_equal_points_stands_exactly_still() -> None:
    points = [(0.1, 0.2, 0.3)] * 3 + [(1.0, 1.0, 1.0)]
    assert {along([0.0, 1.0, 2.0, 3.0], points, t) for t in np.linspace(0, 1, 17)} == {points[0]}
