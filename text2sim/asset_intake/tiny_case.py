"""Cases with one body, for trials of assets."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.errors import AssetError, SpecError

if TYPE_CHECKING:
    from text2sim.spec_schema.loaded import LoadedCase

BODY = "it"
TRIAL_STEPS, TRIAL_STEP = 5, 0.01
TIMEOUT = 900.0
"""Wall time [s] of a trial: the first run on a machine compiles the engine's kernels."""


@dataclass(frozen=True)
class TrialOutcome:
    """Outcome of a trial."""

    state: str
    """State of the run; `finished` if it ran to its end."""
    message: str
    """Why it ended early, or was refused."""
    wall: float
    """Wall time [s]."""
    series: "Mapping[str, list[float]]"
    """Measures by name, and `time` [s], which is empty if nothing was recorded."""

    @property
    def ok(self) -> bool:
        """Whether it ran to its end."""
        return self.state == "finished"


def tiny_case(folder: Path, body: Mapping[str, Any], scene: Mapping[str, Any], **sections: Any) -> "LoadedCase":
    """Return a case with one body, named `it`.

    Args:
        folder: The folder of the files that the body names; nothing is written there.
        body: The body, as in a case.
        scene: Its section `scene`.
        sections: Its other sections.

    Raises:
        AssetError: with the problems of the body, in one line.
    """
    from text2sim.spec_schema.load import load_text
    from text2sim.spec_schema.text.canonical import dump_case

    data = {"text2sim": 2, "name": "trial", "scene": dict(scene), "bodies": {BODY: dict(body)}, **sections}
    try:
        return load_text(dump_case(data), folder / "trial.yaml")
    except SpecError as error:
        raise AssetError(first_of(error)) from None


def first_of(error: SpecError) -> str:
    """Return the problems of a trial in one line, without places, because its file does not exist."""
    rows = [problem.message for problem in error.problems if problem.severity == "error"]
    return "; ".join(rows[:3]) + (f"; and {len(rows) - 3} more" if len(rows) > 3 else "")


def run_trial(loaded: "LoadedCase") -> TrialOutcome:
    """Run a case in a temporary folder.

    Raises:
        MachineError: if this machine cannot run it.
    """
    from text2sim.harness.run import run_case
    from text2sim.recording.run_files import read_measures

    with tempfile.TemporaryDirectory(prefix="text2sim-") as place:
        try:
            result = run_case(loaded, runs=Path(place), film=False, timeout=TIMEOUT)
        except SpecError as error:
            return TrialOutcome("refused", first_of(error), 0.0, {})
        why = "" if result.state == "finished" else result.problem.message if result.problem else result.message
        time, measures = read_measures(result.folder)
        series = {name: values.tolist() for name, values in {"time": time, **measures}.items()}
        return TrialOutcome(result.state, why, result.wall, series)


@dataclass(frozen=True)
class EngineImport:
    """Result of a trial."""

    ok: bool
    message: str
    """Reason if it failed."""
    mass: float | None
    """Mass [kg] at the density of water."""
    pieces: int
    """Convex pieces that the compiler made."""
    wall: float
    """Wall time [s]."""


def import_into_engine(file: Path) -> EngineImport:
    """Drop a mesh above a floor for five steps, through the compiler and the harness.

    Args:
        file: The mesh: .obj, .stl, .ply, .glb or .gltf.

    Raises:
        MachineError: if this machine cannot run the engine.
    """
    from text2sim.compiler.build import resolve_case
    from text2sim.compiler.masses import masses

    shape = {"kind": "mesh", "file": file.name}
    body = {"kind": "rigid", "shape": shape, "place": {"above": "floor", "at": [0, 0], "clearance": 0.01}}
    scene = {"duration": TRIAL_STEPS * TRIAL_STEP, "dt": TRIAL_STEP, "statics": {"floor": {"shape": {"kind": "plane"}}}}
    try:
        loaded = tiny_case(file.parent, body, scene)
        resolution = resolve_case(loaded)
    except (SpecError, AssetError) as error:
        message = first_of(error) if isinstance(error, SpecError) else str(error)
        return EngineImport(False, message, None, 0, 0.0)
    outcome = run_trial(loaded)
    message = outcome.message or ("" if outcome.ok else outcome.state)
    return EngineImport(outcome.ok, message, masses(resolution)[BODY], resolution.lowering.pieces, outcome.wall)
