"""`text2sim check` and the lint: rules are listed and explained, findings counted, waived ones kept."""

from pathlib import Path

from handmade import CASE, Cli, write_case

from text2sim.lint.rules import RULES

SUNK = CASE.replace("[0, 0, 5]", "[0, 0, -5]")
WAIVER = "waive:\n  under-floor: it is to fall for ever in this test\n"


def test_rules_are_listed_with_a_line_each(cli: Cli) -> None:
    answer = cli("check", "--rules")
    assert answer.code == 0
    assert [line.split()[0] for line in answer.out.splitlines()] == [rule.id for rule in RULES]
    assert {row["id"] for row in cli("check", "--rules", "--json").json["rules"]} == {rule.id for rule in RULES}


def test_a_rule_is_explained(cli: Cli) -> None:
    answer = cli("check", "--explain", "overlap")
    assert answer.code == 0
    for part in ("overlap (warning): Two bodies", "Remedy:", "For example:", "fixes it", "waive: {overlap:"):
        assert part in answer.out
    assert cli("check", "--explain", "overlap", "--json").json["severity"] == "warning"


def test_a_rule_that_does_not_exist(cli: Cli) -> None:
    answer = cli("check", "--explain", "overlp")
    assert (answer.code, answer.out) == (2, "")
    assert "did you mean `overlap`?" in answer.err


def test_the_old_meaning_of_explain_is_pointed_to(cli: Cli, case: Path) -> None:
    answer = cli("check", "--explain", case)
    assert answer.code == 2
    assert "--settings says which settings were derived" in answer.err


def test_a_case_has_to_be_given(cli: Cli) -> None:
    answer = cli("check")
    assert answer.code == 2
    assert "--explain RULE" in answer.err


def test_an_error_of_the_lint_stops_check_and_run(cli: Cli, tmp_path: Path) -> None:
    folder = write_case(tmp_path / "sunk", SUNK)
    for command in ("check", "run"):
        answer = cli(command, folder)
        assert answer.code == 2, command
        assert "[under-floor]" in answer.err
        assert not (tmp_path / "runs").exists()


def test_what_is_waived_is_counted_and_kept(cli: Cli, tmp_path: Path) -> None:
    folder = write_case(tmp_path / "sunk", SUNK + WAIVER)
    answer = cli("check", folder)
    assert answer.code == 0
    assert answer.out.splitlines()[-2].endswith(", 1 waived")
    assert answer.out.splitlines()[-1].endswith("would be if nothing moved: falls")
    (row,) = cli("check", folder, "--json").json["cases"]
    (waived,) = row["waived"]
    assert waived["rule"] == "under-floor"
    assert waived["path"] == "/bodies/ball/pose"
    assert waived["reason"] == "it is to fall for ever in this test"


def test_warnings_are_counted_and_do_not_stop(cli: Cli, tmp_path: Path) -> None:
    folder = write_case(tmp_path / "heavy", CASE.replace("    pose:", "    material: {density: 5.0e+4}\n    pose:"))
    answer = cli("check", folder)
    assert answer.code == 0
    assert "[implausible-density]" in answer.err
    assert "1 warning" in answer.out


def test_how_long_a_run_takes_is_said_before_it(cli: Cli, tmp_path: Path) -> None:
    case = write_case(tmp_path / "fall", CASE)
    assert "to simulate" not in cli("check", case).out
    (row,) = cli("check", case, "--set", "scene.duration=600", "--json").json["cases"]
    assert row["seconds"] > 60
    assert "to simulate on two idle cores" in cli("check", case, "--set", "scene.duration=600").out
