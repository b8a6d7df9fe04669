"""Documents that nobody should have written: cases with something changed in them, as text or as data."""

import copy
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 0.5, -0.0, 1e-9, 1e-30, 1e9, 1e300, -1e300, 10**25, 2**31, 99_999, 100_001,
    "", " ", "x", "on", "null", "nan", "inf", "-inf", "1e999", "0x10", "é" * 40, "a" * 5000, "\t", "'", '"', "{{ 7*7 }}",
    "../../../etc/passwd", "/etc/passwd", "assets/../../x.obj", "genesis:../../x", "file:///etc/passwd", "~/.ssh/id_rsa",
    "__import__('os').system('touch pwned')", "${__import__('os')}", "${().__class__}", "${1/0}", "${9**9**9}",
    "${i}", "${i * 0.1}", "${nowhere}", "${", "${}", "${[1,2,3]}", "${'a'}", "${rows}", "${rows * 1e300}", "brick[*]",
    "brick[999999]", "ball[3:1]", "ball.x", "floor", "world", "!!python/object/apply:os.system [ls]",
    [], [0], [0, 0], [0, 0, 0], [0, 0, 0, 0], [1e9, 0, 0], [0, 0, -1e3], [[0]], ["a", "b"], [None], [0] * 500,
    {}, {"kind": "box"}, {"kind": "sphere", "radius": 0.1}, {"kind": "nope"}, {"a": {"b": {"c": {}}}}, {"on": "floor"},
    {"inside": "ball"}, {"kind": "constant", "value": 1e12}, {"kind": "mesh", "file": "x.obj"}, {"use": "cup"},
    {"use": "nope", "with": {"x": 1}}, {"use": "table", "with": {"height": -1}}, {"kind": "net", "cells": [20, 20]},
    {"min": [0, 0, 0], "max": [1, 1, 1]}, {"kind": "ring", "count": 3, "radius": 1}, {"corner": ["left", "top"]},
)  # fmt: skip
"""What is put in the place of a value."""
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
PIECES = ("\n", "  ", "- ", ": ", "{", "}", "[", "]", "&a ", "*a ", "<<: ", "!!int ", "|\n", ">\n", "# ", "---\n", "...\n",
          "${", "}", '"', "'", "\t", "\u202e", "\ufeff", "\x00", "\ue000", "%YAML 1.1\n", "? ", "@", "`", "💥", "=")  # fmt: skip


def mutations(cases: Path, count: int, seed: int) -> list[tuple[str, bytes]]:
    """Make documents, always the same for one seed.

    Args:
        cases: The folder of good cases.
        count: How many.
        seed: Of the choice.

    Returns:
        Name of the case that it began as, and bytes, of each.
    """
    chance = random.Random(seed)
    originals = [(path.parent.name, path.read_text("utf-8")) for path in sorted(cases.glob("*/case.yaml"))]
    data = {name: parse_document(Source(text)).data for name, text in originals}
    made: list[tuple[str, bytes]] = []
    while len(made) < count:
        name, text = chance.choice(originals)
        if chance.random() < 0.3:
            made.append((name, _spoil_text(text, chance)))
            continue
        document = copy.deepcopy(data[name])
        # Half of them stay near to what a case is: only those get past the first checks.
        gentle = chance.random() < 0.6
        for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
            chance.choice(_GENTLE if gentle else _DATA)(document, chance)
        try:
            made.append((name, dump_case(document).encode("utf-8", "surrogatepass")))
        except (ValueError, RecursionError):
            continue  # not a document at all
    return made


