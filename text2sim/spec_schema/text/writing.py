"""Scalars as text that both YAML 1.1 and 1.2 read back as the same value."""

import json
import re
import textwrap
from math import isfinite
from typing import Any

from text2sim.spec_schema.text.scalars import resolve

# Words that YAML 1.1 does not read as text: booleans, numbers with colons or underscores, dates.
_TRAPS = re.compile(
    r"(?i:yes|no|on|off|true|false|null|~)|[-+]?[0-9][0-9_,.:]*([eE][-+]?[0-9]+)?|0[xob][0-9a-fA-F_]+|[-+.].*|\d{4}-\d.*|=|<<"
)
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_STARTS = re.compile(r"[^\W\d]|[\d/(_]")
_BLOCK_STOPS = re.compile(r": |:$| #|^\s|\s$|[\t\r\n\x85\u2028\u2029]|  ")
_FLOW_STOPS = re.compile(r"[\[\]{},]|:")


def scalar(value: Any, *, flow: bool) -> str:
    """Return the text of a scalar on one line.

    Args:
        value: None, a boolean, a finite number, or text.
        flow: Whether it is inside brackets or braces, where more needs quotes.
    """
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return number(value)
    return value if _plain(value, flow) else quoted(value)


def flow_text(value: Any) -> str:
    """Return the text of any value on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key(name)}: {flow_text(item)}" for name, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow_text(item) for item in value) + "]"
    return scalar(value, flow=True)


def key(name: str) -> str:
    """Return the text of a key; words are never quoted, because the language has the key `on`."""
    return name if _WORD.fullmatch(name) else scalar(name, flow=True)


def number(value: float) -> str:
    """Return the shortest text that is read back as the same number.

    Raises:
        ValueError: If it is not finite.
    """
    if not isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    text = repr(float(value))
    mantissa, e, exponent = text.partition("e")
    # YAML 1.1 reads `1e-05` as text.
    return f"{mantissa}.0e{exponent}" if e and "." not in mantissa else text


def quoted(text: str) -> str:
    """Return a text in double quotes."""
    plain = json.dumps(text, ensure_ascii=False)
    return plain.replace("\x7f", "\\x7f").replace("\x85", "\\N").replace("\u2028", "\\L").replace("\u2029", "\\P")


def block_lines(text: str, width: int) -> list[str] | None:
    """Return a long or multi-line text as a block scalar: its header, and its lines without indentation.

    Returns:
        None if the text needs quotes, or is better on one line.
    """
    if "${" in text or not text.strip() or not all(c.isprintable() or c == "\n" for c in text):
        return None
    body = text.removesuffix("\n")
    lines = body.split("\n")
    if any(line != line.rstrip() for line in lines) or body[:1] in (" ", "\n") or body.endswith("\n"):
        return None
    if "\n" in text:
        return ["|" if text.endswith("\n") else "|-", *lines]
    if len(text) <= width or "  " in text:
        return None
    return [">-", *textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)]


def _plain(text: str, flow: bool) -> bool:
    if not text or "${" in text or not _STARTS.match(text) or not text.isprintable():
        return False
    if _BLOCK_STOPS.search(text) or (flow and _FLOW_STOPS.search(text)):
        return False
    return not _TRAPS.fullmatch(text) and isinstance(resolve(text), str)
