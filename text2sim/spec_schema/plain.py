"""Removal of control characters from foreign text, which could rewrite a terminal, or hide or reorder lines."""

import re

_BREAKS = "\t\n"
# Control characters of ASCII and Latin-1; invisible, joining and bidirectional marks; surrogates; tags.
_CONTROL = (
    "\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0000-\U000e007f"
)
_IN_TEXT = re.compile(f"[{_CONTROL}]")
_IN_LINE = re.compile(f"[{_CONTROL}{_BREAKS}]")
MARK = "\N{REPLACEMENT CHARACTER}"
"""Replacement for a control character."""


def plain(text: str) -> str:
    """Return text with `MARK` for each control character except line feeds and tabs."""
    return _IN_TEXT.sub(MARK, text)


def plain_line(text: str) -> str:
    """Return a name or a message with `MARK` for each control character, including line feeds and tabs."""
    return _IN_LINE.sub(MARK, text)


def escaped(text: str) -> str:
    """Return JSON with its control characters escaped."""
    return _IN_TEXT.sub(_escape, text)


def _escape(found: re.Match[str]) -> str:
    units = found[0].encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{units[k : k + 4]}" for k in range(0, len(units), 4))
