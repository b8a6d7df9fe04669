"""Page requests of a role in one conversation: each page is served once, within a size limit."""

from collections.abc import Callable, Sequence

from text2sim.agents import language


class PageRequests:
    """Server of reference pages by name.

    Args:
        other: Returns pages from outside the language for some names, and the names served.
    """

    def __init__(self, other: Callable[[Sequence[str]], dict[str, str]] = lambda names: {}) -> None:
        self._other = other
        self._served: set[str] = set()

    def __call__(self, names: Sequence[str]) -> str:
        """Return the pages with these names."""
        others = {name: text for name, text in self._other(names).items() if name not in self._served}
        text, served = language.explanations([name for name in names if name not in others], self._served)
        self._served |= {*others, *served}
        return "\n\n".join(part for part in (*others.values(), text) if part) or "All of that stands above."
