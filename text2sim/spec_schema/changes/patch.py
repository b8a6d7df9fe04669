"""JSON Patch (RFC 6902) on plain data: all operations are applied, or none.

Stricter than the RFC in one point: unknown members of an operation are errors.
"""

import copy
from collections.abc import Sequence
from typing import Any

from text2sim.spec_schema.changes.operation import (
    Operation,
    Refusal,
    Steps,
    check_text,
    checked_form,
    index_of,
    measure,
    place_of,
    steps_of,
)
from text2sim.spec_schema.errors import Text2SimError, nearest
from text2sim.spec_schema.text.document import MAX_DEPTH, MAX_NODES, pointer
from text2sim.spec_schema.vocabulary.words import show

MAX_OPERATIONS = 1000


class PatchError(Text2SimError):
    """A patch that cannot be applied.

    Attributes:
        index: Index of the operation; None if the patch as a whole is wrong.
        reason: The reason.
        member: The member of the operation that is wrong: `op`, `path`, `from` or `value`.
    """

    def __init__(self, index: int | None, reason: str, member: str = "path", what: str = "") -> None:
        self.index, self.reason, self.member = index, reason, member
        super().__init__(reason if index is None else f"operation {index + 1}{what}: {reason}")


def apply_operations(data: Any, operations: Sequence[Operation]) -> Any:
    """Return patched `data`, without changing it.

    Raises:
        PatchError: If an operation is malformed, or cannot be applied.
    """
    return _run(data, operations)[0]


def inverse(data: Any, operations: Sequence[Operation]) -> list[Operation]:
    """Return the patch that reverts `operations` on `data`; see `apply_operations`."""
    return _run(data, operations)[1]


def same(a: Any, b: Any) -> bool:
    """Return whether two values are equal in JSON: 1 equals 1.0, but not true; the order of keys does not matter."""
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    return isinstance(a, bool) == isinstance(b, bool) and a == b


def _run(data: Any, operations: Sequence[Operation]) -> tuple[Any, list[Operation]]:
    if not isinstance(operations, list | tuple):
        raise PatchError(None, "a patch is a list of operations")
    if len(operations) > MAX_OPERATIONS:
        raise PatchError(None, f"the patch has more than {MAX_OPERATIONS} operations")
    try:
        patch = _Patch(data)
    except Refusal as refusal:
        raise PatchError(None, f"the document cannot be patched: {refusal}") from None
    for index, operation in enumerate(operations):
        try:
            patch.do(operation)
        except Refusal as refusal:
            raise PatchError(index, str(refusal), refusal.member, _title(operation)) from None
    return patch.data, patch.undo[::-1]


def _title(operation: Any) -> str:
    if not isinstance(operation, dict) or not isinstance(operation.get("op"), str):
        return ""
    return f" ({operation['op'][:20]} {str(operation.get('path', ''))[:120]})".replace(" )", ")")


class _Patch:
    """Data under a patch, with the operations that undo it, in reverse order."""

    def __init__(self, data: Any) -> None:
        self.size = measure(data)[0]
        self.data = copy.deepcopy(data)
        self.undo: list[Operation] = []

    def do(self, operation: Operation) -> None:
        op = checked_form(operation)
        path = steps_of(operation, "path")
        if op == "add":
            self.add(path, self.fresh(operation["value"], path))
        elif op == "remove":
            self.remove(path)
        elif op == "replace":
            self.find(path)
            self.replace(path, self.fresh(operation["value"], path))
        elif op == "test":
            found = self.find(path)
            if not same(found, operation["value"]):
                raise Refusal(f"{place_of(path)} is {show(found)}, not {show(operation['value'])}", "value")
        else:
            source = steps_of(operation, "from")
            value = self.find(source, "from")
            if op == "copy":
                self.add(path, self.fresh(value, path))
            elif path[: len(source)] == source and path != source:
                raise Refusal("a value cannot be moved into itself")
            elif path != source:
                self.move(source, path)

    def move(self, source: Steps, path: Steps) -> None:
        value = self.remove(source)
        self.add(path, value, moved=len(path) + measure(value)[1])
        back, home = self.undo[-1], self.undo[-2]["path"]
        # In a list, a value may shift its old position, which then seems to be inside itself.
        if back["op"] == "remove" and not home.startswith(back["path"] + "/"):
            self.undo[-2:] = [{"op": "move", "from": back["path"], "path": home}]
        else:
            self.undo[-2]["value"] = copy.deepcopy(value)

    def add(self, path: Steps, value: Any, moved: int = 0) -> None:
        if moved > MAX_DEPTH:
            raise Refusal(f"the document would be nested more than {MAX_DEPTH} deep")
        if not path:
            self.replace(path, value)
            return
        parent = self.find(path[:-1])
        if isinstance(parent, list):
            index = len(parent) if path[-1] == "-" else index_of(path, parent, len(parent))
            parent.insert(index, value)
            self.undo.append({"op": "remove", "path": pointer((*path[:-1], index))})
        elif not isinstance(parent, dict):
            raise Refusal(f"{place_of(path[:-1])} is neither a mapping nor a list")
        elif path[-1] in parent:
            self.replace(path, value)
        else:
            parent[path[-1]] = value
            self.undo.append({"op": "remove", "path": pointer(path)})

    def replace(self, path: Steps, value: Any) -> None:
        if path:
            parent = self.find(path[:-1])
            step: Any = int(path[-1]) if isinstance(parent, list) else path[-1]
            old, parent[step] = parent[step], value
        else:
            old, self.data = self.data, value
        self.undo.append({"op": "replace", "path": pointer(path), "value": old})

    def remove(self, path: Steps) -> Any:
        if not path:
            raise Refusal("the whole document cannot be removed")
        self.find(path)
        parent = self.find(path[:-1])
        old = parent.pop(int(path[-1]) if isinstance(parent, list) else path[-1])
        self.undo.append({"op": "add", "path": pointer(path), "value": old})
        return old

    def find(self, path: Steps, member: str = "path") -> Any:
        value = self.data
        for depth, step in enumerate(path):
            if isinstance(value, list):
                value = value[index_of(path[: depth + 1], value, len(value) - 1, member)]
            elif not isinstance(value, dict):
                raise Refusal(f"{place_of(path[:depth])} is neither a mapping nor a list", member)
            elif step not in value:
                raise Refusal(f"there is no `{step[:80]}` in {place_of(path[:depth])}", member, nearest(step, value))
            else:
                value = value[step]
        return value

    def fresh(self, value: Any, path: Steps) -> Any:
        """Return a copy of a value for `path`, if the language allows it and it is not too large."""
        size, depth = measure(value)
        self.size += size
        if self.size > MAX_NODES:
            self.size = size + measure(self.data)[0]
        if self.size > MAX_NODES:
            raise Refusal(f"the document would have more than {MAX_NODES} values", "value")
        if len(path) + depth > MAX_DEPTH:
            raise Refusal(f"the document would be nested more than {MAX_DEPTH} deep", "value")
        check_text("".join(path[-1:]), "path")
        return copy.deepcopy(value)
