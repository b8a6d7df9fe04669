"""`text2sim dataset` as far as nothing is simulated."""

import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from handmade import Cli

from text2sim.cli.benchmark import examined
from text2sim.cluster import run
from text2sim.cluster.run import Placement
from text2sim.cluster.task import STOPPED, Done, Task
from text2sim.dataset import build
from text2sim.runtime.lock import RunLock
from text2sim.runtime.stop import Stop

RECIPE = """\
text2sim_dataset: 1
name: falls
sources: {falls: {cases: [../cases/fall]}}
benchmarks: [../cases/fall]
"""


@pytest.fixture
def recipe(tmp_path: Path, case: Path) -> Path:
    (tmp_path / "recipes").mkdir()
    (tmp_path / "recipes/falls.yaml").write_text(RECIPE)
    return tmp_path / "recipes/falls.yaml"


def test_benchmarks_that_cannot_be_are_refused_before_anything_runs(
    cli: Cli, case: Path, recipe: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "run_tasks", None)
    (case / "benchmark.yaml").write_text("observables: {heigth: {}}\n")
    answer = cli("dataset", "build", recipe, "-o", "made")
    assert answer.code == 2
    assert "benchmark.yaml:1:15: error: there is no measure `heigth`" in answer.err
    assert not [*Path().glob("*made*")]


def test_two_cases_of_one_name_would_be_one_benchmark(case: Path) -> None:
    other = case.with_name("other")
    shutil.copytree(case, other)
    rows, tasks = examined([case, other], Path("runs"))
    assert [row.ok for row in rows] == [True, False] and list(tasks) == [0]
    assert rows[1].failure.endswith("cases/fall/case.yaml has the name `fall`, too; give one of them another")


def test_a_build_that_is_stopped_exits_as_other_commands_do(
    cli: Cli, recipe: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(tasks: Sequence[Task], where: Placement, stop: Stop) -> Iterator[Done]:
        stop.request()
        return (Done(task, None, STOPPED) for task in tasks)

    monkeypatch.setattr(build, "run_tasks", stopped)
    message = "stopped on request; the same command continues with what is left"
    answer = cli("dataset", "build", recipe, "-o", "made")
    assert (answer.code, answer.err) == (130, f"text2sim: {message}\n")
    answer = cli("dataset", "build", recipe, "-o", "made", "--json")
    assert (answer.code, answer.json) == (130, {"ok": False, "error": message})
    # While the benchmarks are made, too: the items are complete then.
    monkeypatch.setattr(build, "build", lambda *_, complete, **__: complete(Path("made")))
    monkeypatch.setattr(run, "run_tasks", stopped)
    assert cli("dataset", "build", recipe, "-o", "made").code == 130


def test_a_benchmark_takes_three_runs_at_halved_steps(case: Path, recipe: Path) -> None:
    rows, tasks = examined([case], recipe.parent / "runs")
    assert [row.ok for row in rows] == [True]
    assert [task.label for task in tasks[0]] == [f"fall at step/{n}" for n in (1, 2, 4)]
    assert len({tuple(task.arguments["sets"]) for task in tasks[0]}) == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "decided.yaml:1:1: error: cannot read the file: No such file or directory"),
        ("review:\n  falls-fall-00O: {decision: drop}\n", "decided.yaml:2:3: error: the dataset has no item `falls-fall-00O`"),
        ("review:\n  falls-fall-00O: {decision: drop}\n", "did you mean `falls-fall-000`?"),
    ],
)  # fmt: skip
def test_decisions_are_about_items_of_the_build(
    cli: Cli, recipe: Path, monkeypatch: pytest.MonkeyPatch, text: str | None, said: str
) -> None:
    monkeypatch.setattr(run, "run_tasks", None)
    if text is not None:
        Path("decided.yaml").write_text(text)
    answer = cli("dataset", "build", recipe, "-o", "made", "--decisions", "decided.yaml")
    assert answer.code == 2
    assert said in answer.err
    assert not [*Path().glob("*made*"), *Path().glob(".made*")]


def test_draws_without_an_effect_are_warned_of(cli: Cli, recipe: Path) -> None:
    recipe.write_text(RECIPE.replace("fall]}", "fall], looks: {bodies.ball.look.color: {choice: [red]}}}", 1))
    assert "falls.yaml:3:43: warning: `looks` is not drawn" in cli("dataset", "build", recipe, "-o", "cases").err


def test_two_builds_into_one_folder_do_not_share_their_parts(
    cli: Cli, recipe: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "run_tasks", None)
    with RunLock(Path(".made.parts"), "made"):
        answer = cli("dataset", "build", recipe, "-o", "made")
    assert (answer.code, answer.err) == (
        3,
        f"text2sim: made is being built by another text2sim (process {os.getpid()}); wait for it, or end it\n",
    )
