"""Selectors: `brick`, `brick[*]`, `brick[3]`, `brick[2:5]`, `arm[1].hand`, `net.x5_*`."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

_FORM = re.compile(r"(?P<body>\w+)(?:\[(?P<index>[\d:*]+)\])?(?:\.(?P<part>[\w*]+))?\Z", re.ASCII)
WORLD = "world"
"""Name of the world, for attachments, for loops and in model files."""


@dataclass(frozen=True)
class Selection:
    """The parts of a selector."""

    body: str
    """Name of a body or static."""
    first: int | None = None
    """Number of the first copy; None for every copy."""
    last: int | None = None
    """One more than the number of the last copy."""
    part: str | None = None
    """Link or joint, or a pattern of names with `*` for any letters."""
    indexed: bool = False
    """Whether it has brackets."""

    def count(self, copies: int) -> int:
        """Return the number of selected copies, of a number of copies."""
        if self.first is None or self.last is None:
            return copies
        return max(0, min(self.last, copies) - self.first)


def body_of(selector: str) -> str:
    """Return the name before brackets and dots: `arm` of `arm[1].hand`; any other text stays as it is."""
    return selector.partition("[")[0].partition(".")[0]


def quoted(selectors: Iterable[str]) -> str:
    """Return selectors for messages: "`a`, `b`"."""
    return ", ".join(f"`{selector}`" for selector in selectors)


def strings_in(value: object) -> list[str]:
    """Return all strings in nested mappings and lists, without keys."""
    if isinstance(value, str):
        return [value]
    rows = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return [text for row in rows for text in strings_in(row)]


def named_by(part: str, names: Iterable[str]) -> list[str]:
    """Return the names that the link or joint of a selector matches: itself, or those of a pattern with `*`."""
    if "*" not in part:
        return [name for name in names if name == part]
    return [name for name in names if name != WORLD and _fits(part.split("*"), name)]


def _fits(pieces: list[str], name: str) -> bool:
    """Return whether a name consists of these pieces, with any letters between.

    Each piece is matched at its first occurrence: a regular expression may take exponential time.
    """
    first, *inner, last = pieces
    if not name.startswith(first) or not name.endswith(last):
        return False
    at, end = len(first), len(name) - len(last)
    for piece in inner:
        at = name.find(piece, at, end)
        if at < 0:
            return False
        at += len(piece)
    return at <= end


def keys_for(name: str, keys: Iterable[str]) -> list[str]:
    """Return the keys of a mapping that match a name, patterns first, because names override them."""
    return sorted((key for key in keys if named_by(key, [name])), key=lambda key: "*" not in key)


def spread_over(names: Iterable[str], values: Mapping[str, float]) -> dict[str, float]:
    """Return the values by name from a mapping whose keys may be patterns."""
    found = {name: keys_for(name, values) for name in names}
    return {name: values[keys[-1]] for name, keys in found.items() if keys}


def parse_selector(text: str) -> Selection:
    """Parse a selector.

    Raises:
        ValueError: If it is not a selector; the models refuse such text.
    """
    found = _FORM.match(text)
    if found is None:
        raise ValueError(f"`{text}` is not a selector")
    index = found["index"]
    if index is None or index == "*":
        return Selection(found["body"], None, None, found["part"], index is not None)
    first, colon, last = index.partition(":")
    start = int(first)
    return Selection(found["body"], start, int(last) if colon else start + 1, found["part"], True)
