"""Paths, errors and outcomes of runs in plain words."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.runtime.progress import duration_text

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult


def display_path(path: Path) -> str:
    """Return a path, relative to the working directory if it is below it."""
    try:
        return os.path.relpath(path) if path.absolute().is_relative_to(Path.cwd()) else str(path)
    except OSError:  # the working directory is gone
        return str(path)


def user_message(error: Exception) -> str:
    """Return the message of an error that the user can fix."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)


def run_line(result: "RunResult") -> str:
    """Return one line: the state, the score, the work done and its time."""
    words = result.state.replace("_", " ")
    if result.state != "finished":
        words += f" at {result.time:.4g} s" if result.time else ""
    return f"{words}{_score(result)}, {result.work.value} in {_time_text(result)}"


_APART = {"compile and build": ("compile", "start", "build"), "film": ("film",), "judge": ("judge", "report")}
"""Phases of a run besides the simulation itself, by what they do."""


def _time_text(result: "RunResult") -> str:
    """Return the time of a simulation, and apart from it the other phases that took a second or more."""
    if (simulated := result.timings.get("simulate")) is None:
        return duration_text(result.wall)
    sums = {words: sum(result.timings.get(phase, 0.0) for phase in phases) for words, phases in _APART.items()}
    apart = ", ".join(f"{duration_text(spent)} to {words}" for words, spent in sums.items() if spent >= 1)
    return duration_text(simulated) + (f"; {apart}" if apart else "")


def _score(result: "RunResult") -> str:
    rows = result.expectations
    return f", {sum(row['ok'] is True for row in rows.values())} of {len(rows)} expectations came true" if rows else ""
