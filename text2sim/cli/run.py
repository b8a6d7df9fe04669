"""The command `text2sim run`."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.many import Ray, StoreUrl, Workers, attempts, where_of
from text2sim.cli.options import AsJson, Sets, Variants, overlay_of, with_options
from text2sim.cli.output import say, say_json
from text2sim.cli.verdict import exit_of, say_result
from text2sim.service import exits

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.overlay import CaseOverlay


@dataclass(frozen=True)
class RunOptions:
    """Options of commands that run cases."""

    variants: Variants = None
    sets: Sets = None
    runs: Annotated[Path, typer.Option("--runs", help="Folder of run folders.")] = Path("runs")
    timeout: Annotated[float, typer.Option("--timeout", min=1.0, help="Limit of a program's wall time in seconds.")] = (
        3600.0
    )
    memory: Annotated[
        float | None,
        typer.Option("--memory", min=0.1, help="Limit of a program's memory in GB; 85 % of what is free if left out."),
    ] = None
    force: Annotated[bool, typer.Option("--force", help="Simulate again even if nothing changed.")] = False
    gpu: Annotated[bool, typer.Option("--gpu", help="Simulate on the CUDA device instead of the CPU.")] = False
    workers: Workers = 1
    ray: Ray = ""
    store: StoreUrl = ""
    as_json: AsJson = False

    @property
    def overlay(self) -> "CaseOverlay":
        """The overlay of each case."""
        return overlay_of(self.variants, self.sets)

    def of_attempts(self, *, film: bool) -> dict[str, Any]:
        """Return the keyword arguments of `attempts`."""
        return {
            "where": where_of(self.workers, self.ray, self.store, self.runs),
            "runs": self.runs,
            "timeout": self.timeout,
            "memory_gb": self.memory,
            "film": film,
            "force": self.force,
            "device": "gpu" if self.gpu else "cpu",
        }


@with_options(RunOptions)
def run_cases(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    sweep: Annotated[str, typer.Option("--sweep", metavar="NAME", help="Run this sweep of the case.")] = "",
    grid: Annotated[
        list[str] | None,
        typer.Option("--grid", metavar="PATH=[A,B,...]", help="Run every combination of these values."),
    ] = None,
    no_film: Annotated[bool, typer.Option("--no-film", help="Do not make a film.")] = False,
    *,
    options: RunOptions,
) -> None:
    """Simulate, judge and film cases.

    Finished work is not repeated: a changed render section only films again; changed measures, events and
    expectations are only judged again.

    Ctrl-C stops and keeps what was recorded; a second one kills.
    """
    from text2sim.cli.cases import say_examined
    from text2sim.service.examined import examine, find_cases

    # All are read before the first runs, so that an error in the last one does not show up after an hour.
    paths, overlay, as_json = find_cases(cases), options.overlay, options.as_json
    how = options.of_attempts(film=not no_film)
    if sweep or grid:
        from text2sim.cli.sweep import run_sweep

        if len(paths) != 1:
            raise typer.BadParameter("a sweep takes one case", param_hint="'CASES...'")
        raise typer.Exit(run_sweep(paths[0], overlay, sweep, grid or [], how, as_json=as_json))
    rows = [examine(path, to="linted" if len(paths) > 1 else "loaded", overlay=overlay) for path in paths]
    if any(not row.ok for row in rows):
        if as_json:
            say_json({"ok": False, "runs": [row.as_dict() for row in rows]})
        for row in () if as_json else rows:
            say_examined(row)
        if len(rows) > 1 and not as_json:
            say(f"nothing was run: {sum(not row.ok for row in rows)} of {len(rows)} cases have errors", to=sys.stderr)
        raise typer.Exit(max(row.exit for row in rows))

    code, documents = exits.OK, []
    for row, result in attempts(rows, quiet=as_json, **how):
        code = max(code, row.exit if result is None else exit_of(result))
        documents.append(row.as_dict() if result is None else result.as_dict())
        if not as_json:
            say_examined(row)
            if result is not None:
                say_result(row, result)
        if result is not None and result.stopped:
            break
    if as_json:
        say_json({"ok": code == exits.OK, "runs": documents})
    raise typer.Exit(code)
