"""`diff`, `patch`, `migrate` and `git`: versions of a case, in files and in a real repository."""

import json
import os
import re
import shlex
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from handmade import CASE, Cli, prepare_run, write_case

from text2sim.spec_schema.changes.edit import edit_text
from text2sim.spec_schema.changes.patch import apply_operations
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.migration import LATEST
from text2sim.spec_schema.text.canonical import format_text

ROOT = Path(__file__).resolve().parents[2]
NEW = edit_text(CASE, [{"op": "replace", "path": "/text2sim", "value": LATEST}])
Git = Callable[..., str]


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
        NEW
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


# --- git ------------------------------------------------------------------------------------------------------


@pytest.fixture
def git(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Git:
    """Call git in a repository of its own, in which the case `fall` is committed; nothing of the user's is read."""
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home" / "config"))
    monkeypatch.setenv("GIT_CONFIG_NOSYSTEM", "1")
    root = tmp_path / "repo"
    write_case(root / "cases" / "fall", NEW)
    (tmp_path / "home").mkdir()

    def call(*arguments: str, code: int = 0) -> str:
        done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout + done.stderr

    call("init", "-q", "-b", "main")
    call("config", "user.name", "Somebody")
    call("config", "user.email", "somebody@example.org")
    call("add", ".")
    call("commit", "-qm", "start")
    return call


def commit(git: Git, branch: str, text: str) -> None:
    git("checkout", "-q", "-B", branch, "main")
    Path(git("rev-parse", "--show-toplevel").strip(), "cases", "fall", "case.yaml").write_text(text)
    git("commit", "-qam", f"on {branch}")


def test_revisions_are_compared(cli: Cli, git: Git):
    commit(git, "side/wide", NEW.replace("radius: 0.1", "radius: 0.2"))
    line = "bodies:\n  ~ bodies.ball.shape.radius  0.1 → 0.2\n"
    for a, b in (
        ("repo/cases/fall@main", "repo/cases/fall"),
        ("repo/cases/fall/case.yaml@HEAD~1", "repo/cases/fall@side/wide"),
        ("repo/cases/fall@main", "repo/cases/fall/case.yaml@HEAD"),
    ):
        assert cli("diff", a, b).out == line
    git("mv", "cases/fall", "cases/drop")
    assert cli("diff", "repo/cases/fall@main", "repo/cases/drop").out == line
    git("rm", "-rqf", "cases")
    assert cli("diff", "repo/cases/fall@main", "repo/cases/fall@HEAD").out == line


def test_a_revision_brings_its_own_prefabs(cli: Cli, git: Git):
    prefab = "text2sim: 2\nprefab: pin\ndoc: A pin that is thrown at things.\nparams:\n  size: {kind: length, default: 0.1, doc: Its radius.}\nbody: {kind: rigid, shape: {kind: sphere, radius: \"${size}\"}}\n"  # fmt: skip
    case = Path("repo/cases/fall")
    (case / "prefabs").mkdir()
    (case / "prefabs/pin.yaml").write_text(prefab)
    text = NEW.replace("    kind: rigid\n    shape: {kind: sphere, radius: 0.1}\n", "    use: pin\n")
    (case / "case.yaml").write_text(text)
    git("add", ".")
    git("commit", "-qm", "pin")
    (case / "prefabs/pin.yaml").write_text(prefab.replace("default: 0.1", "default: 0.2"))
    answer = cli("diff", "repo/cases/fall@HEAD", "repo/cases/fall")
    assert (answer.code, answer.out) == (1, "derived values:\n  = bodies.ball.shape.radius  0.1 → 0.2\n")
    assert list(case.rglob(".*")) == []


@pytest.mark.parametrize(
    "revision", ["--help", "nothing", "HEAD~99", "main..side", "HEAD:cases", "main;id", "$(id)", "-", "a b"]
)
def test_what_is_no_revision_is_said_in_a_line(cli: Cli, git: Git, revision: str):
    answer = cli("diff", f"repo/cases/fall@{revision}", "repo/cases/fall")
    assert answer.code == 2
    assert "revision" in answer.err
    assert len(answer.err.splitlines()) == 1


def test_a_revision_needs_a_repository(cli: Cli, case: Path):
    answer = cli("diff", f"{case}@HEAD", case)
    assert answer.code == 2
    assert "not in a git repository" in answer.err


def test_what_plain_git_cannot_merge_merges_by_meaning(cli: Cli, git: Git, monkeypatch: pytest.MonkeyPatch):
    ours = NEW.replace("radius: 0.1}", "radius: 0.2}  # wide")
    theirs = NEW.replace(
        "{kind: sphere, radius: 0.1}\n", "{kind: sphere, radius: 0.1}\n    material: {density: 500}  # light\n"
    )
    commit(git, "theirs", theirs)
    commit(git, "ours", ours)
    git("merge", "theirs", code=1)
    git("merge", "--abort")
    monkeypatch.chdir("repo")
    answer = cli("git", "install")
    assert answer.code == 0
    assert Path(".gitattributes").read_text() == (
        "case.yaml diff=text2sim merge=text2sim\n**/prefabs/*.yaml diff=text2sim merge=text2sim\n"
    )
    assert "unchanged" in cli("git", "install").out
    git("merge", "theirs", "-m", "both")
    merged = Path("cases/fall/case.yaml").read_text()
    assert "radius: 0.2}  # wide\n    material: {density: 500}  # light\n" in merged
    # git speaks of meaning
    said = git("diff", "HEAD~1", "HEAD", "--", "cases")
    assert said == "cases/fall/case.yaml\n  bodies:\n    + bodies.ball.material  {density: 500}\n"
    log = git("log", "-p", "-1", "theirs", "--", "cases")
    assert "+bodies.ball.material:  # light\n+bodies.ball.material.density: 500\n" in log
    # and of lines where there is no other meaning, or none at all
    Path("cases/fall/case.yaml").write_text(merged.replace("# wide", "# very wide"))
    said = git("diff")
    assert "the meaning is the same" in said
    assert "# very wide" in said
    Path("cases/fall/case.yaml").write_text("[")
    assert "+[" in git("diff")
    Path("cases/fall/case.yaml").unlink()
    assert "the case was deleted" in git("diff")
    git("checkout", "-q", "--", "cases")
    # it can be undone
    assert cli("git", "uninstall").code == 0
    assert not Path(".gitattributes").exists()
    assert "text2sim" not in git("config", "--local", "--list")
    assert "--- a/cases/fall/case.yaml" in git("diff", "HEAD~1", "HEAD", "--", "cases")


def test_a_real_conflict_gets_markers(cli: Cli, git: Git, monkeypatch: pytest.MonkeyPatch):
    commit(git, "theirs", NEW.replace("radius: 0.1", "radius: 0.3").replace("duration: 1.0", "duration: 2.0"))
    commit(git, "ours", NEW.replace("radius: 0.1", "radius: 0.2").replace("[0, 0, 5]", "[0, 0, 6]"))
    monkeypatch.chdir("repo")
    cli("git", "install")
    said = git("merge", "theirs", code=1)
    assert "cases/fall/case.yaml: changed on both sides: bodies.ball.shape.radius" in said
    text = Path("cases/fall/case.yaml").read_text()
    assert (
        "<<<<<<< ours\n    shape: {kind: sphere, radius: 0.2}\n=======\n    shape: {kind: sphere, radius: 0.3}\n>>>>>>> theirs\n"
    ) in text
    assert "duration: 2.0" in text
    assert "[0, 0, 6]" in text
    assert text.count("<<<<<<<") == 1
    assert "UU cases/fall/case.yaml" in git("status", "--short")
    assert "++<<<<<<< ours\n" in git("diff")
    assert cli("check", "cases/fall").code == 2


def test_changes_that_only_together_are_wrong_are_marked_at_both_places(
    cli: Cli, git: Git, monkeypatch: pytest.MonkeyPatch
):
    measure = "    height: {kind: position, of: ball, axis: z}\n"
    expect = "    starts_high: {measure: height, at: 0.1, above: 4}\n    falls: {measure: height, at: end, below: 1}\n"
    commit(
        git,
        "theirs",
        NEW.replace("falls: {measure: height, at: end, below: 1}", "falls: {measure: height, at: end, below: 2}"),
    )
    commit(git, "ours", NEW.replace(measure, measure.replace("height", "speed").replace("position", "speed").replace(", axis: z", "")).replace(expect, "    stays_slow: {measure: speed, at: end, below: 99}\n"))  # fmt: skip
    monkeypatch.chdir("repo")
    cli("git", "install")
    said = git("merge", "theirs", code=1)
    assert "actions.measures.height, actions.expect.falls" in said, "both changed the one, and it needs the other"
    git("merge", "--abort")
    commit(git, "theirs", NEW + "    stays: {measure: height, at: 0.2, above: 0}\n")
    git("checkout", "-q", "ours")
    said = git("merge", "theirs", code=1)
    assert "both changes together are not valid (there is no measure `height`)" in said
    text = Path("cases/fall/case.yaml").read_text()
    assert text.count("<<<<<<< ours") == 2, "at the measure that is gone, and at the expectation that names it"


PIN = """\
text2sim: 2
prefab: pin
doc: A pin that is thrown at things.
params:
  size: {kind: length, default: 0.1, doc: Its radius.}
body: {kind: rigid, shape: {kind: sphere, radius: "${size}"}, material: {density: 500}}
"""


def test_prefabs_are_merged_by_meaning_too(cli: Cli, git: Git, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir("repo")
    file = Path("cases/fall/prefabs/pin.yaml")

    def branch(name: str, text: str) -> None:
        git("checkout", "-q", "-B", name, "base")
        file.write_text(text)
        git("commit", "-qam", name)

    file.parent.mkdir()
    file.write_text(PIN)
    git("checkout", "-qb", "base")
    git("add", ".")
    git("commit", "-qm", "pin")
    branch("theirs", PIN.replace("density: 500", "density: 900"))
    branch("ours", PIN.replace("kind: sphere, radius", "kind: capsule, length: 0.3, radius"))
    git("merge", "theirs", code=1)  # both changed one line
    git("merge", "--abort")
    assert cli("git", "install").code == 0
    git("merge", "theirs", "-m", "both")
    merged = file.read_text()
    assert all(word in merged for word in ("kind: capsule", "length: 0.3", "density: 900"))
    said = git("diff", "HEAD~1", "HEAD", "--", "cases")
    assert said == "cases/fall/prefabs/pin.yaml\n  prefab:\n    ~ body.material.density  500 → 900\n"
    # One side drops a parameter, the other takes it up: no prefab.
    branch("theirs", PIN.replace('radius: "${size}"', "radius: 0.1").replace("  size: {kind: length, default: 0.1, doc: Its radius.}", "  wide: {kind: length, default: 0.1, doc: Nothing.}"))  # fmt: skip
    branch("ours", PIN.replace("density: 500", 'density: "${5000 * size}"'))
    assert "both changes together are not valid" in git("merge", "theirs", code=1)
    git("merge", "--abort")
    git("rm", "-q", str(file))
    assert "the prefab was deleted" in git("diff", "HEAD")


def test_drivers_that_do_not_start_leave_a_difference_of_the_lines(git: Git, cli: Cli, monkeypatch: pytest.MonkeyPatch):
    commit(git, "theirs", NEW.replace("radius: 0.1", "radius: 0.3"))
    monkeypatch.chdir("repo")
    cli("git", "install")
    for key in ("diff.text2sim.command", "diff.text2sim.textconv"):
        git("config", key, git("config", key).strip().replace("text2sim git ", "nothing_of_this_name git "))
    for words in (("diff", "main"), ("log", "-p", "-1")):
        rows = [row for row in git(*words).splitlines() if "radius" in row]
        assert [row[0] for row in rows] == ["-", "+"]


def test_a_driver_that_does_not_start_leaves_a_merge_of_the_lines(git: Git, cli: Cli, monkeypatch: pytest.MonkeyPatch):
    commit(git, "theirs", NEW.replace("radius: 0.1", "radius: 0.3").replace("duration: 1.0", "duration: 2.0"))
    commit(git, "ours", NEW.replace("radius: 0.1", "radius: 0.2"))
    monkeypatch.chdir("repo")
    cli("git", "install")
    driver = git("config", "merge.text2sim.driver").strip()
    git("config", "merge.text2sim.driver", driver.replace(" -m text2sim ", " -m nothing_of_this_name "))
    git("merge", "theirs", code=1)
    text = Path("cases/fall/case.yaml").read_text()
    assert "<<<<<<<" in text
    assert "duration: 2.0" in text


def test_an_error_of_ours_does_not_stop_git(cli: Cli, case: Path, monkeypatch: pytest.MonkeyPatch):
    def broken(*_: object, **__: object) -> None:
        raise KeyError("lost")

    Path("new.yaml").write_text(CASE.replace("radius: 0.1", "radius: 0.2"))
    monkeypatch.setattr("text2sim.revision.driver.driver_side", broken)
    answer = cli("git", "diff", "x/case.yaml", case / "case.yaml", "0", "100644", "new.yaml", "0", "100644")
    assert answer.code == 0
    assert "+    shape: {kind: sphere, radius: 0.2}" in answer.out
    Path(answer.err.split()[-1]).unlink()


def test_installing_for_all_repositories(cli: Cli, git: Git, tmp_path: Path):
    cli("git", "install", "--global")
    attributes = tmp_path / "home" / "config" / "git" / "attributes"
    assert attributes.read_text().splitlines()[0] == "case.yaml diff=text2sim merge=text2sim"
    assert "text2sim git merge" in git("config", "--global", "merge.text2sim.driver")
    assert "text2sim" in git("check-attr", "merge", "cases/fall/case.yaml")
    attributes.write_text("*.png binary\n" + attributes.read_text())
    cli("git", "uninstall", "--global")
    assert attributes.read_text() == "*.png binary\n"


def test_installing_needs_a_repository(cli: Cli, tmp_path: Path):
    answer = cli("git", "install")
    assert answer.code == 2
    assert "not in a git repository" in answer.err


def test_hooks_for_pre_commit_fail_where_they_should(case: Path):
    hooks = {hook["id"]: hook for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}
    assert set(hooks) == {"text2sim-fmt", "text2sim-check"}
    file = case / "case.yaml"
    file.write_text(format_text(CASE))

    def run(hook: str) -> int:
        program, *arguments = shlex.split(hooks[hook]["entry"])
        assert program == "text2sim"
        command = [sys.executable, "-m", "text2sim", *arguments, str(file)]
        env = os.environ | {"PYTHONPATH": str(ROOT)}
        return subprocess.run(command, capture_output=True, env=env, check=False).returncode

    assert [run(hook) for hook in hooks] == [0, 0]
    file.write_text(CASE.replace("radius: 0.1", "radius:  -0.1"))
    assert [run(hook) for hook in hooks] == [1, 2]


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
