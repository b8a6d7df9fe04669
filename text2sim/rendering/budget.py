"""Time budget of films: the resolution and frame rate that fit, and partial films when rendering is stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from text2sim.rendering.film import Filming, Reel

STEPS = ((1.0, 1), (0.75, 1), (0.75, 2), (0.5625, 2), (0.5625, 3))
"""Reductions of a film, in order: factors on its width and height, and on the time between pictures."""
SLOWEST = 8.0
"""Lowest frame rate of a film [1/s]."""
OVERTIME = 1.25
"""Factor on the time budget after which no further picture is started, because the estimate is not exact."""
FEWEST = 6
"""Smallest number of pictures from which an incomplete film is encoded."""


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

    Two frames are traced for that: the first compiles kernels, the second is measured.

    Args:
        filming: The requested film.
        reels: Returns the reels of a film of any size.
        minutes: Time budget [min].
    """
    first = reels(filming)[0]
    parts: list[dict[str, float]] = []
    for frame in (first.frames[0], first.frames[len(first.frames) // 2]):
        filming.render(Reel(first.name, [frame]), lambda progress: parts.append(progress.seconds))
        if not parts[-1]:  # already rendered
            parts.append(filming.trace(frame).seconds)
    fixed = parts[-1].pop("update")
    return cut_down(filming, reels, minutes, fixed, sum(parts[-1].values()))


def cut_down(
    filming: Filming, reels: Callable[[Filming], list[Reel]], minutes: float, fixed: float, each: float
) -> FittedFilm:
    """Return the largest and smoothest film that fits a time budget; if none does, the quickest.

    Args:
        filming: The requested film.
        reels: Returns the reels of a film of any size.
        minutes: Time budget [min].
        fixed: Time per frame that does not depend on its size [s].
        each: Further time per frame at the requested size [s].
    """
    found: list[FittedFilm] = []
    for scale, every in STEPS:
        fps = filming.fps / every
        if every > 1 and fps < SLOWEST:
            continue
        width, height = (max(16, round(length * scale / 2) * 2) for length in filming.size)
        other = filming if (scale, every) == STEPS[0] else filming.resized((width, height), fps)
        made = reels(other)
        wanted = {other.finished(frame) for reel in made for frame in reel.frames}
        missing = sum(not path.is_file() for path in wanted)
        seconds = missing * (fixed + each * scale**2)
        found.append(FittedFilm(other, made, missing, seconds, found[0].whole if found else seconds))
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
