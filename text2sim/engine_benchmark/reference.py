"""References of observables: an equation, or the same case at shorter time steps."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.cluster.estimate import needs_of
from text2sim.cluster.task import Done, Needs, Task
from text2sim.compiler.plan import Plan
from text2sim.engine_benchmark.statement import Statement
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.arithmetic.expressions import parse_expression
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.loaded import LoadedCase

HALVINGS = (0, 1, 2)
"""Numbers of halvings of the time step; the last run is the reference without an equation."""
TOLERANCE_SHARE = 0.02
"""Default tolerance, as a part of the observable's range."""
MIN_TOLERANCE = {"m": 1e-3, "rad": 0.01, "deg": 1.0, "m/s": 0.01, "rad/s": 0.05}
"""Smallest default tolerance by unit."""
Array = NDArray[np.floating]


@dataclass(frozen=True)
class Runs:
    """The recorded runs, from the case's own time step to the shortest."""

    folders: list[Path]
    times: Array
    """Times of the frames [s]."""
    values: list[dict[str, Array]]
    """Values of every observable at `times`, for each run."""
    units: dict[str, str]
    records: list[RunRecord]


def tasks_of(loaded: LoadedCase, plan: Plan, runs: Path, known: dict[str, Needs]) -> list[Task]:
    """Return the runs of a case at its own time step and at halved steps, as tasks.

    Args:
        loaded: The case.
        plan: Its plan.
        runs: Folder of runs.
        known: Measured needs by name of the case.
    """
    over, tasks = loaded.overlay, []
    for halvings in HALVINGS:
        sets = [f"scene.dt={plan.dt / 2**halvings!r}", f"scene.substeps={plan.settings.substeps}"]
        arguments: dict[str, Any] = {"file": loaded.path.name, "variants": [*over.variants], "point": over.point}
        arguments |= {"sets": [*over.sets, *(sets if halvings else sets[1:])], "lint": [], "film": False}
        label = f"{loaded.case.name} at step/{2**halvings}"
        needs = needs_of(loaded, known, gpu=False)
        tasks.append(Task("text2sim.cluster.work:simulate", arguments, label, needs, {"case": loaded.folder}, runs))
    return tasks


def collect(loaded: LoadedCase, names: list[str], done: Sequence[Done]) -> Runs:
    """Read the results of the runs of `tasks_of`, in that order.

    Args:
        loaded: The case.
        names: Names of the observables.
        done: Finished tasks, the longest time step first.

    Raises:
        RunError: if one did not finish, or an observable has no value.
    """
    folders = []
    for ended in done:
        task, result = ended.task, ended.result
        if result is None or result["state"] != "finished" or task.output is None:
            why = ended.error if result is None else f"{result['state']}: {result['message']}"
            raise RunError(f"{task.label}: {why}")
        folders.append(task.output / result["folder"])
    times, values, units = np.zeros(0), [], {}
    for folder in folders:
        found, own = observed(folder, loaded, names)
        units = {name: unit for name, (_, unit) in found.items()}
        times = times if len(times) else own
        values.append({name: np.interp(times, own, row) for name, (row, _) in found.items()})
    records = [record for folder in folders if (record := RunRecord.read(folder)) is not None]
    return Runs(folders, times, values, units, records)


def observed(folder: Path, loaded: LoadedCase, names: list[str]) -> tuple[dict[str, tuple[Array, str]], Array]:
    """Return the observables of a recording, with their units, and the times [s] of its frames.

    Args:
        folder: The run folder.
        loaded: The case.
        names: Names of the observables.

    Raises:
        RunError: if one has no value.
    """
    recording = RecordedCase.load(folder, loaded.case)
    series = evaluate(recording)
    for name in names:
        if series[name].problem or not np.isfinite(series[name].values).all():
            raise RunError(f"{folder}: {name} has no value: {series[name].problem or 'it is not finite'}")
    return {name: (series[name].values, series[name].unit) for name in names}, recording.states.time.astype(float)


def references(runs: Runs, statement: Statement) -> dict[str, dict[str, Any]]:
    """Return for each observable: reference, tolerance, convergence, and the end of the comparison.

    `changes` are the largest differences between a run and the next one, at half its step. A reference without an
    equation ends where the last two runs differ by more than half of the tolerance: chaotic motion may not converge at
    any step.
    """
    found = {}
    for name, stated in statement.observables.items():
        rows = [values[name] for values in runs.values]
        if stated.analytic is not None:
            formula = parse_expression(stated.analytic)
            reference = np.array([float(formula.evaluate({"t": float(t)})) for t in runs.times])  # type: ignore[arg-type]
        else:
            reference = rows[-1]
        tolerance = stated.tolerance or max(
            TOLERANCE_SHARE * float(np.ptp(reference)), MIN_TOLERANCE.get(runs.units[name], 1e-3)
        )
        until = runs.times <= (statement.until or np.inf) + 1e-9
        if stated.analytic is None:
            known = np.abs(rows[-1] - rows[-2]) <= tolerance / 2
            until &= np.cumprod(known).astype(bool)
        changes = [float(np.abs(a - b)[until].max(initial=0.0)) for a, b in zip(rows, rows[1:], strict=False)]
        found[name] = {
            "unit": runs.units[name],
            "reference": "analytic" if stated.analytic is not None else "converged",
            "analytic": stated.analytic,
            "tolerance": tolerance,
            "until": float(runs.times[until][-1]) if until.any() else 0.0,
            "convergence": {
                "steps": [1.0 / 2**k for k in HALVINGS],
                "changes": changes,
                "errors": [float(np.abs(row - reference)[until].max(initial=0.0)) for row in rows],
            },
            "values": [float(f"{value:.9g}") for value in reference],
        }
    return found
