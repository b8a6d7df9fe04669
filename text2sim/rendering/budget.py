"""Time budget of films: samples, resolution and frame rate that fit, and partial films when rendering is stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from text2sim.rendering.film import Filming, Reel

CUTS = (
    (1.0, 1.0, 1), (1.0, 1.0, 2), (0.75, 1.0, 2), (0.75, 1.5, 2),
    (0.75, 1.5, 4), (0.75, 2.0, 4), (0.5625, 2.0, 4), (0.5625, 3.0, 4),
)  # fmt: skip
"""Successive cuts: factor on width and height, factor on the time between pictures, divisor of the samples per pixel.

Fewer samples show least, since frames are denoised: 8 and 4 differed from 64 by 2.7 and 3.4 of 255 (RMS) in brick_wall,
4 by 1.9 in laid_table (benchmarks/film_samples.py). With 2, moving shadows are blotches. Coarse pictures show
more than few: at 16 pictures a second motion is still smooth, and the textures and edges of 720 pixels are soft.
"""
FEWEST_SAMPLES = 2
"""Smallest number of samples per pixel of a film that is cut down."""
SLOWEST = 8.0
"""Lowest frame rate of a film [1/s]."""
OVERTIME = 1.25
"""Factor on the time budget after which no further picture is started, because the estimate is not exact."""
MEASURED = 0.5
"""Factor on width and height of the frames by which time is measured: pictures in full size, with all samples, would
take a tenth of the budget on a busy machine."""
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

    Two smaller frames are traced to measure it: the first compiles kernels. Backgrounds are counted as samples.

    Args:
        filming: The requested film.
        reels: Returns the reels of a film of any size.
        minutes: Time budget [min].
    """
    small = filming.variant(_scaled(filming.size, MEASURED), filming.fps, max(1, filming.samples // 2))
    first = reels(small)[0]
    frame = first.frames[len(first.frames) // 2]
    _, traced = (small.trace(one, with_background=False) for one in (first.frames[0], frame))
    start, taken = perf_counter(), traced.seconds
    small.develop(traced)
    tracing = (taken["trace"] + taken["gloss"]) * filming.samples / small.samples_of(frame)
    finishing = taken["guides"] + taken["denoise"] + perf_counter() - start
    pixels = MEASURED**2
    frame_time = FrameTime(taken["update"], tracing / pixels, finishing / pixels, small.traced_share(first))
    return cut_down(filming, reels, minutes, frame_time)


def _scaled(size: tuple[int, int], scale: float) -> tuple[int, int]:
    width, height = (max(16, round(length * scale / 2) * 2) for length in size)
    return width, height


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
        other = filming.variant(_scaled(filming.size, scale), fps, samples) if found else filming
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
