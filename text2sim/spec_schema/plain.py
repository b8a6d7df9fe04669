"""Text of other people without what could rewrite a terminal, hide a line, or turn one around."""

import re

_BREAKS = "\t\n"
# Control characters of ASCII and Latin-1; marks that are not seen, join, or change the order of what is read; half
# characters; tags.
_CONTROL = (
    "\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0000-\U000e007f"
)
_IN_TEXT = re.compile(f"[{_CONTROL}]")
_IN_LINE = re.compile(f"[{_CONTROL}{_BREAKS}]")
MARK = "\N{REPLACEMENT CHARACTER}"
"""What stands in their place."""


def plain(text: str) -> str:
    """Return text of any number of lines with a mark for each control character; line feeds and tabs stay."""
    return _IN_TEXT.sub(MARK, text)


def plain_line(text: str) -> str:
    """Return a name or a message that stays on its line: in it, line feeds and tabs are marked, too."""
    return _IN_LINE.sub(MARK, text)


def escaped(text: str) -> str:
    """Return JSON with its control characters as JSON writes them."""
    return _IN_TEXT.sub(lambda found: "".join(f"\\u{ord(half):04x}" for half in _halves(found[0])), text)


def _halves(character: str) -> str:
    """A character as JSON counts it: those beyond U+FFFF are two."""
    code = ord(character)
    if code < 0x10000:
        return character
    code -= 0x10000
    return chr(0xD800 + (code >> 10)) + chr(0xDC00 + (code & 0x3FF))
