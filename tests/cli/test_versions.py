"""`diff`, `patch` and `migrate`: versions of a case in files; of those in a repository see `test_git.py`."""

import json
import os
import re
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from handmade import CASE, LATEST_CASE, Cli, prepare_run, write_case

from text2sim.spec_schema.changes.patch import apply_operations
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.migration import LATEST
from text2sim.spec_schema.text.canonical import format_text

ROOT = Path(__file__).resolve().parents[2]


def write_patch(*operations: dict[str, Any], name: str = "p.json") -> str:
    Path(name).write_text(json.dumps(operations, indent=1))
    return name


RADIUS = {"op": "replace", "path": "/bodies/ball/shape/radius", "value": 0.2}


# --- diff -----------------------------------------------------------------------------------------------------


def test_versions_that_mean_the_same_do_not_differ(cli: Cli, case: Path, tmp_path: Path):
    (tmp_path / "b.yaml").write_text(
        CASE.replace("{kind: sphere, radius: 0.1}", "{radius: 0.10,  kind: sphere}  # round")
    )
    for options in ([], ["--stat"]):
        answer = cli("diff", case, "b.yaml", *options)
        assert (answer.code, answer.out, answer.err) == (0, "", "")
    assert cli("diff", case, case / "case.yaml", "--json").json == []


def test_differences_are_said_by_section(cli: Cli, case: Path, tmp_path: Path):
    (tmp_path / "b.yaml").write_text(CASE.replace("radius: 0.1", "radius: 0.2").replace("[0, 0, 5]", "[0, 0, 6]"))
    answer = cli("diff", case, "b.yaml")
    assert answer.code == 1
    assert answer.out.splitlines() == [
        "bodies:",
        "  ~ bodies.ball.shape.radius  0.1 → 0.2",
        "  ~ bodies.ball.pose.pos  moved by [0, 0, 1] (1 m): [0, 0, 5] → [0, 0, 6]",
    ]
    assert cli("diff", case, "b.yaml", "--stat").out == "bodies: 1 changed, 1 moved\n"
    answer = cli("diff", case, "b.yaml", "--json")
    assert answer.code == 1
    assert apply_operations(yaml.safe_load(CASE), answer.json) == yaml.safe_load((tmp_path / "b.yaml").read_text())


def test_variants_are_compared(cli: Cli, tmp_path: Path):
    text = (
        LATEST_CASE
        + "variants:\n  wide: {bodies: {ball: {shape: {radius: 0.2}}}}\n  high: {bodies: {ball: {pose: {pos: [0, 0, 9]}}}}\n"
    )
    case = write_case(tmp_path / "v", text)
    for arguments in ((case, f"{case}+wide"), (case, case, "--variant-b", "wide"), (case, f"{case}/case.yaml+wide")):
        answer = cli("diff", *arguments)
        assert answer.out == "bodies:\n  ~ bodies.ball.shape.radius  0.1 → 0.2\n"
    assert "moved by [0, 0, 4]" in cli("diff", case, f"{case}+wide+high").out
    answer = cli("diff", case, f"{case}+wode")
    assert answer.code == 2
    assert "did you mean `wide`?" in answer.err


def test_a_side_that_is_not_valid_is_compared_as_it_is_written(cli: Cli, case: Path, tmp_path: Path):
    (tmp_path / "b.yaml").write_text(CASE.replace("radius: 0.1", "radius: -1"))
    answer = cli("diff", case, "b.yaml")
    assert answer.code == 1
    assert "radius  0.1 → -1" in answer.out
    assert "b.yaml is not valid" in answer.err
    assert "b.yaml:10:35: error: must be greater than 0 (got -1)" in answer.err


@pytest.mark.parametrize("text", ["nowhere", "nowhere@HEAD", "fall+x y"])
def test_what_is_not_there_is_said_in_a_line(cli: Cli, case: Path, text: str):
    answer = cli("diff", case, text)
    assert answer.code == 2
    assert len(answer.err.splitlines()) == 1
    assert "Traceback" not in answer.err


