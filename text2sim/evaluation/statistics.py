"""Statistics of judgements: means, scatter, differences between methods, agreement of judges."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from text2sim.evaluation.judging import Judgement, Kind

CONFIDENCE = 0.95
RESAMPLES = 9999
SEED = 16
"""Seed of the bootstrap: equal judgements give equal intervals."""

Key = tuple[str, str]
"""Method and prompt."""


@dataclass(frozen=True)
class Estimate:
    """A mean over cases with its interval."""

    mean: float
    low: float
    high: float
    """Ends of the 95 % bootstrap interval (percentiles); equal to the mean if there is only one case."""
    count: int
    """Number of cases."""


@dataclass(frozen=True)
class RaterAgreement:
    """Agreement of pairs of judgements, each pair of the same result."""

    pairs: int
    marks: float | None
    """Fraction of the requirements with equal marks; None for visual judgements."""
    difference: float
    """Mean difference of totals, second minus first; 0 between repeats, which have no order."""
    distance: float
    """Mean absolute difference of totals."""
    correlation: float | None
    """Pearson correlation of totals; None if either does not vary."""


def case_scores(rows: Iterable[Judgement], kind: Kind) -> dict[Key, float]:
    """Return the score of each case: the mean of its judgements; cases without one are omitted."""
    return part_scores(_counted(rows, kind), _total)


def spread_within(rows: Iterable[Judgement], kind: Kind, method: str) -> float | None:
    r"""Return the RMS standard deviation within cases, \sqrt{mean_i s_i^2}, with the sample variance s_i^2 of repeats.

    A case here is a prompt with one judge. Cases with a single repeat are ignored; None if there are no others.

    Args:
        rows: The judgements.
        kind: Which judgements: `physical` or `visual`.
        method: Name of the method.
    """
    found: dict[tuple[str, int], list[float]] = defaultdict(list)
    for row in _counted(rows, kind):
        if row.turn.method == method:
            found[row.turn.prompt, row.turn.judge].append(_total(row))
    variances = [np.var(values, ddof=1) for values in found.values() if len(values) > 1]
    return float(np.sqrt(np.mean(variances))) if variances else None


def estimate(values: Sequence[float]) -> Estimate | None:
    """Return the mean over cases with its bootstrap interval; None without cases."""
    if not values:
        return None
    mean = float(np.mean(values))
    if len(values) < 2 or np.ptp(values) == 0:
        return Estimate(mean, mean, mean, len(values))
    from scipy.stats import bootstrap

    found = bootstrap(
        (np.asarray(values, float),), np.mean, confidence_level=CONFIDENCE, n_resamples=RESAMPLES, method="percentile",
        rng=np.random.default_rng(SEED),
    )  # fmt: skip
    interval = found.confidence_interval
    return Estimate(mean, float(interval.low), float(interval.high), len(values))


def paired_difference(scores: Mapping[Key, float], method: str, other: str) -> Estimate | None:
    """Return the mean difference, `method` minus `other`, over the prompts on which both were judged.

    Args:
        scores: Scores by method and prompt.
        method: Name of the first method.
        other: Name of the second method.
    """
    mine = {prompt: score for (name, prompt), score in scores.items() if name == method}
    theirs = {prompt: score for (name, prompt), score in scores.items() if name == other}
    return estimate([mine[prompt] - theirs[prompt] for prompt in mine if prompt in theirs])


def repeats_agree(rows: Iterable[Judgement], kind: Kind) -> RaterAgreement | None:
    """Return the agreement of repeats of the same judge, over all pairs of repeats of a case."""
    groups: dict[Any, list[Judgement]] = defaultdict(list)
    for row in _judgements_of(rows, kind):
        groups[row.turn.method, row.turn.prompt, row.turn.judge].append(row)
    pairs = [pair for group in groups.values() for pair in combinations(group, 2)]
    return _agreement(pairs, ordered=False)


def judges_agree(rows: Iterable[Judgement], kind: Kind, one: int, other: int) -> RaterAgreement | None:
    """Return the agreement of two judges, repeat by repeat.

    Args:
        rows: The judgements.
        kind: Which judgements: `physical` or `visual`.
        one: Number of a judge.
        other: Number of another judge.
    """
    found = {
        (row.turn.method, row.turn.prompt, row.turn.repeat, row.turn.judge): row for row in _judgements_of(rows, kind)
    }
    pairs = [
        (row, found[*key[:3], other]) for key, row in found.items() if key[3] == one and (*key[:3], other) in found
    ]
    return _agreement(pairs, ordered=True)


def part_scores(rows: Iterable[Judgement], part: Callable[[Judgement], float | None]) -> dict[Key, float]:
    """Return the mean of a part of the score for each case; 0 if there was nothing to judge.

    Args:
        rows: The judgements.
        part: Returns the part of one judgement; None excludes the judgement.
    """
    found: dict[Key, list[float]] = defaultdict(list)
    for row in rows:
        if (value := 0.0 if row.state == "nothing" else part(row)) is not None:
            found[row.turn.method, row.turn.prompt].append(value)
    return {key: float(np.mean(values)) for key, values in found.items()}


def _agreement(pairs: Sequence[tuple[Judgement, Judgement]], *, ordered: bool) -> RaterAgreement | None:
    if not pairs:
        return None
    first, second = (np.array([_total(pair[k]) for pair in pairs]) for k in (0, 1))
    same = [mark["mark"] == other["mark"] for a, b in pairs for mark, other in zip(_marks(a), _marks(b), strict=False)]
    both = (np.concatenate([first, second]), np.concatenate([second, first])) if not ordered else (first, second)
    varies = all(np.ptp(values) > 0 for values in both)
    correlation = float(np.corrcoef(*both)[0, 1]) if varies else None
    difference = float((second - first).mean()) if ordered else 0.0
    distance = float(np.abs(second - first).mean())
    return RaterAgreement(len(pairs), float(np.mean(same)) if same else None, difference, distance, correlation)


def _marks(row: Judgement) -> list[Any]:
    """Marks of a judgement, sorted by name."""
    return [mark for _, mark in sorted(((row.reply or {}).get("requirements") or {}).items())]


def _counted(rows: Iterable[Judgement], kind: Kind) -> list[Judgement]:
    return [row for row in rows if row.turn.kind == kind and row.total is not None]


def _judgements_of(rows: Iterable[Judgement], kind: Kind) -> list[Judgement]:
    return [row for row in _counted(rows, kind) if row.state == "judged"]


def _total(row: Judgement) -> float:
    assert row.total is not None
    return row.total
