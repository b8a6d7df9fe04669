"""The commands of a study, from method folders to a table."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from text2sim.cli.main import app
from text2sim.evaluation.method_folder import MethodFolder
from text2sim.study.answers import Answers
from text2sim.study.build import read_study

SUITE = """\
text2sim_suite: 1
name: test
prompts:
  task_0:
    family: rigid
    source: {title: On falling, authors: A. Nobody, year: 1999, venue: Nowhere}
    prompt: A ball falls onto the floor.
"""


@pytest.fixture
def command(tmp_path: Path, methods: Callable[[int], list[MethodFolder]]) -> Callable[..., Result]:
    (tmp_path / "suite.yaml").write_text(SUITE)
    anchor, better, worse = (str(one.folder) for one in methods(1))
    more = ["--anchor", anchor, "--suite", str(tmp_path / "suite.yaml")]
    words = {"build": [better, worse, *more], "analyse": [], "serve": []}

    def run(name: str, *options: str) -> Result:
        return CliRunner().invoke(app, ["study", name, str(tmp_path / "study"), *words[name], *options])

    return run


def test_from_method_folders_to_scores(command: Callable[..., Result], tmp_path: Path) -> None:
    (tmp_path / "consent.txt").write_text("Ours is a study of the university.")
    built = command("build", "--seed", "5", "--consent", str(tmp_path / "consent.txt"))
    assert built.exit_code == 0, built.output
    assert "6 comparisons in 6 assignments" in built.output
    study = read_study(tmp_path / "study")
    assert (study.seed, study.consent) == (5, "Ours is a study of the university.")
    answers = Answers(tmp_path / "study", study)
    for _ in range(4):
        person = answers.begin() or ""
        place = answers.position(person)
        assert place is not None
        (trial,) = study.assignments[place[0]]
        r = 2 if trial.method == "better_system" else -1
        answers.give(person, 0, dict.fromkeys(study.questions, -r if trial.first else r))
    answers.close()
    found = json.loads(command("analyse", "--json").output)
    scores = {name: row["all questions"]["score"] for name, row in found["scores"].items()}
    assert scores == {"anchor_system": 50, "better_system": 100, "worse_system": 25}
    table = command("analyse").output
    assert "better_system" in table and "100.0" in table
    assert "4 of 6 comparisons, by 4 people" in table


def test_errors_are_reported(command: Callable[..., Result], tmp_path: Path) -> None:
    for name in ("analyse", "serve"):
        failed = command(name)
        assert failed.exit_code != 0
        assert not (tmp_path / "study").exists()
