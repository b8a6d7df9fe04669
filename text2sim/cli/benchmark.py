"""The commands `text2sim benchmark export | run`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.many import Ray, StoreUrl, Workers, where_of, with_progress
from text2sim.cli.options import AsJson, Sets, Variants, overlay_of
from text2sim.cli.output import say, say_json
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError, Text2SimError
from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    from text2sim.cluster.run import Placement
    from text2sim.cluster.task import Task
    from text2sim.service.examined import Examined
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

benchmark = typer.Typer(no_args_is_help=True, help="Cases as benchmarks for other simulators, and their results.")


@benchmark.command("export")
def export_cases(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    out: Annotated[Path, typer.Option("--out", help="Folder in which each benchmark has its own.")] = Path("benchmark"),
    variants: Variants = None,
    sets: Sets = None,
    runs: Annotated[Path, typer.Option("--runs", help="Folder of the runs for the references.")] = Path("runs"),
    workers: Workers = 1,
    ray: Ray = "",
    store: StoreUrl = "",
    as_json: AsJson = False,
) -> None:
    """Export cases for other simulators: shapes, masses, joints, initial states, controls, and reference observables.

    Each case runs three times: at its own time step, and at a half and a quarter of it. `benchmark.yaml` beside the
    case defines observables, tolerances and equations.
    """
    from text2sim.cli.cases import say_examined
    from text2sim.cluster.run import Placement

    where = where_of(workers, ray, store, runs) or Placement()
    rows, tasks = examined(cases, runs, overlay_of(variants, sets))
    code, documents = exits.OK, []
    for row, folder, scene in exported(rows, tasks, out, where, quiet=as_json):
        if scene is not None:
            documents.append({"folder": str(folder), "complete": scene["complete"], "left_out": scene["left_out"]})
            left = f"; no MJCF or USD: {', '.join(scene['left_out'])}" if scene["left_out"] else ""
            _ = as_json or say(f"{display_path(folder)}: {len(scene['observables'])} observables{left}")
        else:
            code = max(code, row.exit)
            documents.append(row.as_dict())
            _ = as_json or say_examined(row)
    if as_json:
        say_json({"ok": code == exits.OK, "benchmarks": documents})
    raise typer.Exit(code)


def examined(
    cases: "Iterable[Path]", runs: Path, overlay: "CaseOverlay | None" = None
) -> "tuple[list[Examined], dict[int, list[Task]]]":
    """Check cases before export; return them, and the runs that each valid one needs, by its number.

    Args:
        cases: Paths of cases or folders of them.
        runs: Folder of runs.
        overlay: Overlay of each case.
    """
    from text2sim.cluster.estimate import measured_needs
    from text2sim.cluster.task import Task
    from text2sim.engine_benchmark.reference import tasks_of
    from text2sim.engine_benchmark.statement import read_statement
    from text2sim.service.examined import examine, find_cases
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

    rows = [examine(path, overlay=overlay or CaseOverlay()) for path in find_cases(cases)]
    known, tasks, named = measured_needs(runs), dict[int, list[Task]](), dict[str, Path]()
    for number, row in enumerate(rows):
        try:
            if row.loaded is not None and row.plan is not None:
                # A folder is named as its case: a second one would replace the first.
                if (other := named.setdefault(row.name, row.path)) != row.path:
                    row.blame(
                        RunError(f"{display_path(other)} has the name `{row.name}`, too; give one of them another")
                    )
                    continue
                read_statement(row.loaded)  # reports its errors before anything runs
                tasks[number] = tasks_of(row.loaded, row.plan, runs, known)
        except Text2SimError as error:
            row.blame(error)
    return rows, tasks


def exported(
    rows: "Sequence[Examined]", tasks: "Mapping[int, list[Task]]", out: Path, where: "Placement", *, quiet: bool
) -> "Iterator[tuple[Examined, Path, dict[str, Any] | None]]":
    """Run and export the cases of `examined`; yield each case, its folder, and its benchmark if there is one.

    Args:
        rows: The cases.
        tasks: Their runs by the number of the case.
        out: Output folder; each case gets a folder in it.
        where: Where the runs take place.
        quiet: Whether no progress is printed.
    """
    from text2sim.engine_benchmark.export import export

    done = {
        id(one.task): one for one in with_progress([t for many in tasks.values() for t in many], where, quiet=quiet)
    }
    for number, row in enumerate(rows):
        folder, scene = out / row.name, None
        if number in tasks and row.loaded is not None and row.plan is not None:
            results = [done[id(task)] for task in tasks[number]]
            try:
                scene = export(row.loaded, row.plan, folder, results)
            except Text2SimError as error:
                row.blame(error)
                row.exit = exits.INTERRUPTED if any(one.stopped for one in results) else row.exit
        yield row, folder, scene


@benchmark.command("run")
def run_benchmarks(
    folders: Annotated[list[Path], typer.Argument(help="Benchmarks, or folders of benchmarks.")],
    engine: Annotated[
        str, typer.Option("--engine", metavar="NAME", help="mujoco, or MODULE:FUNCTION of your own adapter.")
    ] = "mujoco",
    write: Annotated[Path | None, typer.Option("--table", metavar="FILE", help="Write the table as Markdown.")] = None,
    as_json: AsJson = False,
) -> None:
    """Run benchmarks in another engine, and compare its observables with the references.

    Exit code 1: an observable is beyond its tolerance; 2: a benchmark could not be run.
    """
    from text2sim.engine_benchmark.compare import Compared, run, table

    found = [
        p.parent for folder in folders for p in sorted([folder / "benchmark.json", *folder.glob("*/benchmark.json")])
    ]
    found = [folder for folder in dict.fromkeys(found) if (folder / "benchmark.json").is_file()] or list(folders)
    rows: list[Compared] = []
    failed: list[dict[str, Any]] = []
    with Stop() as stop:
        for folder in found:
            try:
                rows += run(engine, folder, stop)
            except Text2SimError as error:
                failed.append({"folder": str(folder), "error": str(error)})
                _ = as_json or say(str(error))
            if stop.count:
                break
    text = table(rows, "MuJoCo" if engine == "mujoco" else engine)
    code = exits.INPUT if failed else exits.OK if all(row.ok for row in rows) else exits.PHYSICS
    code = exits.INTERRUPTED if stop.count else code
    if as_json:
        say_json({"ok": code == exits.OK, "rows": [row.as_dict() for row in rows], "failed": failed})
    elif rows:
        say(text)
        say(f"{sum(row.ok for row in rows)} of {len(rows)} observables within their tolerances")
    if write is not None:
        write_atomically(write, text)
    raise typer.Exit(code)
