"""From a save to the new scene on the page: `text2sim watch` on three scenes, one number changed at every save.

With `--memory 50`, the memory of the engine over fifty saves of one scene as well.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import psutil
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
HEAD = "text2sim: 2\nname: {name}\nparams: {{value: 1.0}}\n"
BALL = (
    HEAD.format(name="ball")
    + """\
scene: {duration: 2.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, "${value}"]}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 0.2}}
"""
)
WALL = (
    HEAD.format(name="wall")
    + """\
scene:
  {duration: 2.0, dt: 0.01, substeps: 4, statics: {floor: {shape: {kind: plane, size: 30}, material: {friction: 0.8}}}}
bodies:
  brick:
    kind: rigid
    shape: {kind: box, size: [0.24, 0.11, 0.07]}
    material: {density: 1900, friction: 0.7}
    place: {on: floor, at: [0, 0]}
    repeat: {kind: running_bond, rows: 5, columns: 6, gap: 0.0005}
    look: {color: terracotta}
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.11}
    material: {density: 7800, friction: 0.4}
    pose: {pos: [0.05, -1.2, 0.3]}
actions:
  controls: {launch: {kind: initial_velocity, body: ball, linear: [0, "${8 + value}", 0.6]}}
  measures: {shift: {kind: displacement, of: brick, stat: max}}
  expect: {moves: {measure: shift, at: end, above: 0.1}}
"""
)


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--saves", type=int, default=5, help="saves of each scene")
    parser.add_argument("--memory", type=int, default=0, help="saves over which the engine's memory is measured")
    options = parser.parse_args()
    cradle = (ROOT / "cases/newton_cradle/case.yaml").read_text()
    scenes = {
        "one ball, 2 s": (BALL, r"(value: )[\d.]+", lambda i: f"{1 + (i + 1) / 100:.2f}"),
        "wall of 30 bricks, 2 s": (WALL, r"(value: )[\d.]+", lambda i: f"{1 + (i + 1) / 100:.2f}"),
        "newton_cradle, 6 s in 30,000 steps": (cradle, r"(angle: )[\d.]+", lambda i: f"{35 - (i + 1) / 10:.1f}"),
    }
    table = Table("scene", "problems told [s]", "built [s]", "simulated [s]", "shown [s]", "all [s]", "memory [MB]")
    for name, (text, pattern, value) in scenes.items():
        with tempfile.TemporaryDirectory() as folder:
            rows, memory = measure(Path(folder), text, pattern, value, options.saves)
        cells = [f"{statistics.median(row[key] for row in rows):.2f}" for key in rows[0]]
        table.add_row(name, *cells, f"{memory[0]:.0f} → {memory[-1]:.0f}")
    if options.memory:
        text, pattern, value = scenes["wall of 30 bricks, 2 s"]
        with tempfile.TemporaryDirectory() as folder:
            rows, memory = measure(Path(folder), text, pattern, value, options.memory)
        marks = ", ".join(f"{memory[i]:.0f}" for i in range(0, len(memory), 10))
        table.add_row(f"wall, {options.memory} saves", *[""] * 4, "", f"{marks}, {memory[-1]:.0f}")
    Console(width=160).print(table)
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


def measure(folder: Path, text: str, pattern: str, value, saves: int) -> tuple[list[dict[str, float]], list[float]]:
    """Watch a case and save it; return what each save took [s], and the engine's memory [MB] after each."""
    case = folder / "case.yaml"
    case.write_text(text)
    command = [sys.executable, "-m", "text2sim", "watch", str(case), "--runs", str(folder / "runs"), "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT)
    lines: list[tuple[float, str]] = []

    def read() -> None:
        assert process.stdout is not None
        lines.extend((time.time(), line) for line in process.stdout)

    threading.Thread(target=read, daemon=True).start()

    def wait(pattern: str, after: int) -> tuple[float, int]:
        while True:
            for i, (when, line) in enumerate(lines[after:], after):
                if re.search(pattern, line):
                    return when, i + 1
            if process.poll() is not None:
                raise SystemExit("".join(line for _, line in lines))
            time.sleep(0.005)

    rows, memory = [], []
    try:
        _, seen = wait(r"^take \d+: ", 0)
        engine = max(psutil.Process(process.pid).children(), key=lambda child: child.memory_info().rss)
        for i in range(saves):
            time.sleep(0.7)  # what a warm engine tidies up meanwhile is nobody's wait
            fresh = case.with_name("fresh")
            fresh.write_text(re.sub(pattern, lambda found, i=i: found[1] + value(i), text, count=1))
            os.replace(fresh, case)
            begun = time.time()
            told, _ = wait(r": ok", seen)
            done, seen = wait(r"^take \d+: ", seen)
            (take,) = (folder / "runs").glob("watch-*/take-*")
            seconds = json.loads((take / "watch.json").read_text())["seconds"]
            rows.append({"check": told - begun, **{key: seconds[key] for key in ("build", "simulate", "scene")}})
            rows[-1]["all"] = done - begun
            if engine.is_running():
                memory.append(engine.memory_info().rss / 1e6)
    finally:
        process.terminate()
        process.wait()
    return rows, memory


if __name__ == "__main__":
    main()
