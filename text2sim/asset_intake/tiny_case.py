"""Cases of one body, made to try it."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.errors import AssetError, SpecError

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.spec_schema.loaded import LoadedCase

BODY = "it"
TIMEOUT = 900.0
"""Seconds of wall time: on a machine that never ran the engine, its kernels are compiled first."""


@dataclass(frozen=True)
class TrialOutcome:
    """How a trial ended."""

    state: str
    """One of the states of a run; `finished` if all went well."""
    message: str
    """Why it ended early, or was refused."""
    wall: float
    """Seconds that it took."""
    series: "Mapping[str, list[float]]"
    """Measures by name, and `time` [s]; empty if nothing was recorded."""

    @property
    def ok(self) -> bool:
        """Whether it came to its end."""
        return self.state == "finished"


def tiny_case(folder: Path, body: Mapping[str, Any], scene: Mapping[str, Any], **sections: Any) -> "LoadedCase":
    """Return a case with one body, named `it`.

    Args:
        folder: The folder in which the files that the body names lie; nothing is written there.
        body: The body, as a case has it.
        scene: Its section `scene`.
        sections: Its other sections.

    Raises:
        AssetError: with what is wrong with the body, in one line.
    """
    from text2sim.spec_schema.load import load_text
    from text2sim.spec_schema.text.canonical import dump_case

    data = {"text2sim": 2, "name": "trial", "scene": dict(scene), "bodies": {BODY: dict(body)}, **sections}
    try:
        return load_text(dump_case(data), folder / "trial.yaml")
    except SpecError as error:
        raise AssetError(first_of(error)) from None


def first_of(error: SpecError) -> str:
    """Return what is wrong with a trial, without the places in a file that nobody has."""
    rows = [problem.message for problem in error.problems if problem.severity == "error"]
    return "; ".join(rows[:3]) + (f"; and {len(rows) - 3} more" if len(rows) > 3 else "")


def run_trial(loaded: "LoadedCase") -> TrialOutcome:
    """Run a case in a folder that is gone afterwards, in a process of its own.

    Raises:
        MachineError: if this machine cannot run it.
    """
    from text2sim.harness.run import run_case

    with tempfile.TemporaryDirectory(prefix="text2sim-") as place:
        try:
            result = run_case(loaded, runs=Path(place), film=False, timeout=TIMEOUT)
        except SpecError as error:
            return TrialOutcome("refused", first_of(error), 0.0, {})
        return TrialOutcome(result.state, _why(result), result.wall, _series(result.folder / "measures.csv"))


def _why(result: "RunResult") -> str:
    if result.state == "finished":
        return ""
    return result.problem.message if result.problem is not None else result.message


def _series(file: Path) -> dict[str, list[float]]:
    import csv

    if not file.is_file():
        return {}
    with file.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    if not rows:
        return {}
    return {name: [float(row[k] or "nan") for row in rows[1:]] for k, name in enumerate(rows[0])}
