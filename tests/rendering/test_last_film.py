"""The film in which the work of agents ends."""

import signal
from pathlib import Path

import av
import pytest
from filmed import MakeRun

from text2sim.cli.last_film import MAX_DRAFT_PIXELS, _size, last_film
from text2sim.recording.film_record import read_recording
from text2sim.rendering.budget import FrameTime, cut_down
from text2sim.rendering.film import Filming
from text2sim.rendering.trace import Traced
from text2sim.templates.cadence import Frame


@pytest.mark.usefixtures("tracer")
def test_the_time_it_takes_is_said_before_and_the_film_is_there(
    make_run: MakeRun, capsys: pytest.CaptureFixture[str]
) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}})
    film, why = last_film(run, "draft", None, quiet=False)
    assert film == run / "render" / "draft.mp4"
    assert film.is_file()
    assert not why
    said = capsys.readouterr().err
    assert "draft film: 4 pictures to trace, 64x36, 10 a second, 8 samples per pixel: about" in said
    assert said.index("about") < said.index("rendering draft")
    assert (run / "render" / "legibility.json").is_file()


@pytest.mark.usefixtures("tracer")
def test_a_film_that_is_stopped_is_made_of_what_is_there(make_run: MakeRun, monkeypatch: pytest.MonkeyPatch) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0)
    trace, traced = Filming.trace, []

    def stopping(filming: Filming, frame: Frame, *, with_background: bool = True) -> Traced:
        if not with_background:  # to measure the time
            return trace(filming, frame, with_background=False)
        traced.append(frame.k)
        if len(traced) > 7:
            signal.raise_signal(signal.SIGTERM)
        return trace(filming, frame)

    monkeypatch.setattr(Filming, "trace", stopping)
    film, told = last_film(run, "draft", None, quiet=True)
    assert film == run / "render" / "draft.mp4"
    assert sorted(traced[:7]) == [0, 2, 4, 8, 12, 16, 19], "they are spread over the film"
    with av.open(str(film)) as video:
        assert sum(1 for _ in video.decode(video=0)) == 20, "each is held"
    assert f"7 of 20 pictures, each shown until the next; `text2sim render {run}` traces the others" == told
    traced.clear()
    monkeypatch.setattr(Filming, "trace", trace)
    assert last_film(run, "draft", None, quiet=True) == (film, "")


@pytest.mark.usefixtures("tracer")
def test_a_film_that_is_stopped_at_once_leaves_the_preview(make_run: MakeRun, monkeypatch: pytest.MonkeyPatch) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0)
    (run / "video.mp4").write_bytes(b"preview")
    monkeypatch.setattr(Filming, "trace", lambda *_, **__: signal.raise_signal(signal.SIGTERM))
    film, told = last_film(run, "draft", None, quiet=True)
    assert film == run / "video.mp4"
    assert f"`text2sim render {run}` continues it" in told


def test_a_film_is_as_large_and_smooth_as_there_is_time_for(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0)
    filming = Filming(read_recording(run))
    time = FrameTime(0.1, 0.7, 0.2, 0.25)
    fits = {given: cut_down(filming, Filming.reels, given / 60, time) for given in (13.5, 11.5, 7.5, 6.6, 4.5, 2.5, 0)}
    assert [(fit.filming.size, fit.filming.fps, fit.filming.samples) for fit in fits.values()] == [
        ((64, 36), 50.0, 8), ((64, 36), 50.0, 4), ((48, 28), 50.0, 4), ((48, 28), 100 / 3, 4), ((48, 28), 100 / 3, 2),
        ((36, 20), 25.0, 2), ((36, 20), 50 / 3, 2),
    ]  # fmt: skip
    assert all(fit.seconds <= given for given, fit in fits.items() if given)
    # A quarter of 20 pictures of 8 samples, what tells the quarter, and a background of 36 and 8.
    samples = 20 * (8 / 4 + 1.25) + 36 + 8
    assert {round(fit.whole, 6) for fit in fits.values()} == {round(20 * 0.1 + (5 + 2) * 0.2 + samples * 0.7 / 8, 6)}


def test_none_makes_none_and_a_run_that_recorded_nothing_is_no_error(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5)}})
    assert last_film(run, "none", None, quiet=True)[0] is None
    assert not (run / "render").exists()
    (run / "states" / "layout.json").unlink()
    film, why = last_film(run, "draft", None, quiet=True)
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
    film, why = last_film(tmp_path, "draft", None, quiet=True)
    assert film is None
    assert said in why


def test_a_draft_is_no_larger_than_it_has_to_be() -> None:
    assert _size((640, 360)) == (640, 360)
    assert _size((1920, 1080)) == (1280, 720)
    width, height = _size((1080, 1920))
    assert width * height <= 1.01 * MAX_DRAFT_PIXELS
    assert width % 2 == height % 2 == 0


def test_a_blurred_film_keeps_a_sample_for_each_moment(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0, motion_blur=0.5)
    filming = Filming(read_recording(run))
    assert cut_down(filming, Filming.reels, 0, FrameTime(0.1, 0.7, 0.2)).filming.samples == 4


def test_a_film_of_fewer_pictures_is_no_more_blurred(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0, motion_blur=0.5)
    for fps in (50.0, 25.0):
        frame = Filming(read_recording(run)).variant((64, 36), fps, 4).reels()[0].frames[2]
        assert frame.close - frame.open == pytest.approx(0.5 / 50)
    frame = Filming(read_recording(run), fps=25.0).reels()[0].frames[2]
    assert frame.close - frame.open == pytest.approx(0.5 / 25), "a fraction of the time between two pictures"
