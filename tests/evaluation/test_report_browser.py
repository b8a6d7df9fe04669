"""The page of an evaluation in a real browser: synchronous films, no other requests."""

from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner
from watching import chromium

from tests.evaluation.conftest import Judge
from text2sim.cli.main import app

pytestmark = [
    pytest.mark.usefixtures("browser"),
    pytest.mark.skipif(chromium.find() is None, reason="there is no Chromium"),
]


def test_films_of_a_case_play_together(
    suite: Path, make_method: Callable[..., Path], judge: Judge, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words = ["evaluate", "judge", str(suite), str(make_method("one")), str(make_method("two"))]
    assert CliRunner().invoke(app, [*words, "--out", str(out), "--judge", judge.model, "--repeats", "1"]).exit_code == 0
    page = chromium.Chromium(tmp_path / "profile")
    try:
        page.go((out / "report.html").as_uri())
        page.wait("document.querySelectorAll('details[open] video').length == 2")
        page.wait("[...document.querySelectorAll('details[open] video')].every(film => film.videoWidth == 96)")
        page.ask("document.querySelector('details[open] button').click()")
        page.wait("[...document.querySelectorAll('details[open] video')].every(film => film.currentTime > 0.2)")
        assert page.ask("[...document.querySelectorAll('details:not([open]) video')].every(film => film.paused)")
        page.shoot(tmp_path / "page.png")
    finally:
        page.close()
