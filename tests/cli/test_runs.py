"""`run` and `test` on recordings that were made by hand: what they print, and their exit codes."""

import json
from pathlib import Path

import pytest
from handmade import CASE, Cli, prepare_run, write_case

from text2sim.harness.folder import Work
from text2sim.harness.result import RunResult
from text2sim.runtime.lock import RunLock
from text2sim.service.examined import Examined
from text2sim.service.phrases import run_line


def test_run_ends_with_film_and_report(cli: Cli, case: Path, folder: Path):
    answer = cli("run", case)
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert lines[-2:] == [f"film: {folder}/video.mp4", f"report: {folder}/report.html"]
    assert "fall: finished, 2 of 2 expectations came true, unchanged in" in lines[-3]
    assert lines[0].split()[:2] == ["ok", "starts_high"]
    assert lines[1].split()[:2] == ["ok", "falls"]


def test_an_expectation_that_fails_is_exit_code_one(cli: Cli, case: Path, folder: Path):
    (case / "case.yaml").write_text(CASE.replace("below: 1", "below: 0"))
    answer = cli("run", case)
    assert answer.code == 1
    assert "FAIL  falls        `height` below 0 m at the end: 0.095 m at 1 s" in answer.out
    assert "judged again" in answer.out
    assert "fall: judging" in answer.err


def test_the_time_of_a_simulation_is_told_apart_from_that_of_its_film(tmp_path: Path):
    phases = {"compile": 2.0, "start": 60.0, "build": 18.0, "simulate": 130.2, "film": 125.0, "judge": 0.3}
    how = {"state": "finished", "time": 1.0, "message": "", "problem": None, "evidence": None, "film": None}
    rest = {"film_message": "", "report": None, "stopped": False, "wall": 336.0}
    result = RunResult("fall", tmp_path, Work.SIMULATE, **how, **rest, timings=phases)  # type: ignore[arg-type]
    assert run_line(result) == "finished, simulated in 2 min 10 s; 1 min 20 s to compile and build, 2 min 5 s to film"
    again = RunResult("fall", tmp_path, Work.FILM, **how, **rest, timings={"film": 330.0})  # type: ignore[arg-type]
    assert run_line(again) == "finished, filmed again in 5 min 36 s"


def test_run_speaks_json(cli: Cli, case: Path, folder: Path):
    answer = cli("run", case, "--json")
    assert (answer.code, answer.err) == (0, "")
    (run,) = answer.json["runs"]
    assert (run["state"], run["passed"], run["work"]) == ("finished", True, "unchanged")
    assert run["expect"]["falls"]["ok"] is True
    assert run["suspicions"] == json.loads((folder / "evidence.json").read_text())["suspicions"]
    assert run["folder"] == str(folder)


def test_all_cases_are_checked_before_one_is_run(cli: Cli, case: Path, folder: Path, tmp_path: Path):
    bad = write_case(tmp_path / "bad", CASE.replace("of: ball", "of: bell"))
    answer = cli("run", case, bad)
    assert answer.code == 2
    assert answer.out == ""
    assert "did you mean `ball`?" in answer.err
    answer = cli("run", bad, "--json")
    assert (answer.code, answer.json["ok"]) == (2, False)


def test_a_run_in_use_is_said_in_a_line(cli: Cli, case: Path, folder: Path):
    with RunLock(Path("runs"), folder.name):
        answer = cli("run", case)
        document = cli("run", case, "--json").json
    assert answer.code == 3
    assert answer.err.splitlines()[-1].startswith("cases/fall/case.yaml: ")
    assert "is being run by another text2sim" in answer.err
    assert "another text2sim" in document["runs"][0]["error"]


def test_a_file_in_place_of_the_runs_is_said_in_a_line(cli: Cli, case: Path, tmp_path: Path):
    (tmp_path / "file").touch()
    answer = cli("run", case, "--runs", "file")
    assert answer.code == 2
    assert "not a folder" in answer.err


@pytest.mark.parametrize(
    ("state", "code"),
    [("timeout", 3), ("out_of_memory", 3), ("diverged", 1), ("crashed", 1), ("failed", 2), ("interrupted", 130)],
)
def test_how_a_run_ended_decides_the_exit_code(
    cli: Cli, case: Path, monkeypatch: pytest.MonkeyPatch, state: str, code: int
):
    def ended(row: Examined, **_: object) -> RunResult:
        return RunResult("fall", Path("runs/x"), Work.SIMULATE, state, 0.2, "it did", None, None, None, "", None, False)

    monkeypatch.setattr("text2sim.cli.many.attempt", ended)
    assert cli("run", case).code == code


def test_what_the_machine_lacks_is_exit_code_three(cli: Cli, case: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "")
    answer = cli("run", case, "--gpu")
    assert answer.code == 3
    assert answer.err == "cases/fall/case.yaml: there is no CUDA device here; `text2sim doctor` says why\n"


def test_a_suite_says_a_line_for_each_case(cli: Cli, case: Path, folder: Path, tmp_path: Path):
    write_case(tmp_path / "cases" / "bad", "text2sim: 1\nname: bad\n")
    lost = write_case(tmp_path / "cases" / "lost", CASE.replace("fall\n", "lost\n").replace("below: 1", "below: 0"))
    prepare_run(lost, tmp_path / "runs")
    answer = cli("test", "cases")
    lines = answer.out.splitlines()
    assert answer.code == 2
    assert lines[0] == "ERROR bad"
    assert lines[1].startswith("PASS fall (2/2) ")
    assert lines[2].startswith("FAIL lost (1/2) ")
    assert lines[3].startswith("    falls: `height` below 0 m")
    assert lines[4].startswith("1 passed, 1 failed, 1 in error in ")
    assert cli("test", "cases", "-k", "lost").code == 1
    answer = cli("test", "cases", "-k", "fall", "--json")
    assert answer.code == 0
    assert [(row["case"], row["result"]) for row in answer.json["cases"]] == [("fall", "pass")]


def test_what_looks_wrong_is_told_of_a_case_that_passes(
    cli: Cli, case: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(RunResult, "suspicions", ["`ball` is through `floor`"])
    answer = cli("test", case)
    assert answer.code == 0
    assert answer.out.splitlines()[1] == "    suspicious: `ball` is through `floor`"
    assert "suspicious: `ball` is through `floor`" in cli("run", case).out
    assert cli("run", case, "--json").json["runs"][0]["suspicions"] == ["`ball` is through `floor`"]


def test_a_suite_without_cases_is_wrong_input(cli: Cli, case: Path):
    assert cli("test", case, "-k", "nothing").code == 2
    assert cli("test", "nowhere").code == 2


@pytest.mark.usefixtures("engine", "tracer")
def test_the_doctor_speaks_json(cli: Cli):
    answer = cli("doctor", "--json")
    assert answer.code in (0, 3)
    assert answer.json["ok"] is (answer.code == 0)
    assert {"python", "genesis"} <= {row["name"] for row in answer.json["findings"]}
