"""Scores of panels with known preferences."""

from pathlib import Path

import numpy as np
import pytest

from text2sim.spec_schema.errors import RunError
from text2sim.study.analyse import OVERALL, analyse, krippendorff_alpha
from text2sim.study.answers import FILE, Answers, StudyAnswer
from text2sim.study.build import QUESTIONS, Study
from text2sim.study.plan import assignments

QUESTION = next(iter(QUESTIONS))
TRUE = {"better": 1.0, "worse": -0.6, "like": 0.0}


def planned(tasks: int) -> Study:
    pairs = {f"task_{k}": list(TRUE) for k in range(tasks)}
    return Study(
        seed=0, anchor="old", methods=list(TRUE), prompts=dict.fromkeys(pairs, "A ball falls."),
        films={task: {name: 0 for name in [*TRUE, "old"]} for task in pairs}, assignments=assignments(pairs, 0),
    )  # fmt: skip


def panel(folder: Path, study: Study, answer) -> Answers:
    """Have everybody answer all; `answer` returns r, towards the method, or None."""
    answers = Answers(folder, study)
    while (person := answers.begin()) is not None:
        assignment, _ = answers.position(person)
        for number, trial in enumerate(study.assignments[assignment]):
            levels = {name: answer(trial, name) for name in study.questions}
            towards_b = {name: r if r is None or not trial.first else -r for name, r in levels.items()}
            answers.give(person, number, towards_b)
    return answers


def test_a_panel_that_agrees_comes_out_exactly(tmp_path: Path) -> None:
    study = planned(10)
    known = {"better": 2, "worse": -1, "like": 0}
    found = analyse(study, panel(tmp_path, study, lambda trial, question: known[trial.method]).all())
    for method, r in known.items():
        assert {row["score"] for row in found["scores"][method].values()} == {50 + 25 * r}
    assert found["scores"]["old"][OVERALL]["score"] == 50
    assert set(found["agreement"].values()) == {1.0}
    assert found["comparisons"] == found["planned"] == 90
    assert found["cannot_judge"] == 0


def test_a_panel_with_tastes_and_doubts_comes_out_within_its_intervals(tmp_path: Path) -> None:
    chance, study = np.random.default_rng(4), planned(42)
    quality = {(task, method): r + chance.normal(0, 0.4) for task in study.prompts for method, r in TRUE.items()}

    def answer(trial, question: str) -> int | None:
        if chance.random() < 0.1:
            return None
        return int(np.clip(round(quality[trial.task, trial.method] + chance.normal(0, 0.5)), -2, 2))

    found = analyse(study, panel(tmp_path, study, answer).all())
    for method, r in TRUE.items():
        row = found["scores"][method][OVERALL]
        assert row["low"] < 50 + 25 * r < row["high"]
        assert row["high"] - row["low"] < 12
    assert all(0.4 < value < 0.9 for value in found["agreement"].values())
    assert abs(found["preference_for_a"]) < 0.1
    assert found["cannot_judge"] == pytest.approx(0.1 * found["answers"], rel=0.15)


def test_ratings_count_within_a_task_before_tasks_count() -> None:
    """A task with one rating weighs as much as one with three; who cannot judge weighs nothing."""
    study, answers = planned(2), []
    for k, trials in enumerate(study.assignments):
        for number, trial in enumerate(trials):
            if trial.method == "better":
                r = {"task_0": 2, "task_1": 0}[trial.task]
                known = trial.task == "task_1" or not answers or answers[-1].level is None
                level = (-r if trial.first else r) if known else None
                answers.append(StudyAnswer(str(k), k, number, "physics", level))
    assert sum(one.level is None for one in answers) in (1, 2)
    found = analyse(study, answers)
    assert found["scores"]["better"]["physics"]["score"] == 75.0
    assert found["cannot_judge"] == sum(one.level is None for one in answers)
    assert found["scores"]["worse"]["physics"] == {"score": None, "tasks": 0}


def test_agreement_is_krippendorffs_alpha() -> None:
    """The value of his example for interval data, Computing Krippendorff's Alpha-Reliability (2011), part D."""
    none = None
    coders = [
        [1, 2, 3, 3, 2, 1, 4, 1, 2, none, none, none],
        [1, 2, 3, 3, 2, 2, 4, 1, 2, 5, none, 3],
        [none, 3, 3, 3, 2, 3, 4, 2, 2, 5, 1, none],
        [1, 2, 3, 3, 2, 4, 4, 1, 2, 5, 1, none],
    ]
    groups = [[r for r in unit if r is not None] for unit in zip(*coders, strict=True)]
    assert krippendorff_alpha(groups) == pytest.approx(0.849, abs=5e-4)
    assert krippendorff_alpha([[1], [2]]) is None
    assert krippendorff_alpha([[1, 1], [1, 1]]) is None


def test_an_assignment_that_was_left_goes_to_another(tmp_path: Path) -> None:
    study = planned(10)
    answers = Answers(tmp_path, study)
    people = [answers.begin() for _ in study.assignments]
    assert sorted(answers.position(person)[0] for person in people) == list(range(len(study.assignments)))
    for person in people[1:]:
        for number in range(len(study.assignments[answers.position(person)[0]])):
            answers.give(person, number, dict.fromkeys(QUESTIONS, 0))
    assert answers.position(answers.begin())[0] == answers.position(people[0])[0]
    assert answers.position("nobody") is None


def test_answers_that_cannot_be_are_refused(tmp_path: Path) -> None:
    study = planned(10)
    answers = Answers(tmp_path, study)
    person = answers.begin()
    assert person is not None
    for number, levels in ((15, {QUESTION: 1}), (0, {"taste": 1}), (0, {QUESTION: 7})):
        answers.give(person, number, levels)
        with pytest.raises(RunError, match="that no participant of this study can give"):
            answers.all()
        answers._base.execute("DELETE FROM answer")
    answers.close()
    (tmp_path / FILE).write_bytes(b"no database, but more than a few bytes of something else" * 20)
    with pytest.raises(RunError, match="answers cannot be kept in it"):
        Answers(tmp_path, study)
