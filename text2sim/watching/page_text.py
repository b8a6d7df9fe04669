"""Texts of the page about checks and takes."""

from typing import Any

from text2sim.watching.live_run import LiveRun
from text2sim.watching.protocols import Checked

MAX_EXCERPT = 300
"""Longest line of a case that the page shows [characters]."""


def problem_rows(read: Checked) -> list[dict[str, Any]]:
    """Return the problems with their lines of the case."""
    rows = []
    for problem in read.problems:
        row = problem.as_dict()
        lines = read.sources.get(problem.file, "").splitlines()
        if 0 < problem.line <= len(lines):
            row["excerpt"] = lines[problem.line - 1][:MAX_EXCERPT]
        rows.append(row)
    return rows


def refusal(checked: Checked) -> dict[str, Any]:
    """Return the state of the page for a text that cannot be run."""
    count = sum(problem.severity == "error" for problem in checked.problems)
    words = checked.failure or f"{count} problem{'s' if count != 1 else ''}"
    return {"words": words, "tone": "bad", "mark": "✗", "progress": None}


def closing(live_run: LiveRun, evidence: dict[str, Any] | None, no_scene: str) -> dict[str, Any]:
    """Return the state of the page for a finished run.

    Args:
        live_run: The simulation.
        evidence: Its evidence; None if it could not be judged.
        no_scene: Why there is no scene; empty if there is one.
    """
    if live_run.state != "finished" or evidence is None:
        words, good = live_run.message or live_run.state.replace("_", " "), False
    else:
        good = evidence["verdict"] == "passed"
        words = f"{evidence['verdict']}: {evidence['why']}"
    if no_scene:
        words += f"; nothing to show: {no_scene}"
    return {"words": words, "tone": "good" if good else "bad", "mark": "✓" if good else "✗", "progress": None}


def timing(live_run: LiveRun) -> str:
    """Return the durations of a live run in words."""
    seconds = live_run.seconds
    words = [f"simulated in {seconds['simulate']:.2f} s"] if "simulate" in seconds else []
    words += [f"shown {seconds['scene']:.2f} s after saving"] if "scene" in seconds else []
    words += [f"judged in {seconds['judge']:.2f} s"] if "judge" in seconds and len(seconds) <= 2 else []
    return f"take {live_run.number}: {', '.join(words)}"
