"""Parallel runs of cases, on this machine or on a Ray cluster."""

import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.live import LINE_INTERVAL, watch
from text2sim.cli.output import say
from text2sim.cli.recorded import Chosen
from text2sim.runtime.progress import duration_text
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.spec_schema.errors import MachineError, RunError, Text2SimError

if TYPE_CHECKING:
    from text2sim.cluster.run import Placement
    from text2sim.cluster.task import Done, Task
    from text2sim.harness.result import RunResult
    from text2sim.service.examined import Examined

Workers = Annotated[int, typer.Option("--workers", min=1, max=256, help="Number of runs at a time, in warm engines.")]
Ray = Annotated[
    str, typer.Option("--ray", metavar="ADDRESS", help="Run on this Ray cluster (auto: that of this machine).")
]
StoreUrl = Annotated[
    str,
    typer.Option(
        "--store", metavar="URL", help="With --ray: folder or URL that all nodes reach; RUNS/.store if left out."
    ),
]
RENDER_CORES = 4
"""Cores of a render task on a Ray cluster."""
RENDER_MEMORY = 3_000_000_000
"""Memory of a render task [bytes]."""


def where_of(workers: int, ray: str, store: str, runs: Path) -> "Placement | None":
    """Return where tasks run according to the options; None for sequentially in this process.

    Args:
        workers: Number of tasks that run at once here.
        ray: Address of a Ray cluster; none if empty.
        store: Folder or URL that all its nodes reach; a folder in `runs` if empty.
        runs: Folder of runs.

    Raises:
        typer.BadParameter: if there is a store and no cluster.
    """
    from text2sim.cluster.run import Placement

    if store and not ray:
        raise typer.BadParameter("needs --ray", param_hint="'--store'")
    return Placement(workers, ray, store or str((runs / ".store").absolute())) if ray or workers > 1 else None


def attempts(
    rows: "Sequence[Examined]", where: "Placement | None", *, quiet: bool, runs: Path, **options: Any
) -> "Iterator[tuple[Examined, RunResult | None]]":
    """Run loaded cases, and yield each, in order, with its result; see `attempt`.

    Args:
        rows: The cases.
        where: Where they run; None runs them here, one after another.
        quiet: Print no progress.
        runs: Folder of runs.
        **options: Options of `attempt`.
    """
    if where is None:
        for row in rows:
            yield row, None if row.loaded is None else attempt(row, quiet=quiet, runs=runs, **options)
        return
    from text2sim.cluster.estimate import measured_needs, needs_of
    from text2sim.cluster.task import Task
    from text2sim.harness.result import RunResult
    from text2sim.spec_schema.reuse.library import VARIABLE

    known, tasks = measured_needs(runs), dict[int, Task]()
    for number, row in enumerate(rows):
        try:
            if row.loaded is not None and row.plan is None and row.ok:
                row.plan_and_lint()
        except Text2SimError as error:
            row.blame(error)
        if row.loaded is None or not row.ok:
            continue
        over, prefabs = row.overlay, os.environ.get(VARIABLE)
        arguments = {"file": row.path.name, "variants": over.variants, "sets": over.sets, "point": over.point}
        inputs = {"case": row.path.parent} | ({"prefabs": Path(prefabs)} if prefabs else {})
        needs = needs_of(row.loaded, known, gpu=options["device"] == "gpu")
        arguments |= {"lint": row.findings(), **options}
        tasks[number] = Task("text2sim.cluster.work:simulate", arguments, row.title, needs, inputs, runs)
    found: dict[int, RunResult | None] = {number: None for number in range(len(rows)) if number not in tasks}
    numbers, next_row = {id(task): number for number, task in tasks.items()}, 0
    for done in with_progress(list(tasks.values()), where, quiet=quiet):
        number = numbers[id(done.task)]
        if done.result is None:
            rows[number].blame((MachineError if done.machine else RunError)(done.error))
            rows[number].exit = exits.INTERRUPTED if done.stopped else rows[number].exit
            found[number] = None
        else:
            result = RunResult.from_dict(done.result, runs / done.result["folder"])
            found[number] = replace(result, warnings=rows[number].problems)
        while next_row in found:
            yield rows[next_row], found[next_row]
            next_row += 1
    for rest in range(next_row, len(rows)):
        yield rows[rest], found.get(rest)


def trace(chosen: Chosen, where: "Placement", arguments: dict[str, Any], pictures: int, *, quiet: bool) -> None:
    """Trace the frames of a run in several processes; existing ones are kept.

    Args:
        chosen: The run.
        where: Where processes run.
        arguments: Arguments of `work.render`, without its part.
        pictures: Number of frames.
        quiet: Print nothing.

    Raises:
        RunError: if a part could not be traced.
    """
    from text2sim.cluster.run import capacity
    from text2sim.cluster.task import Needs, Task

    folder, free = chosen.recording.folder, capacity(where)
    # A tracer uses all cores that it gets, so the cores of this machine are divided.
    cores = RENDER_CORES if where.ray else max(1, (os.cpu_count() or 1) // free)
    parts = max(1, min(free // cores if where.ray else free, pictures))
    inputs = {"run": folder} | ({"case": chosen.case.parent} if chosen.case else {})
    arguments = arguments | {"cores": cores, "file": chosen.case.name if chosen.case else "case.yaml"}
    needs, frames = Needs(cores, RENDER_MEMORY), folder / "render" / "frames"
    tasks = [
        Task(
            "text2sim.cluster.work:render", arguments | {"shard": [part, parts]}, f"part {part + 1} of {parts}", needs,
            inputs, frames,
        )
        for part in range(parts)
    ]  # fmt: skip
    for done in with_progress(tasks, where, quiet=quiet):
        if done.result is None:
            raise RunError(f"{done.task.label} of the pictures: {done.error}")


def with_progress(tasks: "Sequence[Task]", where: "Placement", *, quiet: bool) -> "Iterator[Done]":
    """Run tasks; print an estimate first, then progress.

    Args:
        tasks: The tasks.
        where: Where they run.
        quiet: Print nothing.
    """
    from text2sim.cluster.estimate import in_words
    from text2sim.cluster.run import capacity, run_tasks

    if not tasks:
        return
    if not quiet:
        say(in_words(tasks, capacity(where)), to=sys.stderr)
    begun = following = monotonic()
    with Stop() as stop:
        for count, done in enumerate(run_tasks(tasks, where, stop), 1):
            now = monotonic()
            if not quiet and (now >= following or count == len(tasks)):
                following = now + LINE_INTERVAL
                left = (now - begun) / count * (len(tasks) - count)
                say(f"{count} of {len(tasks)} done, {duration_text(left)} left", to=sys.stderr)
            yield done


def attempt(row: "Examined", *, quiet: bool = False, **options: Any) -> "RunResult | None":
    """Run a loaded case.

    Args:
        row: The case; its problems are updated.
        quiet: Show no progress.
        options: Keyword arguments of `run_case`.

    Returns:
        The result; None if the case cannot be run, with the reasons in `row.problems`.
    """
    from text2sim.harness.run import run_case

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
