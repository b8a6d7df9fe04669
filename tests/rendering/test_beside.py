"""Two runs in one film."""

from pathlib import Path

import av
import numpy as np
import pytest
from filmed import MakeRun
from typer.testing import CliRunner

from text2sim.cli.main import app
from text2sim.rendering.beside import GAP
from text2sim.spec_schema.errors import RunError

RED = {"half": 0.4, "pos": (0, 0, 0.4), "color": (1.0, 0.0, 0.0)}
BLUE = {"half": 0.4, "pos": (0, 0, 0.4), "color": (0.0, 0.0, 1.0)}


def pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as film:
        return [picture.to_ndarray(format="rgb24").astype(int) for picture in film.decode(video=0)]


@pytest.mark.usefixtures("tracer")
def test_two_runs_are_seen_side_by_side_and_the_shorter_waits(make_run: MakeRun) -> None:
    left, right = make_run({"crate": RED}, "red-0123456789"), make_run({"crate": BLUE}, "blue-0123456789", end=0.2)
    command = ["render", str(left), "--beside", str(right), "--resolution", "64x36"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    shown = pictures(left / "render" / "draft_beside_blue-0123456789.mp4")
    longer = len(list((left / "render" / "frames").glob("*.png")))
    assert shown[0].shape == (36, 2 * 64 + GAP, 3)
    assert len(shown) >= longer
    for picture in (shown[0], shown[-1]):
        a, b = picture[14:22, 26:38].mean(axis=(0, 1)), picture[14:22, 64 + GAP + 26 : 64 + GAP + 38].mean(axis=(0, 1))
        assert a[0] > a[2] + 60
        assert b[2] > b[0] + 60
    again = CliRunner().invoke(app, [*command, "--join"])
    assert again.exit_code == 0, again.output


@pytest.mark.parametrize("option", [["--quality", "still"], ["--shard", "1/2"], ["--frames-only", "png"]])
def test_what_makes_no_film_is_refused(make_run: MakeRun, option: list[str]) -> None:
    run = make_run({"crate": RED})
    assert CliRunner().invoke(app, ["render", str(run), "--beside", str(run), *option]).exit_code == 2


def test_films_of_two_rates_are_not_put_together(make_run: MakeRun) -> None:
    left, right = make_run({"crate": RED}, "red-0123456789"), make_run({"crate": BLUE}, "blue-0123456789", fps=20.0)
    done = CliRunner().invoke(app, ["render", str(left), "--beside", str(right), "--resolution", "64x36"])
    assert isinstance(done.exception, RunError)
    assert f"{left} has 10, {right} has 20" in str(done.exception)
    assert not (left / "render" / "draft.mp4").exists()


@pytest.mark.usefixtures("tracer")
def test_a_part_does_not_take_the_place_of_the_whole(make_run: MakeRun) -> None:
    left, right = make_run({"crate": RED}, "red-0123456789"), make_run({"crate": BLUE}, "blue-0123456789")
    command = ["render", str(left), "--beside", str(right), "--resolution", "64x36", "--frames", "1:3"]
    assert CliRunner().invoke(app, command).exit_code == 0
    assert [path.name for path in (left / "render").glob("*.mp4")] == ["draft_beside_blue-0123456789_1-2.mp4"]
