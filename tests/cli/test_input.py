"""Commands on files that people wrote, and what is said when something is wrong with them."""

import json
import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest
from handmade import CASE, Cli, write_case


def test_help_names_every_command(cli: Cli):
    answer = cli("--help")
    assert answer.code == 0
    for command in ("new", "check", "run", "test", "compile", "fmt", "schema", "doctor"):
        assert command in answer.out


def test_an_unknown_command_is_wrong_input(cli: Cli):
    answer = cli("chekc")
    assert answer.code == 2
    assert "chekc" in answer.err


# --- check -----------------------------------------------------------------------------------------------


def test_a_good_case_is_ok(cli: Cli, case: Path):
    answer = cli("check", case)
    said = "cases/fall/case.yaml: ok\n    already true at the start, and would be if nothing moved: starts_high\n"
    assert (answer.code, answer.out, answer.err) == (0, said, "")


def test_settings_come_with_reasons(cli: Cli, case: Path):
    answer = cli("check", "--settings", case)
    assert answer.code == 0
    assert "solver = newton: " in answer.out


def test_all_problems_are_said_at_their_places(cli: Cli, tmp_path: Path):
    text = CASE.replace("radius: 0.1", "radius: -0.1").replace("axis: z", "axsi: z")
    folder = write_case(tmp_path / "broken", text)
    answer = cli("check", folder / "case.yaml")
    assert answer.code == 2
    assert f"{folder}/case.yaml:10:" in answer.err
    assert f"{folder}/case.yaml:14:" in answer.err
    assert "did you mean `axis`?" in answer.err
    assert "radius: -0.1" in answer.err
    assert "Traceback" not in answer.err


def test_one_bad_case_does_not_hide_the_others(cli: Cli, case: Path, tmp_path: Path):
    bad = write_case(tmp_path / "cases" / "bad", "text2sim: 1\n")
    answer = cli("check", tmp_path / "cases", "--json")
    assert answer.code == 2
    assert answer.err == ""
    assert answer.json["ok"] is False
    rows = {row["case"]: row for row in answer.json["cases"]}
    assert (rows["fall"]["ok"], rows["bad"]["ok"]) == (True, False)
    assert rows["bad"]["file"] == str(bad / "case.yaml")
    assert {"file", "line", "column", "message", "rule", "path", "hint"} <= set(rows["bad"]["problems"][0])


def test_what_cannot_be_read_is_said_in_a_line(cli: Cli, tmp_path: Path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "binary.yaml").write_bytes(b"\x00\xff\xfe" * 100)
    (tmp_path / "dangling.yaml").symlink_to(tmp_path / "nowhere")
    (tmp_path / "loop.yaml").symlink_to(tmp_path / "loop.yaml")
    (tmp_path / "case.yaml").mkdir()
    for name in (
        "missing.yaml",
        "missing/case.yaml",
        "empty",
        "binary.yaml",
        "dangling.yaml",
        "loop.yaml",
        ".",
    ):
        answer = cli("check", name)
        assert answer.code == 2, name
        assert len(answer.err.splitlines()) <= 3, answer.err
        assert "Traceback" not in answer.err
        assert cli("check", name, "--json").json["cases"][0]["problems"], name


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="nothing is unreadable for root")
def test_a_file_without_permission_is_said_in_a_line(cli: Cli, case: Path):
    (case / "case.yaml").chmod(0)
    assert "ermission" in cli("check", case).err


def test_what_files_say_cannot_move_the_cursor(cli: Cli, tmp_path: Path):
    folder = write_case(tmp_path / "x\x1b[2Jy", 'text2sim: 1\n"a\\e[31m": 1\n')
    answer = cli("check", folder)
    assert answer.code == 2
    assert "\x1b" not in answer.err


def test_check_is_quick_and_loads_no_engine(case: Path):
    code = """
import sys
sys.argv = ["text2sim", "check", sys.argv[1]]
from text2sim.cli.main import run
try:
    run()
finally:
    heavy = {"genesis", "torch", "matplotlib", "jinja2", "rich.progress"} & set(sys.modules)
    print("heavy:", sorted(heavy))
"""
    begun = time.monotonic()
    answer = subprocess.run([sys.executable, "-c", code, case], capture_output=True, text=True, check=True)
    assert "heavy: []" in answer.stdout
    assert time.monotonic() - begun < 60.0  # 0.4 s on a machine with nothing else to do


