"""Means, scatter, differences and agreement, against values worked out by hand."""

from math import sqrt
from typing import Any

import pytest

from text2sim.evaluation.judging import Judgement, Turn
from text2sim.evaluation.statistics import (
    case_scores,
    estimate,
    judges_agree,
    paired_difference,
    repeats_agree,
    spread_within,
)


def judged(method: str, prompt: str, *totals: float | None, judge: int = 1, marks: str = "1") -> list[Judgement]:
    """Repeats of a judgement; `marks` are those of its requirements, one after the other."""
    rows = []
    for repeat, total in enumerate(totals, 1):
        reply: Any = {"requirements": {f"r{k}": {"mark": float(m)} for k, m in enumerate(marks.split())}}
        state = "judged" if total is not None else "not_judged"
        rows.append(Judgement(Turn(prompt, method, "physical", judge, repeat), "", state, total, reply=reply))  # type: ignore[arg-type]
    return rows


ROWS = [
    *judged("a", "one", 80, 90, 100), *judged("a", "two", 60, 60, 60), *judged("a", "three", 50, None, 40),
    *judged("b", "one", 70, 70, 70), *judged("b", "two", 65, 55, 60),
]  # fmt: skip


def test_a_case_is_the_mean_of_its_judgements_without_missing_ones() -> None:
    assert case_scores(ROWS, "physical")["a", "one"] == 90
    assert case_scores(ROWS, "physical")["a", "three"] == 45
    assert case_scores(ROWS, "visual") == {}


def test_scatter_is_the_root_of_the_mean_variance_within_cases() -> None:
    assert spread_within(ROWS, "physical", "a") == pytest.approx(sqrt((100 + 0 + 50) / 3))
    assert spread_within(judged("a", "one", 50), "physical", "a") is None


def test_differences_are_of_the_same_prompts_alone() -> None:
    found = paired_difference(case_scores(ROWS, "physical"), "a", "b")
    assert found is not None
    assert (found.mean, found.count) == (10, 2)
    assert (found.low, found.high) == (0, 20), "two cases: the interval reaches from one to the other"
    assert paired_difference(case_scores(ROWS, "physical"), "a", "c") is None


def test_intervals_are_those_of_the_bootstrap_and_the_same_every_time() -> None:
    values = [float(x) for x in range(40, 100, 3)]
    found = estimate(values)
    assert found is not None
    error = sqrt(sum((x - found.mean) ** 2 for x in values) / len(values) / len(values))
    assert found.low == pytest.approx(found.mean - 1.96 * error, abs=0.15 * error)
    assert found.high == pytest.approx(found.mean + 1.96 * error, abs=0.15 * error)
    assert estimate(values) == found
    one = estimate([7.0])
    assert one is not None
    assert (one.mean, one.low, one.high) == (7, 7, 7)
    assert estimate([]) is None


def test_repeats_agree_in_marks_and_totals() -> None:
    rows = [*judged("a", "one", 80, marks="1 0.5 0"), *judged("a", "one", 70, marks="1 1 0")[:1]]
    rows[1] = Judgement(Turn("one", "a", "physical", 1, 2), "", "judged", 70, reply=rows[1].reply)
    found = repeats_agree(rows, "physical")
    assert found is not None
    assert (found.pairs, found.marks, found.difference, found.distance) == (1, pytest.approx(2 / 3), 0, 10)
    assert repeats_agree(judged("a", "one", 80), "physical") is None


def test_judges_are_compared_repeat_by_repeat() -> None:
    first = [*judged("a", "one", 80, 90), *judged("a", "two", 50, 40)]
    second = [*judged("a", "one", 70, 84, judge=2), *judged("a", "two", 50, None, judge=2)]
    found = judges_agree([*first, *second], "physical", 1, 2)
    assert found is not None
    assert (found.pairs, found.difference, found.distance) == (3, pytest.approx(-16 / 3), pytest.approx(16 / 3))
    assert found.correlation == pytest.approx(700 / sqrt(2600 / 3 * 584))
    assert judges_agree(first, "physical", 1, 2) is None
