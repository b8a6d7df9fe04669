"""Variants, single values and sweeps on the command line."""

import csv
import json
import re
from pathlib import Path

import pytest
from handmade import CASE, Cli, prepare_run, write_case

from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.reuse.overlay import CaseOverlay

VARIED = (
    CASE.replace("text2sim: 1", "text2sim: 2")
    + """\
variants:
  strict: {actions: {expect: {falls: {below: 0}}}}
  wrong: {bodies: {ball: {shape: {radius: -1}}}}
sweeps:
  limits: {grid: {actions.expect.falls.below: [1, 0]}}
"""
)


@pytest.fixture
def varied(tmp_path: Path) -> Path:
    """A case with variants and a sweep."""
    return write_case(tmp_path / "cases" / "fall", VARIED)


def test_check_takes_variants_and_values(cli: Cli, varied: Path):
    answer = cli("check", varied, "--variant", "strict", "--set", "bodies.ball.material.density=500")
    assert answer.code == 0
    assert "cases/fall/case.yaml (strict, bodies.ball.material.density=500): ok" in answer.out
    answer = cli("check", varied, "--set", "bodies.ball.material.densty=500")
    assert answer.code == 2
    lines = answer.err.splitlines()
    assert lines[-3].startswith("--set:1:22: error: unknown key `densty`")
    assert lines[-2].strip() == "bodies.ball.material.densty=500"
    assert lines[-1] == " " * 25 + "^"
    answer = cli("check", varied, "--variant", "strickt", "--json")
    assert answer.code == 2
    assert answer.json["cases"][0]["problems"][0]["hint"] == "strict"


def test_check_can_look_at_every_variant(cli: Cli, varied: Path):
    assert cli("check", varied).code == 0
    answer = cli("check", varied, "--variants", "--json")
    assert answer.code == 2
    assert [(row["variants"], row["ok"]) for row in answer.json["cases"]] == [
        ([], True),
        (["strict"], True),
        (["wrong"], False),
    ]
    answer = cli("check", varied, "--variants")
    assert "cases/fall/case.yaml (wrong):" in answer.err
    assert "case.yaml:20:43: error: must be greater than 0 (got -1)" in answer.err


def test_compile_takes_them_too(cli: Cli, varied: Path):
    assert cli("compile", varied, "--set", "bodies.ball.shape.radius=0.25").code == 0
    assert "radius=0.25" in (varied / "program" / "bodies.py").read_text()


def test_a_run_is_called_after_what_is_laid_over_the_case(cli: Cli, varied: Path, tmp_path: Path):
    overlay = CaseOverlay(("strict",), ("actions.measures.height.axis=z",))
    folder = prepare_run(varied, tmp_path / "runs", overlay)
    assert folder.name.startswith("fall-strict-axis_z-")
    assert (folder / "case.yaml").read_text() == VARIED
    expanded = load_case(folder / "expanded.yaml")
    assert expanded.data == load_case(varied, overlay).data
    record = json.loads((folder / "run.json").read_text())
    assert (record["variants"], record["sets"]) == (["strict"], ["actions.measures.height.axis=z"])
    answer = cli("run", varied, "--variant", "strict", "--set", "actions.measures.height.axis=z")
    assert answer.code == 1
    assert "fall: finished, 1 of 2 expectations came true, unchanged in" in answer.out
    answer = cli("test", varied, "--variant", "strict", "--set", "actions.measures.height.axis=z")
    assert answer.out.startswith("FAIL fall (1/2)")


