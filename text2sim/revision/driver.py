"""What git calls for a case: to show a difference, to make it text, and to merge."""

import difflib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path as FilePath

from text2sim.revision.repository import run_git_status
from text2sim.revision.side import Side, text_side
from text2sim.spec_schema.changes.diff_words import value_text
from text2sim.spec_schema.changes.edit import identical
from text2sim.spec_schema.changes.merge_text import MergedText, marked, merge_texts, unmarked
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.reuse.library import prefab_problems
from text2sim.spec_schema.text.document import Path, parse_document
from text2sim.spec_schema.text.layout import Entry, plain_data, written_layout
from text2sim.spec_schema.text.source import Source, read_source


@dataclass(frozen=True)
class MergeResult:
    """What a merge leaves behind."""

    text: bytes
    clean: bool
    """Whether nobody has to look at it."""
    remarks: list[str] = field(default_factory=list)


def flat_text(source: Source) -> str:
    """A case as one line for each value, with the way to it, for `git log -p`; the text itself if it is no YAML.

    Of a text with conflict markers, both sides are made so, and marked where they differ.
    """
    sides = unmarked(source.text)
    if sides is not None:
        ours, theirs = (flat_text(Source(text, source.file)) for text in sides)
        return marked(ours, theirs, 7)
    try:
        root, head, foot = written_layout(parse_document(source))
    except SpecError:
        return source.text
    return "".join(f"{row}\n" for row in [*head, *_flat_rows(root, ()), *foot])


def _flat_rows(entry: Entry, path: Path) -> Iterator[str]:
    """Rows of what is inside an entry; lists of scalars stand on one line."""
    for index, child in enumerate(entry.inner):
        inner = (*path, child.key if child.key is not None else index)
        yield from (row for row in child.before if row)
        trail = f"  {child.trail}" if child.trail else ""
        if child.inner and (child.mapping or any(isinstance(item.value, list) for item in child.inner)):
            if trail:
                yield f"{dotted(inner)}:{trail}"
            yield from _flat_rows(child, inner)
        else:
            yield f"{dotted(inner)}: {value_text(plain_data(child), shown=100_000)}{trail}"
        yield from child.after


def driver_side(path: FilePath, name: str, label: str) -> Side | None:
    """A version that git has put into a file of its own; None if there was none, or it is no YAML."""
    try:
        source = read_source(path)
        return text_side(Source(source.text, label), label, FilePath(name)) if source.text.strip() else None
    except SpecError:
        return None


def text_difference(old: FilePath, new: FilePath, name: str) -> list[str]:
    """The lines that differ, for what has no meaning that could be compared."""
    before, after = (_lines(path) for path in (old, new))
    return [row.rstrip("\n") for row in difflib.unified_diff(before, after, f"a/{name}", f"b/{name}")]


def _lines(path: FilePath) -> list[str]:
    try:
        return path.read_text("utf-8", "replace").splitlines(keepends=True)
    except OSError:
        return []


def merge_files(base: FilePath, ours: FilePath, theirs: FilePath, name: str, marker: int) -> MergeResult:
    """Merge three files that git has written.

    Meaning decides. Git's own merge of the lines is taken where it is clean and says the same, and where meaning
    cannot help: if one of the files is no YAML, or what comes out of the merge of meaning is no valid case.

    Args:
        base: The common ancestor.
        ours: Our version.
        theirs: Their version.
        name: The path of the case in the repository.
        marker: How many characters a conflict marker has.
    """
    lines, clean = _merge_lines(base, ours, theirs, marker)
    try:
        one, two, three = (read_source(path, name) for path in (base, ours, theirs))
        merged = merge_texts(one, two, three, marker)
    except SpecError as error:
        return MergeResult(lines, clean, [f"merged line by line: {error.problems[0]}"])
    if merged.conflicts:
        places = ", ".join(dotted(conflict.path) for conflict in merged.conflicts)
        return MergeResult(merged.text.encode(), False, [f"changed on both sides: {places}", *_lost(merged)])
    if clean and _says_the_same(lines, merged.text, name):
        return MergeResult(lines, True)
    wrong = _first_problem(merged.text, name)
    if wrong is None or any(_first_problem(source.text, name) for source in (two, three)):
        return MergeResult(merged.text.encode(), True, _lost(merged))
    remark = f"both changes together are not valid, so it was merged line by line: {wrong}"
    clean = clean and _first_problem(lines.decode("utf-8", "replace"), name) is None
    return MergeResult(lines, clean, [remark])


def _lost(merged: MergedText) -> list[str]:
    return [f"a comment of theirs has found no place: {row}" for row in merged.lost]


def _merge_lines(base: FilePath, ours: FilePath, theirs: FilePath, marker: int) -> tuple[bytes, bool]:
    """What git's own merge of the lines makes of it, and whether it is without conflicts."""
    labels = ["-L", "ours", "-L", "base", "-L", "theirs"]
    arguments = ["merge-file", "-p", f"--marker-size={marker}", *labels]
    files = [str(path.absolute()) for path in (ours, base, theirs)]
    with tempfile.TemporaryDirectory(prefix="text2sim-") as folder:
        text, code = run_git_status([*arguments, *files], FilePath(folder))
    return text, code == 0


def _says_the_same(lines: bytes, text: str, name: str) -> bool:
    try:
        found = parse_document(Source(lines.decode("utf-8"), name)).data
    except (SpecError, UnicodeDecodeError):
        return False
    return identical(found, parse_document(Source(text, name)).data)


def _first_problem(text: str, name: str) -> str | None:
    """What keeps a text from being a case whose references hold, or a prefab; None if nothing does."""
    source = Source(text, name)
    try:
        data = parse_document(source).data
        prefab = isinstance(data, dict) and "prefab" in data
        problems = prefab_problems(source) if prefab else check_references(load_text(text, FilePath(name)))
    except SpecError as error:
        problems = error.problems
    return next((str(problem) for problem in problems if problem.severity == "error"), None)
