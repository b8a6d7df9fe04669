"""Renders that are killed go on; runs that an older version recorded are filmed all the same."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from filmed import MakeRun
from PIL import Image

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming, FilmProgress
from text2sim.rendering.frames import ABANDONED
from text2sim.spec_schema.errors import RunError

pytestmark = pytest.mark.usefixtures("tracer")

SLIDING = {"half": 0.4, "pos": (0, 0, 0.4), "velocity": (1.0, 0, 0)}
CASE = """\
text2sim: 2
name: slide
scene: {duration: 0.4, statics: {floor: {shape: {kind: plane}}}}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.8, 0.8, 0.8]}, place: {on: floor}, look: {color: "#ff0000", finish: wood}}
render: {resolution: [64, 64], fps: 10, cameras: {side: {kind: still, from: [0, -4, 1], look_at: crate}}}
"""


def test_a_render_that_is_killed_goes_on(make_run: MakeRun) -> None:
    folder = make_run({"crate": SLIDING | {"velocity": (10.0, 0, 0)}}, fps=100.0)
    command = [sys.executable, "-m", "text2sim", "render", str(folder), "--resolution", "32x18"]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    frames, limit = folder / "render" / "frames", time.monotonic() + 120
    while len(list(frames.glob("[!.]*.png"))) < 3 and time.monotonic() < limit and child.poll() is None:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    kept = {path: path.stat().st_mtime_ns for path in frames.glob("[!.]*.png")}
    assert 3 <= len(kept) < 40
    for path in kept:
        with Image.open(path) as picture:
            picture.load()  # each is whole
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "40 of 40 pictures" in done.stderr
    assert (folder / "render" / "draft.mp4").is_file()
    assert len(list(frames.glob("[!.]*.png"))) == 40
    assert all(path.stat().st_mtime_ns == at for path, at in kept.items()), "what was done is not done again"


def test_what_was_half_written_is_removed_later(make_run: MakeRun) -> None:
    folder = make_run({"crate": SLIDING}, end=0.2)
    frames = folder / "render" / "frames"
    frames.mkdir(parents=True)
    old, young = frames / ".1-a.png", frames / ".2-b.png"
    for part in (old, young):
        part.touch()
    os.utime(old, (0, time.time() - 2 * ABANDONED))
    filming = Filming(read_recording(folder), size=(32, 18), samples=4)
    told: list[FilmProgress] = []
    filming.render(filming.reels()[0], told.append)
    assert len(told) == 2
    assert (old.exists(), young.exists()) == (False, True)


def older(folder: Path) -> Path:
    """Make of a run one of a version that wrote no looks and another `render.py`."""
    (folder / "program" / "looks.json").unlink()
    (folder / "program" / "render.py").write_text("def cameras():\n    return {}\n")
    (folder / "expanded.yaml").write_text(CASE)
    return folder


def test_runs_of_older_versions_are_planned_anew(make_run: MakeRun) -> None:
    recording = read_recording(older(make_run({"crate": SLIDING, "floor": {"half": 0.01, "pos": (0, 0, 0)}})))
    assert list(recording.film["cameras"]) == ["side"]
    crate = next(part.look for part in recording.parts if part.body == "crate")
    assert (crate.color, crate.finish) == ((1, 0, 0), "wood")
    filming = Filming(recording, size=(32, 32), samples=4)
    picture = filming.develop(filming.trace(filming.reels()[0].frames[0])).astype(int)
    assert (picture[..., 0] > picture[..., 2] + 40).any(), "the red crate is in the picture"


@pytest.mark.parametrize("text", ["", CASE.replace("kind: box", "kind: ball"), None])
def test_an_older_run_whose_case_means_nothing_any_more(make_run: MakeRun, text: str | None) -> None:
    folder = older(make_run({"crate": SLIDING}))
    (folder / "expanded.yaml").unlink() if text is None else (folder / "expanded.yaml").write_text(text)
    with pytest.raises(RunError, match=r"older version.*name its case"):
        read_recording(folder)


def test_an_older_run_without_a_section_of_looks_has_its_recorded_colours(make_run: MakeRun) -> None:
    folder = make_run({"crate": SLIDING | {"color": (0.1, 0.2, 0.9)}})
    (folder / "program" / "looks.json").write_text(json.dumps({}))
    assert read_recording(folder).parts[0].look.color == (0.1, 0.2, 0.9)


@pytest.mark.parametrize(("speed", "drawn"), [(1e-6, 1), (0.12, 2), (1.0, 4)])
def test_frames_in_which_nothing_moves_visibly_are_drawn_once(make_run: MakeRun, speed: float, drawn: int) -> None:
    """At 4 m and with 36 pixels for 40 degrees, 0.1 s of 0.12 m/s are 0.15 pixels: every second frame is drawn."""
    folder = make_run({"crate": SLIDING | {"velocity": (speed, 0, 0)}})
    filming = Filming(read_recording(folder), size=(64, 36), samples=4)
    reel = filming.reels()[0]
    assert len({filming.finished(frame) for frame in reel.frames}) == drawn
