"""Trial of a mesh in the engine: a case with the mesh is compiled and run for a few steps."""

from dataclasses import dataclass
from pathlib import Path

from text2sim.asset_intake.tiny_case import BODY, first_of, run_trial, tiny_case
from text2sim.spec_schema.errors import AssetError, SpecError

TRIAL_STEPS, TRIAL_STEP = 5, 0.01


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
