"""The main job through the command line, in the real engine: simulate, film, judge; then change one thing at a time."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import av
import numpy as np
import pytest

from text2sim.recording.states import RunStates

CASE = """\
text2sim: 1
name: drop
scene: {duration: 0.6, dt: 0.005, substeps: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball:
    kind: rigid
    shape:
      kind: compound
      parts:
        core: {shape: {kind: sphere, radius: 0.1}}
        eye: {shape: {kind: box, size: [0.03, 0.06, 0.03]}, pose: {pos: [0, -0.1, 0]}, decor: true}
    pose: {pos: [0, 0, 0.6]}
  arm:
    kind: rigid
    shape: {kind: capsule, radius: 0.03, length: 0.3}
    pose: {pos: [1, 0, 0.5]}
    mount: {kind: hinge, axis: y, anchor: [0, 0, 0.15], actuator: {damping: 200}}
actions:
  controls:
    turn: {kind: drive, joint: arm, velocity: 2.0}
  measures:
    height: {kind: position, of: ball, axis: z}
    angle: {kind: joint_position, of: arm}
  events:
    touch: {kind: contact, between: [ball, floor]}
  expect:
    lands: {event: touch, within: [0.30, 0.34]}
    rests_on_the_floor: {measure: height, at: end, above: 0.09, below: 0.105}
    turns: {measure: angle, at: end, equals: 1.2, tolerance: 0.02}
render: {resolution: [192, 108], fps: 25, speed: 1}
"""


def text2sim(*arguments: object) -> tuple[int, dict]:
    command = [sys.executable, "-m", "text2sim", *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert "Traceback" not in done.stderr + done.stdout
    return done.returncode, json.loads(done.stdout)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("end_to_end")


def run(place: Path, text: str, *options: str) -> tuple[int, dict, Path]:
    (place / "case.yaml").write_text(text)
    code, answer = text2sim("run", place, "--runs", place / "runs", *options)
    (result,) = answer["cases"] if "cases" in answer else answer["runs"]
    return code, result, Path(result["folder"])


@pytest.fixture(scope="module")
def first(engine: None, place: Path) -> tuple[int, dict, Path]:
    return run(place, CASE)


@pytest.mark.smoke
def test_run_leaves_all_its_evidence(first: tuple[int, dict, Path]) -> None:
    code, result, folder = first
    assert (code, result["state"], result["passed"]) == (0, "finished", True)
    for name in ("run.json", "case.yaml", "states/layout.json", "geometry/index.json", "events.jsonl", "measures.csv",
                 "evidence.json", "first.png", "contact_sheet.png", "report.html", "program/main.py", "log.txt"):  # fmt: skip
        assert (folder / name).is_file(), name


@pytest.mark.smoke
def test_what_is_only_drawn_is_no_solid(first: tuple[int, dict, Path]) -> None:
    states = RunStates.load(first[2])
    (ball,) = [k for k, link in enumerate(states.links) if link.body == "ball"]
    drawn, solids = (
        json.loads((first[2] / f"geometry/{name}.json").read_text())[str(ball)] for name in ("index", "solids")
    )
    assert len(drawn) == 2
    assert [(row["kind"], row["size"]) for row in solids] == [("sphere", [pytest.approx(0.1)])]


@pytest.mark.smoke
def test_film_is_h264_with_a_frame_for_every_twenty_fifth(first: tuple[int, dict, Path]) -> None:
    if first[1]["film"] is None:
        pytest.skip(f"no OpenGL here: {first[1]['film_message']}")
    with av.open(first[1]["film"]) as film:
        stream = film.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
    assert len(frames) == 15
    assert np.abs(frames[0].astype(int) - frames[7]).max() > 50, "the picture never changes"


@pytest.mark.smoke
def test_states_say_what_the_measures_say(first: tuple[int, dict, Path]) -> None:
    folder = first[2]
    states = RunStates.load(folder)
    link = next(
        i
        for i, row in enumerate(json.loads((folder / "states/layout.json").read_text())["links"])
        if row["body"] == "ball"
    )
    with (folder / "measures.csv").open() as file:
        rows = list(csv.DictReader(file))
    height = [float(row["height"]) for row in rows]
    assert np.allclose(height, states.pos[:, link, 2], atol=1e-6)
    # Free fall by semi-implicit Euler: z = h - g dt^2 n (n + 1) / 2, exact but for float32.
    n = np.arange(len(rows)) * round(float(rows[1]["time"]) / 0.005)
    fall = 0.6 - 9.81 * 0.005**2 * n * (n + 1) / 2
    assert np.allclose(np.array(height)[fall > 0.11], fall[fall > 0.11], atol=1e-5)


def test_nothing_is_done_twice(place: Path, first: tuple[int, dict, Path]) -> None:
    assert run(place, CASE)[1]["work"] == "unchanged"


@pytest.mark.smoke
def test_other_expectations_judge_the_same_run_and_fail_it(place: Path, first: tuple[int, dict, Path]) -> None:
    code, result, folder = run(place, CASE.replace("[0.30, 0.34]", "[0.10, 0.20]"))
    assert (code, result["work"], folder) == (1, "judged again", first[2])
    assert [name for name, row in result["expect"].items() if not row["ok"]] == ["lands"]


def test_other_camera_films_the_same_run(place: Path, first: tuple[int, dict, Path]) -> None:
    if first[1]["film"] is None:
        pytest.skip("no OpenGL here")
    states = (first[2] / "states/chunk_00000.npz").read_bytes()
    code, result, folder = run(place, CASE.replace("fps: 25", "fps: 10"))
    assert (code, result["work"], folder) == (0, "filmed again", first[2])
    assert (folder / "states/chunk_00000.npz").read_bytes() == states


def test_broken_case_fails(place: Path, first: tuple[int, dict, Path]) -> None:
    code, result, folder = run(place, CASE.replace("pos: [0, 0, 0.6]", "pos: [0, 0, 0.9]"), "--no-film")
    assert code == 1 and folder != first[2]
    assert not result["expect"]["lands"]["ok"] and result["expect"]["turns"]["ok"]


def test_killed_program_keeps_what_it_recorded(place: Path, first: tuple[int, dict, Path]) -> None:
    """`kill -9` in the middle: the chunks on disk are whole, and can be judged."""
    program, out = place / "program", place / "killed"
    (place / "case.yaml").write_text(CASE.replace("duration: 0.6", "duration: 600"))
    assert text2sim("compile", place, "-o", program)[0] == 0
    child = subprocess.Popen([sys.executable, "main.py", "--out", str(out), "--no-film"], cwd=program)
    try:
        deadline = time.monotonic() + 300
        while (
            len(list((out / "states").glob("chunk_*.npz"))) < 2 and child.poll() is None and time.monotonic() < deadline
        ):
            time.sleep(0.1)
    finally:
        os.kill(child.pid, signal.SIGKILL)
        child.wait()
    states = RunStates.load(out)
    assert len(states.time) >= 100
    assert np.isfinite(states.pos).all()
