"""From a case to a benchmark folder and to a comparison, with both engines."""

import json
import sys
from pathlib import Path

import pytest

from text2sim.cli.main import run
from text2sim.engine_benchmark.compare import Compared
from text2sim.spec_schema.errors import RunError

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks/engines"
LAZY = """\
import numpy as np

def simulate(folder, scene, times, step):
    return {name: np.zeros((len(times), 1, n)) for name, n in (("pos", 3), ("quat", 3))}
"""


def call(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    monkeypatch.setattr(sys, "argv", ["text2sim", "benchmark", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        run()
    return int(ended.value.code or 0)


@pytest.mark.usefixtures("engine")
def test_a_case_is_exported_and_mujoco_agrees_with_the_equation(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, "export", BENCHMARKS / "projectile", "--out", "out") == 0
    folder = tmp_path / "out/projectile"
    assert {path.name for path in folder.iterdir()} == {"benchmark.json", "case.yaml", "scene.usda", "scene.xml"}
    scene = json.loads((folder / "benchmark.json").read_text())
    z = scene["observables"]["z"]
    # The error of a semi-implicit step is g t h / 2: halved with the step.
    assert z["convergence"]["errors"] == pytest.approx([9.81 * 0.005 / 2 / n for n in (1, 2, 4)], rel=0.02)
    assert scene["initial_velocities"] == [{"body": "ball", "linear": [2, 0, 3], "angular": [0, 5, 0]}]
    capsys.readouterr()
    assert call(monkeypatch, "run", "out", "--json") == 0
    rows = {row["observable"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    assert rows["z"]["theirs"] == pytest.approx(9.81 * 0.005 / 2, rel=0.02)
    assert rows["spin"]["theirs"] < 1e-6
    assert all(row["ok"] and row["memory"][1] > 1e7 for row in rows.values())
    # What is not the case's is marked.
    scene["initial_velocities"][0]["linear"] = [2, 0, 2.9]
    (folder / "benchmark.json").write_text(json.dumps(scene))
    assert call(monkeypatch, "run", "out") == 1
    assert "**!**" in capsys.readouterr().out
    # An adapter that returns something else is told so.
    (tmp_path / "lazy.py").write_text(LAZY)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert call(monkeypatch, "run", "out", "--engine", "lazy:simulate") == 2
    assert "`quat` has the shape (101, 1, 3), not (101, 1, 4)" in capsys.readouterr().out


ROW = {"unit": "m", "reference": "analytic", "tolerance": 1, "until": 1, "convergence": {"errors": [0]}, "values": [0]}
SCENE = {
    "name": "x", "step": 0.01, "complete": True, "left_out": [], "times": [0.0], "observables": {"z": ROW},
    "ours": {"seconds": 1, "memory": 1},
}  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (None, "is not a benchmark: text2sim benchmark export CASE writes one"),
        ({"name": "x", "step": 0.01, "complete": True}, "is not a benchmark"),
        (SCENE | {"observables": [1]}, "is not a benchmark"),
        (SCENE | {"observables": {"z": ROW | {"values": [0, 1]}}}, "is not a benchmark"),
        (SCENE | {"complete": False, "left_out": ["a soft body"]}, "no model of its scene, because of a soft body"),
        (SCENE, "case.yaml"),
    ],
)
def test_other_folders_are_refused(scene, words, tmp_path, monkeypatch, capsys):
    if scene is not None:
        (tmp_path / "benchmark.json").write_text(json.dumps(scene))
    assert call(monkeypatch, "run", tmp_path) == 2
    assert words in capsys.readouterr().out
    assert call(monkeypatch, "run", tmp_path, "--json") == 2
    assert not json.loads(capsys.readouterr().out)["ok"]


@pytest.mark.parametrize("theirs", [0.5, 2.0])
def test_a_benchmark_that_could_not_run_is_not_hidden_by_others(theirs, tmp_path, monkeypatch, capsys):
    good = Compared("x", "z", "m", "analytic", 1.0, 1.0, 0.0, theirs, 0.0, (1.0, 1.0), (1, 1))

    def run(engine, folder, stop):
        if folder.name == "bad":
            raise RunError("mujoco did not finish")
        return [good]

    monkeypatch.setattr("text2sim.engine_benchmark.compare.run", run)
    assert call(monkeypatch, "run", tmp_path / "bad", tmp_path / "good", "--json") == 2
    assert not json.loads(capsys.readouterr().out)["ok"]
    assert call(monkeypatch, "run", tmp_path / "good") == (0 if good.ok else 1)
    # A table that cannot be written loses nothing: half an hour of runs may be in it.
    assert call(monkeypatch, "run", tmp_path / "good", "--table", tmp_path / "none/table.md") == 2
    assert "| x | z | analytic" in capsys.readouterr().out
