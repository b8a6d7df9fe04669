"""Changes of a document's entries as changes of its text: what is not touched stays byte for byte."""

import re
from dataclasses import dataclass

from text2sim.spec_schema.changes.amendment import Amendment
from text2sim.spec_schema.changes.spans import Spans, attached, in_flow
from text2sim.spec_schema.text.canonical import SECTIONS, WIDTH, entry_lines, flow_text
from text2sim.spec_schema.text.layout import Entry
from text2sim.spec_schema.text.source import Source
from text2sim.spec_schema.text.writing import key

_BREAK = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Edit:
    """A piece of text to be replaced."""

    start: int
    stop: int
    text: str


def splice(source: Source, amendment: Amendment) -> str | None:
    """Return the text with all that was amended; entries that are touched are written in canonical form.

    Returns:
        None if the document has to be written anew as a whole. The text may say something else than what was
        amended where YAML is written in a way that nobody would expect; whoever calls this reads it again.
    """
    splicer = _Splicer(source, amendment)
    splicer.visit(amendment.root)
    return splicer.text()


class _Splicer:
    def __init__(self, source: Source, amendment: Amendment) -> None:
        self.source, self.amendment = source, amendment
        self.spans = Spans(source, amendment)
        self.lines, self.starts = source.lines, self.spans.starts
        self.newline = "\r\n" if "\r\n" in source.text else "\n"
        self.edits: list[Edit] = []
        self.anew: set[Entry] = set()
        """Written entries that are written anew as a whole."""

    def text(self) -> str | None:
        """The text with every edit in it."""
        if self.amendment.root in self.anew:
            return None
        for entry in self.anew:
            if not any(outer in self.anew for outer in _above(entry)):
                fresh = self._rewritten(entry)
                # What is put right before it is the end of its neighbour.
                self.edits = [e for e in self.edits if e.stop <= fresh.start or e.start >= fresh.stop]
                self.edits.append(fresh)
        text, pieces, done = self.source.text, [], 0
        for edit in sorted(self.edits, key=lambda edit: (edit.start, edit.stop)):
            pieces += [text[done : edit.start], edit.text]
            done = max(done, edit.stop)
        # Text on lines of its own has to end with one.
        end = self.newline if done == len(text) and text and not text.endswith(("\r", "\n")) else ""
        return "".join([*pieces, text[done:], end])

    def visit(self, entry: Entry) -> None:
        """Collect the edits of a written entry and of what is inside it."""
        if entry in self.amendment.renamed:
            self.edits.append(Edit(*entry.name, key(entry.key or "")))
        if entry in self.amendment.above:
            self._recomment(entry)
        if entry in self.amendment.commented:
            self.rewrite(entry)
        if entry in self.amendment.changed:
            self._revalue(entry)
        elif isinstance(entry.value, list):
            before = len(self.edits)
            written = self.amendment.written[entry]
            now = set(entry.value)
            kept = [child for child in written if child in now]
            for child in kept:
                self.visit(child)
            if entry.value != written:
                if not kept:
                    self.rewrite(entry)
                elif entry.flow:
                    self._change_flow(entry, written)
                else:
                    self._change_block(entry, written)
            if entry.flow and not in_flow(entry) and self._overflows(entry, self.edits[before:]):
                self.rewrite(entry)

    def rewrite(self, entry: Entry) -> None:
        """Write an entry anew; of one in brackets, the outermost brackets."""
        while entry.parent is not None and (in_flow(entry) or self.spans.begin(entry) is None):
            entry = entry.parent
        self.anew.add(entry)

    def _overflows(self, entry: Entry, edits: list[Edit]) -> bool:
        """Whether edits make the line on which something in brackets ends too long."""
        longer = sum(len(edit.text) - (edit.stop - edit.start) for edit in edits)
        column = self.source.place(entry.span[1])[1] - 1
        return longer > 0 and column <= WIDTH < column + longer

    def _rewritten(self, entry: Entry) -> Edit:
        start = self.spans.begin(entry) or 0
        stop = self.starts[self.spans.bottom(entry)] + len(self.lines[self.spans.bottom(entry)])
        indent = self.source.place(start)[1] - 1
        margin = " " * indent
        lines = [*entry_lines(entry, indent), *(margin + row for row in entry.after)]
        return Edit(start, stop, self.newline.join([lines[0][indent:], *lines[1:]]))

    def _revalue(self, entry: Entry) -> None:
        """Another value: in the place of the old one if both are words on a line, with its entry otherwise."""
        start, stop = entry.span
        old = self.source.text[start:stop]
        plain = entry not in self.amendment.written and start < stop and old[0] not in "|>" and not _BREAK.search(old)
        if plain and in_flow(entry):
            self.edits.append(Edit(start, stop, flow_text(entry)))
        elif plain and not isinstance(entry.value, list) and self.spans.begin(entry) is not None:
            bare = Entry(entry.value, entry.key, parent=entry.parent)
            lines = entry_lines(bare, self.source.place(self.spans.begin(entry) or 0)[1] - 1)
            if len(lines) > 1:
                self.rewrite(entry)
            else:
                lead = len(key(entry.key)) + 2 if entry.key is not None else 2
                self.edits.append(Edit(start, stop, lines[0].lstrip(" ")[lead:]))
        else:
            self.rewrite(entry)

    def _recomment(self, entry: Entry) -> None:
        """Other comments above an entry."""
        begin = self.spans.begin(entry)
        if in_flow(entry) or begin is None or not self.spans.alone(begin):
            if entry.parent is not None:
                self.rewrite(entry if in_flow(entry) else entry.parent)
            return
        line, column = self.source.place(begin)
        rows = [" " * (column - 1) + row for row in attached(entry.before)]
        text = "".join(row + self.newline for row in rows)
        self.edits.append(Edit(self.starts[self.spans.first(entry)], self.starts[line - 1], text))

    # --- in brackets

    def _change_flow(self, entry: Entry, written: list[Entry]) -> None:
        now = set(entry.value)
        spans = {child: (child.name[0] if child.key is not None else child.span[0], child.span[1]) for child in written}
        kept: Entry | None = None
        run: list[Entry] = []
        for child in [*written, None]:
            if child is not None and child not in now:
                run.append(child)
                continue
            if run:
                start = spans[run[0]][0] if child is not None else spans[kept][1] if kept is not None else 0
                stop = spans[child][0] if child is not None else spans[run[-1]][1]
                if "#" in self.source.text[start:stop]:
                    self.rewrite(entry)
                    return
                self.edits.append(Edit(start, stop, ""))
            kept, run = child, []
        kept = None
        for fresh, after in _runs(entry.value, set(written)):
            if any(child.has_comments or child.before or child.trail or child.after for child in fresh):
                self.rewrite(entry)
                return
            words = [(f"{key(child.key)}: " if child.key is not None else "") + flow_text(child) for child in fresh]
            if after is not None:
                self.edits.append(Edit(spans[after][1], spans[after][1], "".join(f", {word}" for word in words)))
            else:
                first = spans[next(child for child in entry.value if child in spans)][0]
                self.edits.append(Edit(first, first, "".join(f"{word}, " for word in words)))

    # --- line by line

    def _change_block(self, entry: Entry, written: list[Entry]) -> None:
        now, begins = set(entry.value), {child: self.spans.begin(child) for child in written}
        if any(begin is None for begin in begins.values()):
            self.rewrite(entry)
            return
        alone = self.spans.alone(begins[written[0]] or 0)
        if not alone and entry.value[0] is not written[0]:
            self.rewrite(entry)
            return
        for child in written:
            if child not in now:
                self._delete(child)
        indent = self.source.place(begins[written[0]] or 0)[1] - 1
        apart = len(written) > 1 and all(child.before[:1] == [""] for child in written[1:])
        for fresh, after in _runs(entry.value, set(written)):
            lines: list[str] = []
            for child in fresh:
                block = [*child.before, *entry_lines(child, indent), *child.after]
                block = [row if row.startswith(" " * indent) else " " * indent + row for row in block]
                gap = [""] if apart or (entry.parent is None and child.key in SECTIONS) else []
                lines += [*gap, *block] if after is not None else [*block, *gap]
            self._insert(lines, self.spans.bottom(after) + 1 if after is not None else self._top(entry.value, written))

    def _insert(self, lines: list[str], line: int) -> None:
        text = "".join(row + self.newline for row in lines)
        if line < len(self.starts):
            self.edits.append(Edit(self.starts[line], self.starts[line], text))
        else:  # the last line has no end
            end = len(self.source.text)
            self.edits.append(Edit(end, end, self.newline + text.removesuffix(self.newline)))

    def _delete(self, entry: Entry) -> None:
        first, last = self.spans.first(entry), self.spans.bottom(entry)
        if not self.spans.blank(last + 1):
            pass
        elif first and self.spans.blank(first - 1):
            while first and self.spans.blank(first - 1):
                first -= 1
        elif entry is self.amendment.written[entry.parent or entry][0]:
            while last + 1 < len(self.lines) - 1 and self.spans.blank(last + 1):
                last += 1
        stop = self.starts[last + 1] if last + 1 < len(self.starts) else len(self.source.text)
        self.edits.append(Edit(self.starts[first], stop, ""))

    def _top(self, entries: list[Entry], written: list[Entry]) -> int:
        """Line above which entries are put that come first."""
        known = set(written)
        return self.spans.first(next(entry for entry in entries if entry in known))


def _above(entry: Entry) -> list[Entry]:
    return [entry.parent, *_above(entry.parent)] if entry.parent is not None else []


def _runs(entries: list[Entry], known: set[Entry]) -> list[tuple[list[Entry], Entry | None]]:
    """Entries that are new, in runs, each with the known one that it follows."""
    runs: list[tuple[list[Entry], Entry | None]] = []
    last: Entry | None = None
    for entry in entries:
        if entry in known:
            last = entry
        elif runs and runs[-1][1] is last:
            runs[-1][0].append(entry)
        else:
            runs.append(([entry], last))
    return runs
