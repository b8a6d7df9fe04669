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
SCENES = {"brick_wall": 200, "tumbler": 100, "catch_net": 200}
"""Case, and how many steps are timed."""
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
    pairs = parser.parse_args().pairs
    table = Table("benchmark", "measured", "goal")
    with tempfile.TemporaryDirectory() as folder:
        for case, steps in SCENES.items():
            table.add_row(*recording(case, steps, pairs, Path(folder)))
        for row in checking(Path(folder)):
            table.add_row(*row)
        for row in disk(Path(folder)):
            table.add_row(*row)
    Console().print(table)


def recording(case: str, steps: int, pairs: int, folder: Path) -> tuple[str, str, str]:
    """Return the row for the overhead of recording one case."""
    program = folder / case
    subprocess.run(
        [sys.executable, "-m", "text2sim", "compile", str(ROOT / "cases" / case), "-o", str(program)], check=True
    )

    def loop(mode: str) -> float:
        command = [sys.executable, str(HERE / "loop.py"), str(program), mode, str(steps), str(folder / f"out_{case}")]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return json.loads(done.stdout.strip().splitlines()[-1])["seconds"]

    ratios, bare = [], []
    for _ in range(pairs):
        bare.append(loop("bare"))
        ratios.append(loop("recorded") / bare[-1])
    spread = f"{min(ratios):.3f} to {max(ratios):.3f}"
    pace = 1000 * statistics.median(bare) / steps
    return f"recording {case}", f"x {statistics.median(ratios):.3f} ({spread}; {pace:.1f} ms a bare step)", "x 1.05"


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
        ("check, cold start", best("check", str(ROOT / "cases" / "crank_slider")), "0.5 s"),
        ("check, 2,000 bodies", best("check", str(many)), "1 s"),
        ("compile, 2,000 bodies", best("compile", str(many), "-o", str(folder / "program")), "1 s"),
    ]


def disk(folder: Path) -> list[tuple[str, str, str]]:
    """Return the rows for the size of the states that `recording` left."""
    rows = []
    for case, steps in SCENES.items():
        states = folder / f"out_{case}" / "states"
        layout = json.loads((states / "layout.json").read_text())
        links = sum(not link["fixed"] for link in layout["links"])
        frames = steps // layout["every"] + 1
        size = sum(path.stat().st_size for path in states.glob("chunk_*.npz"))
        rows.append((f"states {case}", f"{size / links / frames:.0f} bytes a link and frame", "-"))
    return rows


if __name__ == "__main__":
    main()
