"""Time budget of films: samples, resolution and frame rate that fit, and partial films when rendering is stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from text2sim.rendering.film import Filming, Reel
from text2sim.templates.cadence import Frame

CUTS = (
    (1.0, 1.0, 1), (1.0, 1.0, 2), (0.75, 1.0, 2), (0.75, 1.5, 2),
    (0.75, 1.5, 4), (0.75, 2.0, 4), (0.5625, 2.0, 4), (0.5625, 3.0, 4),
)  # fmt: skip
"""Successive cuts: factor on width and height, factor on the time between pictures, divisor of the samples per pixel.

Fewer samples show least, since frames are denoised: 8 and 4 differed from 64 by 2.4 and 3.1 of 255 (RMS) in brick_wall,
by 1.5 and 2.0 in laid_table (benchmarks/film_samples.py). With 2, moving shadows are blotches. Coarse pictures show
more than few: at 16 pictures a second motion is still smooth, and the textures and edges of 720 pixels are soft.
"""
FEWEST_SAMPLES = 2
"""Smallest number of samples per pixel of a film that is cut down."""
SLOWEST = 8.0
"""Lowest frame rate of a film [1/s]."""
OVERTIME = 1.25
"""Factor on the time budget after which no further picture is started, because the estimate is not exact."""
FEWEST = 6
"""Smallest number of pictures from which an incomplete film is encoded."""


@dataclass(frozen=True)
class FrameTime:
    """Time [s] that a frame takes."""

    update: float
    """Independent of its size."""
    tracing: float
    """Proportional to its pixels and samples."""
    finishing: float
    """Proportional to its pixels."""
    share: float = 1.0
    """Share of a picture with a background that is traced."""


@dataclass(frozen=True)
class FittedFilm:
    """A film that fits the budget."""

    filming: Filming
    reels: list[Reel]
    missing: int = 0
    """Number of pictures to trace."""
    seconds: float = 0.0
    """Estimated time for these [s]."""
    whole: float = 0.0
    """Estimated time for the requested film [s]."""


def fitted(filming: Filming, reels: Callable[[Filming], list[Reel]], minutes: float) -> FittedFilm:
    """Return the largest and smoothest film that can be traced in a given time.

    Two frames are traced to measure it: the first compiles kernels. Backgrounds are counted as samples.

    Args:
        filming: The requested film.
        reels: Returns the reels of a film of any size.
        minutes: Time budget [min].
    """
    first = reels(filming)[0]
    frame = first.frames[len(first.frames) // 2]
    _, taken = _frame_seconds(filming, first.frames[0]), _frame_seconds(filming, frame)
    tracing = (taken["trace"] + taken["gloss"]) * filming.samples / filming.samples_of(frame)
    finishing = taken["guides"] + taken["denoise"]
    return cut_down(
        filming, reels, minutes, FrameTime(taken["update"], tracing, finishing, filming.traced_share(first))
    )


def _frame_seconds(filming: Filming, frame: Frame) -> dict[str, float]:
    """Return the times [s] of a frame by step; it is kept unless a background would have to be traced for it first."""
    seconds: dict[str, float] = {}
    if not filming.has_background(frame):
        filming.render(Reel("", [frame]), lambda progress: seconds.update(progress.seconds))
    return seconds or filming.trace(frame, with_background=False).seconds


def cut_down(
    filming: Filming, reels: Callable[[Filming], list[Reel]], minutes: float, frame_time: FrameTime
) -> FittedFilm:
    """Return the largest and smoothest film that fits a time budget; if none does, the quickest.

    Args:
        filming: The requested film.
        reels: Returns the reels of a film of any size.
        minutes: Time budget [min].
        frame_time: Time of one frame of the requested film.
    """
    found: list[FittedFilm] = []
    fewest = min(filming.samples, max(FEWEST_SAMPLES, filming.fewest_samples))
    for scale, every, divisor in CUTS:
        fps, samples = filming.fps / every, max(fewest, filming.samples // divisor)
        if every > 1 and fps < SLOWEST:
            continue
        size = tuple(max(16, round(length * scale / 2) * 2) for length in filming.size)
        other = filming.variant((size[0], size[1]), fps, samples) if found else filming
        cut = reels(other)
        work = other.missing(cut, frame_time.share)
        finishing, tracing = work.finished * frame_time.finishing, work.samples * frame_time.tracing / filming.samples
        seconds = work.pictures * frame_time.update + scale**2 * (finishing + tracing)
        found.append(FittedFilm(other, cut, work.pictures, seconds, found[0].whole if found else seconds))
        if seconds <= 60 * minutes:
            break
    return found[-1]


def encode_films(filming: Filming, reels: list[Reel], part: Callable[[Reel], str]) -> dict[Path, int]:
    """Encode films from the frames that exist; return the number of missing frames of each.

    Args:
        filming: The renderer of the films.
        reels: The films; those with hardly any frames are skipped.
        part: Returns the suffix of a film's file name.
    """
    made = {}
    for reel in reels:
        missing = sum(not filming.finished(frame).is_file() for frame in reel.frames)
        if missing == 0 or len(reel.frames) - missing >= FEWEST:
            made[filming.encode(filming.held(reel) if missing else reel, part(reel))] = missing
    return made
