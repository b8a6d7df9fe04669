"""Scores of methods from the answers of participants.

An answer r from -2 to 2 says how much better the method's film is than the anchor's. The mean over the ratings of a
task, then over tasks, gives 50 + 25 r; the anchor has 50. "Cannot judge" is excluded.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from text2sim.evaluation.statistics import estimate
from text2sim.study.answers import StudyAnswer
from text2sim.study.build import Study

OVERALL = "all questions"


def analyse(study: Study, answers: Sequence[StudyAnswer]) -> dict[str, Any]:
    """Return scores, agreement and counts of answers, also of people who have not finished, as plain data."""
    ratings = defaultdict[tuple[str, str, str], list[int]](list)
    left, abstained = list[int](), 0
    for answer in answers:
        trial = study.assignments[answer.assignment][answer.trial]
        if answer.level is None:
            abstained += 1
            continue
        left.append(-answer.level)
        ratings[trial.method, answer.question, trial.task].append(-answer.level if trial.first else answer.level)
    scores = {study.anchor: dict.fromkeys([*study.questions, OVERALL], {"score": 50.0})}
    for method in study.methods:
        by_task = {
            question: {
                task: float(np.mean(rows))
                for (who, what, task), rows in ratings.items()
                if (who, what) == (method, question)
            }
            for question in study.questions
        }
        together = {
            task: float(np.mean([rows[task] for rows in by_task.values() if task in rows]))
            for task in dict.fromkeys(task for rows in by_task.values() for task in rows)
        }
        scores[method] = {name: _score(list(rows.values())) for name, rows in {**by_task, OVERALL: together}.items()}
    groups = {q: [rows for (_, what, _), rows in ratings.items() if what == q] for q in study.questions}
    trials = {(answer.person, answer.trial) for answer in answers}
    return {
        "people": len({answer.person for answer in answers}),
        "comparisons": len(trials),
        "planned": sum(map(len, study.assignments)),
        "answers": len(answers),
        "cannot_judge": abstained,
        "scores": scores,
        "agreement": {question: krippendorff_alpha(rows) for question, rows in groups.items()},
        "preference_for_a": float(np.mean(left)) if left else None,
        "left_out": study.left_out,
    }


def _score(means: Sequence[float]) -> dict[str, Any]:
    """50 + 25 r over tasks, with the same bootstrap interval as in the tables of `evaluation`."""
    found = estimate([50 + 25 * r for r in means])
    if found is None:
        return {"score": None, "tasks": 0}
    interval = {"low": found.low, "high": found.high} if found.count > 1 else {}
    return {"score": found.mean, "tasks": found.count, **interval}


def krippendorff_alpha(groups: Sequence[Sequence[float]]) -> float | None:
    """Return Krippendorff's alpha for interval data: 1 is full agreement, 0 is chance; None if it is undefined.

    alpha = 1 - D_o / D_e. For squared differences, D_o is the mean of the variances within units, weighted by their
    numbers of ratings, and D_e the variance of all ratings (K. Krippendorff, Content Analysis, 2nd ed. 2004, 11.3).

    Args:
        groups: Ratings of each unit by different people; units with a single rating are ignored.
    """
    groups = [rows for rows in groups if len(rows) > 1]
    everything = np.concatenate(groups) if groups else np.zeros(0)
    if not len(everything) or (expected := everything.var(ddof=1)) == 0:
        return None
    observed = sum(len(rows) * np.var(rows, ddof=1) for rows in groups) / len(everything)
    return float(1 - observed / expected)
