"""Merge driver of git for cases; nothing that either side wrote is lost without a conflict marker."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from text2sim.revision.repository import run_git_status
from text2sim.spec_schema.changes.amendment import identical
from text2sim.spec_schema.changes.diff import NOTHING
from text2sim.spec_schema.changes.merge_text import MergedText, merge_texts, split_at_markers
from text2sim.spec_schema.errors import Problem, SpecError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.reuse.library import prefab_problems
from text2sim.spec_schema.text.document import Path, parse_document, parse_pointer
from text2sim.spec_schema.text.source import Source, read_source


@dataclass(frozen=True)
class MergeResult:
    """Result of a merge."""

    text: bytes
    clean: bool
    """Whether it needs no review by a person."""
    remarks: list[str] = field(default_factory=list)


def merge_files(base: FilePath, ours: FilePath, theirs: FilePath, name: str, marker: int) -> MergeResult:
    """Merge three files that git has written.

    The files are merged by meaning. Git's own merge of the lines is used if it is clean and has the same meaning, or if
    merging by meaning fails: one of the files is not YAML, or the merged case is invalid for no known cause.

    Args:
        base: The common ancestor.
        ours: Our version.
        theirs: Their version.
        name: The path of the case in the repository.
        marker: Number of characters of a conflict marker.
    """
    lines, clean = _merge_lines(base, ours, theirs, marker)
    try:
        one, two, three = (read_source(path, name) for path in (base, ours, theirs))
        return _merge_meaning((one, two, three), name, marker, lines, clean)
    except SpecError as error:
        return MergeResult(lines, clean, [f"merged line by line: {error.problems[0]}"])
    except (Text2SimError, AssertionError, ValueError, LookupError, TypeError) as error:
        # A failure of the semantic merge must not lose the merge of lines; a person has to review that.
        return MergeResult(lines, False, [f"merged line by line: {type(error).__name__}: {error}"])


def _merge_meaning(sources: Sequence[Source], name: str, marker: int, lines: bytes, clean: bool) -> MergeResult:
    base, ours, theirs = sources
    merged, why = merge_texts(base, ours, theirs, marker), "changed on both sides"
    problems = [problem for text in _sides(merged) for problem in _problems(text, name)]
    if problems and not any(_problems(source.text, name) for source in (ours, theirs)):
        opposed = _opposed_entries(merged.versions, problems)
        if opposed:
            merged = merge_texts(base, ours, theirs, marker, opposed)
            why = f"both changes together are not valid ({problems[0].message})"
        elif not merged.conflicts:
            remark = f"both changes together are not valid, so it was merged line by line: {problems[0]}"
            return MergeResult(lines, False, [remark])
    if merged.conflicts:
        places = ", ".join(dotted(conflict.path) for conflict in merged.conflicts)
        return _marked(merged, marker, [f"{why}: {places}"])
    if clean and _has_same_meaning(lines, merged.text, name):
        return MergeResult(lines, True)
    if merged.lost or merged.lost_ours:
        return _marked(merged, marker, [])
    return MergeResult(merged.text.encode(), True)


def _marked(merged: MergedText, marker: int, remarks: list[str]) -> MergeResult:
    """A merge that needs review; comments without a place in it are appended."""
    text, lost = merged.text.encode(), (merged.lost_ours, merged.lost)
    if any(lost):
        ours, theirs = ("".join(f"{row}\n" for row in rows).encode() for rows in lost)
        text += _side_by_side(ours, theirs, marker)
    found = [
        f"a comment of {whose} has no place in the merge: {row}"
        for whose, rows in zip(("ours", "theirs"), lost, strict=True)
        for row in rows
    ]
    return MergeResult(text, False, [*remarks, *found])


def _sides(merged: MergedText) -> tuple[str, ...]:
    """The texts that result from resolving all conflicts in favour of one side."""
    return (split_at_markers(merged.text) or ()) if merged.conflicts else (merged.text,)


# --- incompatible changes -------------------------------------------------------------------------------------


def _opposed_entries(versions: tuple[Any, Any, Any], problems: Sequence[Problem]) -> list[Path]:
    """Paths of the entries that make a merge invalid: invalid ones, and removed ones that they refer to.

    No path is below another. One side has changed each entry, and the other has not.
    """
    gone, (_, ours, theirs) = list(_removed_entries(*versions, ())), versions
    found: set[Path] = set()
    for problem in problems:
        place = _changed(ours, theirs, parse_pointer(problem.path))
        if place is None:
            continue
        words = {word for side in (ours, theirs) for word in _words_in(_value_at(side, place))}
        culprits = [path for path in gone if path[-1] in words and not _overlap(path, place)]
        found |= {place, *culprits}
    return sorted(path for path in found if not any(path != other and path[: len(other)] == other for other in found))


def _changed(ours: Any, theirs: Any, path: Path) -> Path | None:
    """The shortest prefix of a path at which the sides differ and are not both mappings; None if they agree."""
    for depth in range(1, len(path) + 1):
        prefix = path[:depth]
        mine, others = _value_at(ours, prefix), _value_at(theirs, prefix)
        if identical(mine, others):
            return None
        if not isinstance(mine, dict) or not isinstance(others, dict):
            return prefix
    return path if path else None


def _removed_entries(base: Any, ours: Any, theirs: Any, path: Path) -> Iterator[Path]:
    """Named entries of the ancestor that exactly one side has removed."""
    if not isinstance(base, dict):
        return
    for key, value in base.items():
        mine, others = ((side.get(key, NOTHING) if isinstance(side, dict) else NOTHING) for side in (ours, theirs))
        if mine is NOTHING and others is NOTHING:
            continue
        if mine is NOTHING or others is NOTHING:
            yield (*path, key)
        else:
            yield from _removed_entries(value, mine, others, (*path, key))


def _words_in(value: Any) -> Iterator[str]:
    """Words in a value: `ball` for `ball`, `ball[3]`, `ball.hand` and `${ball + 1}`."""
    if isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _words_in(item)
    elif isinstance(value, str):
        yield from "".join(c if c.isalnum() or c == "_" else " " for c in value).split()


def _value_at(data: Any, path: Path) -> Any:
    for step in path:
        if isinstance(data, list) and isinstance(step, int) and step < len(data):
            data = data[step]
        elif isinstance(data, dict) and step in data:
            data = data[step]
        else:
            return NOTHING
    return data


def _overlap(a: Path, b: Path) -> bool:
    least = min(len(a), len(b))
    return a[:least] == b[:least]


# --- lines ----------------------------------------------------------------------------------------------------


def _merge_lines(base: FilePath, ours: FilePath, theirs: FilePath, marker: int) -> tuple[bytes, bool]:
    """Git's own merge of the lines, and whether it has no conflicts."""
    labels = ["-L", "ours", "-L", "base", "-L", "theirs"]
    arguments = ["merge-file", "-p", f"--marker-size={marker}", *labels]
    files = [str(path.absolute()) for path in (ours, base, theirs)]
    with tempfile.TemporaryDirectory(prefix="text2sim-") as folder:
        text, code = run_git_status([*arguments, *files], FilePath(folder))
    if 0 <= code < 128:
        return text, code == 0
    mine, others = ours.read_bytes(), theirs.read_bytes()
    return _side_by_side(mine, others, marker), mine == others


def _side_by_side(ours: bytes, theirs: bytes, marker: int) -> bytes:
    """Both files as one conflict; ours if they are binary, as in git."""
    if ours == theirs or b"\0" in ours + theirs:
        return ours
    sides = [side + (b"" if not side or side.endswith(b"\n") else b"\n") for side in (ours, theirs)]
    marks = [mark * marker for mark in (b"<", b"=", b">")]
    return b"%s ours\n%s%s\n%s%s theirs\n" % (marks[0], sides[0], marks[1], sides[1], marks[2])


def _has_same_meaning(lines: bytes, text: str, name: str) -> bool:
    try:
        found = parse_document(Source(lines.decode("utf-8"), name)).data
    except (SpecError, UnicodeDecodeError):
        return False
    return identical(found, parse_document(Source(text, name)).data)


def _problems(text: str, name: str) -> list[Problem]:
    """Errors of a text as a case, including its references, or as a prefab."""
    source = Source(text, name)
    try:
        data = parse_document(source).data
        prefab = isinstance(data, dict) and "prefab" in data
        problems = prefab_problems(source) if prefab else check_references(load_text(text, FilePath(name)))
    except SpecError as error:
        problems = error.problems
    return [problem for problem in problems if problem.severity == "error"]