def test_a_reader_that_has_enough_is_no_error(case: Path):
    command = f'"{sys.executable}" -m text2sim schema | head -1'
    answer = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert answer.stdout == "{\n"
    assert answer.stderr == ""


def test_an_error_of_ours_says_so_and_where_the_details_are(
    cli: Cli, case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def broken(*_: object, **__: object) -> None:
        raise KeyError("lost")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("SOME_API_KEY", "open sesame")
    monkeypatch.setattr("text2sim.service.examined.examine", broken)
    answer = cli("check", case)
    assert answer.code == 70
    assert "our bug" in answer.err
    assert "Traceback" not in answer.err
    details = Path(answer.err.splitlines()[-1].partition(": cat ")[2])
    assert details.parent == tmp_path / "cache" / "text2sim" / "bugs"
    assert "KeyError: 'lost'" in details.read_text()
    assert "sesame" not in details.read_text()
    assert (details.stat().st_mode & 0o777, details.parent.stat().st_mode & 0o777) == (0o600, 0o700)
    answer = cli("check", case, "--json")
    assert (answer.code, answer.json["ok"]) == (70, False)
    assert Path(answer.json["details"]).is_file()


# --- compile ---------------------------------------------------------------------------------------------


def test_compile_writes_the_program(cli: Cli, case: Path):
    answer = cli("compile", case)
    assert answer.code == 0
    assert "cases/fall/program/main.py" in answer.out.splitlines()
    first = (case / "program" / "bodies.py").read_bytes()
    assert cli("compile", case, "-o", "elsewhere").code == 0
    assert Path("elsewhere/bodies.py").read_bytes() == first
    assert cli("compile", case).code == 0


def test_compile_writes_over_nothing_that_is_not_its_own(cli: Cli, case: Path, tmp_path: Path):
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "thesis.txt").write_text("mine")
    assert cli("compile", case, "-o", precious).code == 2
    (case / "program").symlink_to(precious)
    answer = cli("compile", case)
    assert answer.code == 2
    assert "symbolic link" in answer.err
    assert [path.name for path in precious.iterdir()] == ["thesis.txt"]


def test_compile_says_what_is_wrong_and_writes_nothing(cli: Cli, tmp_path: Path):
    folder = write_case(tmp_path / "bad", CASE.replace("radius: 0.1", "radius: 0"))
    answer = cli("compile", folder, "--json")
    assert answer.code == 2
    assert answer.json["problems"][0]["line"] == 10
    assert not (folder / "program").exists()


# --- fmt -------------------------------------------------------------------------------------------------


def test_fmt_rewrites_once(cli: Cli, case: Path):
    file = case / "case.yaml"
    file.write_text(CASE.replace("{kind: plane}}", "{  kind: plane  }}  # flat"))
    file.chmod(0o640)
    assert cli("fmt", "--check", case).code == 1
    diff = cli("fmt", "--diff", case)
    assert diff.code == 1
    assert "-    floor: {shape: {  kind: plane  }}  # flat" in diff.out
    assert "{  kind" in file.read_text()
    assert cli("fmt", case).code == 0
    assert "{kind: plane}}  # flat" in file.read_text()
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert cli("fmt", "--check", case).code == 0
    assert cli("fmt", case).out == ""


def test_fmt_does_not_write_through_links(cli: Cli, case: Path, tmp_path: Path):
    outside = tmp_path / "outside.yaml"
    outside.write_text(CASE.replace("{kind: plane}", "{  kind: plane  }"))
    (case / "case.yaml").unlink()
    (case / "case.yaml").symlink_to(outside)
    assert cli("fmt", case).code == 2
    assert "{  kind" in outside.read_text()


