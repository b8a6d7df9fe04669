"""The film in which the work of agents ends."""

from pathlib import Path

import pytest
from filmed import MakeRun

from text2sim.cli.last_film import DRAFT, _size, last_film


@pytest.mark.usefixtures("tracer")
def test_the_time_it_takes_is_said_before_and_the_film_is_there(
    make_run: MakeRun, capsys: pytest.CaptureFixture[str]
) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (1, 0, 0)}})
    film, why = last_film(run, "draft", quiet=False)
    assert film == run / "render" / "draft.mp4"
    assert film.is_file()
    assert not why
    said = capsys.readouterr().err
    assert "draft film: 2 of 4 pictures to trace, about" in said
    assert said.index("about") < said.index("rendering draft")
    assert (run / "render" / "legibility.json").is_file()


def test_none_makes_none_and_a_run_that_recorded_nothing_is_no_error(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5)}})
    assert last_film(run, "none", quiet=True)[0] is None
    assert not (run / "render").exists()
    (run / "states" / "layout.json").unlink()
    film, why = last_film(run, "draft", quiet=True)
    assert film is None
    assert "nothing was recorded" in why


@pytest.mark.parametrize(
    ("error", "said"),
    [(OSError(28, "No space left on device"), "No space left on device"), (MemoryError(), "MemoryError")],
)
def test_whatever_becomes_of_the_film_is_said(
    error: Exception, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails() -> None:
        raise error

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("text2sim.rendering.renderer.find_variant", fails)
    film, why = last_film(tmp_path, "draft", quiet=True)
    assert film is None
    assert said in why


def test_a_draft_is_no_larger_than_it_has_to_be() -> None:
    assert _size((640, 360)) == (640, 360)
    assert _size((1280, 720)) == (854, 480)
    width, height = _size((1080, 1920))
    assert width * height <= 1.01 * DRAFT
    assert width % 2 == height % 2 == 0
