"""Runs of benchmarks in another engine, and comparison of the observables with the references."""

import json
import shutil
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.engine_benchmark.reference import observed
from text2sim.runtime.child import Limits, run_child
from text2sim.runtime.outcome import last_error, read_end
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_case

MODULE = "text2sim.engine_benchmark.trial"
TIMEOUT = 1800.0


@dataclass(frozen=True)
class Compared:
    """An observable in another engine."""

    benchmark: str
    observable: str
    unit: str
    reference: str
    """analytic or converged."""
    tolerance: float
    until: float
    """End of the comparison [s]."""
    ours: float
    """Largest error of Genesis at the case's own step."""
    theirs: float
    """Largest error of the other engine at the same step."""
    own_change: float
    """Largest change of the other engine's values when the step is halved."""
    seconds: tuple[float, float]
    """Wall time [s] of Genesis and of the other engine."""
    memory: tuple[int, int]
    """Peak memory [bytes] of both."""

    @property
    def ok(self) -> bool:
        """Whether the other engine is within the tolerance."""
        return self.theirs <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {**asdict(self), "ok": self.ok}


@dataclass(frozen=True)
class _Reference:
    """What `benchmark.json` says about an observable."""

    unit: str
    kind: str
    tolerance: float
    until: float
    error: float
    """Largest error of Genesis at the case's own step."""
    values: np.ndarray

    @classmethod
    def read(cls, row: dict[str, Any], count: int) -> "_Reference":
        """Read one with this number of values; what is malformed raises ValueError, LookupError or TypeError."""
        values = np.array(row["values"], float)
        if values.shape != (count,):
            raise ValueError("an observable needs a value for each time")
        numbers = float(row["tolerance"]), float(row["until"]), float(row["convergence"]["errors"][0])
        return cls(str(row["unit"]), str(row["reference"]), *numbers, values)


def run(engine: str, folder: Path, stop: Stop) -> list[Compared]:
    """Run a benchmark at its own time step and at half of that.

    Args:
        engine: `mujoco`, or `MODULE:FUNCTION`.
        folder: The benchmark.
        stop: Requests to stop.

    Raises:
        RunError: if it is not a benchmark, lacks files for the engine, or the engine fails.
    """
    try:
        scene = json.loads((folder / "benchmark.json").read_text("utf-8"))
        name, step, complete = scene["name"], float(scene["step"]), scene["complete"]
        left_out, times = ", ".join(scene["left_out"]), np.array(scene["times"], float)
        ours = float(scene["ours"]["seconds"]), int(scene["ours"]["memory"])
        wanted = {key: _Reference.read(row, len(times)) for key, row in scene["observables"].items()}
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise RunError(f"{folder} is not a benchmark: text2sim benchmark export CASE writes one") from error
    if not complete:
        raise RunError(f"{folder} has no model of its scene, because of {left_out}")
    loaded, names = load_case(folder / "case.yaml"), list(wanted)
    values, seconds, memory = [], 0.0, 0
    with tempfile.TemporaryDirectory(prefix="text2sim-benchmark-") as place:
        for halvings in (0, 1):
            out = Path(place) / str(halvings)
            out.mkdir()
            took, used = _trial(engine, folder, out, step / 2**halvings, stop)
            if not halvings:
                seconds, memory = took, used
            found, _ = observed(out, loaded, names)
            values.append({key: row for key, (row, _) in found.items()})
            shutil.rmtree(out)
    rows = []
    for key, row in wanted.items():
        until = times <= row.until + 1e-9
        off = np.abs(values[0][key] - row.values)[until]
        change = np.abs(values[0][key] - values[1][key])[until]
        rows.append(
            Compared(
                name, key, row.unit, row.kind, row.tolerance, row.until, row.error, float(off.max(initial=0.0)),
                float(change.max(initial=0.0)), (ours[0], seconds), (ours[1], memory),
            )
        )  # fmt: skip
    return rows


def _trial(engine: str, folder: Path, out: Path, step: float, stop: Stop) -> tuple[float, int]:
    command = [sys.executable, "-P", "-m", MODULE, engine, str(folder.absolute()), str(out), repr(step)]
    log = out / "log.txt"
    ended = run_child(
        command, folder=Path.cwd(), log=log, limits=Limits(timeout=TIMEOUT), stop=stop, on_poll=lambda: None
    )
    if ended.cause != "ended" or ended.code:
        end = read_end(log)
        why = ended.cause if ended.cause != "ended" else last_error(end) or end.strip().rpartition("\n")[2]
        raise RunError(f"{engine} did not finish {folder}: {why or f'exit code {ended.code}'}")
    trial = json.loads((out / "trial.json").read_text())
    return float(trial["seconds"]), int(trial["memory"])


def table(rows: list[Compared], engine: str) -> str:
    """Return the comparison as a table in Markdown."""
    heads = [
        "benchmark", "observable", "reference", "tolerance", "Genesis off by", f"{engine} off by",
        f"{engine} changes by, h to h/2", "until", "time", "memory",
    ]  # fmt: skip
    lines = [heads, ["---"] * len(heads)]
    for row in rows:
        mark = "" if row.ok else " **!**"
        unit = f" {row.unit}" if row.unit else ""
        lines.append(
            [
                row.benchmark, row.observable, row.reference, f"{row.tolerance:.3g}{unit}", f"{row.ours:.2g}",
                f"{row.theirs:.2g}{mark}", f"{row.own_change:.2g}", f"{row.until:.3g} s",
                " / ".join(f"{s:.2f} s" for s in row.seconds), " / ".join(f"{m / 1e6:.0f} MB" for m in row.memory),
            ]
        )  # fmt: skip
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"
