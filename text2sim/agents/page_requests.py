"""Pages that a role asks for by name in one conversation: each once, as many as there is room for."""

from collections.abc import Callable, Sequence

from text2sim.agents import language


class PageRequests:
    """Serves pages.

    Args:
        other: Returns what there is besides the language under some names, and which those are.
    """

    def __init__(self, other: Callable[[Sequence[str]], dict[str, str]] = lambda names: {}) -> None:
        self._other = other
        self._served: set[str] = set()

    def __call__(self, names: Sequence[str]) -> str:
        """Return pages about kinds, prefabs, and whatever else goes by these names."""
        others = {name: text for name, text in self._other(names).items() if name not in self._served}
        text, served = language.explained([name for name in names if name not in others], self._served)
        self._served |= {*others, *served}
        return "\n\n".join(part for part in (*others.values(), text) if part) or "All of that stands above."
