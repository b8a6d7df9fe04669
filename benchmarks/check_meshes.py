"""What `text2sim check` takes for bodies that are meshes of some hundred thousand vertices: one table.

Processor time is printed beside wall time, because the first tells what the check costs, and the second what else the
machine does. `first` is a file that was never read before; what was found out about it is then remembered.
"""

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from text2sim.compiler.shapes.rings import turned  # noqa: E402
from text2sim.compiler.shapes.softmesh import SoftMesh, write_obj  # noqa: E402

GOAL = "2 s"
HEAD = "text2sim: 2\nname: meshes\nscene: {duration: 0.5, statics: {floor: {shape: {kind: plane}}}}\nbodies:\n"
BODIES = {
    "rigid box (no mesh)": "kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}",
    "rigid": "kind: rigid, shape: {kind: mesh, file: ball.obj}",
    "soft, mpm": "kind: soft, solver: mpm, cell: 0.02, shape: {kind: mesh, file: ball.obj}",
    "soft, fem": "kind: soft, solver: fem, cell: 0.03, shape: {kind: mesh, file: ball.obj}",
    "cloth, pbd": "kind: cloth, solver: pbd, cell: 0.02, shape: {kind: mesh, file: cloth.obj}",
    "cloth, sheet": "kind: cloth, solver: pbd, cell: 0.004, shape: {kind: sheet, size: [1.2, 1.2]}",
    "soft letters": "kind: soft, solver: mpm, cell: 0.02, repeat: {kind: glyphs}, "
    'shape: {kind: text, text: "five rows\\nof soft\\nletters", height: 0.25, depth: 0.1}',
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vertices", type=int, default=100_000, help="of each mesh, about")
    parser.add_argument("--repeat", type=int, default=3, help="warm checks; the quickest counts")
    options = parser.parse_args()
    table = Table("body", "vertices", "first: cpu", "wall", "again: cpu", "wall", "goal")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        count = {"ball.obj": ball(folder, options.vertices), "cloth.obj": cloth(folder, options.vertices)}
        for label, words in BODIES.items():
            of = next((n for file, n in count.items() if file in words), None)
            case = folder / "case.yaml"
            case.write_text(f"{HEAD}  thing: {{{words}, pose: {{pos: [0, 0, 0.8]}}}}\n")
            os.environ["XDG_CACHE_HOME"] = str(folder / f"cache {label}")
            first = check(case)
            again = min((check(case) for _ in range(options.repeat)), key=lambda row: row[0])
            table.add_row(label, f"{of:,}" if of else "-", *(f"{t:.2f} s" for t in (*first, *again)), GOAL)
    Console().print(table)


def check(case: Path) -> tuple[float, float]:
    """Return processor time and wall time [s] of one check."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "text2sim", "check", str(case)], cwd=ROOT, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.perf_counter() - began


def ball(folder: Path, vertices: int) -> int:
    """Write a bumpy ball with about so many vertices, and return how many it has."""
    # Rings at equal distances e on a ball of radius r hold 4 pi r^2 / (e * 0.87 e) points.
    rings = round(math.sqrt(vertices * math.pi / 4))
    angles = [math.pi * (k / rings - 0.5) for k in range(1, rings)]
    profile = [(0.0, -0.3), *((0.3 * math.cos(a), 0.3 * math.sin(a)) for a in angles), (0.0, 0.3)]
    points, faces = turned(profile, 0.3 * math.pi / rings, closed=False)
    points = points * (1 + 0.05 * np.sin(20 * points[:, :1]) * np.cos(17 * points[:, 1:2]))
    (folder / "ball.obj").write_bytes(write_obj(SoftMesh(points, faces)))
    return len(points)


def cloth(folder: Path, vertices: int) -> int:
    """Write a wavy cloth with its place in a picture, and return how many vertices it has."""
    from text2sim.compiler.shapes.softmesh import grid_faces

    n = round(math.sqrt(vertices)) - 1
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    points = np.column_stack([uvs, 0.03 * np.sin(9 * uvs[:, 0]) * np.cos(7 * uvs[:, 1])])
    (folder / "cloth.obj").write_bytes(write_obj(SoftMesh(points, grid_faces(n, n), uvs)))
    return len(points)


if __name__ == "__main__":
    main()
