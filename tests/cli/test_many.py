"""Cases that are run several at once: what is said and returned is as if they had been run one after the other."""

from pathlib import Path

from handmade import CASE, Cli, prepare_run, write_case

from text2sim.spec_schema.reuse.overlay import CaseOverlay


def test_a_sweep_in_two_workers_has_the_table_of_one(cli: Cli, tmp_path: Path) -> None:
    case = write_case(tmp_path / "fall", CASE)
    for seed in (1, 2):  # as if they had been simulated: workers find them, and judge nothing again
        prepare_run(case, tmp_path / "runs", CaseOverlay(sets=(f"scene.seed={seed}",)))
    sweep = ["run", case, "--grid", "scene.seed=[1, 2]", "--json"]
    alone, together = cli(*sweep), cli(*sweep, "--workers", 2)
    assert (alone.code, together.code) == (0, 0)
    assert alone.json == together.json
    assert [row["passed"] for row in together.json["runs"]] == [True, True]


def test_a_case_that_is_wrong_is_told_as_ever(cli: Cli, tmp_path: Path) -> None:
    write_case(tmp_path / "cases/good", CASE)
    write_case(tmp_path / "cases/bad", CASE.replace("sphere", "spere"))
    prepare_run(tmp_path / "cases/good", tmp_path / "runs")
    answer = cli("test", "cases", "--workers", 2, "--film")
    assert answer.code == 2
    assert "did you mean `sphere`" in answer.err
    assert "PASS fall (2/2)" in answer.out
    assert "1 passed, 1 in error" in answer.out


def test_a_store_goes_with_a_cluster(cli: Cli, case: Path) -> None:
    answer = cli("run", case, "--store", "x")
    assert answer.code == 2
    assert "needs --ray" in answer.err


def test_nothing_is_run_if_one_of_many_is_wrong_and_that_is_said(cli: Cli, tmp_path: Path) -> None:
    write_case(tmp_path / "cases/good", CASE)
    write_case(tmp_path / "cases/bad", CASE.replace("sphere", "spere"))
    answer = cli("run", "cases")
    assert answer.code == 2
    assert "nothing was run: 1 of 2 cases have errors" in answer.err
    assert not (tmp_path / "runs").exists()
