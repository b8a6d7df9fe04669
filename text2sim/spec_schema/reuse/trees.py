"""Values with the positions of their parts, and operations that do not change them."""

from collections.abc import Callable
from functools import reduce
from typing import Any, NamedTuple

from text2sim.spec_schema.text.document import Node, Path


class LocatedValue(NamedTuple):
    """A value and its node."""

    data: Any
    node: Node

    def child(self, step: str | int) -> "LocatedValue":
        """Return an existing part of it."""
        children: Any = self.node.children
        return LocatedValue(self.data[step], children[step])

    def at(self, path: Path) -> "LocatedValue":
        """Return the existing part of it at a path."""
        return reduce(LocatedValue.child, path, self)


def merge(base: LocatedValue, over: LocatedValue, path: Path = ()) -> LocatedValue:
    """Merge a value into another: mappings key by key, null removes, anything else is replaced (RFC 7396).

    If both have different kinds (or uses), the mapping is replaced as a whole: the fields of a box have no meaning for
    a ball.

    Args:
        base: The value.
        over: Its changes.
        path: Their path in a case.
    """
    if not isinstance(over.data, dict):
        return over
    if not isinstance(base.data, dict) or _is_another(base.data, over.data, path):
        return without_nulls(over)
    assert isinstance(base.node.children, dict)
    assert isinstance(over.node.children, dict)
    node = base.node.copy()
    data, children, keys = dict(base.data), dict(base.node.children), dict(base.node.keys)
    for key, value in over.data.items():
        if value is None:
            data.pop(key, None)
            children.pop(key, None)
            keys.pop(key, None)
            continue
        upper = over.child(key)
        if isinstance(value, dict) and isinstance(data.get(key), dict):
            upper = merge(LocatedValue(data[key], children[key]), upper, (*path, key))
        else:
            upper = without_nulls(upper)
            keys[key] = over.node.keys[key]
        data[key], children[key] = upper
    node.children, node.keys = children, keys
    return LocatedValue(data, node)


def without_nulls(tree: LocatedValue) -> LocatedValue:
    """Return the value without its null keys."""
    if not isinstance(tree.data, dict) or not _has_null(tree.data):
        return tree
    kept = {key: without_nulls(tree.child(key)) for key, value in tree.data.items() if value is not None}
    return mapping(tree.node, kept)


def mapping(like: Node, parts: dict[str, LocatedValue], keys: dict[str, tuple[int, int]] | None = None) -> LocatedValue:
    """Return a mapping of parts at the position of a node.

    Args:
        like: The node.
        parts: Its parts by key.
        keys: Line and column of each key; those of the node if None.
    """
    node = like.copy()
    places = like.keys if keys is None else keys
    node.children = {key: part.node for key, part in parts.items()}
    node.keys = {key: places.get(key, (part.node.line, part.node.column)) for key, part in parts.items()}
    return LocatedValue({key: part.data for key, part in parts.items()}, node)


def sequence(like: Node, items: list[LocatedValue]) -> LocatedValue:
    """Return a list of items at the position of a node."""
    node = like.copy()
    node.children = [item.node for item in items]
    return LocatedValue([item.data for item in items], node)


def put(tree: LocatedValue, path: Path, value: LocatedValue | None) -> LocatedValue:
    """Return the value with one part of it set or removed; missing mappings along the path are made.

    Lists along the path must exist and be long enough.

    Args:
        tree: The value.
        path: Path of the part.
        value: The new part; None removes it.
    """
    if not path:
        assert value is not None
        return value
    step = path[0]
    if isinstance(tree.data, list):
        assert isinstance(step, int)
        items = [tree.child(index) for index in range(len(tree.data))]
        items[step] = put(items[step], path[1:], value)
        return sequence(tree.node, items)
    assert isinstance(step, str)
    parts = {key: tree.child(key) for key in tree.data} if isinstance(tree.data, dict) else {}
    keys = dict(tree.node.keys)
    if value is None and len(path) == 1:
        parts.pop(step, None)
        return mapping(tree.node, parts, keys)
    if step not in parts:
        if value is None:
            return tree
        node = value.node.copy()
        node.children, node.keys = {}, {}
        parts[step] = LocatedValue({}, node)
        keys[step] = (value.node.line, value.node.column)
    parts[step] = put(parts[step], path[1:], value)
    return mapping(tree.node, parts, keys)


def moved(tree: LocatedValue, place: Callable[[Node], Node]) -> LocatedValue:
    """Return the same value with `place` applied to each of its nodes."""
    node = place(tree.node)
    if isinstance(tree.data, dict):
        inner = {key: moved(tree.child(key), place) for key in tree.data}
        node.children = {key: part.node for key, part in inner.items()}
        node.keys = {key: (part.node.line, part.node.column) for key, part in inner.items()}
    elif isinstance(tree.data, list):
        node.children = [moved(tree.child(index), place).node for index in range(len(tree.data))]
    return LocatedValue(tree.data, node)


def count(data: Any) -> int:
    """Return how many values there are in a value, itself included."""
    total, stack = 0, [data]
    while stack:
        value = stack.pop()
        total += 1
        if isinstance(value, dict):
            stack += value.values()
        elif isinstance(value, list):
            stack += value
    return total


def _is_another(base: dict[str, Any], over: dict[str, Any], path: Path) -> bool:
    """Return whether two mappings have different kinds."""
    if path[:1] in (("params",), ("waive",)) or path[-1:] == ("with",):
        return False
    first, second = ((found.get("use"), found.get("kind")) for found in (base, over))
    for was, now in zip(first, second, strict=True):
        if isinstance(was, str) and isinstance(now, str):
            return was != now
    crossed = (first[0], second[1]), (first[1], second[0])
    return any(isinstance(was, str) and isinstance(now, str) for was, now in crossed)


def _has_null(data: Any) -> bool:
    return any(value is None or (isinstance(value, dict) and _has_null(value)) for value in data.values())
