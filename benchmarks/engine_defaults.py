"""Processor time of a substep of deformable bodies as our programs take it, and as the engine takes it by default.

    python -m benchmarks.engine_defaults

The hash grid of cloth covers the cloth's whole space by default, and is cleared in every substep. The grid of mpm is
visited as a whole, although the engine lists the nodes that particles touch.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from text2sim.compiler.build import compile_case
from text2sim.spec_schema.load import load_case

SCENES = Path(__file__).with_name("scenes")
LEFT_OUT = {
    "cloth_falls_far": ("scene.py", r"hash_grid_res=\([^)]*\),"),
    "water_poured": ("bodies.py", r"    skip_far\(.*\)\n"),
}
"""Scene -> file of its program, and what is left out of it to have the engine's default."""
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


def main() -> None:
    """Print both times of each scene."""
    for scene, (file, pattern) in LEFT_OUT.items():
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "program"
            compile_case(load_case(SCENES / f"{scene}.yaml"), program)
            ours = measure(program)
            text = (program / file).read_text("utf-8")
            default = re.sub(pattern, "", text)
            assert default != text
            (program / file).write_text(default, "utf-8")
            print(f"{scene}: {ours:.2f} ms a substep, with the engine's default {measure(program):.2f} ms")


if __name__ == "__main__":
    main()