def test_a_sweep_is_a_table_of_runs(cli: Cli, varied: Path, tmp_path: Path):
    for value in (1, 0):
        prepare_run(varied, tmp_path / "runs", CaseOverlay(sets=(f"actions.expect.falls.below={value}",)))
    answer = cli("run", varied, "--sweep", "limits")
    assert answer.code == 1
    lines = answer.out.splitlines()
    assert lines[0].startswith("[1/2] below=1: finished, 2 of 2 expectations came true, unchanged")
    assert lines[2].split() == ["came", "true", "starts_high", "[m]", "falls", "[m]"]
    assert lines[3].split() == [">", "4", "bounds", "vary"]
    height = f"{5 - 4.905 * 0.1**2:.4g}"  # when it is judged, not at the end
    assert lines[4].split() == ["below=1", "2/2", height, "0.095"]
    assert lines[5].split() == ["below=0", "1/2", height, "0.095", "FAIL"]
    assert lines[6] == "sweep: runs/fall-sweep-limits/sweep.json"
    document = json.loads(Path("runs/fall-sweep-limits/sweep.json").read_text())
    assert [row["sets"] for row in document["runs"]] == [
        ["actions.expect.falls.below=1"],
        ["actions.expect.falls.below=0"],
    ]
    assert all((Path("runs") / row["folder"] / "run.json").is_file() for row in document["runs"])
    rows = list(csv.reader(Path("runs/fall-sweep-limits/sweep.csv").read_text().splitlines()))
    assert rows[0] == ["label", "folder", "state", "came_true", "expected", "starts_high", "falls"]
    assert [float(row[6]) for row in rows[1:]] == pytest.approx([0.095, 0.095])
    again = cli("run", varied, "--grid", "actions.expect.falls.below=[1]", "--json")
    assert again.code == 0
    assert [row["observed"]["falls"] for row in again.json["runs"]] == pytest.approx([0.095])


MANY = """\
  events:
    low: {kind: threshold, measure: height, below: 4.5}
    lower: {kind: threshold, measure: height, below: 4}
    under: {kind: threshold, measure: height, below: 0}
  expect:
    soon: {event: lower, on: low, within: [0.1, 0.2]}
    once: {event: low, count: [1, 2], before: lower}
    above: {event: under, never: true}
    drop: {measure: height, during: [0, 0.2], stat: range, equals: 0.2, tolerance: 0.01}
"""


def test_a_comparison_in_a_pipe_has_whole_lines(cli: Cli, varied: Path, tmp_path: Path) -> None:
    folders = [
        prepare_run(varied, tmp_path / "runs", CaseOverlay(sets=(f"bodies.ball.material.density={density}",)))
        for density in (500, 600, 700, 800)
    ]
    answer = cli("compare", *folders)
    assert answer.code == 0, answer.err
    assert re.search(r"^ +bodies\.ball\.material\.density +500 +600 +700 +800 *$", answer.out, re.MULTILINE)


def test_a_sweep_of_many_expectations_wraps_and_shows_what_was_compared(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLUMNS", "70")
    case = write_case(tmp_path / "fall", CASE[: CASE.index("  expect:")] + MANY)
    prepare_run(case, tmp_path / "runs", CaseOverlay(sets=("scene.seed=1",)))
    answer = cli("run", case, "--grid", "scene.seed=[1]")
    lines = answer.out.splitlines()[1:7]
    assert max(map(len, lines)) <= 70
    assert lines[0].split("  ")[-1].strip() == "once"
    assert lines[1].split() == "0.1 to 0.2 after low 1 to 2 times before lower".split()
    # From 4.5 m to 4 m: sqrt(2 / 9.81) - sqrt(1 / 9.81) = 0.1322 s
    assert lines[2].split() == ["seed=1", "4/4", "0.1322", "1"]
    assert lines[3].split() == ["above", "drop", "[m]"]
    assert lines[4].split() == ["never", "range", "0.2", "±", "0.01"]
    assert lines[5].split() == ["seed=1", "0", "0.1962"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--sweep", "limit"), "has no sweep `limit`; there are limits; did you mean `limits`?"),
        (("--grid", "params.x"), "`params.x` is not an axis: write PATH=[a, b, c]"),
        (("--grid", "params.x=[1, 2]"), "there is no `x` in `params`"),
        (("--grid", "bodies.ball.shape.radius=[0.1, -1]"), "must be greater than 0 (got -1)"),
        (("--sweep", "limits", "--grid", "scene.dt=[1]"), "give either --sweep or --grid"),
        (("--sweep", "limits", "--variant", "wrong"), "must be greater than 0"),
    ],
)
def test_a_sweep_that_is_wrong_runs_nothing(cli: Cli, varied: Path, arguments: tuple[str, ...], says: str):
    answer = cli("run", varied, *arguments)
    assert answer.code == 2
    assert answer.err.count(says) == 1  # also of what is wrong with each of several values
    assert not Path("runs").exists()
    assert cli("run", varied, *arguments, "--json").json["ok"] is False


def test_a_sweep_is_of_one_case(cli: Cli, varied: Path):
    assert cli("run", varied, varied / "case.yaml", "--sweep", "limits").code == 2
