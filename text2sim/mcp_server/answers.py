"""Answers of tools: a small document, and optionally text and a picture; longer ones have pages."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from io import BytesIO
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.plain import plain

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_PAGE = 9_000
"""Characters of a page of text or rows, so that an answer has at most about 3,000 tokens."""
MAX_STRING = 600
"""Characters of a value."""
MAX_LIST = 30
"""Rows of a list without pages."""
MAX_PICTURE = 1_500_000
"""Size of a picture [bytes]."""


@dataclass
class ToolAnswer:
    """Answer of a tool."""

    document: dict[str, Any]
    """Sent as one line of JSON."""
    text: str = ""
    """Sent after the document, unchanged."""
    picture: bytes = b""
    media: str = "image/png"
    failed: bool = False
    """Whether the tool failed."""

    def words(self) -> str:
        """Return the document as JSON of at most two pages."""
        text = _dump(self.document)
        if len(text) > 2 * MAX_PAGE:
            text = _dump({key: clipped(value, rows=8) for key, value in self.document.items()} | {"shortened": True})
        return text if len(text) <= 2 * MAX_PAGE else _dump({"shortened": True, "start": text[:MAX_PAGE]})


def refusal(error: str, **more: Any) -> ToolAnswer:
    """Return the answer of a tool that did nothing, with the reason."""
    return ToolAnswer({"ok": False, "error": clipped(error), **more}, failed=True)


def clipped(value: Any, rows: int = MAX_LIST) -> Any:
    """Return plain data with long texts and lists cut, and a note where they are."""
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
    """Return the page of rows that begins at `offset`, with the offset of the next page."""
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
    """Return the page of a text that begins at a character, up to the end of a line, and members for the document."""
    piece = text[offset : offset + MAX_PAGE]
    if offset + len(piece) < len(text) and (cut := piece.rfind("\n")) > MAX_PAGE // 2:
        piece = piece[: cut + 1]
    end = offset + len(piece)
    return plain(piece), {"characters": len(text)} | ({"next_offset": end} if end < len(text) else {})


def digest(text: str) -> str:
    """Return the digest of a text, which a caller gives to show which text it replaces."""
    return sha256(text.encode()).hexdigest()[:16]


def problem_rows(problems: Iterable[Problem], sources: dict[str, str] | None = None) -> list[dict[str, Any]]:
    """Return problems as rows with places and lines, without empty members."""
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
    # Names and messages come from other people's files, and a lone surrogate could not be sent.
    return plain(json.dumps(value, ensure_ascii=False, default=str))


def compressed(png: bytes) -> tuple[bytes, str]:
    """Return a PNG as a JPEG, and its type."""
    from PIL import Image

    with Image.open(BytesIO(png)) as picture:
        return jpeg(picture.convert("RGB")), "image/jpeg"


def jpeg(picture: "Image") -> bytes:
    """Return a picture as a JPEG of limited size; quality is reduced first, then resolution."""
    for quality in (88, 75, 60):
        content = picture_bytes(picture, "JPEG", quality=quality, optimize=True)
        if len(content) <= MAX_PICTURE:
            return content
    picture = picture.resize((max(1, picture.width // 2), max(1, picture.height // 2)))
    return picture_bytes(picture, "JPEG", quality=60)
