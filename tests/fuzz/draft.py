"""A document that nobody should have written, and ways into it."""

import copy
import random
from dataclasses import dataclass, field
from typing import Any

from hostile import Content

from text2sim.spec_schema.reuse.overlay import CaseOverlay

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
PIECES = ("\n", "  ", "- ", ": ", "{", "}", "[", "]", "&a ", "*a ", "<<: ", "!!int ", "|\n", ">\n", "# ", "---\n", "...\n",
          "${", "}", '"', "'", "\t", "\u202e", "\ufeff", "\x00", "\ue000", "%YAML 1.1\n", "? ", "@", "`", "💥", "=")  # fmt: skip


@dataclass
class Draft:
    """A document, with what comes with it."""

    case: str
    """The case as which it began."""
    text: bytes = b""
    data: Any = None
    files: dict[str, Content] = field(default_factory=dict)
    """Other files of its folder."""
    overlay: CaseOverlay = field(default_factory=CaseOverlay)
    operations: list[dict[str, Any]] = field(default_factory=list)
    """A patch."""


def places_of(value: Any) -> list[tuple[Any, Any]]:
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


def pick_place(document: Any, chance: random.Random) -> tuple[Any, Any] | None:
    places = places_of(document)
    return chance.choice(places) if places else None


def way_into(data: Any, chance: random.Random) -> tuple[list[Any], Any]:
    """Return a way into data, and what is there."""
    steps: list[Any] = []
    while isinstance(data, dict | list) and data and (not steps or chance.random() < 0.85):
        key = chance.choice(list(data)) if isinstance(data, dict) else chance.randrange(len(data))
        steps.append(key)
        data = data[key]
    return steps, data


def changed_value(found: Any, chance: random.Random) -> Any:
    if isinstance(found, int | float) and chance.random() < 0.7:
        return found * chance.choice((2, 0.5, 1.1))
    return copy.deepcopy(chance.choice(VALUES) if chance.random() < 0.7 else found)
