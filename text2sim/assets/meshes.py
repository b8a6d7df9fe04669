"""Checks and repairs of mesh files in a child process, which is all that hostile files and the libraries can crash.

The libraries also change the state of a whole process, such as its working directory.
"""

import json
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.confined import end_of, environment
from text2sim.assets.safe_write import read_file
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.whole_files import naming

if TYPE_CHECKING:
    from text2sim.assets.mesh_intake import Up
    from text2sim.assets.mesh_repair import RepairGoal
    from text2sim.assets.mesh_report import MeshReport

CHILD = "text2sim.assets.mesh_child"
TIMEOUT = 300
"""Seconds; two million triangles take a minute or two."""
REQUEST, RESULT, MESH = "request.json", "result.json", "mesh"


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
    found, _ = _ask({"task": "check", "path": str(path.absolute()), "up": up})
    return _report(found["report"])


def repair_mesh(path: Path, goal: "RepairGoal | None" = None, suffix: str | None = None) -> RepairedFile:
    """Return a repaired copy of a mesh file.

    Args:
        path: The file, as for `check_mesh`.
        goal: Goal of the repair.
        suffix: `.glb` or `.obj`; the one that loses nothing if None.

    Raises:
        AssetError: if it cannot be used.
    """
    wanted = None if goal is None else asdict(goal)
    found, content = _ask({"task": "repair", "path": str(path.absolute()), "goal": wanted, "suffix": suffix})
    return RepairedFile(str(found["suffix"]), content, _report(found["report"]), tuple(found["done"]))


def _report(data: dict[str, Any]) -> "MeshReport":
    from text2sim.assets.mesh_report import MeshReport

    x, y, z = data["extent"]
    lists = {name: tuple(data[name]) for name in ("problems", "notes")}
    return MeshReport(**{**data, **lists, "extent": (x, y, z)})


def _ask(request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    name = Path(request["path"]).name
    read_file(Path(request["path"]))  # reports an unreadable file without starting a process
    with tempfile.TemporaryDirectory(prefix="text2sim-") as place:
        folder = Path(place)
        with naming(folder / REQUEST):
            (folder / REQUEST).write_text(json.dumps(request), "utf-8")
        try:
            done = subprocess.run(
                [sys.executable, "-P", "-m", CHILD, str(folder)], cwd=folder, env=environment(),
                capture_output=True, timeout=TIMEOUT, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise AssetError(f"`{name}` takes more than {TIMEOUT} s to read and repair; make it simpler") from None
        if done.returncode or not (folder / RESULT).is_file():
            raise AssetError(f"`{name}` crashes the mesh libraries ({end_of(done)})")
        found: dict[str, Any] = json.loads((folder / RESULT).read_text("utf-8"))
        content = (folder / MESH).read_bytes() if (folder / MESH).is_file() else b""
    if "error" in found:
        raise AssetError(str(found["error"]))
    return found, content
