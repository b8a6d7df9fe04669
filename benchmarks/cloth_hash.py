"""Processor time of a substep of cloth, with the hash grid of our programs and with the engine's default.

    python -m benchmarks.cloth_hash [CASE]

The default covers the whole space of the cloth and is cleared in every substep.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from text2sim.compiler.build import compile_case
from text2sim.spec_schema.load import load_case

CASE = Path(__file__).with_name("scenes") / "cloth_falls_far.yaml"
LOOP = """
import time

import genesis as gs
import main
import scene

scene.start_engine(gs.cpu)
made, bodies, _ = main.assemble(with_cameras=False)
for _ in range(10):
    made.step()
begin = time.process_time()
for _ in range(60):
    made.step()
print(1e3 * (time.process_time() - begin) / 60 / made.sim.substeps)
"""


def measure(program: Path) -> float:
    """Return the processor time of a substep [ms]."""
    done = subprocess.run([sys.executable, "-c", LOOP], cwd=program, capture_output=True, text=True, check=True)
    return float(done.stdout.split()[-1])


def run(case: Path) -> None:
    """Print both times of a case."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program"
        compile_case(load_case(case), program)
        ours = measure(program)
        scene = program / "scene.py"
        text = scene.read_text("utf-8")
        scene.write_text(re.sub(r"hash_grid_res=\([^)]*\),", "", text), "utf-8")
        assert scene.read_text("utf-8") != text
        print(f"{case.stem}: {ours:.2f} ms a substep, with the engine's default {measure(program):.2f} ms")


if __name__ == "__main__":
    run(Path(sys.argv[1]) if len(sys.argv) > 1 else CASE)
