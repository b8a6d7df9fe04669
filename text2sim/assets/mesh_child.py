"""Checks or repairs one mesh file. `meshes.py` runs it: `python -m text2sim.assets.mesh_child FOLDER`.

FOLDER has `request.json`; `result.json`, and a repaired `mesh`, are written into it.
"""

import json
import sys
from pathlib import Path
from typing import Any

from text2sim.assets.inspection_child import limit_resources
from text2sim.assets.meshes import MESH, REQUEST, RESULT
from text2sim.spec_schema.errors import AssetError


def main(folder: Path) -> None:
    """Do the task in a folder."""
    limit_resources()
    request = json.loads((folder / REQUEST).read_text("utf-8"))
    path = Path(request["path"])
    try:
        found = _check(request, path) if request["task"] == "check" else _repair(request, path, folder)
    except AssetError as error:
        message = str(error)
        found = {"error": message if message.startswith("`") else f"`{path.name}` {message}"}
    except MemoryError:
        found = {"error": f"`{path.name}` needs more memory than is allowed; make it simpler"}
    (folder / RESULT).write_text(json.dumps(found), "utf-8")


def _check(request: dict[str, Any], path: Path) -> dict[str, Any]:
    from text2sim.assets.mesh_intake import read_surface
    from text2sim.assets.mesh_report import report

    surface, notes = read_surface(path, request["up"])
    return {"report": report(surface, path.name, path.stat().st_size, notes).as_dict()}


def _repair(request: dict[str, Any], path: Path, folder: Path) -> dict[str, Any]:
    from text2sim.assets.mesh_intake import read_surface
    from text2sim.assets.mesh_repair import RepairGoal, repair
    from text2sim.assets.mesh_report import report

    goal = RepairGoal(**(request["goal"] or {}))
    surface, notes = read_surface(path, goal.up)
    repaired = repair(surface, goal)
    suffix, content = repaired.file(request["suffix"])
    (folder / MESH).write_bytes(content)
    # The report is about the file as a case will read it.
    again = folder / f"again{suffix}"
    again.write_bytes(content)
    surface, _ = read_surface(again)
    about = report(surface, f"{path.stem}{suffix}", len(content))
    return {"suffix": suffix, "done": [*notes, *repaired.done], "report": about.as_dict()}


if __name__ == "__main__":
    main(Path(sys.argv[1]))
