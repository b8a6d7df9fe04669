"""Entries that are called otherwise in another version of a case."""

import json
from collections import Counter
from collections.abc import Iterator
from difflib import SequenceMatcher
from typing import Any

from text2sim.spec_schema.changes.naming import Rename, follow
from text2sim.spec_schema.text.document import Path

STAGES: tuple[tuple[Path, ...], ...] = (
    (("params",), ("prefabs",)),
    (("scene", "statics"), ("bodies",)),
    (("actions", "controls"), ("actions", "measures")),
    (("actions", "events"),),
    (("actions", "expect"), ("render", "cameras"), ("render", "lights"), ("variants",)),
    (("render", "shots"),),
    (("sweeps",),),
)
"""Mappings from names, after those whose names they mention."""
NESTED = ("links", "loops", "parts")
ALIKE = 0.6
"""Share of what two entries say that must be equal for one to be the other."""
FEW = 4
"""Entries that say less than this must be equal altogether."""
MAX_PAIRS = 2500
MAX_WORK = 200_000
"""Where there is more to compare, entries are told apart by their names."""


def find_renames(a: Any, b: Any) -> list[Rename]:
    """Entries of `a` that `b` has under another name, with the same content or nearly so.

    They are given in an order in which each can be renamed after those before it, with `follow`.
    """
    found: list[Rename] = []
    for stage in STAGES:
        fresh = [rename for path in stage for rename in _matches(_mapping(a, path), _mapping(b, path), path)]
        if fresh:
            found += fresh
            a = follow(a, fresh)[0]
    for path in list(_nested(a, b, ())):
        fresh = list(_matches(_mapping(a, path), _mapping(b, path), path))
        if fresh:
            found += fresh
            a = follow(a, fresh)[0]
    return found


def _matches(a: dict[str, Any], b: dict[str, Any], path: Path) -> Iterator[Rename]:
    gone = {name: value for name, value in a.items() if name not in b}
    come = {name: value for name, value in b.items() if name not in a}
    if not gone or not come or len(gone) * len(come) > MAX_PAIRS:
        return
    said_a = {name: _said(value) for name, value in gone.items()}
    said_b = {name: _said(value) for name, value in come.items()}
    if sum(min(before.total(), after.total()) for before in said_a.values() for after in said_b.values()) > MAX_WORK:
        return
    scores = []
    for old, before in said_a.items():
        for new, after in said_b.items():
            share = _share(before, after)
            if _kind(gone[old]) != _kind(come[new]) or share < (ALIKE if before.total() >= FEW else 1.0):
                continue
            if not isinstance(gone[old], dict) and _ambiguous(gone[old], gone, come):
                continue
            scores.append((-share, -SequenceMatcher(None, old, new).ratio(), len(scores), old, new))
    used: set[str] = set()
    for _, _, _, old, new in sorted(scores):
        if old not in used and new not in used:
            used |= {old, new}
            yield Rename(path, old, new)


def _ambiguous(value: Any, gone: dict[str, Any], come: dict[str, Any]) -> bool:
    """Whether a bare value, which says little about who it is, occurs more than once."""
    return list(gone.values()).count(value) > 1 or list(come.values()).count(value) > 1


def _said(value: Any) -> Counter[str]:
    """What an entry says: its scalars, each with the way to it."""
    said: Counter[str] = Counter()
    stack: list[tuple[str, Any]] = [("", value)]
    while stack:
        path, item = stack.pop()
        if isinstance(item, dict) and item:
            stack += [(f"{path}/{key}", inner) for key, inner in item.items()]
        elif isinstance(item, list) and item:
            stack += [(f"{path}/{index}", inner) for index, inner in enumerate(item)]
        else:
            said[f"{path} {json.dumps(float(item) if type(item) is int else item)}"] += 1
    return said


def _share(a: Counter[str], b: Counter[str]) -> float:
    return 2 * (a & b).total() / (a.total() + b.total())


def _kind(value: Any) -> Any:
    return value.get("kind") if isinstance(value, dict) else None


def _mapping(data: Any, path: Path) -> dict[str, Any]:
    for step in path:
        if isinstance(data, dict) and step in data:
            data = data[step]
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            data = data[step]
        else:
            return {}
    return data if isinstance(data, dict) else {}


def _nested(a: Any, b: Any, path: Path) -> Iterator[Path]:
    """Mappings from names inside bodies and statics that both have."""
    if not isinstance(a, dict) or not isinstance(b, dict) or path[:1] in (("variants",), ("sweeps",), ("prefabs",)):
        return
    for key in a:
        if key in b:
            if key in NESTED and path:
                yield (*path, key)
            yield from _nested(a[key], b[key], (*path, key))
