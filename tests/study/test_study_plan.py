"""Assignments of comparisons."""

from collections import Counter, defaultdict

import pytest

from text2sim.study.plan import COMPARISONS, RATINGS, assignments

PAPER = {f"task_{k}": ["a", "b", "c", "d", "e"] for k in range(42)}
UNEVEN = {f"task_{k}": ["a", "b"][: 1 + k % 2] for k in range(9)}


@pytest.mark.parametrize("pairs", [PAPER, UNEVEN, {"one": ["a", "b"]}])
@pytest.mark.parametrize("seed", [0, 1])
def test_every_pair_is_rated_three_times_by_different_people(pairs: dict[str, list[str]], seed: int) -> None:
    dealt = assignments(pairs, seed)
    count = Counter((trial.task, trial.method) for trials in dealt for trial in trials)
    assert count == {(task, method): RATINGS for task, methods in pairs.items() for method in methods}
    sizes = {len(trials) for trials in dealt}
    assert max(sizes) <= COMPARISONS
    assert max(sizes) - min(sizes) <= 1
    assert all(len({trial.task for trial in trials}) == len(trials) for trials in dealt)


def test_forty_two_tasks_and_five_pairs_are_forty_two_assignments_of_fifteen() -> None:
    assert [len(trials) for trials in assignments(PAPER, 7)] == [15] * 42


def test_sides_alternate_over_the_ratings_of_a_pair() -> None:
    sides = defaultdict[tuple[str, str], list[bool]](list)
    for trials in assignments(PAPER, 0):
        for trial in trials:
            sides[trial.task, trial.method].append(trial.first)
    firsts = Counter(sum(rows) for rows in sides.values())
    assert set(firsts) == {1, 2}, "of three, the method is A once or twice"
    assert abs(firsts[1] - firsts[2]) < 50, "chance decides which"


def test_a_seed_decides_everything() -> None:
    assert assignments(PAPER, 5) == assignments(PAPER, 5)
    assert assignments(PAPER, 5) != assignments(PAPER, 6)
    orders = {tuple(trial.task for trial in trials) for trials in assignments(PAPER, 5)}
    assert len(orders) == 42
