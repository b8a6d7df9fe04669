"""Two runs in one film."""

from pathlib import Path

import av
import numpy as np
import pytest
from filmed import MakeRun
from typer.testing import CliRunner

from text2sim.cli.main import app
from text2sim.rendering.beside import GAP, captions

RED = {"half": 0.4, "pos": (0, 0, 0.4), "color": (1.0, 0.0, 0.0)}
BLUE = {"half": 0.4, "pos": (0, 0, 0.4), "color": (0.0, 0.0, 1.0)}


def pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as film:
        return [picture.to_ndarray(format="rgb24").astype(int) for picture in film.decode(video=0)]


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


def test_runs_are_called_by_their_case_or_by_their_whole_name() -> None:
    assert captions("wall-1a2b", "wall-gentle-3c4d") == ("wall", "wall-gentle")
    assert captions("wall-1a2b", "wall-3c4d") == ("wall-1a2b", "wall-3c4d")
