"""Where the entries of a document that is amended stand in its text."""

import re
from itertools import takewhile

from text2sim.spec_schema.changes.amendment import Amendment
from text2sim.spec_schema.text.layout import Entry
from text2sim.spec_schema.text.source import Source

_BREAK = re.compile(r"\r\n|\r|\n")


def attached(rows: list[str]) -> list[str]:
    """The comments right above an entry: those below the last blank line."""
    return list(takewhile(bool, reversed(rows)))[::-1]


def in_flow(entry: Entry) -> bool:
    """Whether an entry stands in brackets."""
    return entry.parent is not None and entry.parent.flow


class Spans:
    """Places of written entries; lines are counted from 0.

    Attributes:
        starts: Index of the first character of each line.
    """

    def __init__(self, source: Source, amendment: Amendment) -> None:
        self.source, self.amendment, self.lines = source, amendment, source.lines
        self.starts = [0, *(found.end() for found in _BREAK.finditer(source.text))]

    def first(self, entry: Entry) -> int:
        """First line of an entry, or of the comments right above it."""
        comments = attached(self.amendment.above.get(entry, entry.before))
        return self.source.place(self.begin(entry) or 0)[0] - 1 - len(comments)

    def bottom(self, entry: Entry) -> int:
        """Last line of an entry with everything in it, and of the comments below it."""
        line = self.source.place(max(entry.span[0], entry.span[1] - 1))[0] - 1
        inner = self.amendment.written.get(entry, [])
        return max([line, entry.lowest, *(self.bottom(child) for child in inner)])

    def begin(self, entry: Entry) -> int | None:
        """Where an entry starts: at its key, or at the dash of an item; None if the dash is not beside it."""
        if entry.key is not None or entry.parent is None:
            return entry.name[0] if entry.parent is not None else None
        at = entry.span[0] - 1
        while at >= 0 and self.source.text[at] == " ":
            at -= 1
        return at if at >= 0 and self.source.text[at] == "-" else None

    def alone(self, index: int) -> bool:
        """Whether nothing stands before a character on its line."""
        line, column = self.source.place(index)
        return not self.lines[line - 1][: column - 1].strip()

    def blank(self, line: int) -> bool:
        """Whether there is nothing on a line, or no such line."""
        return line >= len(self.lines) or not self.lines[line].strip()
