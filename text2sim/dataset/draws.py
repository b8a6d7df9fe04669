"""Random draws, each with its own seed, so that the n-th does not depend on those before it."""

import json
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

import numpy as np

from text2sim.dataset.recipe import Draw, parse_path
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.reuse.overlay import CaseOverlay

DIGITS = 9
"""Significant digits of a drawn number: the written value is the value that is used."""
Values = dict[str, Any]
"""Drawn values by dotted path."""


def generator(*key: object) -> np.random.Generator:
    """Return a generator that depends only on these words and numbers."""
    return np.random.default_rng(list(sha256(json.dumps(key).encode()).digest()))


def draw(table: Mapping[str, Draw], rng: np.random.Generator, case: Any) -> Values:
    """Draw a value for every path.

    Args:
        table: Distributions by path.
        rng: Source of randomness.
        case: The case's data with expressions evaluated, for draws relative to its values.

    Raises:
        RunError: if a relative draw finds no number in the case.
    """
    return {dotted(parse_path(path)): _value(distribution, rng, case, path) for path, distribution in table.items()}


def _value(distribution: Draw, rng: np.random.Generator, case: Any, path: str) -> Any:
    if distribution.choice is not None:
        return distribution.choice[int(rng.integers(len(distribution.choice)))]
    if distribution.integer is not None:
        return int(rng.integers(distribution.integer[0], distribution.integer[1], endpoint=True))
    if distribution.log_uniform is not None:
        return _rounded(np.exp(rng.uniform(*np.log(distribution.log_uniform))))
    if distribution.normal is not None:
        return _rounded(rng.normal(*distribution.normal))
    if distribution.uniform is not None:
        return _rounded(rng.uniform(*distribution.uniform))
    given = number_at(case, path)
    if distribution.times is not None:
        return _rounded(given * rng.uniform(*distribution.times))
    assert distribution.plus is not None
    return _rounded(given + rng.uniform(*distribution.plus))


def number_at(case: Any, path: str) -> float:
    """Return the number at a path of a case.

    Raises:
        RunError: if there is none.
    """
    found = case
    for step in parse_path(path):
        try:
            found = found[step]
        except (KeyError, IndexError, TypeError):
            raise RunError(f"{path}: the case has no value there for `times` or `plus` to change") from None
    if isinstance(found, bool) or not isinstance(found, int | float):
        raise RunError(f"{path}: `times` and `plus` need a number, and the case has {json.dumps(found)[:60]} there")
    return float(found)


def overlay_of(values: Values) -> CaseOverlay:
    """Return drawn values as an overlay of a case."""
    return CaseOverlay(sets=tuple(f"{path}={json.dumps(value)}" for path, value in values.items()))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
