"""Layout of a document: its entries in order, with comments and blank lines."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from text2sim.spec_schema.text.document import Document, open_parser
from text2sim.spec_schema.text.masking import mask


@dataclass(eq=False)
class LayoutEntry:
    """A value with its key, or an item of a list."""

    value: Any
    """Scalar, or list of entries."""
    key: str | None = None
    mapping: bool = False
    """Whether the value is a mapping, not a list, if it is a collection."""
    before: list[str] = field(default_factory=list)
    """Comments above it; an empty string is a blank line."""
    trail: str | None = None
    """Comment at the end of its line."""
    after: list[str] = field(default_factory=list)
    """Comments below it, at its own indentation."""
    line: int = 0
    column: int = 0
    end: int = 0
    """Line on which it ends."""
    parent: "LayoutEntry | None" = None
    flow: bool = False
    """Whether the value is a collection in brackets."""

    @property
    def inner(self) -> list["LayoutEntry"]:
        """Entries inside it; none for a scalar."""
        return self.value if isinstance(self.value, list) else []

    def child(self, step: str | int) -> "LayoutEntry | None":
        """Return the entry under a key, or at an index of a list; None if there is none."""
        if self.mapping:
            return next((child for child in self.inner if child.key == step), None)
        return next(iter(self.inner[int(step) :]), None)

    @property
    def has_comments(self) -> bool:
        """Whether there is a comment inside it."""
        return any(child.trail or child.has_comments or child.after or any(child.before) for child in self.inner)


@dataclass(frozen=True)
class Comment:
    """A comment, with its position."""

    line: int
    column: int
    text: str
    alone: bool
    """Whether nothing else is on its line."""


_BLOCKS = ("|", ">")
"""Styles of block scalars."""


def plain_layout(data: Any, key: str | None = None) -> LayoutEntry:
    """Return plain data as an entry without comments."""
    if isinstance(data, dict):
        entry = LayoutEntry([plain_layout(value, str(name)) for name, value in data.items()], key, mapping=True)
    elif isinstance(data, list | tuple):
        entry = LayoutEntry([plain_layout(value) for value in data], key)
    else:
        return LayoutEntry(data, key)
    for child in entry.value:
        child.parent = entry
    return entry


def plain_data(entry: LayoutEntry) -> Any:
    """Return the data of an entry."""
    if not isinstance(entry.value, list):
        return entry.value
    if entry.mapping:
        return {child.key: plain_data(child) for child in entry.value}
    return [plain_data(child) for child in entry.value]


def written_layout(document: Document) -> tuple[LayoutEntry, list[str], list[str]]:
    """Return the root entry of a document, and the comments above and below it."""
    reader = _Reader(document)
    reader.read()
    head = _attach(reader, document.source.lines)
    return reader.root, head, reader.root.after


class _Reader:
    """Second pass over the parser's events, for comments and layout."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.root = LayoutEntry(None)
        self.entries: list[LayoutEntry] = []
        self.comments: list[Comment] = []
        self.scanned = 0

    def read(self) -> None:
        text = self.document.source.text
        # Open collections: entry, data, and the remaining keys.
        stack: list[tuple[LayoutEntry, Any, Iterator[str]]] = []
        key: tuple[str, Any] | None = None
        parser = open_parser(mask(text))
        while (event := parser.get_event()) is not None and not isinstance(event, yaml.StreamEndEvent):
            if isinstance(event, yaml.ScalarEvent):
                self._step_over(event)
            if isinstance(event, yaml.CollectionEndEvent):
                entry = stack.pop()[0]
                entry.end = event.end_mark.line if entry.flow else -1
            if not isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent):
                continue
            if stack and stack[-1][0].mapping and key is None:
                key = (next(stack[-1][2]), event)
                continue
            data = self.document.data if not stack else stack[-1][1][key[0] if key else len(stack[-1][0].value)]
            entry = self._entry(event, data, key, stack[-1][0] if stack else None)
            key = None
            if isinstance(event, yaml.CollectionStartEvent):
                # A block ends where the next entry begins, so only the end of brackets is useful.
                entry.flow = bool(event.flow_style)
                stack.append((entry, data, iter(data)))
        self._scan(self.scanned, len(text))

    def _entry(self, event: Any, data: Any, key: tuple[str, Any] | None, parent: LayoutEntry | None) -> LayoutEntry:
        collection = isinstance(event, yaml.CollectionStartEvent)
        entry = LayoutEntry([] if collection else data, mapping=isinstance(data, dict), parent=parent)
        mark = event.start_mark
        if key is not None:
            entry.key, mark = key[0], key[1].start_mark
        entry.line, entry.column, entry.end = mark.line, mark.column, event.end_mark.line
        if parent is None:
            self.root = entry
        else:
            parent.value.append(entry)
            self.entries.append(entry)
        return entry

    def _step_over(self, event: Any) -> None:
        """Find the comments between the last scalar and this one."""
        text = self.document.source.text
        start, end = event.start_mark.index, event.end_mark.index
        if event.style in _BLOCKS:  # a comment may follow the header
            start = next((i for i in range(start, end) if text[i] in "\r\n"), end)
        self._scan(self.scanned, start)
        self.scanned = max(end, self.scanned)

    def _scan(self, start: int, end: int) -> None:
        source = self.document.source
        while (at := source.text.find("#", start, end)) >= 0:
            start = at + 1
            if at and source.text[at - 1] not in " \t\r\n":
                continue
            line, column = (number - 1 for number in source.place(at))
            row = source.lines[line]
            self.comments.append(Comment(line, column, row[column:].rstrip(), not row[:column].strip()))
            start = at + len(row) - column


