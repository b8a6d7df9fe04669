"""Time of a substep of deformable bodies as our programs take it, and as the engine takes it by default.

    python -m benchmarks.engine_defaults

The hash grid of cloth covers the cloth's whole space by default, and is cleared in every substep. The grid of mpm is
visited as a whole, although the engine lists the nodes that particles touch. The engine's law of soft bodies
decomposes the deformation of each particle, and its transfers add to the grid atomically. It runs on one thread.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from text2sim.compiler.build import compile_case
from text2sim.spec_schema.load import load_case

ROOT = Path(__file__).parents[1]
DEFAULTS = (
    ("hash grid", "benchmarks/scenes/cloth_falls_far.yaml", "scene.py", r"hash_grid_res=\([^)]*\),", ""),
    ("steps of the grid", "benchmarks/scenes/water_poured.yaml", "bodies.py", r"    skip_far\(.*\)\n", ""),
    ("law", "cases/soft_press/case.yaml", "bodies.py", r"\bCorotated\(", "gs.materials.MPM.Elastic("),
    ("transfers", "cases/soft_press/case.yaml", "bodies.py", r"    transfer_in_turn\(.*\)\n", ""),
    ("transfers", "cases/snow_plough/case.yaml", "bodies.py", r"    transfer_in_turn\(.*\)\n", ""),
    ("singular values", "cases/snow_plough/case.yaml", "transfers.py", r"\bdecomposed\(F_tmp", "qd.svd(F_tmp"),
    ("threads", "cases/snow_plough/case.yaml", "scene.py", r"with spare_threads\(\)", "if True"),
)
"""What is compared, case, file of its program, what to replace there to have the engine's default, and by what."""
LOOP = """
import time

import genesis as gs
import main
import scene

scene.start_engine(gs.cpu)
made, bodies, _ = main.assemble(with_cameras=False)
for _ in range(10):
    made.step()
begin = time.process_time(), time.perf_counter()
for _ in range(60):
    made.step()
for start, end in zip(begin, (time.process_time(), time.perf_counter())):
    print(f"{1e3 * (end - start) / 60 / made.sim.substeps:.2f}", end=" ")
"""


def measure(program: Path) -> str:
    """Return the processor time of a substep and its wall time [ms], in words."""
    done = subprocess.run([sys.executable, "-c", LOOP], cwd=program, capture_output=True, text=True, check=True)
    processor, wall = done.stdout.split()[-2:]
    return f"{processor} ms of processor time ({wall} ms of wall time)"


def main() -> None:
    """Print both times of each scene."""
    for what, case, file, pattern, instead in DEFAULTS:
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "program"
            compile_case(load_case(ROOT / case), program)
            ours = measure(program)
            text = (program / file).read_text("utf-8")
            default = re.sub(pattern, instead, text)
            assert default != text
            (program / file).write_text(default, "utf-8")
            print(f"{case}, {what}: {ours} a substep, with the engine's {measure(program)}")


if __name__ == "__main__":
    main()
