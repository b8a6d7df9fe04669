"""Selectors: which copies, and which link or joint of them, a name in `actions` means."""

from text2sim.compiler.placing.placement import Copy
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.names.selectors import parse_selector


def select(selector: str, copies: dict[str, list[Copy]]) -> tuple[list[Copy], str | None]:
    """Return the copies that a selector names, and the link or joint.

    Raises:
        KeyError: if the body does not exist.
        IndexError: if no copy has that index.
    """
    chosen = parse_selector(selector)
    found = copies[chosen.body][chosen.first : chosen.last]
    if not found:
        raise IndexError(f"{chosen.body} has {len(copies[chosen.body])} copies, counted from 0")
    return found, chosen.part


def select_all(selectors: str | list[str], copies: dict[str, list[Copy]]) -> list[Copy]:
    """Return the copies that a selector or a list of them names, each once.

    Raises:
        KeyError: if a body does not exist.
        IndexError: if no copy has that index.
    """
    return list({copy.name: copy for selector in listed(selectors) for copy in select(selector, copies)[0]}.values())
