"""Effects of a change: values that change because of the parameters they use."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.changes.diff import NOTHING
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.text.document import Path, leaves


@dataclass(frozen=True)
class Effect:
    """A value whose expression is unchanged, but whose value changed."""

    path: Path
    was: Any
    now: Any
    because: tuple[str, ...] = ()
    """Changed parameters that it depends on."""


def effects(a: Any, b: Any, values: tuple[Any, Any], depends: Mapping[Path, frozenset[str]]) -> Iterator[Effect]:
    """Yield the values that are written in `b` as in `a`, but differ.

    Args:
        a: Plain data of a document, with `${…}`, as in `difference`.
        b: Plain data of another.
        values: Their data with every expression evaluated.
        depends: Parameters on which expressions of `b` depend, by path.
    """
    raw, was = dict(leaves(a)), dict(leaves(values[0]))
    written, now = dict(leaves(b)), dict(leaves(values[1]))
    changed = {
        str(path[1])
        for path in raw.keys() | written.keys() | was.keys() | now.keys()
        if path[:1] == ("params",) and len(path) > 1 and not same(was.get(path, NOTHING), now.get(path, NOTHING))
    }
    edited = {
        path for path in raw.keys() | written.keys() if not same(raw.get(path, NOTHING), written.get(path, NOTHING))
    }
    for path, value in now.items():
        if any(path[:depth] in edited for depth in range(len(path) + 1)) or path not in was or path[:1] == ("params",):
            continue
        if not same(was[path], value):
            names = next((depends[path[:d]] for d in range(len(path), 0, -1) if path[:d] in depends), frozenset())
            yield Effect(path, was[path], value, tuple(sorted(names & changed)))
