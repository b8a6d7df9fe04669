"""Tools that run a case and report the result."""

from functools import partial
from typing import Any

from text2sim.harness.result import RunResult
from text2sim.harness.run import run_case
from text2sim.mcp_server.answers import ToolAnswer, clipped, problem_rows, refusal
from text2sim.mcp_server.jobs import BackgroundRun, Jobs
from text2sim.mcp_server.reading import verdict
from text2sim.mcp_server.workspace import Workspace
from text2sim.runtime.progress import OnProgress
from text2sim.runtime.stop import Stop
from text2sim.service.examined import Examined, examine
from text2sim.service.phrases import run_line, user_message
from text2sim.spec_schema.errors import SpecError, Text2SimError
from text2sim.spec_schema.reuse.overlay import CaseOverlay

MAX_TIMEOUT = 3600.0
"""Largest time limit of a simulation [s]."""


def start(
    workspace: Workspace, jobs: Jobs, case: str, overlay: CaseOverlay, *, timeout: float, film: bool
) -> ToolAnswer | BackgroundRun:
    """Start to run a case; the answer is that of `check` if it has errors.

    Args:
        workspace: The workspace.
        jobs: The background runs.
        case: The case.
        overlay: Its overlay.
        timeout: Time limit of the simulation [s].
        film: Whether to film it.

    Raises:
        RunError: if another run is in progress.
    """
    file = workspace.case_file(case)
    row = examine(file, overlay=overlay)
    if not row.ok or row.loaded is None:
        return ToolAnswer({"state": "not run", **verdict(row)}, failed=True)
    what = repr((str(file), row.loaded.source.text, overlay, film))
    work = partial(_run, workspace, row, timeout=timeout, film=film)
    return jobs.start(row.name, what, work)


def _run(
    workspace: Workspace, row: Examined, on_progress: OnProgress, stop: Stop, *, timeout: float, film: bool
) -> ToolAnswer:
    """Run an examined case to its end."""
    assert row.loaded is not None
    try:
        result = run_case(
            row.loaded,
            runs=workspace.runs(),
            on_progress=on_progress,
            timeout=timeout,
            film=film,
            stop=stop,
            lint=row.findings(),
        )
    except SpecError as error:
        return ToolAnswer({"state": "not run", "problems": problem_rows(error.problems[:20], row.sources)}, failed=True)
    except (Text2SimError, OSError) as error:
        return refusal(user_message(error), state="not run")
    return ToolAnswer(_document(row, result), failed=result.state not in ("finished", "diverged", "interrupted"))


def _document(row: Examined, result: RunResult) -> dict[str, Any]:
    """Summary of a run."""
    document: dict[str, Any] = {
        "run": result.folder.name,
        "state": result.state,
        "passed": result.passed,
        "summary": run_line(result),
        "expect": clipped({name: expectation(found) for name, found in result.expectations.items()}),
        "suspicions": clipped(result.suspicions),
        "film": str(result.film) if result.film else f"none: {result.film_message or 'none was requested'}",
        "warnings": clipped(problem_rows(row.problems, row.sources), 8),
    }
    if result.message:
        document["message"] = clipped(result.message)
    if result.problem is not None:
        document["problem"] = problem_rows([result.problem], row.sources)[0]
    if result.state in ("failed", "crashed"):
        document["log"] = "the end of the log: evidence, part: log"
    document["next"] = f"evidence and frames, run: {result.folder.name}"
    return document


def expectation(found: dict[str, Any]) -> str:
    """Return an expectation as a line: verdict, expected and found values."""
    ok = found.get("ok")
    mark = "ok" if ok is True else "FAIL" if ok is False else "open"
    return f"{mark}: {found.get('wanted', '')}: {found.get('why', '')}"
