"""A three-way merge of meaning, on the texts: our comments stay, theirs come along, conflicts get markers."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from itertools import takewhile
from typing import Any

from text2sim.spec_schema.changes.amendment import DocumentLayout
from text2sim.spec_schema.changes.diff import NOTHING, operations
from text2sim.spec_schema.changes.edit import edit_source, write_amended
from text2sim.spec_schema.changes.merge import Conflict, merge
from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.reuse.migration import steps_for
from text2sim.spec_schema.text.document import Path, parse_document, pointer
from text2sim.spec_schema.text.layout import LayoutEntry, written_layout
from text2sim.spec_schema.text.source import Source

Steps = tuple[str, ...]


@dataclass(frozen=True)
class MergedText:
    """What comes out of a merge."""

    text: str
    """With conflict markers where there are conflicts."""
    conflicts: list[Conflict]
    lost: list[str]
    """Comments of theirs that found no place."""
    lost_ours: list[str]
    """Comments of ours that went with what they took away."""
    versions: tuple[Any, Any, Any]
    """The data of the ancestor, of ours and of theirs, all in one version of the language."""


def merge_texts(
    base: Source, ours: Source, theirs: Source, marker: int = 7, opposed: Sequence[Path] = ()
) -> MergedText:
    """Merge two versions of a case.

    Args:
        base: The common ancestor; without any text if there is none.
        ours: What we made of it.
        theirs: What they made of it.
        marker: How many characters a conflict marker has.
        opposed: As in `merge`.

    Raises:
        SpecError: If one of them is not YAML that the language accepts.
    """
    if _version(ours) != _version(theirs):
        base, ours, theirs = (_migrated(source) for source in (base, ours, theirs))
    old, mine, others = (_data(source) for source in (base, ours, theirs))
    merged = merge(old, mine, others, opposed)
    entries = dict(_entries(written_layout(parse_document(theirs))[0])) if theirs.text.strip() else {}
    text = _amend(ours, operations(mine, merged.data), merged.data, entries, base)
    lost, lost_ours = (_lost(text, source, base) for source in (theirs, ours))
    if merged.conflicts:
        steps = list(_take_theirs(merged.conflicts))
        other = edit_source(Source(text, ours.file), steps, entries.get)
        text = marked(text, other, marker)
    return MergedText(text, merged.conflicts, lost, lost_ours, (old, mine, others))


def _data(source: Source) -> Any:
    return parse_document(source).data if source.text.strip() else {}


def _version(source: Source) -> Any:
    data = _data(source)
    return data.get("text2sim") if isinstance(data, dict) else None


def _migrated(source: Source) -> Source:
    """The text in the latest version of the language, of which the other side may be."""
    steps = steps_for(_data(source))
    return replace(source, text=edit_source(source, steps)) if steps else source


def _amend(ours: Source, steps: list[Operation], wanted: Any, theirs: dict[Steps, LayoutEntry], base: Source) -> str:
    """Our text with their changes and their comments."""
    amendment = DocumentLayout(parse_document(ours), theirs.get)
    written = {entry for _, entry in _entries(amendment.root)}
    amendment.apply(steps)
    known = dict(_entries(written_layout(parse_document(base))[0])) if base.text.strip() else {}
    for path, entry in list(_entries(amendment.root)):
        other, old = theirs.get(path), known.get(path)
        if other is None or old is None or entry not in written:
            continue
        above = _both(_attached(old.before), _attached(entry.before), _attached(other.before))
        rest = entry.before[: len(entry.before) - len(_attached(entry.before))]
        entry.before = [*rest, *above]
        entry.trail = "  ".join(_both(_listed(old.trail), _listed(entry.trail), _listed(other.trail))) or None
        entry.after = _both(old.after, entry.after, other.after)
    return write_amended(ours, amendment, wanted)


def _both(base: list[str], ours: list[str], theirs: list[str]) -> list[str]:
    """Comments of a place after both could have changed them: what they wrote comes after what we wrote."""
    if ours == base:
        return theirs
    return ours if theirs == base else [*ours, *(row for row in theirs if row not in ours and row not in base)]


def _attached(rows: list[str]) -> list[str]:
    """The comments right above an entry: those below the last blank line."""
    return list(takewhile(bool, reversed(rows)))[::-1]


def _listed(trail: str | None) -> list[str]:
    return [trail] if trail else []


def _entries(entry: LayoutEntry, path: Steps = ()) -> Iterator[tuple[Steps, LayoutEntry]]:
    for index, child in enumerate(entry.inner):
        inner = (*path, child.key if child.key is not None else str(index))
        yield inner, child
        yield from _entries(child, inner)


def _lost(text: str, side: Source, base: Source) -> list[str]:
    """Comments that a side added and that are not in the text."""
    return [row for row in _comments(side.text) if row not in text and row not in base.text]


def _comments(text: str) -> list[str]:
    document = parse_document(Source(text))
    root, head, foot = written_layout(document)
    rows = [*head, *foot]
    for _, entry in _entries(root):
        rows += [*entry.before, *entry.after, *([entry.trail] if entry.trail else [])]
    return [row for row in rows if row]


# --- conflicts ------------------------------------------------------------------------------------------------


def _take_theirs(conflicts: list[Conflict]) -> Iterator[Operation]:
    """What makes their version of the merged text."""
    for conflict in conflicts:
        place = pointer(conflict.path)
        if conflict.theirs is NOTHING:
            yield {"op": "remove", "path": place}
        else:
            yield {"op": "add" if conflict.ours is NOTHING else "replace", "path": place, "value": conflict.theirs}


def marked(ours: str, theirs: str, marker: int) -> str:
    """Return two texts in one, with conflict markers around the lines in which they differ.

    Args:
        ours: The one text.
        theirs: The other text.
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


def unmarked(text: str) -> tuple[str, str] | None:
    """Return the two texts that a text with conflict markers holds; None if it holds none, or others than ours."""
    both: tuple[list[str], list[str]] = ([], [])
    inside: int | None = None
    seen = False
    for row in text.splitlines(keepends=True):
        found = _MARKER.match(row)
        step = found[0][0] if found is not None else ""
        if (step, inside) in _STEPS:
            inside, seen = _STEPS[step, inside], True
        elif inside != -1:
            for side, rows in enumerate(both):
                if inside in (None, side):
                    rows.append(row)
    return ("".join(both[0]), "".join(both[1])) if seen and inside is None else None


_MARKER = re.compile(r"(<{7,}|\|{7,}|={7,}|>{7,})(?: .*)?\r?$")
_STEPS: dict[tuple[str, int | None], int | None] = {
    ("<", None): 0, ("|", 0): -1, ("=", 0): 1, ("=", -1): 1, (">", 1): None,
}  # fmt: skip
"""What comes after each marker: our lines (0), those of the ancestor (-1), theirs (1), or those of both (None)."""
