"""All benchmarks: one command, one table. See README.md beside this file."""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SCENES = {
    "cases/brick_wall": 200,
    "cases/tumbler": 100,
    "cases/catch_net": 200,
    "benchmarks/scenes/soft_pile.yaml": 100,
    "benchmarks/scenes/cloth_drape.yaml": 100,
    "benchmarks/scenes/soft_bar.yaml": 40,
}
"""Case, and how many steps are timed."""
CHECKED = {
    "cases/brick_wall": "0.5 s",
    "cases/crank_slider": "0.5 s",
    "cases/newton_cradle": "0.5 s",
    "cases/conveyor_sorter": "0.5 s",
    "cases/tumbler": "0.7 s",
    "cases/dolphin_squeeze": "0.7 s",
    "cases/curtains": "0.7 s",
    "cases/falling_letters": "0.7 s",
}
"""Case, and the goal for its check in a fresh process: bodies of primitives; 250 that are packed; a sculpt;
cloth; letters."""
HEAD = "text2sim: 2\nname: many\nscene: {duration: 1.0, statics: {floor: {shape: {kind: plane, size: 200}}}}\nbodies:\n"
BODY = """\
  b{i}:
    kind: rigid
    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}
    material: {{density: 500, friction: 0.6}}
    pose: {{pos: [{x}, {y}, 0.05]}}
    look: {{color: seagreen}}
"""


def main() -> None:
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=3, help="pairs of processes for each scene")
    parser.add_argument(
        "--only", default="", help="part of the names of the scenes that are recorded; nothing else then"
    )
    options = parser.parse_args()
    table = Table("benchmark", "measured", "goal")
    with tempfile.TemporaryDirectory() as folder:
        scenes = {case: steps for case, steps in SCENES.items() if options.only in case}
        for case, steps in scenes.items():
            table.add_row(*recording(case, steps, options.pairs, Path(folder)))
        for row in () if options.only else checking(Path(folder)):
            table.add_row(*row)
        for case, steps in scenes.items():
            table.add_row(*disk(case, steps, Path(folder)))
    Console().print(table)


def recording(case: str, steps: int, pairs: int, folder: Path) -> tuple[str, str, str]:
    """Return the row for the overhead of recording one case."""
    name = Path(case).stem
    program = folder / name
    subprocess.run([sys.executable, "-m", "text2sim", "compile", str(ROOT / case), "-o", str(program)], check=True)

    def loop(mode: str) -> dict[str, float]:
        command = [sys.executable, str(HERE / "loop.py"), str(program), mode, str(steps), str(folder / f"out_{name}")]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return json.loads(done.stdout.strip().splitlines()[-1])

    taken = [(loop("bare"), loop("recorded")) for _ in range(pairs)]
    ratios = [recorded["seconds"] / bare["seconds"] for bare, recorded in taken]
    on_cpu = statistics.median(recorded["cpu"] / bare["cpu"] for bare, recorded in taken)
    spread = f"{min(ratios):.3f} to {max(ratios):.3f}, of the processor x {on_cpu:.3f}"
    pace = 1000 * statistics.median(bare["seconds"] for bare, _ in taken) / steps
    return f"recording {name}", f"x {statistics.median(ratios):.3f} ({spread}; {pace:.1f} ms a bare step)", "x 1.05"


def checking(folder: Path) -> list[tuple[str, str, str]]:
    """Return the rows for `check` and `compile`."""
    many = folder / "many"
    many.mkdir()
    text = HEAD + "".join(BODY.format(i=i, x=0.2 * (i % 50), y=0.2 * (i // 50)) for i in range(2000))
    (many / "case.yaml").write_text(text)

    def best(*arguments: str) -> str:
        times = []
        for _ in range(5):
            began = time.perf_counter()
            subprocess.run([sys.executable, "-m", "text2sim", *arguments], check=True, capture_output=True)
            times.append(time.perf_counter() - began)
        return f"{min(times):.2f} s"

    return [
        *((f"check {case}", best("check", str(ROOT / case)), goal) for case, goal in CHECKED.items()),
        ("check, 2,000 bodies", best("check", str(many)), "1 s"),
        ("compile, 2,000 bodies", best("compile", str(many), "-o", str(folder / "program")), "1 s"),
    ]


def disk(case: str, steps: int, folder: Path) -> tuple[str, str, str]:
    """Return the row for the size of the states that `recording` left."""
    name = Path(case).stem
    states = folder / f"out_{name}" / "states"
    layout = json.loads((states / "layout.json").read_text())
    frames = steps // layout["every"] + 1
    size = sum(path.stat().st_size for path in states.glob("chunk_*.npz")) / frames
    deformables = layout.get("deformables", [])
    if not deformables:
        links = sum(not link["fixed"] for link in layout["links"])
        return f"states {name}", f"{size / links:.0f} bytes a link and frame", "-"
    points = deformables[-1]["points"][1]
    vertices = max(row["surface"][1] if row["surface"] else 0 for row in deformables)
    measured = f"{size / (points + vertices):.0f} bytes a point and frame ({points} points, {vertices} vertices)"
    return f"states {name}", measured, "-"


if __name__ == "__main__":
    main()
