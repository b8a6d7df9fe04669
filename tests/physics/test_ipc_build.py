"""Programs of contact model ipc pass the checks of the engine's coupler, with a stand-in for libuipc.

Nothing is simulated: libuipc computes on CUDA devices alone.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from text2sim.compiler.build import compile_case
from text2sim.spec_schema.load import load_case

HERE = Path(__file__).resolve().parent
TOWEL = HERE.parent / "fuzz" / "soft" / "towel"


def build(program: Path) -> dict[str, Any]:
    command = [sys.executable, HERE / "ipc_standin.py", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=500)
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT ")), "")
    assert line, done.stderr[-3000:]
    return json.loads(line.removeprefix("RESULT "))


@pytest.mark.usefixtures("engine")
def test_the_coupler_takes_the_program(tmp_path: Path) -> None:
    compile_case(load_case(TOWEL), tmp_path)
    found = build(tmp_path)
    assert found["failure"] == ""
    assert found["coupled"] == {
        "floor": "ipc_only",
        "table": "ipc_only",
        "plate": "ipc_only",
        "clamp": "two_way_soft_constraint",
    }
    friction = {frozenset(pair[:2]): pair[2] for pair in found["pairs"]}
    # The geometric means of what the case says: cloth 0.3, plate 0.4, table and floor 0.5.
    assert friction[frozenset(("cloth", "plate"))] == pytest.approx((0.3 * 0.4) ** 0.5, abs=1e-4)
    assert friction[frozenset(("cloth", "table"))] == pytest.approx((0.3 * 0.5) ** 0.5, abs=1e-4)
    assert friction[frozenset(("cloth", "floor"))] == pytest.approx((0.3 * 0.5) ** 0.5, abs=1e-4)
    assert friction[frozenset(("cloth", "jelly"))] == pytest.approx((0.3 * 0.5) ** 0.5, abs=1e-4)
    assert friction[frozenset(("cloth",))] == pytest.approx(0.3)
    assert friction[frozenset(("plate", "table"))] == pytest.approx((0.4 * 0.5) ** 0.5, abs=1e-4)
    # Pose and velocity of a free body are those of libuipc: position, a quarter turn about z, 3 + 3 velocities.
    half = round(0.5**0.5, 5)
    assert found["restored"] == pytest.approx([0.1, 0.2, 0.9, half, 0, 0, half, 1, 2, 3, 0, 0, 4], abs=1e-4)
    # Springs of strength 1e4 / s^2 pull what they tie, 1 mm away, with m k x; what they do not tie, they leave alone.
    assert found["lift"] == pytest.approx([0.0, 10.0], rel=1e-3)