def test_what_came_of_both_when_both_were_run(cli: Cli, case: Path, folder: Path, tmp_path: Path):
    other = write_case(tmp_path / "cases" / "high", CASE.replace("[0, 0, 5]", "[0, 0, 6]"))
    run = prepare_run(other, tmp_path / "runs")
    evidence = json.loads((run / "evidence.json").read_text())
    evidence["measures"]["height"] |= {"last": 2.5, "max": 6.0}
    evidence["expect"]["falls"] |= {"ok": False, "why": "2.5 m at 1 s"}
    (run / "evidence.json").write_text(json.dumps(evidence))
    rows = [
        f"results ({folder} → runs/{run.name}):",
        "  height  end 0.095 → 2.5 m, max 5 → 6 m",
        "  falls  ok → FAIL: 2.5 m at 1 s",
    ]
    assert cli("diff", case, other).out.splitlines()[-3:] == rows
    assert cli("diff", folder, run).out.splitlines()[-2:] == rows[1:]
    assert "what came" not in cli("diff", case, other, "--runs", "elsewhere").out
    (run / "evidence.json").write_text("[1, {")
    answer = cli("diff", case, other)
    assert (answer.code, "  falls  ok → open: 0.095 m at 1 s\n" in answer.out) == (1, True)
    write_case(tmp_path / "cases" / "same", CASE.replace("starts_high", "begins_high"))
    assert "what came" not in cli("diff", case, "cases/same").out


# --- patch ----------------------------------------------------------------------------------------------------


def test_a_patch_is_written_in_canonical_form_with_the_comments(cli: Cli, case: Path):
    file = case / "case.yaml"
    text = CASE.replace("radius: 0.1}", "radius:   0.1}  # small")
    file.write_text(text)
    file.chmod(0o640)
    answer = cli("patch", case, write_patch(RADIUS), "--dry-run")
    assert (answer.code, file.read_text()) == (0, text)
    assert "-    shape: {kind: sphere, radius:   0.1}  # small" in answer.out
    assert answer.out.endswith("1 operation would be applied\n")
    answer = cli("patch", case, write_patch(RADIUS))
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == "~ bodies.ball.shape.radius  0.1 → 0.2\ncases/fall/case.yaml: 1 operation applied\n"
    assert file.read_text() == format_text(text.replace("radius:   0.1}", "radius: 0.2}"))
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    document = cli("patch", case, write_patch(RADIUS | {"value": 0.3}), "--json").json
    assert document["ok"] is document["written"] is True
    assert document["undo"] == [RADIUS]
    assert cli("patch", case, write_patch(*document["undo"])).code == 0
    assert cli("patch", case, write_patch(RADIUS)).out == "cases/fall/case.yaml: the patch changes nothing\n"


def test_a_patch_can_be_read_in(cli: Cli, case: Path):
    command = [sys.executable, "-m", "text2sim", "patch", case, "-"]
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, input=json.dumps([RADIUS]), text=True, capture_output=True, env=env, check=True)
    assert "radius  0.1 → 0.2" in done.stdout


REFUSED = [
    ("no JSON", '[{"op": "remove" "path": "/a"}]', ["p.json:1:18: error: not valid JSON"]),
    ("no list", '{"op": "remove", "path": "/a"}', ["a patch is a list of operations"]),
    ("a key twice", '[{"op": "test", "op": "remove", "path": "/prompt"}]', ["the key `op` is given twice"]),
    ("not finite", '[{"op": "add", "path": "/params", "value": {"x": NaN}}]', ["a finite number"]),
    ("nested without end", "[" * 100_000, ["p.json", "nested"]),
    ("not there", '[\n  {"op": "replace",\n   "path": "/bodies/bal/shape", "value": 1}]',
     ["p.json:3:12: error: operation 1 (replace /bodies/bal/shape): there is no `bal`", "did you mean `ball`?"]),
    ("schema", '[{"op": "replace", "path": "/bodies/ball/shape/radius", "value": -1}]',
     ["case.yaml:12:35: error: must be greater than 0 (got -1)", "radius: -1}", "operation 1 (replace", "is not changed"]),
    ("a reference", '[{"op": "test", "path": "/name", "value": "fall"},\n {"op": "move", "from": "/bodies/ball", "path": "/bodies/shot"}]',
     ["case.yaml:17:34: error: there is no body or static `ball`", "operation 2 (move /bodies/shot)", "is not changed"]),
    ("an expectation without a measure", '[{"op": "remove", "path": "/actions/measures/height"}]', ["operation 1 (remove", "`height`"]),
    ("the lint", '[{"op": "replace", "path": "/bodies/ball/pose/pos", "value": [0, 0, -3]}]', ["[under-floor]", "is not changed"]),
    ("another one's section", '[{"op": "add", "path": "/params", "value": {"x": 1}}]', ["/params is outside /bodies", "`--owner bodies`"]),
    ("all at once", '[{"op": "replace", "path": "", "value": {}}]', ["the whole case is outside /bodies"]),
    ("taken from another", '[{"op": "move", "from": "/actions/measures", "path": "/bodies/measures"}]', ["p.json:1:25", "/actions is outside /bodies"]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "reasons"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED])