@pytest.mark.parametrize("text", ["just words\nand more\n", "- 1\n-   2\n", "services: {web:   {image: x}}\n"])
def test_what_is_no_case_is_not_rewritten(cli: Cli, tmp_path: Path, text: str) -> None:
    (tmp_path / "other.yaml").write_text(text)
    answer = cli("fmt", tmp_path / "other.yaml")
    assert answer.code == 2
    assert "is neither a case nor a prefab" in answer.err
    assert (tmp_path / "other.yaml").read_text() == text


@pytest.mark.parametrize("words", ["check", "check --json", "show --no-png", "diff", "new other --from", "patch"])
def test_no_command_reads_what_a_case_file_points_at(cli: Cli, case: Path, tmp_path: Path, words: str):
    (tmp_path / "secret").write_text("password: 1234\n")
    (case / "case.yaml").unlink()
    (case / "case.yaml").symlink_to(tmp_path / "secret")
    more = {"diff": [tmp_path], "patch": [write_patch(tmp_path)]}.get(words, [])
    answer = cli(*words.split(), case, *more)
    assert answer.code == 2
    assert "1234" not in answer.out + answer.err
    assert "link" in answer.out + answer.err
    assert not (tmp_path / "cases" / "other").exists()


def write_patch(folder: Path) -> Path:
    path = folder / "patch.json"
    path.write_text('[{"op": "remove", "path": "/password"}]')
    return path


def test_fmt_says_what_is_no_yaml(cli: Cli, tmp_path: Path):
    folder = write_case(tmp_path / "bad", "text2sim: [1\n")
    answer = cli("fmt", folder, "--json")
    assert answer.code == 2
    assert answer.json["files"][0]["problems"]
    assert (folder / "case.yaml").read_text() == "text2sim: [1\n"


# --- new, schema -----------------------------------------------------------------------------------------


def test_a_new_case_is_good_and_canonical(cli: Cli):
    answer = cli("new", "my_case")
    assert answer.code == 0
    assert answer.out.splitlines()[0] == "cases/my_case/case.yaml"
    assert "name: my_case\n" in Path("cases/my_case/case.yaml").read_text()
    assert cli("check", "cases/my_case").code == 0
    assert cli("fmt", "--check", "cases/my_case").code == 0
    again = cli("new", "my_case")
    assert again.code == 2
    assert "already exists" in again.err


def test_a_new_case_knows_where_the_schema_is(cli: Cli, tmp_path: Path):
    (tmp_path / "spec_schema").mkdir()
    assert cli("schema", "-o", "spec_schema/case.schema.json").code == 0
    assert json.loads(Path("spec_schema/case.schema.json").read_text())["title"]
    cli("new", "pointed")
    first = Path("cases/pointed/case.yaml").read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=../../spec_schema/case.schema.json"
    assert cli("fmt", "--check", "cases/pointed").code == 0


@pytest.mark.parametrize("name", ["../out", "/tmp/out", "a b", "1st", "", "a" * 60, "x/y", "x\n"])
def test_a_new_case_has_a_sane_name(cli: Cli, name: str):
    assert cli("new", "--", name).code == 2
    assert not Path("cases").exists() or not any(Path("cases").iterdir())


def test_a_copy_takes_what_belongs_to_the_case(cli: Cli, case: Path, tmp_path: Path):
    (case / "assets").mkdir()
    (case / "assets" / "cup.obj").write_text("v 0 0 0\n")
    (case / "assets" / "secret").symlink_to("/etc/passwd")
    (case / "program").mkdir()
    assert cli("new", "second", "--from", "fall").code == 0
    second = tmp_path / "cases" / "second"
    assert (second / "case.yaml").read_text() == CASE.replace("name: fall", "name: second")
    assert sorted(str(path.relative_to(second)) for path in second.rglob("*")) == [
        "assets",
        "assets/cup.obj",
        "case.yaml",
    ]
    assert cli("new", "third", "--from", case / "case.yaml").code == 0
    assert cli("new", "fourth", "--from", "nothing").code == 2


def test_closed_streams_are_no_error(case: Path):
    for closed in (">&-", "2>&-", ">&- 2>&-"):
        answer = subprocess.run(
            f'"{sys.executable}" -m text2sim check {case} {closed}', shell=True, capture_output=True
        )
        assert (answer.returncode, b"Traceback" in answer.stderr) == (0, False), closed
