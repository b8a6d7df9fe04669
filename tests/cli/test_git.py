"""`git` and revisions: cases compared, merged and checked in a real repository."""

import os
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from handmade import CASE, LATEST_CASE, Cli, write_case

from text2sim.spec_schema.text.canonical import format_text

ROOT = Path(__file__).resolve().parents[2]
Git = Callable[..., str]
PIN = """\
text2sim: 2
prefab: pin
doc: A pin that is thrown at things.
params:
  size: {kind: length, default: 0.1, doc: Its radius.}
body: {kind: rigid, shape: {kind: sphere, radius: "${size}"}, material: {density: 500}}
"""


@pytest.fixture
def git(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Git:
    """Call git in a repository of its own, in which the case `fall` is committed; nothing of the user's is read."""
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home" / "config"))
    monkeypatch.setenv("GIT_CONFIG_NOSYSTEM", "1")
    root = tmp_path / "repo"
    write_case(root / "cases" / "fall", LATEST_CASE)
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
    commit(git, "side/wide", LATEST_CASE.replace("radius: 0.1", "radius: 0.2"))
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
    case = Path("repo/cases/fall")
    (case / "prefabs").mkdir()
    (case / "prefabs/pin.yaml").write_text(PIN)
    text = LATEST_CASE.replace("    kind: rigid\n    shape: {kind: sphere, radius: 0.1}\n", "    use: pin\n")
    (case / "case.yaml").write_text(text)
    git("add", ".")
    git("commit", "-qm", "pin")
    (case / "prefabs/pin.yaml").write_text(PIN.replace("default: 0.1", "default: 0.2"))
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
    ours = LATEST_CASE.replace("radius: 0.1}", "radius: 0.2}  # wide")
    theirs = LATEST_CASE.replace(
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
    commit(git, "theirs", LATEST_CASE.replace("radius: 0.1", "radius: 0.3").replace("duration: 1.0", "duration: 2.0"))
    commit(git, "ours", LATEST_CASE.replace("radius: 0.1", "radius: 0.2").replace("[0, 0, 5]", "[0, 0, 6]"))
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
        LATEST_CASE.replace(
            "falls: {measure: height, at: end, below: 1}", "falls: {measure: height, at: end, below: 2}"
        ),
    )
    commit(git, "ours", LATEST_CASE.replace(measure, measure.replace("height", "speed").replace("position", "speed").replace(", axis: z", "")).replace(expect, "    stays_slow: {measure: speed, at: end, below: 99}\n"))  # fmt: skip
    monkeypatch.chdir("repo")
    cli("git", "install")
    said = git("merge", "theirs", code=1)
    assert "actions.measures.height, actions.expect.falls" in said, "both changed the one, and it needs the other"
    git("merge", "--abort")
    commit(git, "theirs", LATEST_CASE + "    stays: {measure: height, at: 0.2, above: 0}\n")
    git("checkout", "-q", "ours")
    said = git("merge", "theirs", code=1)
    assert "both changes together are not valid (there is no measure `height`; there are speed)" in said
    text = Path("cases/fall/case.yaml").read_text()
    assert text.count("<<<<<<< ours") == 2, "at the measure that is gone, and at the expectation that names it"


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
    commit(git, "theirs", LATEST_CASE.replace("radius: 0.1", "radius: 0.3"))
    monkeypatch.chdir("repo")
    cli("git", "install")
    for key in ("diff.text2sim.command", "diff.text2sim.textconv"):
        git("config", key, git("config", key).strip().replace("text2sim git ", "nothing_of_this_name git "))
    for words in (("diff", "main"), ("log", "-p", "-1")):
        rows = [row for row in git(*words).splitlines() if "radius" in row]
        assert [row[0] for row in rows] == ["-", "+"]


def test_a_driver_that_does_not_start_leaves_a_merge_of_the_lines(git: Git, cli: Cli, monkeypatch: pytest.MonkeyPatch):
    commit(git, "theirs", LATEST_CASE.replace("radius: 0.1", "radius: 0.3").replace("duration: 1.0", "duration: 2.0"))
    commit(git, "ours", LATEST_CASE.replace("radius: 0.1", "radius: 0.2"))
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
