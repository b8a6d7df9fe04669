"""Assignments: comparisons of methods with an anchor, dealt to participants."""

import random
from collections.abc import Mapping, Sequence
from math import ceil

from text2sim.spec_schema.models.base import Model

RATINGS = 3
"""Number of times that each pair of films is compared, by different people."""
COMPARISONS = 15
"""Largest number of comparisons in an assignment."""


class Trial(Model):
    """One comparison: the films of a method and the anchor, made from the same prompt."""

    task: str
    method: str
    first: bool
    """Whether the method's film is A."""


def assignments(pairs: Mapping[str, Sequence[str]], seed: int) -> list[list[Trial]]:
    """Deal all comparisons to assignments.

    No assignment has two comparisons of one task, and the lengths of assignments differ by one at most. The first side
    of a pair is random, and sides alternate over its ratings. The order within an assignment is random.

    Args:
        pairs: Methods that are compared with the anchor, by task.
        seed: Seed of the random numbers.
    """
    chance = random.Random(seed)
    most = RATINGS * max(map(len, pairs.values()), default=0)
    total = RATINGS * sum(map(len, pairs.values()))
    dealt: list[list[Trial]] = [[] for _ in range(max(most, ceil(total / COMPARISONS)))]
    for task in chance.sample(sorted(pairs), len(pairs)):
        trials = []
        for method in pairs[task]:
            start = chance.randrange(2)
            trials += [Trial(task=task, method=method, first=(start + rating) % 2 == 0) for rating in range(RATINGS)]
        # The shortest assignments get one each, so that lengths stay balanced.
        takers = sorted(dealt, key=lambda trials: (len(trials), chance.random()))
        for taker, trial in zip(takers, chance.sample(trials, len(trials)), strict=False):
            taker.append(trial)
    for trials in dealt:
        chance.shuffle(trials)
    return dealt
