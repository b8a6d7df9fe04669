"""Output of the verdict on a run."""

import sys
from typing import TYPE_CHECKING

from text2sim.cli.output import expectation_rows, say, say_problems
from text2sim.service import exits
from text2sim.service.phrases import display_path, run_line
from text2sim.spec_schema.plain import plain

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.service.examined import Examined

_EXITS = {
    "failed": exits.INPUT,
    "timeout": exits.MACHINE,
    "out_of_memory": exits.MACHINE,
    "interrupted": exits.INTERRUPTED,
}


def exit_of(result: "RunResult") -> int:
    """Return the exit code for a run."""
    if result.stopped:
        return exits.INTERRUPTED
    if result.state != "finished":
        return _EXITS.get(result.state, exits.PHYSICS)
    if not result.passed:
        return exits.PHYSICS
    return exits.MACHINE if result.film_message else exits.OK


def say_result(case: "Examined", result: "RunResult") -> None:
    """Print the result of a run; the paths of film and report come last."""
    if result.damage:
        say(f"{display_path(result.folder)}: {result.damage}", to=sys.stderr)
    say_failure(case, result)
    rows = expectation_rows(result.expectations)
    if rows:
        _say_table(rows)
    say(f"{result.case}: {run_line(result)}")
    for words in result.suspicions:
        say(f"suspicious: {words}")
    if result.film is not None:
        say(f"film: {display_path(result.film)}")
    elif result.film_message:
        say(f"film: none ({result.film_message})")
        if result.film_message.startswith("cannot draw"):
            say(f"text2sim render {display_path(result.folder)} makes a path-traced film, without OpenGL")
    if result.report is not None:
        say(f"report: {display_path(result.report)}")


def say_failure(case: "Examined", result: "RunResult") -> None:
    """Print why a run ended early, at the line of the case if that is known, and the path of the log."""
    if result.state == "finished":
        return
    if result.problem is not None and case.loaded is not None:
        say_problems([result.problem], {result.problem.file: case.loaded.source.text})
    else:
        state = result.state.replace("_", " ")
        message = result.message if result.message.startswith(state) else f"{state}: {result.message}"
        say(f"{display_path(case.path)}: {message}", to=sys.stderr)
    say(f"    log: {display_path(result.folder / 'log.txt')}", to=sys.stderr)


MARKS = {True: "ok", False: "FAIL", None: "open"}


def _say_table(rows: list[tuple[bool | None, str, str]]) -> None:
    if not sys.stdout.isatty():
        width = max(len(name) for _, name, _ in rows)
        for ok, name, words in rows:
            say(f"  {MARKS[ok]:<4}  {name:<{width}}  {words}")
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, show_header=False, padding=(0, 1))
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for ok, name, words in rows:
        style = {True: "green", False: "bold red", None: "yellow"}[ok]
        table.add_row(Text(f"{MARKS[ok]:>4}", style=style), Text(name), Text(plain(words)))
    Console().print(table)
