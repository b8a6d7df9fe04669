"""Progress of a run: phases, simulated time, speed, and time left."""

import json
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

PHASES = {
    "check": "checking",
    "compile": "compiling",
    "start": "starting the engine",
    "build": "building the scene",
    "simulate": "simulating",
    "film": "filming",
    "judge": "judging",
    "report": "writing the report",
}
"""Phases in order, with words for them; a run that only films or judges again skips some."""

CHILD_PHASES = ("start", "build", "simulate", "film")
"""Phases that the program itself reports."""

SPEED_WINDOW = 15.0
"""Wall time [s] over which speed is measured: contact makes it vary by a factor of a hundred within a run."""

CHUNK = 1 << 20


@dataclass(frozen=True)
class Progress:
    """Where a run is."""

    phase: str
    """One of `PHASES`."""
    t: float = 0.0
    """Simulated time reached [s]."""
    duration: float = 0.0
    """Simulated time wanted [s]."""
    wall: float = 0.0
    """Time [s] since the run began."""
    speed: float | None = None
    """Recent simulated seconds per second."""
    eta: float | None = None
    """Time left [s] in this phase, at that speed."""
    note: str = ""
    """Something to tell the user once."""

    @property
    def fraction(self) -> float | None:
        """Part of the phase that is done, 0 to 1; None if unknown."""
        if self.phase not in ("simulate", "film") or self.duration <= 0:
            return None
        return min(1.0, max(0.0, self.t / self.duration))


OnProgress = Callable[[Progress], None]


def ignore(progress: Progress) -> None:
    """Do nothing."""


class Clock:
    """Reports phases to a listener, and keeps their durations."""

    def __init__(self, listener: OnProgress, duration: float = 0.0) -> None:
        self.duration = duration
        self.timings: dict[str, float] = {}
        self._listener = listener
        self._begun = self._phase_begun = monotonic()
        self._phase: str | None = None
        self._last: tuple[Any, ...] | None = None
        self._samples: deque[tuple[float, float]] = deque()

    @property
    def wall(self) -> float:
        """Time [s] since the clock was made."""
        return monotonic() - self._begun

    def enter(self, phase: str, note: str = "") -> None:
        """Begin a phase, unless it is already running."""
        if phase != self._phase:
            self._close()
            self._phase = phase
            self._samples.clear()
            self.tell(0.0, note=note)

    def finish(self) -> dict[str, float]:
        """End the last phase; return the time [s] that each took."""
        self._close()
        self._phase = None
        return self.timings

    def tell(self, t: float, *, duration: float | None = None, note: str = "") -> None:
        """Report the time `t` [s] that the running phase has reached, of `duration` if it has its own.

        Args:
            t: Time that the phase has reached [s].
            duration: Its length, if it has its own [s].
            note: Something to tell the user once.
        """
        now = monotonic()
        duration = duration or self.duration
        if (self._phase, t, note) == self._last:
            return
        self._last = (self._phase, t, note)
        if t > 0 and self._samples and self._samples[-1][1] == 0:
            self._samples.clear()  # the first step loads kernels, and says nothing about the others
        self._samples.append((now, t))
        while len(self._samples) > 2 and now - self._samples[0][0] > SPEED_WINDOW:
            self._samples.popleft()
        begun, before = self._samples[0]
        elapsed = now - begun
        speed = (t - before) / elapsed if elapsed > 0.2 and t > before else None
        eta = (duration - t) / speed if speed and duration > t else None
        self._listener(Progress(self._phase or "", t, duration, now - self._begun, speed, eta, note))

    def _close(self) -> None:
        now = monotonic()
        if self._phase is not None:
            self.timings[self._phase] = self.timings.get(self._phase, 0.0) + now - self._phase_begun
        self._phase_begun = now


class ProgressTail:
    """Reads what a program appends to its `progress.jsonl`; never fails."""

    def __init__(self, path: Path) -> None:
        self._path = path
        # Lines of an earlier program are skipped: filming again appends to the same file.
        self._offset = path.stat().st_size if path.is_file() else 0
        self._rest = b""

    def read(self) -> list[dict[str, Any]]:
        """Return the records that were completed since the last call."""
        try:
            with self._path.open("rb") as stream:
                stream.seek(self._offset)
                block = stream.read(CHUNK)
        except OSError:
            return []
        self._offset += len(block)
        *lines, self._rest = (self._rest + block).split(b"\n")
        # A line without end is not progress.
        self._rest = self._rest[-CHUNK:]
        return [record for line in lines if (record := _record(line)) is not None]


def _record(line: bytes) -> dict[str, Any] | None:
    try:
        record = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) else None


def duration_text(value: float | None) -> str:
    """Return a duration [s] for people: `0.4 s`, `41 s`, `3 min 5 s`."""
    if value is None:
        return "?"
    if value < 10:
        return f"{value:.1f} s"
    minutes, rest = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def rough_duration(seconds: float) -> str:
    """Return an estimate of a duration for people: `41 s`, `50 min`, `2.5 h`."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
