"""The cases of the repository in the real engine: each meets its expectations, and nothing looks wrong."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

CASES = Path(__file__).parents[2] / "cases"
LONG = {"snow_plough": 1800}
"""Limits [s] of those that may take longer than other tests."""


def runnable() -> list[object]:
    names = sorted(path.parent.name for path in CASES.glob("*/case.yaml"))
    limits = {name: [pytest.mark.timeout(limit)] for name, limit in LONG.items()}
    return [pytest.param(name, marks=[pytest.mark.about(f"cases/{name}"), *limits.get(name, [])]) for name in names]


@pytest.mark.slow
@pytest.mark.parametrize("name", runnable())
def test_a_case_does_what_it_says(engine: None, name: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "text2sim", "run", CASES / name, "--no-film", "--runs", tmp_path, "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 3 and "no CUDA device" in done.stdout:
        pytest.skip("it needs a CUDA device")
    assert done.returncode == 0, done.stdout + done.stderr
    (run,) = json.loads(done.stdout)["runs"]
    assert run["expect"]
    assert all(row["ok"] for row in run["expect"].values())
    assert run["suspicions"] == []
