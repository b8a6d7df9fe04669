"""Three-way merge of the texts of a case, with the comments of both sides and conflict markers."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from itertools import takewhile
from typing import Any

from text2sim.spec_schema.changes.amendment import DocumentLayout
from text2sim.spec_schema.changes.diff import NOTHING, operations
from text2sim.spec_schema.changes.edit import edit_source
from text2sim.spec_schema.changes.merge import Conflict, merge
from text2sim.spec_schema.changes.operation import Operation, Steps
from text2sim.spec_schema.reuse.migration import steps_for
from text2sim.spec_schema.text.document import Path, parse_document, pointer
from text2sim.spec_schema.text.layout import LayoutEntry, written_layout
from text2sim.spec_schema.text.source import Source


@dataclass(frozen=True)
class MergedText:
    """The result of a merge."""

    text: str
    """The merged text, with markers for conflicts."""
    conflicts: list[Conflict]
    lost: list[str]
    """Their comments that were lost."""
    lost_ours: list[str]
    """Our comments that were lost with removed entries."""
    versions: tuple[Any, Any, Any]
    """The data of the ancestor, ours and theirs, in the same version of the language."""


def merge_texts(
    base: Source, ours: Source, theirs: Source, marker: int = 7, opposed: Sequence[Path] = ()
) -> MergedText:
    """Merge two versions of a case.

    Args:
        base: The common ancestor; empty if there is none.
        ours: Our version.
        theirs: Their version.
        marker: Length of a conflict marker.
        opposed: As in `merge`.

    Raises:
        SpecError: If one of them is not YAML that the language accepts.
    """
    if _version(ours) != _version(theirs):
        base, ours, theirs = (_migrated(source) for source in (base, ours, theirs))
    versions = _data(base), _data(ours), _data(theirs)
    merged = merge(*versions, opposed)
    entries = _entries_of(theirs)
    text = _apply_theirs(ours, merged.data, entries, _entries_of(base))
    lost, lost_ours = (_lost_comments(text, source, base) for source in (theirs, ours))
    if merged.conflicts:
        theirs_taken = edit_source(Source(text, ours.file), list(_take_theirs(merged.conflicts)), entries.get)
        text = with_conflict_markers(text, theirs_taken, marker)
    return MergedText(text, merged.conflicts, lost, lost_ours, versions)


def _data(source: Source) -> Any:
    return parse_document(source).data if source.text.strip() else {}


def _version(source: Source) -> Any:
    data = _data(source)
    return data.get("text2sim") if isinstance(data, dict) else None


def _migrated(source: Source) -> Source:
    """Return the text in the latest version of the language."""
    steps = steps_for(_data(source))
    return replace(source, text=edit_source(source, steps)) if steps else source


def _apply_theirs(ours: Source, wanted: Any, theirs: dict[Steps, LayoutEntry], base: dict[Steps, LayoutEntry]) -> str:
    """Return our text with their changes and their comments."""
    document = parse_document(ours)
    layout = DocumentLayout(document, theirs.get)
    written = {entry for _, entry in _entries(layout.root)}
    layout.apply(operations(document.data, wanted))
    for path, entry in list(_entries(layout.root)):
        other, old = theirs.get(path), base.get(path)
        if other is None or old is None or entry not in written:
            continue
        above = _both_sides(_comments_above(old.before), _comments_above(entry.before), _comments_above(other.before))
        rest = entry.before[: len(entry.before) - len(_comments_above(entry.before))]
        entry.before = [*rest, *above]
        entry.trail = "  ".join(_both_sides(_as_list(old.trail), _as_list(entry.trail), _as_list(other.trail))) or None
        entry.after = _both_sides(old.after, entry.after, other.after)
    return layout.dump(wanted)


def _both_sides(base: list[str], ours: list[str], theirs: list[str]) -> list[str]:
    """Return the merged comments of an entry: theirs follow ours."""
    if ours == base:
        return theirs
    return ours if theirs == base else [*ours, *(row for row in theirs if row not in ours and row not in base)]


def _comments_above(rows: list[str]) -> list[str]:
    """Return the comments above an entry below the last blank line."""
    return list(takewhile(bool, reversed(rows)))[::-1]


def _as_list(trail: str | None) -> list[str]:
    return [trail] if trail else []


def _entries_of(source: Source) -> dict[Steps, LayoutEntry]:
    """Return the entries of a text by path; none of an empty text."""
    return dict(_entries(written_layout(parse_document(source))[0])) if source.text.strip() else {}


def _entries(entry: LayoutEntry, path: Steps = ()) -> Iterator[tuple[Steps, LayoutEntry]]:
    for index, child in enumerate(entry.inner):
        inner = (*path, child.key if child.key is not None else str(index))
        yield inner, child
        yield from _entries(child, inner)


def _lost_comments(text: str, side: Source, base: Source) -> list[str]:
    """Return the comments that a side added and that are not in the text."""
    return [row for row in _comments(side.text) if row not in text and row not in base.text]


def _comments(text: str) -> list[str]:
    root, head, foot = written_layout(parse_document(Source(text)))
    rows = [*head, *foot]
    for _, entry in _entries(root):
        rows += [*entry.before, *entry.after, *_as_list(entry.trail)]
    return [row for row in rows if row]


# --- conflicts ------------------------------------------------------------------------------------------------


def _take_theirs(conflicts: list[Conflict]) -> Iterator[Operation]:
    """Yield the operations from the merged text to their version."""
    for conflict in conflicts:
        place = pointer(conflict.path)
        if conflict.theirs is NOTHING:
            yield {"op": "remove", "path": place}
        else:
            yield {"op": "add" if conflict.ours is NOTHING else "replace", "path": place, "value": conflict.theirs}


def with_conflict_markers(ours: str, theirs: str, marker: int) -> str:
    """Return two texts as one, with conflict markers around different lines.

    Args:
        ours: Our text.
        theirs: Their text.
        marker: Length of a conflict marker.
    """
    mine, others = ours.splitlines(keepends=True), theirs.splitlines(keepends=True)
    newline = "\r\n" if mine and mine[0].endswith("\r\n") else "\n"
    rows: list[str] = []
    for tag, a, b, c, d in SequenceMatcher(None, mine, others, autojunk=False).get_opcodes():
        if tag == "equal":
            rows += mine[a:b]
            continue
        rows += [f"{'<' * marker} ours{newline}", *mine[a:b], f"{'=' * marker}{newline}"]
        rows += [*others[c:d], f"{'>' * marker} theirs{newline}"]
    return "".join(rows)


def split_at_markers(text: str) -> tuple[str, str] | None:
    """Return the two texts in a text with conflict markers; None if it has none, or malformed ones."""
    both: tuple[list[str], list[str]] = ([], [])
    inside: int | None = None
    seen = False
    for row in text.splitlines(keepends=True):
        found = _MARKER.match(row)
        step = found[0][0] if found is not None else ""
        if (step, inside) in _MARKER_TRANSITIONS:
            inside, seen = _MARKER_TRANSITIONS[step, inside], True
        elif inside != -1:
            for side, rows in enumerate(both):
                if inside in (None, side):
                    rows.append(row)
    return ("".join(both[0]), "".join(both[1])) if seen and inside is None else None


_MARKER = re.compile(r"(<{7,}|\|{7,}|={7,}|>{7,})(?: .*)?\r?$")
_MARKER_TRANSITIONS: dict[tuple[str, int | None], int | None] = {
    ("<", None): 0, ("|", 0): -1, ("=", 0): 1, ("=", -1): 1, (">", 1): None,
}  # fmt: skip
"""State after each marker: our lines (0), those of the ancestor (-1), theirs (1), or common lines (None)."""