def test_a_patch_that_is_refused_changes_nothing(cli: Cli, case: Path, text: str, reasons: list[str]):
    Path("p.json").write_text(text)
    owner = ["--owner", "bodies"] if any("is outside" in reason for reason in reasons) else []
    answer = cli("patch", case, "p.json", *owner)
    assert answer.code == 2
    assert "Traceback" not in answer.err
    for reason in reasons:
        assert reason in answer.err
    assert (case / "case.yaml").read_text() == CASE
    document = cli("patch", case, "p.json", *owner, "--json").json
    assert document["ok"] is False
    assert document["problems"]
    assert sorted(path.name for path in case.iterdir()) == ["case.yaml"]


def test_a_patch_may_mend_a_case_that_is_broken(cli: Cli, case: Path):
    (case / "case.yaml").write_text(CASE.replace("radius: 0.1", "radius: 0"))
    assert cli("patch", case, write_patch(RADIUS)).code == 0
    assert cli("check", case).code == 0


def test_an_owner_changes_what_is_its_own(cli: Cli, case: Path):
    look = {"op": "copy", "from": "/scene/duration", "path": "/bodies/ball/shape/radius"}
    check = {"op": "test", "path": "/scene/duration", "value": 1}
    assert cli("patch", case, write_patch(check, look), "--owner", "bodies").code == 0
    assert "radius: 1.0}" in (case / "case.yaml").read_text()
    assert cli("patch", case, write_patch(RADIUS), "--owner", "planner").code == 2


def test_nothing_is_written_through_a_link(cli: Cli, case: Path, tmp_path: Path):
    (case / "case.yaml").rename(tmp_path / "outside.yaml")
    (case / "case.yaml").symlink_to(tmp_path / "outside.yaml")
    assert "a link that leads out of the folder" in cli("patch", case, write_patch(RADIUS)).err
    assert (tmp_path / "outside.yaml").read_text() == CASE


# --- migrate --------------------------------------------------------------------------------------------------


def test_an_old_case_is_written_anew_with_its_comments(cli: Cli, case: Path):
    old = CASE + "render:\n  cameras:\n    main: {kind: still,  from: [3, 0, 1], look_at: ball, fov: 40}  # narrow\n"
    (case / "case.yaml").write_text(old)
    assert cli("migrate", "--check", case).code == 1
    assert (case / "case.yaml").read_text() == old
    answer = cli("migrate", "cases")
    assert (answer.code, answer.out) == (0, f"cases/fall/case.yaml: version 1 is now version {LATEST}\n")
    new = (case / "case.yaml").read_text()
    assert new == format_text(old).replace("text2sim: 1", f"text2sim: {LATEST}").replace("fov: 40", "fov_deg: 40")
    assert load_text(new).case.render == load_text(old).case.render
    assert (cli("migrate", "--check", case).code, cli("migrate", case).out) == (0, "")


def test_what_cannot_be_migrated_is_said(cli: Cli, tmp_path: Path):
    bad = write_case(tmp_path / "bad", "text2sim: [1\n")
    answer = cli("migrate", bad, "--json")
    assert answer.code == 2
    assert answer.json["files"][0]["problems"]


def test_commands_of_the_page_are_real(cli: Cli):
    text = (ROOT / "docs" / "versions.md").read_text()
    calls = [call.split("#")[0].split() for block in re.findall(r"```sh\n(.*?)```", text, re.S) for line in block.splitlines() for call in line.split("|")]  # fmt: skip
    assert len(calls) >= 10
    for program, *words in calls:
        assert program == "text2sim"
        command = words[:2] if words[0] == "git" else words[:1]
        said = cli(*command, "--help").out
        assert "Usage" in said
        assert all(word in said for word in words if word.startswith("--")), words
