"""Frames of a film for a judge."""

from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image

from tests.evaluation.conftest import write_film
from text2sim.evaluation.film_frames import EVEN_FRAMES, film_frames, length_of, pictures_at
from text2sim.spec_schema.errors import RunError


def test_pictures_are_spread_evenly_at_the_films_own_size(tmp_path: Path) -> None:
    found = film_frames(write_film(tmp_path / "a.mp4", size=(320, 180)))
    assert len(found.images) == EVEN_FRAMES
    assert (found.size, found.duration) == ((320, 180), pytest.approx(3.0))
    assert found.times[0] == 0
    assert found.times[-1] == pytest.approx(2.9)
    assert {Image.open(BytesIO(image.data)).size for image in found.images} == {(320, 180)}
    assert found.images == film_frames(tmp_path / "a.mp4").images, "the same letter every time"


def test_the_first_picture_behind_a_change_of_scene_is_shown(tmp_path: Path) -> None:
    found = film_frames(write_film(tmp_path / "a.mp4", cut=17))
    assert len(found.times) == EVEN_FRAMES + 1
    assert 1.7 in [round(t, 3) for t in found.times]


def test_pictures_stand_at_shared_times_and_the_last_one_stays(tmp_path: Path) -> None:
    film = write_film(tmp_path / "a.mp4", cut=17)
    assert length_of(film) == pytest.approx(3.0)
    grounds = [picture.getpixel((90, 5))[0] > 150 for picture in pictures_at(film, [0.0, 1.6, 1.7, 99.0])]
    assert grounds == [False, False, True, True]


@pytest.mark.parametrize("data", [b"", b"no film", b"\x00\x00\x00\x20ftypisom" + bytes(64)])
def test_films_that_do_not_decode_are_reported(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.mp4").write_bytes(data)
    with pytest.raises(RunError, match="the film does not decode"):
        film_frames(tmp_path / "a.mp4")
