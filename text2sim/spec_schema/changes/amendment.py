"""Layout of a document under operations that change it: unchanged entries keep comments and order."""

import copy
from collections.abc import Callable, Sequence
from typing import Any

from text2sim.spec_schema.changes.operation import Operation, Steps, common_ends, split_pointer
from text2sim.spec_schema.text.canonical import dump_layout, format_document
from text2sim.spec_schema.text.document import Document, parse_document
from text2sim.spec_schema.text.layout import LayoutEntry, plain_data, plain_layout, written_layout
from text2sim.spec_schema.text.source import Source, check_source

EntryLookup = Callable[[Steps], LayoutEntry | None]
"""Returns the entry, with comments, from which the value that is added at a path may come."""
ORDERED = (("shots",), ("cameras",))
"""Mappings whose order has a meaning: a replacement has its own."""


class DocumentLayout:
    """The layout of a document, changed in place.

    Attributes:
        root: The current layout.
        head: Comments above it.
        foot: Comments below it.
    """

    def __init__(self, document: Document, lookup: EntryLookup | None = None) -> None:
        self.root, self.head, self.foot = written_layout(document)
        self._file = document.source.file
        self._lookup = lookup

    def dump(self, wanted: Any) -> str:
        """Return the current document in canonical form, which must have the data `wanted`.

        Raises:
            SpecError: If it is too large.
            AssertionError: If it has other data.
        """
        document = parse_document(check_source(Source(dump_layout(self.root, self.head, self.foot), self._file)))
        if not identical(document.data, wanted):
            raise AssertionError("the edited text has other data than the patch gives")
        return format_document(document)  # comments of the remaining entries may have another place now

    def apply(self, operations: Sequence[Operation]) -> None:
        """Apply operations that were successful on the data."""
        for operation in operations:
            op, path = operation["op"], split_pointer(operation["path"])
            if op == "test":
                continue
            if op == "remove":
                self.detach(path)
            elif op == "replace" or not path:
                self.set(self.find(path), self._value(operation), path)
            elif op == "move":
                self.move(split_pointer(operation["from"]), path)
            elif op == "copy":
                self.put(path, plain_layout(self._value(operation)))
            else:
                self.put(path, self.fresh(path, operation["value"]))

    def _value(self, operation: Operation) -> Any:
        """Return the value that an operation writes."""
        if "value" in operation:
            return operation["value"]
        return plain_data(self.find(split_pointer(operation["from"])))

    def find(self, path: Sequence[str]) -> LayoutEntry:
        """Return the entry at a path."""
        entry = self.root
        for step in path:
            entry = entry.child(step)
            assert entry is not None
        return entry

    def fresh(self, path: Steps, value: Any) -> LayoutEntry:
        """Return a new entry for a value, with the comments of the entry that it comes from, if any."""
        entry = self._lookup(path) if self._lookup is not None else None
        if entry is None or not identical(plain_data(entry), value):
            return plain_layout(value)
        entry = copy.copy(entry)
        entry.before = [row for row in entry.before if row]
        return _loose(entry)

    def put(self, path: Sequence[str], entry: LayoutEntry) -> None:
        """Put an entry, with its comments, at a path; it replaces an old one with the same key."""
        parent = self.find(path[:-1])
        entry.parent = parent
        if not parent.mapping:
            entry.key = None
            parent.value.insert(len(parent.value) if path[-1] == "-" else int(path[-1]), entry)
            return
        entry.key = path[-1]
        old = parent.child(path[-1])
        if old is None:
            parent.value.append(entry)
        elif entry.before or entry.trail or entry.after or entry.has_comments:
            parent.value[parent.value.index(old)] = entry
        else:
            self.set(old, plain_data(entry), tuple(path))

    def detach(self, path: Sequence[str]) -> LayoutEntry:
        """Remove the entry at a path, and return it."""
        entry = self.find(path)
        assert entry.parent is not None
        entry.parent.value.remove(entry)
        return entry

    def move(self, source: Sequence[str], path: Sequence[str]) -> None:
        """Move an entry with its comments; a renamed one keeps its position."""
        entry = self.find(source)
        if source == path:
            return
        if source[:-1] == path[:-1] and entry.parent and entry.parent.mapping and not entry.parent.child(path[-1]):
            entry.key = path[-1]
            return
        # The copy has no text at the new position.
        moved = copy.copy(self.detach(source))
        moved.before = [row for row in moved.before if row]
        self.put(path, _loose(moved))

    def set(self, entry: LayoutEntry, value: Any, path: Steps) -> None:
        """Give an entry another value; equal parts stay as they are written.

        Args:
            entry: The entry.
            value: Its new value.
            path: Its path.
        """
        if isinstance(value, dict) and entry.mapping:
            for child in list(entry.value):
                if child.key not in value:
                    entry.value.remove(child)
            for key, inner in value.items():
                child = entry.child(key)
                if child is not None:
                    self.set(child, inner, (*path, key))
                else:
                    fresh = self.fresh((*path, key), inner)
                    fresh.key = key
                    fresh.parent = entry
                    entry.value.append(fresh)
            if path[-1:] in ORDERED:
                entry.value.sort(key=lambda child: list(value).index(child.key))
        elif isinstance(value, list) and isinstance(entry.value, list) and not entry.mapping:
            self._set_items(entry, value, path)
        elif isinstance(entry.value, list) or isinstance(value, dict | list) or not identical(entry.value, value):
            fresh = self.fresh(path, value)
            entry.value, entry.mapping = fresh.value, fresh.mapping
            for child in entry.inner:
                child.parent = entry

    def _set_items(self, entry: LayoutEntry, value: list[Any], path: Steps) -> None:
        """Set the items of a list: equal items at both ends stay; those between take the new values in order."""
        now = [plain_data(child) for child in entry.value]
        first, last = common_ends(now, value, identical)
        old, new = entry.value[first : len(now) - last], value[first : len(value) - last]
        for index, (child, inner) in enumerate(zip(old, new, strict=False), first):
            self.set(child, inner, (*path, str(index)))
        for child in old[len(new) :]:
            entry.value.remove(child)
        for index, inner in enumerate(new[len(old) :], first + len(old)):
            item = self.fresh((*path, str(index)), inner)
            item.parent = entry
            entry.value.insert(index, item)


def identical(a: Any, b: Any) -> bool:
    """Return whether two values are equal and of the same types, in any order of keys."""
    if type(a) is not type(b):
        return False
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(identical(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(identical, a, b))
    return a == b


def _loose(entry: LayoutEntry) -> LayoutEntry:
    """Return an entry with copies of all entries inside it."""
    if isinstance(entry.value, list):
        entry.value = [_loose(copy.copy(child)) for child in entry.value]
        for child in entry.value:
            child.parent = entry
    return entry