def _spoil_text(text: str, chance: random.Random) -> bytes:
    data = text
    for _ in range(chance.choice((1, 1, 2, 5))):
        at, other = sorted(chance.randrange(len(data) + 1) for _ in range(2))
        kind = chance.randrange(6)
        if kind == 0:
            data = data[:at] + chance.choice(PIECES) + data[at:]
        elif kind == 1:
            data = data[:at] + data[min(other, at + 40) :]
        elif kind == 2:
            data = data[:at] + data[at : min(other, at + 200)] * 2 + data[at:]
        elif kind == 3:
            lines = data.split("\n")
            i, j = (chance.randrange(len(lines)) for _ in range(2))
            lines[i], lines[j] = lines[j], lines[i]
            data = "\n".join(lines)
        elif kind == 4:
            lines = data.split("\n")
            i = chance.randrange(len(lines))
            lines[i] = " " * chance.randrange(9) + lines[i].lstrip()
            data = "\n".join(lines)
        else:
            data = data[:at] + chance.choice("0123456789.e-") + data[at + 1 :]
        data = data or " "
    spoiled = data.encode("utf-8")
    if chance.random() < 0.1:
        at = chance.randrange(len(spoiled))
        spoiled = spoiled[:at] + bytes([chance.randrange(256)]) + spoiled[at + 1 :]
    return spoiled


# --- changes of data -------------------------------------------------------------------------------------


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a document."""
    found, stack = [], [value]
    while stack:
        container = stack.pop()
        rows = container.items() if isinstance(container, dict) else enumerate(container)
        for key, item in rows:
            found.append((container, key))
            if isinstance(item, dict | list):
                stack.append(item)
    return found


def _pick(document: Any, chance: random.Random) -> tuple[Any, Any] | None:
    places = _places(document)
    return chance.choice(places) if places else None


def _replace(document: Any, chance: random.Random) -> None:
    if found := _pick(document, chance):
        found[0][found[1]] = copy.deepcopy(chance.choice(VALUES))


def _delete(document: Any, chance: random.Random) -> None:
    if found := _pick(document, chance):
        del found[0][found[1]]


def _scale(document: Any, chance: random.Random) -> None:
    numbers = [(c, k) for c, k in _places(document) if isinstance(c[k], int | float) and not isinstance(c[k], bool)]
    if numbers:
        container, key = chance.choice(numbers)
        if isinstance(container[key], int) and chance.random() < 0.5:
            container[key] += chance.choice((-1, 1, 10))
            return
        container[key] *= chance.choice((-1, 0, 1e-6, 0.01, 0.5, 2, 10, 100, 1e4, 1e8))


def _rename(document: Any, chance: random.Random) -> None:
    keys = [(c, k) for c, k in _places(document) if isinstance(c, dict)]
    if keys:
        container, key = chance.choice(keys)
        value = container.pop(key)
        container[chance.choice((key[:-1], key + "s", key.upper(), "x", "kind", "use", "ball", "a b", "é", ""))] = value


def _transplant(document: Any, chance: random.Random) -> None:
    """Put a copy of one part in the place of another."""
    if (a := _pick(document, chance)) and (b := _pick(document, chance)):
        a[0][a[1]] = copy.deepcopy(b[0][b[1]])


def _sibling(document: Any, chance: random.Random) -> None:
    """Put a value in the place of another one of the same key: the right form, somewhere else."""
    places = [(c, k) for c, k in _places(document) if isinstance(c, dict)]
    container, key = chance.choice(places)
    container[key] = copy.deepcopy(chance.choice([c[k] for c, k in places if k == key]))


def _section(document: Any, chance: random.Random) -> None:
    key, value = chance.choice(ROOTS)
    document[key] = copy.deepcopy(value)


def _word(document: Any, chance: random.Random) -> None:
    """Put one word of the document in the place of another: the right type, the wrong meaning."""
    words = [(c, k) for c, k in _places(document) if isinstance(c[k], str)]
    if words:
        (a, i), (b, j) = chance.choice(words), chance.choice(words)
        a[i] = b[j]


_GENTLE = (_scale, _scale, _scale, _sibling)
_DATA: tuple[Callable[[Any, random.Random], None], ...] = (
    _replace, _replace, _replace, _delete, _scale, _scale, _rename, _transplant, _word, _word, _section,
)  # fmt: skip
