"""Progress of a run on the error stream: a live line on a terminal, a few plain lines elsewhere."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from text2sim.cli.output import say
from text2sim.runtime.progress import PHASES, duration_text
from text2sim.spec_schema.plain import plain_line

if TYPE_CHECKING:
    from text2sim.runtime.progress import OnProgress, Progress

LINE_INTERVAL = 15.0
"""Wall time [s] between plain lines of one phase."""


@contextmanager
def watch(name: str, *, quiet: bool = False) -> Iterator["OnProgress"]:
    """Yield a listener that shows the progress of the run called `name`."""
    if quiet:
        yield lambda progress: None
    elif sys.stderr.isatty():
        with _live(name) as listener:
            yield listener
    else:
        yield _Plain(name)


class _Plain:
    """One line for each phase, and occasional ones within a long phase."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._phase = ""
        self._next = 0.0

    def __call__(self, progress: "Progress") -> None:
        words = f"{self._name}: {PHASES.get(progress.phase, progress.phase)}"
        if progress.phase != self._phase or progress.note:
            self._phase = progress.phase
            self._next = progress.wall + LINE_INTERVAL
            say(words + (f" ({progress.note})" if progress.note else ""), to=sys.stderr)
        elif progress.wall >= self._next and progress.fraction is not None:
            self._next = progress.wall + LINE_INTERVAL
            say(f"{words} {_numbers(progress)}", to=sys.stderr)
        sys.stderr.flush()


@contextmanager
def _live(name: str) -> Iterator["OnProgress"]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(finished_text=" "),
        TextColumn("{task.fields[name]}", markup=False),
        TextColumn("{task.description}", style="bold", markup=False),
        BarColumn(bar_width=24),
        TextColumn("{task.fields[numbers]}", markup=False),
        TimeElapsedColumn(),
    )
    # Output is not redirected: captured output would break the line.
    live = Progress(
        *columns, console=Console(stderr=True), transient=True, redirect_stdout=False, redirect_stderr=False
    )
    with live:
        task = live.add_task("", total=None, name=plain_line(name), numbers="")

        def listener(progress: "Progress") -> None:
            fields: dict[str, Any] = {"description": PHASES.get(progress.phase, progress.phase)}
            if progress.note:
                live.console.print(plain_line(progress.note), style="dim", markup=False, highlight=False)
            if progress.fraction is None:
                fields |= {"total": None, "completed": 0, "numbers": ""}
            else:
                fields |= {"total": progress.duration, "completed": progress.t, "numbers": _numbers(progress)}
            live.update(task, **fields)

        yield listener


def _numbers(progress: "Progress") -> str:
    text = f"{progress.t:.2f} of {progress.duration:g} s"
    if progress.speed:
        text += f", {progress.speed:.2g} simulated s per s"
    if progress.eta is not None:
        text += f", {duration_text(progress.eta)} left"
    return text
