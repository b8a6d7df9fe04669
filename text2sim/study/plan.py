"""Who compares what: pairs with an anchor, dealt to assignments; a seed decides order and sides."""

import random
from collections.abc import Mapping, Sequence
from math import ceil

from text2sim.spec_schema.models.base import Model

RATINGS = 3
"""Times that each pair of films is compared, by different people."""
COMPARISONS = 15
"""Comparisons of an assignment at most."""


class Trial(Model):
    """One comparison: the film of a method and that of the anchor, made from one prompt."""

    task: str
    method: str
    first: bool
    """Whether the method's film is A."""


def assignments(pairs: Mapping[str, Sequence[str]], seed: int) -> list[list[Trial]]:
    """Deal all comparisons.

    No assignment has two comparisons of one task, and none has more than one comparison more than another. The sides of
    a pair alternate over its ratings, from a side that chance has chosen; so does chance the order of each assignment.

    Args:
        pairs: Methods that are compared with the anchor, by task.
        seed: What chance starts from.
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
        # Those that have least get one each, so that they stay equally long.
        takers = sorted(dealt, key=lambda trials: (len(trials), chance.random()))
        for taker, trial in zip(takers, chance.sample(trials, len(trials)), strict=False):
            taker.append(trial)
    for trials in dealt:
        chance.shuffle(trials)
    return dealt
