"""Run of one case for a command; errors that the author can fix become problems."""

from dataclasses import replace
from typing import Any

from text2sim.cli.live import watch
from text2sim.harness.result import RunResult
from text2sim.harness.run import run_case
from text2sim.service.examined import Examined
from text2sim.spec_schema.errors import Text2SimError


def attempt(row: Examined, *, quiet: bool = False, **options: Any) -> RunResult | None:
    """Run a loaded case.

    Args:
        row: The case; its problems are updated.
        quiet: Show no progress.
        options: Keyword arguments of `run_case`.

    Returns:
        The result; None if the case cannot be run, with the reasons in `row.problems`.
    """
    assert row.loaded is not None
    try:
        if row.plan is None:
            row.plan_and_lint()
        with watch(row.name, quiet=quiet) as on_progress:
            result = run_case(row.loaded, on_progress=on_progress, lint=row.findings(), **options)
    except Text2SimError as error:
        row.blame(error)
        return None
    # The lint's warnings include those of the plan, which the result has.
    return replace(result, warnings=row.problems)
