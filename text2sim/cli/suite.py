"""The command `text2sim test`."""

import sys
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.many import attempts
from text2sim.cli.options import with_options
from text2sim.cli.output import expectation_rows, say, say_json
from text2sim.cli.run import RunOptions
from text2sim.cli.verdict import exit_of, say_failure
from text2sim.runtime.progress import duration_text
from text2sim.service import exits

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.service.examined import Examined


@with_options(RunOptions)
def run_suite(
    paths: Annotated[list[Path], typer.Argument(help="Cases, or folders of cases.")],
    pattern: Annotated[str, typer.Option("-k", help="Only cases whose name contains this.")] = "",
    film: Annotated[bool, typer.Option("--film", help="Make films, too.")] = False,
    *,
    options: RunOptions,
) -> None:
    """Run cases like a test suite: a case passes if it meets all its expectations."""
    from text2sim.service.examined import examine, find_cases

    begun, code, as_json = monotonic(), exits.OK, options.as_json
    tally = {"PASS": 0, "FAIL": 0, "ERROR": 0}
    documents: list[dict[str, Any]] = []
    # On a terminal a live line shows progress; elsewhere a suite only prints its summary.
    quiet, overlay = as_json or not sys.stderr.isatty(), options.overlay
    rows = [row for path in find_cases(paths) if pattern in (row := examine(path, to="loaded", overlay=overlay)).name]
    for row, result in attempts(rows, quiet=quiet, **options.of_attempts(film=film)):
        word = "ERROR" if result is None else "PASS" if result.passed else "FAIL"
        tally[word] += 1
        code = max(code, row.exit if result is None else exit_of(result))
        documents.append({"result": word.lower()} | (row.as_dict() if result is None else result.as_dict()))
        if not as_json:
            _say_row(word, row, result)
        if result is not None and result.stopped:
            break
    if not rows:
        code = exits.INPUT
    if as_json:
        say_json({"ok": code == exits.OK, "cases": documents})
    elif not rows:
        say("no case matches", to=sys.stderr)
    else:
        counts = [f"{n} {word}" for word, n in zip(("passed", "failed", "in error"), tally.values(), strict=True) if n]
        say(f"{', '.join(counts)} in {duration_text(monotonic() - begun)}")
    raise typer.Exit(code)


def _say_row(word: str, row: "Examined", result: "RunResult | None") -> None:
    from text2sim.cli.cases import say_examined

    if result is None:
        say(f"ERROR {row.name}")
        say_examined(row)
        return
    rows = expectation_rows(result.expectations)
    passed = sum(ok is True for ok, _, _ in rows)
    again = "" if result.work.value == "simulated" else f" ({result.work.value})"
    say(f"{word} {result.case} ({passed}/{len(rows)}) {duration_text(result.wall)}{again}")
    for ok, name, words in rows:
        if not ok:
            say(f"    {name}: {words}")
    for words in result.suspicions:
        say(f"    suspicious: {words}")
    say_failure(row, result)
