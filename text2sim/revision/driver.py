"""Versions of a case for git's diff driver and text conversion."""

import difflib
from collections.abc import Iterator
from pathlib import Path as FilePath

from text2sim.revision.side import Side, text_side
from text2sim.spec_schema.changes.diff_words import value_text
from text2sim.spec_schema.changes.merge_text import split_at_markers, with_conflict_markers
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.text.document import Path, parse_document
from text2sim.spec_schema.text.layout import LayoutEntry, plain_data, written_layout
from text2sim.spec_schema.text.source import Source, read_source


def flat_text(source: Source) -> str:
    """Return a case as one line `path: value` for each value, for `git log -p`; the text itself if it is not YAML.

    Both sides of a text with conflict markers are converted, and marked where they differ.
    """
    sides = split_at_markers(source.text)
    if sides is not None:
        ours, theirs = (flat_text(Source(text, source.file)) for text in sides)
        return with_conflict_markers(ours, theirs, 7)
    try:
        root, head, foot = written_layout(parse_document(source))
    except SpecError:
        return source.text
    return "".join(f"{row}\n" for row in [*head, *_flat_rows(root, ()), *foot])


def _flat_rows(entry: LayoutEntry, path: Path) -> Iterator[str]:
    """Rows of the values in an entry; a list of scalars takes one row."""
    for index, child in enumerate(entry.inner):
        inner = (*path, child.key if child.key is not None else index)
        yield from (row for row in child.before if row)
        trail = f"  {child.trail}" if child.trail else ""
        if child.inner and (child.mapping or any(isinstance(item.value, list) for item in child.inner)):
            if trail:
                yield f"{dotted(inner)}:{trail}"
            yield from _flat_rows(child, inner)
        else:
            yield f"{dotted(inner)}: {value_text(plain_data(child), width=100_000)}{trail}"
        yield from child.after


def driver_side(path: FilePath, name: str, label: str) -> Side | None:
    """Return a version that git has written to a temporary file; None if it is empty or not YAML.

    Args:
        path: File that git has written.
        name: Path of the case in the repository.
        label: Name of the version in messages.
    """
    try:
        source = read_source(path)
        return text_side(Source(source.text, label), label, FilePath(name)) if source.text.strip() else None
    except SpecError:
        return None


def text_difference(old: FilePath, new: FilePath, name: str) -> list[str]:
    """Return a unified diff, for files that are not cases.

    Args:
        old: File of the earlier version.
        new: File of the later version.
        name: Path of the file in the repository.
    """
    before, after = (_lines(path) for path in (old, new))
    return [row.rstrip("\n") for row in difflib.unified_diff(before, after, f"a/{name}", f"b/{name}")]


def _lines(path: FilePath) -> list[str]:
    try:
        return path.read_text("utf-8", "replace").splitlines(keepends=True)
    except OSError:
        return []
