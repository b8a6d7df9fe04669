"""Masking of `${…}` and of the brackets of `brick[3]` for the YAML parser.

`[${speed}, 0, 0]`, `{size: ${brick}}` and `{body: brick[3]}` are not YAML: braces, brackets, commas and colons end a
plain scalar in a flow collection. So every character there with a meaning in YAML is replaced by one of the private use
area before parsing; lines and columns do not change, and the scalars are mapped back.
"""

import re

# Quotes and backslashes keep their meaning in YAML.
_HIDDEN = "{}[],:#&*!|>%@`?-<=~^ "
_FIRST = 0xE000
_MASK = {ord(c): _FIRST + i for i, c in enumerate(_HIDDEN)}
# YAML 1.2 reads these as content, the parser (of YAML 1.1) as line breaks.
_BREAKS = {0x85: _FIRST + 100, 0x2028: _FIRST + 101, 0x2029: _FIRST + 102}
_UNMASK = {v: chr(k) for k, v in (_MASK | _BREAKS).items()}
_PRIVATE = re.compile("[\ue000-\ue0ff]")
_START = re.compile(r"\$\{")
_BRACKETS = re.compile(r"(?<=\w)\[(?:[\d:*]|\$\ue000[^\ue001\n]*\ue001)+\]")
_INSIDE = re.compile(r"[{}\r\n]")
_DEEPEST = 60  # nested braces; without a bound, a line of many `${` takes quadratic time

MARK = chr(_MASK[ord("{")])
"""Character after the dollar sign of every masked expression."""


def mask(text: str) -> str:
    """Return the text with every `${…}` on one line and the brackets of every selector masked; its length stays."""
    if any(chr(c) in text for c in _BREAKS):
        text = text.translate(_BREAKS)
    if "${" in text:
        text = _mask_expressions(text)
    return _BRACKETS.sub(lambda found: found[0].translate(_MASK), text) if "[" in text else text


def _mask_expressions(text: str) -> str:
    pieces, done = [], 0
    while found := _START.search(text, done):
        end = closing_brace(text, found.end())
        if end is None or _leaves_quotes(text, found.start(), end):
            pieces.append(text[done : found.end()])
            done = found.end()
            continue
        pieces.append(text[done : found.start() + 1])
        pieces.append(text[found.start() + 1 : end + 1].translate(_MASK))
        done = end + 1
    pieces.append(text[done:])
    return "".join(pieces)


def unmask(text: str) -> str:
    """Undo `mask`."""
    return text.translate(_UNMASK) if _PRIVATE.search(text) else text


def find_unclosed(text: str) -> int | None:
    """Return the index of the first `${` outside comments that is not closed on its line and in its quotes."""
    for found in _START.finditer(text):
        line = text[text.rfind("\n", 0, found.start()) + 1 : found.start()]
        end = closing_brace(text, found.end())
        if (end is None or _leaves_quotes(text, found.start(), end)) and "#" not in line:
            return found.start()
    return None


def _leaves_quotes(text: str, start: int, end: int) -> bool:
    """Return whether the brace at `end` is outside the quotes around `${` at `start`, as in `{height: "${length"}`."""
    line = text.rfind("\n", 0, start) + 1
    return any(text.count(q, line, start) % 2 == 1 and text.count(q, start, end) % 2 == 1 for q in "\"'")


def closing_brace(text: str, start: int) -> int | None:
    """Return the index of the brace that closes the one before `start` on the same line, or None."""
    depth = 1
    while found := _INSIDE.search(text, start):
        if found[0] == "{":
            depth += 1
            if depth > _DEEPEST:
                return None
        elif found[0] == "}":
            depth -= 1
            if depth == 0:
                return found.start()
        else:
            return None
        start = found.end()
    return None
