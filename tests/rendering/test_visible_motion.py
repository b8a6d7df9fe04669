"""What counts as motion in the pictures of a film: bodies that move in space and in the picture."""

from math import radians, tan
from types import SimpleNamespace
from typing import Any

import numpy as np
from filmed import FILM, MakeRun

from text2sim.legibility.visible_motion import SLACK, visible_motion
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
WALL: dict[str, Any] = {"half": 0.2, "pos": (0, 0, 0.4)}


def motion(
    make_run: MakeRun, camera: dict[str, Any], boxes: dict[str, Any], way: Any = None, **film: Any
) -> np.ndarray:
    """Motion in a film of four pictures; `way` are the places of the only link at the five recorded times along x [m]."""
    run = make_run(boxes, cameras={"main": camera}, **film)
    if way is not None:
        with np.load(run / "states" / "chunk_00000.npz") as arrays:
            states = dict(arrays)
        states["links_pos"][:, 0, 0] = way
        np.savez(run / "states" / "chunk_00000.npz", **states)  # type: ignore[arg-type]
    recording = read_recording(run)
    shown = frames(recording.film, reels(recording.film)[MAIN], recording.last)
    assert len(shown) == 4
    return visible_motion(recording, shown)


def counted(way: Any) -> np.ndarray:
    """What counts of the way of a body [m] that goes on in one direction."""
    return np.maximum(np.asarray(way) / HEIGHT - SLACK, 0.0)


def test_a_body_that_passes_moves_by_its_way_in_heights_of_the_picture(make_run: MakeRun) -> None:
    found = motion(make_run, STILL, {"truck": TRUCK, "wall": WALL})
    np.testing.assert_allclose(found, counted(np.arange(4) * 0.1), rtol=1e-4)


def test_what_flutters_by_little_does_not_move_and_by_more_only_beyond_that(make_run: MakeRun) -> None:
    some = 0.8 * SLACK * HEIGHT
    flutters = motion(make_run, STILL, {"flag": TRUCK}, way=[0, some, -some, some, 0])
    np.testing.assert_allclose(flutters, [0, 0, 0, 0], atol=1e-9)
    swings = motion(make_run, STILL, {"flag": TRUCK}, way=[0, 0.1, 0.0, 0.1, 0])
    once = 0.1 / HEIGHT
    np.testing.assert_allclose(
        np.diff(swings), [once - SLACK, max(once - 2 * SLACK, 0), max(once - 2 * SLACK, 0)], atol=1e-6
    )


def test_a_camera_that_follows_shows_only_what_goes_another_way(make_run: MakeRun) -> None:
    """What is faster than the truck moves away from it; once it stops, it rests in space, though not in the picture."""
    ahead = TRUCK | {"velocity": (2.0, 0, 0), "during": (0.0, 0.2)}
    found = motion(make_run, FOLLOW, {"truck": TRUCK, "load": TRUCK, "ahead": ahead})
    np.testing.assert_allclose(found, counted([0, 0.1, 0.2, 0.2]), rtol=1e-3)


def test_a_camera_that_travels_past_moves_nothing(make_run: MakeRun) -> None:
    waits = TRUCK | {"velocity": (0.0, 0, 0)}
    assert not motion(make_run, PAST, {"truck": waits, "wall": WALL}).any()


def test_what_spins_in_place_or_is_out_of_the_picture_shows_no_motion(make_run: MakeRun) -> None:
    spins = TRUCK | {"velocity": (0.0, 0, 0), "spin": 3.0}
    assert not motion(make_run, STILL, {"wheel": spins, "far": TRUCK | {"pos": (9.0, 0, 0.4)}}).any()


def test_links_of_a_body_count_in_proportion_and_replays_do_not(make_run: MakeRun) -> None:
    still = {"half": 0.1, "pos": (0, 0, 0.1), "velocity": (0.0, 0, 0), "of": "arm"}
    boxes = {"arm": TRUCK | {"velocity": (2.0, 0, 0)}, "hand": still}
    np.testing.assert_allclose(motion(make_run, STILL, boxes), counted(np.arange(4) * 0.2) / 2, rtol=1e-4)
    shots = [{"camera": "main", "from": a, "to": b, "speed": 0.5, "hold": 0.0} for a, b in ((0.2, 0.3), (0.0, 0.1))]
    found = motion(make_run, STILL, boxes, shots=shots)
    np.testing.assert_allclose(found, [0, *counted([0.1] * 3) / 2], rtol=1e-4)


def test_what_deforms_moves_by_its_points_and_what_is_not_drawn_by_nothing() -> None:
    """Half of the points of a towel slide by 0.2 m in each step, and a dyed liquid that is invisible pours out."""
    points = np.array([(0, 0, 0.4), (0.1, 0, 0.4)])
    states = SimpleNamespace(
        soft=None,
        boxes=lambda names: SimpleNamespace(names=names),
        placed=lambda boxes, t: (np.zeros((0, 3)),),
        tracks=lambda names, t: points + [[0, 0, 0], [2 * t * (1 + 9 * (names == ["dye"])), 0, 0]],
    )
    soft = [SimpleNamespace(body=name, look=SimpleNamespace(drawn=name == "towel")) for name in ("towel", "dye")]
    film = FILM | {"cameras": {"main": STILL}}
    recording: Any = SimpleNamespace(film=film, states=states, parts=[], soft=soft, statics=frozenset())
    found = visible_motion(recording, frames(film, reels(film)[MAIN], 0.4))
    np.testing.assert_allclose(found, counted(np.arange(4) * 0.2) / 2, rtol=1e-6)
