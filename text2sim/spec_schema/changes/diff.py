"""Differences between the data of two versions of a case, and values that change because of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from math import dist
from typing import Any, Literal

from text2sim.spec_schema.arithmetic.values import is_number
from text2sim.spec_schema.changes.operation import Operation, common_ends
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.text.document import Path, leaves, mapping_at, pointer

Kind = Literal["changed", "added", "removed", "moved", "kind"]
_SPACE = (("pose", "pos"), ("place", "at"), ("place", "offset"))
_CAMERA = ("from", "pos", "look_at")
LONG_LIST = 8
"""Longer lists are compared item by item."""
SHOTS = ("render", "shots")
"""The only mapping whose order has a meaning: the sequence of shots."""


class _Nothing:
    def __bool__(self) -> bool:
        return False


NOTHING: Any = _Nothing()
"""Marks a missing value, in contrast to null."""


@dataclass(frozen=True)
class Change:
    """One difference."""

    kind: Kind
    """`kind` replaces a value by one of another kind, such as a sphere by a box; `moved` changes a position."""
    path: Path
    old: Any = None
    """The old value."""
    new: Any = None
    """The new value."""
    was: Any = NOTHING
    """Evaluated `old`, if it has expressions and is known."""
    now: Any = NOTHING
    """Evaluated `new`, likewise."""
    by: tuple[float, ...] | None = None
    """Displacement [m]."""


def difference(a: Any, b: Any, values: tuple[Any, Any] = (NOTHING, NOTHING)) -> list[Change]:
    """Return the changes from `a` to `b`.

    Args:
        a: Plain data of a document, with `${…}`.
        b: Plain data of another.
        values: Their data with every expression evaluated, if known.
    """
    return list(_compare(a, b, *values, ()))


def operations(a: Any, b: Any) -> list[Operation]:
    """Return a short RFC 6902 patch from `a` to `b`, with the shots of a film in the order of `b`."""
    steps, old, new = _steps(a, b, ()), _shots(a), _shots(b)
    if [*new] == [*(name for name in old if name in new), *(name for name in new if name not in old)]:
        return steps
    if any(pointer(SHOTS).startswith(step["path"]) for step in steps):
        return steps  # the section is replaced as a whole
    others = [step for step in steps if not step["path"].startswith(pointer(SHOTS))]
    return [*others, {"op": "replace", "path": pointer(SHOTS), "value": new}]


def _shots(case: Any) -> dict[str, Any]:
    return reduce(mapping_at, SHOTS, case)


# --- for people -----------------------------------------------------------------------------------------------


def _compare(a: Any, b: Any, was: Any, now: Any, path: Path) -> Iterator[Change]:
    if same(a, b):
        return
    if isinstance(a, dict) and isinstance(b, dict):
        if is_another_kind(a, b):
            yield Change("kind", path, a, b, *_evaluated(a, was, b, now))
            return
        for key in [*a, *(key for key in b if key not in a)]:
            inner = (*path, key)
            if key not in b:
                yield Change("removed", inner, a[key], NOTHING, _value(a[key], _child(was, key)))
            elif key not in a:
                yield Change("added", inner, NOTHING, b[key], NOTHING, _value(b[key], _child(now, key)))
            elif key == "kind":
                if not same(a[key], b[key]):
                    yield Change("kind", inner, a[key], b[key])
            else:
                yield from _compare(a[key], b[key], _child(was, key), _child(now, key), inner)
        return
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b) and (len(a) > LONG_LIST or _nested(a)):
        for index, (old, new) in enumerate(zip(a, b, strict=True)):
            yield from _compare(old, new, _child(was, index), _child(now, index), (*path, index))
        return
    values = _evaluated(a, was, b, now)
    if _is_place(path) and (by := _distance(values[0] if values[0] is not NOTHING else a, values[1] or b)):
        yield Change("moved", path, a, b, *values, by=by)
    else:
        yield Change("changed", path, a, b, *values)


def is_another_kind(a: dict[str, Any], b: dict[str, Any]) -> bool:
    """Return whether two mappings are of different kinds and contain no mappings: then one replaces the other."""
    return a.get("kind") != b.get("kind") and not any(isinstance(x, dict) for x in (*a.values(), *b.values()))


def _nested(items: list[Any]) -> bool:
    return any(isinstance(item, dict | list) for item in items)


def _child(value: Any, step: str | int) -> Any:
    if isinstance(value, dict):
        return value.get(str(step), NOTHING)
    return value[step] if isinstance(value, list) and isinstance(step, int) and step < len(value) else NOTHING


def _evaluated(a: Any, was: Any, b: Any, now: Any) -> tuple[Any, Any]:
    return _value(a, was), _value(b, now)


def _value(raw: Any, value: Any) -> Any:
    """Return the value of data with expressions; nothing if it has none."""
    return NOTHING if value is NOTHING or same(raw, value) else value


def _is_place(path: Path) -> bool:
    return path[-2:] in _SPACE or (path[:2] == ("render", "cameras") and path[-1] in _CAMERA)


def _distance(a: Any, b: Any) -> tuple[float, ...] | None:
    """Return the vector from one point to another; None if they are not points."""
    if not (isinstance(a, list) and isinstance(b, list) and len(a) == len(b)):
        return None
    if not all(map(is_number, [*a, *b])) or dist(a, b) == 0:
        return None
    return tuple(float(f"{new - old:.9g}") for old, new in zip(a, b, strict=True))


# --- for machines ---------------------------------------------------------------------------------------------


def _steps(a: Any, b: Any, path: Path) -> list[Operation]:
    if same(a, b):
        return []
    whole: Operation = {"op": "replace", "path": pointer(path), "value": b}
    if isinstance(a, dict) and isinstance(b, dict):
        steps: list[Operation] = [{"op": "remove", "path": pointer((*path, key))} for key in a if key not in b]
        for key, value in b.items():
            if key in a:
                steps += _steps(a[key], value, (*path, key))
            else:
                steps.append({"op": "add", "path": pointer((*path, key)), "value": value})
    elif isinstance(a, list) and isinstance(b, list):
        steps = _item_steps(a, b, path)
    else:
        return [whole]
    return steps if _size(steps) < _size([whole]) else [whole]


def _item_steps(a: list[Any], b: list[Any], path: Path) -> list[Operation]:
    """Return the steps for a list: equal items at both ends stay; those between change in order."""
    first, last = common_ends(a, b, same)
    old, new = a[first : len(a) - last], b[first : len(b) - last]
    steps: list[Operation] = []
    for offset, (before, after) in enumerate(zip(old, new, strict=False)):
        steps += _steps(before, after, (*path, first + offset))
    place = first + min(len(old), len(new))
    steps += [{"op": "remove", "path": pointer((*path, place))} for _ in old[len(new) :]]
    for offset, item in enumerate(new[len(old) :]):
        steps.append({"op": "add", "path": pointer((*path, place + offset)), "value": item})
    return steps


def _size(steps: list[Operation]) -> int:
    """Return the approximate length of some steps as text."""
    return sum(20 + len(step["path"]) + (_weight(step["value"]) if "value" in step else 0) for step in steps)


def _weight(value: Any) -> int:
    if isinstance(value, dict):
        return 2 + sum(len(key) + 4 + _weight(item) for key, item in value.items())
    if isinstance(value, list):
        return 2 + sum(2 + _weight(item) for item in value)
    return len(str(value))


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
