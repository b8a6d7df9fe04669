"""Trials of meshes in the engine: a case with the mesh is compiled and run for a few steps."""

from dataclasses import dataclass
from pathlib import Path

from text2sim.asset_intake.tiny_case import BODY, first_of, run_trial, tiny_case
from text2sim.spec_schema.errors import AssetError, SpecError

STEPS, STEP = 5, 0.01


@dataclass(frozen=True)
class EngineImport:
    """What came of it."""

    ok: bool
    message: str
    """Why not."""
    mass: float | None
    """[kg], at the density of water."""
    pieces: int
    """Convex pieces that the compiler made of it."""
    wall: float
    """Seconds that it took."""


def import_into_engine(file: Path) -> EngineImport:
    """Drop a mesh above a floor for five steps, through the compiler and the harness.

    Args:
        file: The mesh as a case would name it: .obj, .stl, .ply, .glb or .gltf.

    Raises:
        MachineError: if this machine cannot run the engine.
    """
    from text2sim.compiler.build import resolve_case
    from text2sim.compiler.masses import masses

    shape = {"kind": "mesh", "file": file.name}
    body = {"kind": "rigid", "shape": shape, "place": {"above": "floor", "at": [0, 0], "clearance": 0.01}}
    scene = {"duration": STEPS * STEP, "dt": STEP, "statics": {"floor": {"shape": {"kind": "plane"}}}}
    try:
        loaded = tiny_case(file.parent, body, scene)
        resolution = resolve_case(loaded)
    except SpecError as error:
        return EngineImport(False, first_of(error), None, 0, 0.0)
    except AssetError as error:
        return EngineImport(False, str(error), None, 0, 0.0)
    outcome = run_trial(loaded)
    message = outcome.message or ("" if outcome.ok else outcome.state)
    return EngineImport(outcome.ok, message, masses(resolution)[BODY], resolution.lowering.pieces, outcome.wall)
