"""Which moments a film shows."""

import pytest

from text2sim.templates.cadence import film_of, frames, read_film, reels

FILM = {
    "fps": 10.0,
    "speed": 1.0,
    "start": 0.0,
    "end": 2.0,
    "motion_blur": 0.0,
    "cameras": {"wide": {}, "near": {}, "top": {}},
    "shots": [],
}


def shot(camera, first, last, speed=1.0, hold=0.0):
    return {"name": "s", "camera": camera, "from": first, "to": last, "speed": speed, "hold": hold}


def test_without_shots_every_camera_films_all_of_it():
    films = reels(FILM)
    assert list(films) == ["video", "video_near", "video_top"]
    pictures = frames(FILM, films["video"], 5.0)
    assert len(pictures) == 20
    assert [p.t for p in pictures[:3]] == pytest.approx([0.0, 0.1, 0.2])
    assert {p.camera for p in pictures} == {"wide"}
    assert (pictures[0].part, pictures[-1].part) == (0.0, 1.0)


def test_what_was_not_recorded_is_not_shown():
    assert len(frames(FILM, reels(FILM)["video"], 0.5)) == 5
    assert [p.t for p in frames(FILM, reels(FILM)["video"], 0.0)] == [0.0]
    late = FILM | {"shots": [shot("near", 1.0, 2.0, hold=3.0)]}
    assert [p.t for p in frames(late, reels(late)["video"], 0.4)] == [0.4]


def test_a_replay_in_slow_motion_with_a_hold():
    film = FILM | {"shots": [shot("wide", 0.0, 1.0), shot("near", 0.5, 0.6, speed=0.1, hold=0.5)]}
    films = reels(film)
    assert list(films) == ["video", "video_top"]
    pictures = frames(film, films["video"], 2.0)
    assert [p.camera for p in pictures] == ["wide"] * 10 + ["near"] * 15
    assert [p.k for p in pictures] == list(range(25))
    assert pictures[11].t == pytest.approx(0.51)
    assert {p.t for p in pictures[20:]} == {0.6}
    assert [p.again for p in pictures] == [False] * 10 + [True] * 15, "it is marked as a replay"


def test_only_what_was_shown_before_is_a_replay():
    """A cut that goes back a little is none, and a second view is one until it comes to what is new."""
    film = FILM | {"shots": [shot("wide", 0.0, 1.0), shot("near", 0.9, 1.5), shot("top", 1.0, 2.0)]}
    pictures = frames(film, reels(film)["video"], 2.0)
    again = {camera: [p.again for p in pictures if p.camera == camera] for camera in ("wide", "near", "top")}
    assert again == {"wide": [False] * 10, "near": [False] * 6, "top": [True] * 5 + [False] * 5}


def test_a_moving_camera_goes_on_over_shots_without_a_cut_and_while_time_is_held():
    film = FILM | {"shots": [shot("near", 0.0, 1.0), shot("near", 1.0, 1.5, speed=0.5, hold=0.5), shot("top", 0, 1)]}
    pictures = frames(film, reels(film)["video"], 2.0)
    parts = [p.part for p in pictures if p.camera == "near"]
    assert len(parts) == 25
    assert parts == pytest.approx([k / 24 for k in range(25)])
    assert pictures[25].part == 0.0


def test_the_shutter_is_open_around_its_moment_and_never_beyond_the_cut():
    film = FILM | {"motion_blur": 0.5, "shots": [shot("wide", 0.0, 1.0, hold=0.1)]}
    first, second, *_, held = frames(film, reels(film)["video"], 2.0)
    assert (second.open, second.close) == pytest.approx((0.075, 0.125))
    assert (first.open, first.close) == pytest.approx((0.0, 0.025))
    assert held.open == held.close == held.t
    assert held.moments(4) == [(held.t, held.part)]
    moments = second.moments(2)
    assert [t for t, _ in moments] == pytest.approx([0.0875, 0.1125])
    # The camera moves on while the shutter is open: a tenth of a part in a tenth of a second here.
    assert moments[1][1] - moments[0][1] == pytest.approx(0.025 * second.pace)
    assert second.pace == pytest.approx(1.0)


def test_a_script_is_read_without_running_it():
    assert read_film('"""Film."""\nFPS = 25.0\nCAMERAS = {"a": {"pos": (0.0, -1.0, 2.0)}}\n') == {
        "fps": 25.0,
        "cameras": {"a": {"pos": (0.0, -1.0, 2.0)}},
    }
    for text in ("import os\nCAMERAS = os.environ", "CAMERAS = open('x')", "FPS = 2", "CAMERAS = (", "(" * 5000):
        with pytest.raises(ValueError, match=r"render\.py"):
            read_film(text)


def test_an_imported_script_says_the_same():
    module = type("render", (), {"FPS": 25.0, "CAMERAS": {}, "__doc__": "", "lower": 1})
    assert film_of(module) == {"fps": 25.0, "cameras": {}}
