"""Tracing of films with progress reports, until they are finished, stopped or out of time."""

import sys
from collections.abc import Callable
from math import inf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from text2sim.cli.live import LINE_INTERVAL
from text2sim.runtime.progress import duration_text
from text2sim.spec_schema.plain import plain_line

if TYPE_CHECKING:
    from text2sim.rendering.budget import FittedFilm
    from text2sim.rendering.film import FilmProgress, Reel
    from text2sim.runtime.stop import Stop


def trace_films(
    fit: "FittedFilm",
    report: "Callable[[FilmProgress], None]",
    stop: "Stop",
    minutes: float = inf,
    suffix: "Callable[[Reel], str]" = lambda reel: "",
) -> dict[Path, int]:
    """Trace and encode films; from the finished frames if stopped or out of time.

    Args:
        fit: The films.
        report: Called after each frame.
        stop: Counter of stop signals.
        minutes: Approximate time after which no further frame is begun [min].
        suffix: Returns the suffix of a film's file name.

    Returns:
        The number of missing frames of each film.

    Raises:
        KeyboardInterrupt: if it was stopped with hardly any finished frames.
    """
    from text2sim.rendering.budget import OVERTIME, encode_films

    until = monotonic() + 60 * minutes * OVERTIME
    try:
        for reel in fit.reels:
            fit.filming.render(reel, report, until=until)
    except KeyboardInterrupt:
        stop.request()
    with stop.gently():
        paths = encode_films(fit.filming, fit.reels, suffix)
    if not paths:
        raise KeyboardInterrupt
    return paths


class ProgressReporter:
    """Reporter of a render's progress and remaining time: a live line on a terminal, else occasional lines."""

    def __init__(self, reels: "list[Reel]", *, quiet: bool) -> None:
        self._total, self._done, self._traced = sum(len(reel.frames) for reel in reels), 0, 0
        self._begun = self._next = monotonic()
        self._quiet, self._sums = quiet, {}

    def __call__(self, progress: "FilmProgress") -> None:
        """Count a finished frame and report."""
        self._done += 1
        if progress.seconds:
            self._traced += 1
            for name, value in progress.seconds.items():
                self._sums[name] = self._sums.get(name, 0.0) + value
        now = monotonic()
        live = sys.stderr.isatty()
        if self._quiet or not (live or now >= self._next or self._done == self._total):
            return
        self._next = now + LINE_INTERVAL
        left = ""
        if self._traced and self._done < self._total:
            each = (now - self._begun) / self._traced
            left = f", {each:.1f} s each, {duration_text(each * (self._total - self._done))} left"
        text = f"rendering {progress.film}: {self._done} of {self._total} pictures{left}"
        ending = "\n" if not live or self._done == self._total else ""
        print(("\r\x1b[K" if live else "") + plain_line(text), end=ending, file=sys.stderr, flush=True)

    def mean(self) -> dict[str, float]:
        """Return the mean time of a frame by part [s]."""
        return {name: round(value / max(self._traced, 1), 3) for name, value in self._sums.items()}
