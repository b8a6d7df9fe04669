"""Answers of tools: a small document, perhaps with text and a picture; the rest can be asked for."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.plain import plain

MAX_PAGE = 9_000
"""Characters of one page of text or rows, so that an answer is some 3,000 tokens at most."""
MAX_STRING = 600
"""Characters of one value."""
MAX_LIST = 30
"""Rows of a list that has no pages of its own."""
MAX_PICTURE = 1_500_000
"""Bytes of a picture."""


@dataclass
class ToolAnswer:
    """What a tool answers."""

    document: dict[str, Any]
    """Comes as one line of JSON."""
    text: str = ""
    """Comes after it, as it is."""
    picture: bytes = b""
    media: str = "image/png"
    failed: bool = False
    """Whether the tool did not do what it was asked to."""

    def words(self) -> str:
        """Return the document as JSON, never longer than two pages."""
        said = _dump(self.document)
        if len(said) > 2 * MAX_PAGE:
            said = _dump({key: clipped(value, rows=8) for key, value in self.document.items()} | {"shortened": True})
        return said if len(said) <= 2 * MAX_PAGE else _dump({"shortened": True, "start": said[:MAX_PAGE]})


def refusal(error: str, **more: Any) -> ToolAnswer:
    """Return the answer of a tool that did nothing, and why."""
    return ToolAnswer({"ok": False, "error": clipped(error), **more}, failed=True)


def clipped(value: Any, rows: int = MAX_LIST) -> Any:
    """Return plain data with long texts and long lists cut, and said to be."""
    if isinstance(value, str):
        return value if len(value) <= MAX_STRING else f"{value[:MAX_STRING]}… ({len(value)} characters)"
    if isinstance(value, dict):
        kept = {str(key)[:MAX_STRING]: clipped(inner, rows) for key, inner in list(value.items())[: 2 * rows]}
        return kept if len(value) <= 2 * rows else kept | {"…": f"{len(value) - 2 * rows} more"}
    if isinstance(value, list | tuple):
        some = [clipped(inner, rows) for inner in value[:rows]]
        return some if len(value) <= rows else [*some, f"… {len(value) - rows} more"]
    return value


def paged(rows: Sequence[Any], offset: int) -> dict[str, Any]:
    """Return the rows from `offset` on that fit on a page, and where the next page begins."""
    taken, room = [], MAX_PAGE
    for row in rows[offset:]:
        row = clipped(row)
        room -= len(_dump(row)) + 2
        if taken and room < 0:
            break
        taken.append(row)
    end = offset + len(taken)
    document: dict[str, Any] = {"rows": taken, "total": len(rows)}
    return document | ({"next_offset": end} if end < len(rows) else {})


def text_page(text: str, offset: int) -> tuple[str, dict[str, Any]]:
    """Return a page of text from a character on, to the end of a line, and what to say of it."""
    piece = text[offset : offset + MAX_PAGE]
    if offset + len(piece) < len(text) and (cut := piece.rfind("\n")) > MAX_PAGE // 2:
        piece = piece[: cut + 1]
    end = offset + len(piece)
    said = {"characters": len(text)} | ({"next_offset": end} if end < len(text) else {})
    return plain(piece), said


def digest(text: str) -> str:
    """Return what names a text: whoever replaces it has to know what they replace."""
    return sha256(text.encode()).hexdigest()[:16]


def problem_rows(problems: Iterable[Problem], sources: dict[str, str] | None = None) -> list[dict[str, Any]]:
    """Return problems as rows, each with its place and its line; empty members are left out."""
    lines = {file: text.splitlines() for file, text in (sources or {}).items()}
    rows = []
    for problem in problems:
        text = lines.get(problem.file, [])
        row = {
            "severity": problem.severity,
            "at": f"{problem.file}:{problem.line}:{problem.column}",
            "path": problem.path,
            "message": problem.message,
            "did_you_mean": problem.hint,
            "rule": problem.rule,
            "line": text[problem.line - 1].strip()[:160] if problem.line <= len(text) else "",
        }
        rows.append({key: value for key, value in row.items() if value})
    return rows


def _dump(value: Any) -> str:
    # Names and messages come from files of other people, and half a character could not be sent at all.
    return plain(json.dumps(value, ensure_ascii=False, default=str))
