"""The sheet that the Critic sees shows what happened, not only what was filmed at even distances."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from text2sim.agents.pictures import EVENTS, frame_sheet
from text2sim.templates.video import Video

FILM = """
START, END, SPEED, FPS, MOTION_BLUR = 0.0, 2.0, 1.0, 25.0, 0.0
CAMERAS = {"main": {}}
SHOTS = []
"""
SIZE = (160, 90)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run with a film that gets brighter by two of 255 from picture to picture, and three kept pictures."""
    (tmp_path / "program").mkdir()
    (tmp_path / "frames").mkdir()
    (tmp_path / "program" / "render.py").write_text(FILM)
    video = Video(tmp_path / "video.mp4", SIZE, 25.0)
    for k in range(50):
        video.write(np.full((SIZE[1], SIZE[0], 3), 2 * k + 40, np.uint8))
    video.close()
    for k in range(3):
        Image.new("RGB", SIZE, "white").save(tmp_path / "frames" / f"main_{k}.png")
    (tmp_path / "visibility.json").write_text(json.dumps({"main": [{"t": t, "shares": {}} for t in (0.0, 1.0, 1.96)]}))
    return tmp_path


def tell(run: Path, **first: float | None) -> None:
    events = {name: {"count": 1, "first": t, "last": t, "problem": None} for name, t in first.items()}
    (run / "evidence.json").write_text(json.dumps({"events": events, "time": {"reached": 2.0}}))


def brightness(sheet: Image.Image, count: int) -> list[int]:
    """Of the middle of each picture in the first row."""
    wide = sheet.width // min(count, 4)
    row = np.asarray(sheet)[4 + SIZE[1] * 3 // 4]
    return [int(row[4 + k * wide + SIZE[0] // 2, 0]) for k in range(min(count, 4))]


def test_an_event_has_its_picture_among_the_others_in_order(run: Path) -> None:
    tell(run, hit=0.41, never=None)
    sheet, count = frame_sheet(run)
    assert count == 4
    first, hit, second, third = brightness(sheet, count)
    assert first == second == third == 255
    assert abs(hit - (2 * 10 + 40)) <= 1, "nearest to 0.41 s is the picture of 0.40 s"


def test_of_many_events_the_first_are_shown_and_two_at_once_share_a_picture(run: Path) -> None:
    tell(run, **{f"e{k}": 0.1 + 0.1 * k for k in range(9)})
    assert frame_sheet(run)[1] == 3 + EVENTS
    tell(run, one=0.5, two=0.5)
    assert frame_sheet(run)[1] == 4


def test_a_run_of_another_kind_shows_what_it_has(run: Path) -> None:
    assert frame_sheet(run)[1] == 3
    tell(run, hit=0.41)
    (run / "program" / "render.py").write_text("FPS = 1 / 0")
    assert frame_sheet(run)[1] == 3
    (run / "program" / "render.py").write_text(FILM)
    (run / "video.mp4").write_bytes(b"no film")
    assert frame_sheet(run)[1] == 3
