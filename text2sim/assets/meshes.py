"""Checks and repairs of mesh files in a child process, so that files and libraries cannot crash ours.

The libraries also change the state of a whole process, such as its working directory.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from text2sim.assets.confined import call_confined
from text2sim.assets.safe_write import read_file
from text2sim.spec_schema.errors import AssetError

if TYPE_CHECKING:
    from text2sim.assets.mesh_intake import Up
    from text2sim.assets.mesh_repair import RepairGoal
    from text2sim.assets.mesh_report import MeshReport

PROCESSOR_LIMIT, MEMORY_LIMIT = 100, 6 * 1024**3
"""Limits of processor time [s] and memory [bytes]: two million triangles take a minute or two on a busy machine."""
R = TypeVar("R")


@dataclass(frozen=True)
class RepairedFile:
    """A repaired mesh file."""

    suffix: str
    content: bytes
    report: "MeshReport"
    """Report on the repaired mesh, with its remaining `problems`."""
    done: tuple[str, ...]
    """Repairs, in words."""


def check_mesh(path: Path, up: "Up | None" = None) -> "MeshReport":
    """Return a report on a mesh file.

    Args:
        path: The file: .obj, .stl, .ply, .off, .glb or .gltf, in any folder.
        up: Its axis that points up; the one of its format if None.

    Raises:
        AssetError: if it cannot be used.
    """
    return _in_child(_check, path, up)


def repair_mesh(path: Path, goal: "RepairGoal | None") -> RepairedFile:
    """Return a repaired copy of a mesh file, in the format that loses nothing: .glb or .obj.

    Args:
        path: The file, as for `check_mesh`.
        goal: Goal of the repair; the default one if None.

    Raises:
        AssetError: if it cannot be used.
    """
    return _in_child(_repair, path, goal)


def _in_child(function: Callable[..., R], path: Path, *args: Any) -> R:
    read_file(path)  # reports an unreadable file without starting a process
    try:
        return call_confined(function, path.absolute(), *args, large=True, seconds=PROCESSOR_LIMIT, memory=MEMORY_LIMIT)
    except AssetError as error:
        message = str(error)
        raise AssetError(message if message.startswith("`") else f"`{path.name}` {message}") from None


def _check(path: Path, up: "Up | None") -> "MeshReport":
    from text2sim.assets.mesh_intake import read_surface
    from text2sim.assets.mesh_report import report

    surface, notes = read_surface(path, up)
    return report(surface, path.name, path.stat().st_size, notes)


def _repair(path: Path, goal: "RepairGoal | None") -> RepairedFile:
    from text2sim.assets.mesh_intake import read_surface
    from text2sim.assets.mesh_output import mesh_bytes, suffix_for
    from text2sim.assets.mesh_repair import RepairGoal, repair

    goal = goal or RepairGoal()
    surface, notes = read_surface(path, goal.up)
    repaired = repair(surface, goal)
    suffix = suffix_for(repaired.surface)
    content = mesh_bytes(repaired.surface, suffix)
    with tempfile.TemporaryDirectory(prefix="text2sim-") as folder:
        # The report is about the file as a case will read it.
        again = Path(folder) / f"{path.stem}{suffix}"
        again.write_bytes(content)
        return RepairedFile(suffix, content, _check(again, None), (*notes, *repaired.done))
