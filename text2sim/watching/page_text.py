"""What the page says about a check and about a take."""

from typing import Any

from text2sim.watching.live_run import LiveRun
from text2sim.watching.protocols import Checked

EXCERPT = 300
"""Longest line of a case that the page shows [characters]."""


def problem_rows(read: Checked) -> list[dict[str, Any]]:
    """Problems with the lines that they are about."""
    rows = []
    for problem in read.problems:
        row = problem.as_dict()
        lines = read.sources.get(problem.file, "").splitlines()
        if 0 < problem.line <= len(lines):
            row["excerpt"] = lines[problem.line - 1][:EXCERPT]
        rows.append(row)
    return rows


def refusal(checked: Checked) -> dict[str, Any]:
    """Why a text is not run."""
    count = sum(problem.severity == "error" for problem in checked.problems)
    words = checked.failure or f"{count} problem{'s' if count != 1 else ''}"
    return {"words": words, "tone": "bad", "mark": "✗", "progress": None}


def findings(evidence: dict[str, Any] | None) -> dict[str, Any]:
    """Expectations and measures."""
    if evidence is None:
        return {"expect": [], "measures": []}
    return {
        "expect": [{"name": name, **row} for name, row in evidence["expect"].items()],
        "measures": [{"name": name, **row} for name, row in evidence["measures"].items()],
    }


def closing(take: LiveRun, evidence: dict[str, Any] | None, no_film: str) -> dict[str, Any]:
    """How a take ended, and what was found."""
    if take.state != "finished" or evidence is None:
        words, good = take.message or take.state.replace("_", " "), False
    else:
        good = evidence["verdict"] == "passed"
        words = f"{evidence['verdict']}: {evidence['why']}"
    if no_film:
        words += f"; no film: {no_film}"
    return {"words": words, "tone": "good" if good else "bad", "mark": "✓" if good else "✗", "progress": None}


def timing(take: LiveRun) -> str:
    """What was done, and how long that took."""
    seconds = take.seconds
    words = [f"simulated in {seconds['simulate']:.2f} s"] if "simulate" in seconds else []
    words += [f"film {seconds['film']:.2f} s after saving"] if "film" in seconds else []
    words += [f"judged in {seconds['judge']:.2f} s"] if "judge" in seconds and len(seconds) <= 2 else []
    return f"take {take.number}: {', '.join(words)}"
