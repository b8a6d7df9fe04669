"""Selectors: which copies, and which link or joint of them, a name in `actions` means."""

import re

from text2sim.compiler.placing.placement import Copy

SELECTOR = re.compile(r"(?P<body>\w+)(?:\[(?P<index>[^\]]+)\])?(?:\.(?P<part>[\w*]+))?\Z")


def split(selector: str) -> tuple[str, str | None, str | None]:
    """Return (body, index text, link or joint) of a selector that the schema has accepted."""
    match = SELECTOR.match(selector)
    assert match is not None, selector
    return match["body"], match["index"], match["part"]


def select(selector: str, copies: dict[str, list[Copy]]) -> tuple[list[Copy], str | None]:
    """Return the copies that a selector names, and the link or joint.

    Raises:
        KeyError: if the body does not exist.
        IndexError: if no copy has that index.
    """
    body, index, part = split(selector)
    found = copies[body]
    if index is None or index == "*":
        return found, part
    if ":" in index:
        first, last = (int(x) for x in index.split(":"))
        chosen = found[first:last]
    else:
        chosen = found[int(index) : int(index) + 1]
    if not chosen:
        raise IndexError(f"{body} has {len(found)} copies, counted from 0")
    return chosen, part
