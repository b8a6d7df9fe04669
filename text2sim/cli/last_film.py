"""Path-traced film at the end of a loop of agents: as large and smooth as time allows."""

import sys
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from text2sim.cli.film_tracing import ProgressReporter, trace_films
from text2sim.cli.output import say
from text2sim.runtime.progress import duration_text
from text2sim.runtime.stop import Stop
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import Text2SimError

if TYPE_CHECKING:
    from text2sim.rendering.budget import FittedFilm

Quality = Literal["draft", "final", "none"]
Film = Annotated[
    Quality,
    typer.Option("--film", help="Path-traced film at the end: draft (8 samples per pixel or fewer), final (36), none."),
]
FilmMinutes = Annotated[
    float | None,
    typer.Option(
        "--film-minutes",
        min=0.1,
        help="Time limit of this film in minutes; it decides samples, size and frame rate. 8 for a draft if left out.",
    ),
]

MAX_DRAFT_PIXELS = 1280 * 720
"""Largest size of a draft [pixels]; time is proportional to size."""
DRAFT_MINUTES = 8.0
"""Time limit of a draft [min]."""


def last_film(run: Path, quality: Quality, minutes: float | None, *, quiet: bool) -> tuple[Path | None, str]:
    """Make the film of a run from all frames, or from the finished ones if it is stopped, or else use the preview.

    Args:
        run: The run folder.
        quality: Quality of the film.
        minutes: Time budget [min]; if None, 8 for a draft, and unlimited otherwise.
        quiet: Print nothing.

    Returns:
        The film, None without one, and a note about it.
    """
    from text2sim.recording.film_record import read_recording
    from text2sim.rendering.budget import fitted
    from text2sim.rendering.film import Filming
    from text2sim.rendering.legibility import write_legibility
    from text2sim.rendering.renderer import find_variant
    from text2sim.runtime.internal_errors import internal_error_message

    if quality == "none":
        return None, "none was requested"
    if minutes is None:
        minutes = DRAFT_MINUTES if quality == "draft" else inf
    again = f"text2sim render {display_path(run)}" + (f" --quality {quality}" if quality != "draft" else "")
    try:
        with Stop() as stop:
            find_variant()
            recording = read_recording(run)
            size = _size(recording.film["resolution"]) if quality == "draft" else None
            fit = fitted(Filming(recording, quality, size=size), lambda filming: filming.reels()[:1], minutes)
            again += _options(fit)
            if not quiet:
                say(_announcement(fit, quality, minutes), to=sys.stderr)
            film, missing = next(
                iter(trace_films(fit, ProgressReporter(fit.reels, quiet=quiet), stop, minutes).items())
            )
            with stop.gently():
                write_legibility(fit.filming, fit.reels)
        total = len(fit.reels[0].frames)
        some = f"{total - missing} of {total} pictures, each shown until the next; `{again}` traces the others"
        return film, some if missing else ""
    except Text2SimError as error:
        why = str(error)
    except KeyboardInterrupt:
        why = f"the path-traced film was stopped; `{again}` continues it"
    except OSError as error:
        why = f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}"
    except Exception as error:  # a failed film must not hide the result of the loop
        why = internal_error_message(error)
    preview = run / "video.mp4"
    return (preview, f"the preview: {why}") if preview.is_file() else (None, why)


def _announcement(fit: "FittedFilm", quality: str, minutes: float) -> str:
    width, height = fit.filming.size
    took = f"about {duration_text(fit.seconds)}" if fit.missing else "a moment"
    size = f"{width}x{height}, {fit.filming.fps:g} a second, {fit.filming.samples} samples per pixel"
    text = f"{quality} film: {fit.missing} pictures to trace, {size}: {took}"
    if fit.whole > fit.seconds:
        text += f" (uncut {duration_text(fit.whole)}, which is more than --film-minutes {minutes:g})"
    return f"{text}; Ctrl-C makes a film of the finished pictures"


def _options(fit: "FittedFilm") -> str:
    """Options of `text2sim render` that make the same film."""
    from text2sim.rendering.trace import QUALITIES

    film, (width, height) = fit.filming.recording.film, fit.filming.size
    wanted = QUALITIES[fit.filming.quality].samples
    options = f" --resolution {width}x{height}" if (width, height) != tuple(film["resolution"]) else ""
    options += f" --fps {fit.filming.fps:g}" if fit.filming.fps != film["fps"] else ""
    return options + (f" --samples {fit.filming.samples}" if fit.filming.samples != wanted else "")


def _size(resolution: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a draft [pixels], even numbers."""
    width, height = resolution
    scale = min(1.0, (MAX_DRAFT_PIXELS / (width * height)) ** 0.5)
    return round(width * scale / 2) * 2, round(height * scale / 2) * 2
