"""Changes of a document that look at nothing but its data: places, types and words."""

import copy
import random
from collections.abc import Callable
from typing import Any

from draft import VALUES, pick_place, places_of

ROOTS: tuple[tuple[str, Any], ...] = (
    ("variants", {"soft": {"bodies": {"ball": None}}}),
    ("variants", {"soft": {"bodies": {"nope": {"material": {"density": "x"}}}}}),
    ("sweeps", {"all": {"grid": {"params.speed": [1, 2, 3], "nowhere.at.all": []}}}),
    ("prefabs", {"p": {"params": {"a": {"kind": "length"}}, "body": {"kind": "rigid", "shape": "${a}"}}}),
    ("prefabs", {"p": {"body": {"use": "p"}}}),
    ("waive", {"overlap": "it is meant to be so"}),
    ("waive", {"nope": ""}),
    ("params", {"a": "${b}", "b": "${a}"}),
    ("params", {"a": "${[0] * 9999}", "b": "${a + a}", "c": "${b + b}"}),
)
"""Sections that are put in, or in the place of what is there."""


def _replace(document: Any, chance: random.Random) -> None:
    if found := pick_place(document, chance):
        found[0][found[1]] = copy.deepcopy(chance.choice(VALUES))


def _delete(document: Any, chance: random.Random) -> None:
    if found := pick_place(document, chance):
        del found[0][found[1]]


def _scale(document: Any, chance: random.Random) -> None:
    numbers = [(c, k) for c, k in places_of(document) if isinstance(c[k], int | float) and not isinstance(c[k], bool)]
    if numbers:
        container, key = chance.choice(numbers)
        if isinstance(container[key], int) and chance.random() < 0.5:
            container[key] += chance.choice((-1, 1, 10))
            return
        container[key] *= chance.choice((-1, 0, 1e-6, 0.01, 0.5, 2, 10, 100, 1e4, 1e8))


def _rename(document: Any, chance: random.Random) -> None:
    keys = [(c, k) for c, k in places_of(document) if isinstance(c, dict)]
    if keys:
        container, key = chance.choice(keys)
        value = container.pop(key)
        container[chance.choice((key[:-1], key + "s", key.upper(), "x", "kind", "use", "ball", "a b", "é", ""))] = value


def _transplant(document: Any, chance: random.Random) -> None:
    """Put a copy of one part in the place of another."""
    if (a := pick_place(document, chance)) and (b := pick_place(document, chance)):
        a[0][a[1]] = copy.deepcopy(b[0][b[1]])


def _sibling(document: Any, chance: random.Random) -> None:
    """Put a value in the place of another one of the same key: the right form, somewhere else."""
    places = [(c, k) for c, k in places_of(document) if isinstance(c, dict)]
    container, key = chance.choice(places)
    container[key] = copy.deepcopy(chance.choice([c[k] for c, k in places if k == key]))


def _section(document: Any, chance: random.Random) -> None:
    key, value = chance.choice(ROOTS)
    document[key] = copy.deepcopy(value)


def _word(document: Any, chance: random.Random) -> None:
    """Put one word of the document in the place of another: the right type, the wrong meaning."""
    words = [(c, k) for c, k in places_of(document) if isinstance(c[k], str)]
    if words:
        (a, i), (b, j) = chance.choice(words), chance.choice(words)
        a[i] = b[j]


GENTLE = (_scale, _scale, _scale, _sibling)
DATA: tuple[Callable[[Any, random.Random], None], ...] = (
    _replace, _replace, _replace, _delete, _scale, _scale, _rename, _transplant, _word, _word, _section,
)  # fmt: skip
