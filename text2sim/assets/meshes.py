"""Mesh files, checked and repaired in a process of their own: hostile files and upset libraries end only that.

The libraries also change things that belong to a whole process, such as its working directory.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
SECRET = ("KEY", "TOKEN", "SECRET", "PASSWORD")
"""A variable with one of these in its name is not handed on."""


@dataclass(frozen=True)
class RepairedFile:
    """A repaired mesh file."""

    suffix: str
    content: bytes
    report: "MeshReport"
    """What it is like now; what is still wrong are its `problems`."""
    done: tuple[str, ...]
    """What was done to it, in words."""


def check_mesh(path: Path, up: "Up | None" = None) -> "MeshReport":
    """Return what a mesh file is like.

    Args:
        path: The file: .obj, .stl, .ply, .off, .glb or .gltf, wherever it lies.
        up: Which of its axes points up; as its format has it if None.

    Raises:
        AssetError: if it cannot be used.
    """
    found, _ = _ask({"task": "check", "path": str(path.absolute()), "up": up})
    return _report(found["report"])


def repair_mesh(path: Path, wish: "RepairGoal | None" = None, suffix: str | None = None) -> RepairedFile:
    """Return what a mesh file becomes; the file itself stays as it is.

    Args:
        path: The file, as above.
        wish: What it shall become.
        suffix: `.glb` or `.obj`; the one that loses nothing if None.

    Raises:
        AssetError: if it cannot be used.
    """
    wanted = None if wish is None else asdict(wish)
    found, content = _ask({"task": "repair", "path": str(path.absolute()), "wish": wanted, "suffix": suffix})
    return RepairedFile(str(found["suffix"]), content, _report(found["report"]), tuple(found["done"]))


def _report(data: dict[str, Any]) -> "MeshReport":
    from text2sim.assets.mesh_report import MeshReport

    x, y, z = data["extent"]
    lists = {name: tuple(data[name]) for name in ("problems", "notes")}
    return MeshReport(**{**data, **lists, "extent": (x, y, z)})


def _ask(request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    name = Path(request["path"]).name
    read_file(Path(request["path"]))  # what cannot be read is said without a process
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
            raise AssetError(f"`{name}` takes more than {TIMEOUT} s to read and mend; make it simpler first") from None
        if done.returncode or not (folder / RESULT).is_file():
            how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit {done.returncode}"
            said = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
            raise AssetError(f"`{name}` brings the mesh libraries down ({', '.join([how, *said])[:200]})")
        found: dict[str, Any] = json.loads((folder / RESULT).read_text("utf-8"))
        content = (folder / MESH).read_bytes() if (folder / MESH).is_file() else b""
    if "error" in found:
        raise AssetError(str(found["error"]))
    return found, content


def environment() -> dict[str, str]:
    """Return the environment of a child: without keys, and such that it finds this package."""
    kept = {name: value for name, value in os.environ.items() if not any(word in name.upper() for word in SECRET)}
    return kept | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