def _attach(reader: _Reader, lines: list[str]) -> list[str]:
    """Attach every comment and blank line to an entry; return those above all entries."""
    starts: dict[int, list[LayoutEntry]] = {}
    for entry in reader.entries:
        starts.setdefault(entry.line, []).append(entry)
    for comment in reader.comments:
        if not comment.alone:
            _attach_trail(reader, comment, starts.get(comment.line, []))
    alone = {comment.line: comment for comment in reader.comments if comment.alone}
    for number, (first, *_) in starts.items():
        gap = _gap_above(number, alone, lines)
        above = _attach_below(reader, starts, gap, first.column)
        first.before = _squeezed(gap[above:])
    gap = _gap_above(len(lines), alone, lines)
    below = _attach_below(reader, starts, gap, 0)
    reader.root.after += [row.text for row in gap[below:] if row is not None]
    if not reader.entries:  # only a scalar, or empty brackets
        return [comment.text for comment in alone.values() if comment.line < len(lines) - len(gap)]
    return _take_head(reader)


def _attach_below(reader: _Reader, starts: dict[int, list[LayoutEntry]], gap: list[Comment | None], column: int) -> int:
    """Attach the comments that are indented deeper than the next entry to the end of their block.

    Returns:
        Number of attached rows of the gap; the rest belongs to the next entry.
    """
    used = 0
    for number, row in enumerate(gap):
        if row is None:
            continue
        index = bisect_left(reader.entries, row.line, key=lambda entry: entry.line)
        owner = reader.entries[index - 1] if index else None
        while owner is not None and (owner.column > row.column or starts[owner.line][0] is not owner):
            owner = owner.parent if owner.parent is not reader.root else None
        if owner is None or owner.column <= column:
            break
        owner.after.append(row.text)
        used = number + 1
    return used


def _gap_above(number: int, alone: dict[int, Comment], lines: list[str]) -> list[Comment | None]:
    """Return the comments and blank lines (None) right above a line."""
    gap: list[Comment | None] = []
    while number > 0 and (
        number - 1 in alone or not lines[number - 1].strip() or lines[number - 1].startswith(("---", "..."))
    ):
        number -= 1
        gap.append(alone.get(number))
    return gap[::-1]


def _squeezed(gap: list[Comment | None]) -> list[str]:
    """Return the text of a gap, without repeated blank lines."""
    rows: list[str] = []
    for row in gap:
        text = row.text if row is not None else ""
        if text or rows[-1:] != [""]:
            rows.append(text)
    return rows


def _attach_trail(reader: _Reader, comment: Comment, starting: list[LayoutEntry]) -> None:
    """Attach a trailing comment to the outermost entry that ends on its line, or to the last that starts there."""
    complete = [entry for entry in starting if entry.end == comment.line]
    owner = complete[0] if complete else starting[-1] if starting else None
    if owner is None:
        index = bisect_right(reader.entries, comment.line, key=lambda entry: entry.line)
        owner = reader.entries[index - 1] if index else reader.root
    if owner.trail is None and owner is not reader.root:
        owner.trail = comment.text
    else:
        owner.after.append(comment.text)


def _take_head(reader: _Reader) -> list[str]:
    """Remove and return the comments above a blank line before the first entry, and the modeline of editors."""
    first = reader.entries[0]
    rows = first.before[1:] if first.before[:1] == [""] else first.before
    cut = max((i + 1 for i, row in enumerate(rows) if not row), default=0)
    if cut == 0 and rows[:1] and rows[0].startswith("# yaml-language-server:"):
        cut = 1
    first.before = rows[cut:]
    return rows[:cut]
