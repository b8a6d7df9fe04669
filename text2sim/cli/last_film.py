"""The path-traced film in which the work of agents ends, with the time that it will take said before."""

import sys
from pathlib import Path
from time import perf_counter
from typing import Annotated, Literal

import typer

Quality = Literal["draft", "final", "none"]
Film = Annotated[
    Quality,
    typer.Option("--film", help="The path-traced film at the end: draft, small, 8 samples per pixel; final, 36; none."),
]


DRAFT = 854 * 480
"""Pixels of a draft at most: twice as many take twice as long."""


def last_film(run: Path, quality: Quality, *, quiet: bool) -> tuple[Path | None, str]:
    """Trace the main film of a run.

    Two pictures are traced first, for the estimate: the first of a scene compiles kernels. They stay, as all do: a film
    that was stopped goes on with `text2sim render`.

    Args:
        run: Its folder.
        quality: Of the film.
        quiet: Say nothing.

    Returns:
        The film, or None, and why there is none.
    """
    from text2sim.cli.output import say
    from text2sim.cli.render import Teller
    from text2sim.recording.film_record import read_recording
    from text2sim.rendering.film import Filming, Reel
    from text2sim.rendering.legibility import write_legibility
    from text2sim.rendering.renderer import find_variant
    from text2sim.runtime.trouble import told
    from text2sim.service.wording import seconds
    from text2sim.spec_schema.errors import Text2SimError

    if quality == "none":
        return None, "none was wanted"
    try:
        find_variant()
        recording = read_recording(run)
        filming = Filming(recording, quality, size=_size(recording.film["resolution"]) if quality == "draft" else None)
        reel = filming.reels()[0]
        first, middle = reel.frames[0], reel.frames[len(reel.frames) // 2]
        filming.render(Reel(reel.name, [first]), lambda progress: None)
        started = perf_counter()
        filming.render(Reel(reel.name, [middle]), lambda progress: None)
        each = perf_counter() - started
        if not quiet:
            missing = sum(not filming.finished(frame).is_file() for frame in reel.frames)
            took = f"about {seconds(each * missing)}" if missing else "a moment"
            what = f"{missing} of {len(reel.frames)} pictures to trace, {took}"
            say(f"{quality} film: {what}; Ctrl-C leaves it to `text2sim render {run}`", to=sys.stderr)
        filming.render(reel, Teller([reel], quiet=quiet))
        film = filming.encode(reel)
        write_legibility(filming, [reel])
    except Text2SimError as error:
        return None, str(error)
    except KeyboardInterrupt:
        return None, "it was stopped"
    except OSError as error:
        return None, f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}"
    except Exception as error:  # the work is done and is told of, whatever becomes of its film
        return None, told(error)
    return film, ""


def _size(resolution: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a draft [pixels], even numbers."""
    width, height = resolution
    scale = min(1.0, (DRAFT / (width * height)) ** 0.5)
    return round(width * scale / 2) * 2, round(height * scale / 2) * 2
