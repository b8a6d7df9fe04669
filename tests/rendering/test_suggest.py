"""Proposals of a camera and light: what they show, how they are written."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from filmed import MakeRun
from typer.testing import CliRunner

from text2sim.cli.main import app
from text2sim.compiler.build import plan_case
from text2sim.compiler.film_lights import STUDIOS
from text2sim.recording.film_record import read_recording
from text2sim.rendering import suggest as module
from text2sim.rendering.candidates import HEIGHTS, Candidate, Scorer, best, directions
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_case, load_text

CASE = """\
text2sim: 2
name: peek  # kept
scene:
  duration: 0.4
  statics:
    floor: {shape: {kind: plane}}
    wall: {shape: {kind: box, size: [4, 0.1, 3]}, pose: {pos: [0, -1, 1.5]}}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.8, 0.8, 0.8]}, place: {on: floor}}
actions:
  measures: {height: {kind: position, of: crate, axis: z}}
  expect: {stays: {measure: height, at: end, below: 1}}
# The film.
render:
  resolution: [64, 64]  # small
  fps: 10
  cameras:
    main: {kind: still, from: [0, -9, 1], look_at: crate}
  shots: {all: {camera: main}}
"""
BOXES: dict[str, Any] = {
    "crate": {"half": 0.4, "pos": (0, 0, 0.4), "velocity": (0.5, 0, 0), "color": (0.8, 0.3, 0.1)},
    "wall": {"half": (2, 0.05, 1.5), "pos": (0, -1, 1.5)},
    "floor": {"half": (9, 9, 0.001), "pos": (0, 0, -0.001)},
}
HIDING = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -9, 1), "look_at": (0, 0, 0.4)}}


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Light is compared in smaller pictures than people would look at."""
    monkeypatch.setattr(module, "TRIAL", (32, 32))


def written(tmp_path: Path, make_run: MakeRun, text: str = CASE) -> tuple[Path, Path]:
    """A case and the folder with its run."""
    case = tmp_path / "peek" / "case.yaml"
    case.parent.mkdir()
    case.write_text(text)
    run = make_run(BOXES, "made", cameras=HIDING)
    runs = tmp_path / "runs"
    runs.mkdir()
    run.rename(runs / f"peek-{plan_case(load_case(case)).sim_digest[:10]}")
    return case, runs


@pytest.mark.usefixtures("tracer")
def test_a_camera_comes_out_from_behind_a_wall(make_run: MakeRun) -> None:
    recording = read_recording(make_run(BOXES, cameras=HIDING))
    proposal = module.suggest(recording, load_text(CASE), lambda text: None)
    (camera,) = proposal.render["cameras"].values()
    assert camera["direction"][1] > 0 or camera["direction"][2] > 0.7, "the wall stands in front of it"
    assert proposal.score > proposal.before + 0.3
    seen = proposal.legibility["films"]["video"]["bodies"]["crate"]
    assert seen["hidden"] < 0.1
    assert seen["share"]["min"] > 0.05
    assert proposal.render["lighting"] in proposal.lights.keys() == STUDIOS.keys()
    assert proposal.tried > len(HEIGHTS) * 12


def test_lights_of_the_author_stay(make_run: MakeRun) -> None:
    text = CASE.replace("  fps: 10\n", "  fps: 10\n  lights: {key: {kind: sun}}\n")
    proposal = module.suggest(read_recording(make_run(BOXES, cameras=HIDING)), load_text(text), lambda text: None)
    assert list(proposal.render) == ["cameras"]
    assert proposal.lights == {}


def test_what_comes_straight_at_the_camera_is_seen_worse(make_run: MakeRun) -> None:
    boxes = {"ball": {"half": 0.2, "pos": (0, -0.4, 0.2), "velocity": (0, 2.0, 0)}}
    jury = Scorer(read_recording(make_run(boxes)), [], [0.0, 0.2, 0.4])
    ahead, aside = (jury.score(Candidate(("ball",), way, 42.0, 0.0)) for way in ((0, -1, 0.3), (-1, 0, 0.3)))
    assert aside > ahead + 0.05


def test_a_camera_frames_what_it_is_told_to(make_run: MakeRun) -> None:
    jury = Scorer(read_recording(make_run(BOXES, cameras=HIDING)), ["crate"], [0.0, 0.4])
    camera = jury.camera(Candidate(("crate",), (0.0, 0.9, 0.4), 42.0, 0.0))
    assert camera["look_at"] == pytest.approx((0.1, 0, 0.4), abs=0.2)
    assert camera["fov"] == pytest.approx(2 * math.degrees(math.atan(12 / 42)))
    ways = [way for way, _ in directions()]
    assert len(set(ways)) == len(ways)
    assert all(math.hypot(*way) == pytest.approx(1, abs=0.01) for way in ways)
    ranked = best(jury, [("crate",)])
    assert [score for score, _ in ranked] == sorted((score for score, _ in ranked), reverse=True)


@pytest.mark.usefixtures("tracer")
def test_it_is_written_into_the_case_with_its_comments(tmp_path: Path, make_run: MakeRun) -> None:
    case, runs = written(tmp_path, make_run)
    before, command = case.read_text(), ["render", str(case.parent), "--runs", str(runs), "--suggest"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    assert "cameras tried" in done.output
    assert case.read_text() == before
    done = CliRunner().invoke(app, [*command, "--write", "--json"])
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document["written"]
    assert [row["op"] for row in document["patch"]] == ["add", "add", "remove"]
    text = case.read_text()
    assert all(words in text for words in ("# kept", "# The film.", "# small", "fps: 10"))
    render = load_case(case).case.render
    assert (render.lighting, render.shots) == (document["render"]["lighting"], {})
    assert list(render.cameras) == ["main"]
    assert plan_case(load_case(case)).sim_digest[:10] in next(runs.iterdir()).name, "nothing is simulated again"


def test_what_cannot_be_written_is_said(tmp_path: Path, make_run: MakeRun) -> None:
    case, runs = written(tmp_path, make_run)
    (run,) = runs.iterdir()
    (run / "expanded.yaml").write_text(CASE)
    done = CliRunner().invoke(app, ["render", str(run), "--suggest", "--write"])
    assert isinstance(done.exception, RunError)
    assert "name the case" in str(done.exception)
    assert CliRunner().invoke(app, ["render", str(run), "--write"]).exit_code == 2
    case.write_text(CASE.replace("duration: 0.4", "duration: 0.5"))
    done = CliRunner().invoke(app, ["render", str(case), "--runs", str(runs)])
    assert isinstance(done.exception, RunError)
    assert "text2sim run" in str(done.exception)


@pytest.mark.usefixtures("tracer")
def test_a_case_is_filmed_as_it_says_now(tmp_path: Path, make_run: MakeRun) -> None:
    case, runs = written(tmp_path, make_run)
    case.write_text(CASE.replace("fps: 10", "fps: 5"))
    command = ["render", str(case), "--runs", str(runs), "--resolution", "32x18", "--frames-only", "png"]
    assert CliRunner().invoke(app, command).exit_code == 0
    (run,) = runs.iterdir()
    assert len(list((run / "render" / "draft").iterdir())) == 2, "0.4 s at 5 pictures a second"
