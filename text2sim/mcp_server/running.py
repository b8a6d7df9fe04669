"""The tools that run a case and say what came of it."""

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
from text2sim.service.phrases import reason, summary
from text2sim.spec_schema.errors import SpecError, Text2SimError
from text2sim.spec_schema.reuse.overlay import CaseOverlay

MAX_TIMEOUT = 3600.0
"""Wall time [s] that a simulation may be given."""


def start(
    workspace: Workspace, jobs: Jobs, case: str, overlay: CaseOverlay, *, timeout: float, film: bool
) -> ToolAnswer | BackgroundRun:
    """Begin to run a case; the answer is that of `check` if it is not fit to be run.

    Args:
        workspace: The workspace.
        jobs: Runs it.
        case: The case.
        overlay: What is laid over it.
        timeout: Limit of the run [s].
        film: Whether it is filmed.

    Raises:
        RunError: if something else runs.
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
    """Run a case that was examined, to its end."""
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
        return refusal(reason(error), state="not run")
    return ToolAnswer(_told(row, result), failed=result.state not in ("finished", "diverged", "interrupted"))


def _told(row: Examined, result: RunResult) -> dict[str, Any]:
    """What came of a run, in a few lines."""
    document: dict[str, Any] = {
        "run": result.folder.name,
        "state": result.state,
        "passed": result.passed,
        "summary": summary(result),
        "expect": clipped({name: expectation(found) for name, found in result.expectations.items()}),
        "suspicions": clipped((result.evidence or {}).get("suspicions", [])),
        "film": str(result.film) if result.film else f"none: {result.film_message or 'none was asked for'}",
        "warnings": clipped(problem_rows(row.problems, row.sources), 8),
    }
    if result.message:
        document["message"] = clipped(result.message)
    if result.problem is not None:
        document["problem"] = problem_rows([result.problem], row.sources)[0]
    if result.state == "failed" or result.state == "crashed":
        document["log"] = "the end of the log: evidence, part: log"
    document["next"] = f"evidence and frames, run: {result.folder.name}"
    return document


def expectation(found: dict[str, Any]) -> str:
    """Return one expectation in a line: whether it came true, what was wanted, what was found."""
    mark = {True: "ok", False: "FAIL", None: "open"}[found.get("ok")]
    return f"{mark}: {found.get('wanted', '')}: {found.get('why', '')}"
