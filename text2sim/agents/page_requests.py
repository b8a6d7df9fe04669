"""Page requests of a role in one conversation: each page is served once."""

from collections.abc import Callable, Sequence

from text2sim.agents import language


class PageRequests:
    """Answers requests for reference pages by name.

    Args:
        other: Returns those of the named pages that are not part of the language reference, by name.
        examples: Whether to show how a kind is written, as for a reader who writes a section.
    """

    def __init__(
        self, other: Callable[[Sequence[str]], dict[str, str]] = lambda names: {}, *, examples: bool = True
    ) -> None:
        self._other = other
        self._examples = examples
        self._served: set[str] = set()

    def __call__(self, names: Sequence[str]) -> str:
        """Return the pages with these names."""
        others = {name: text for name, text in self._other(names).items() if name not in self._served}
        left = [name for name in names if name not in others]
        text, served = language.explanations(left, self._served, examples=self._examples)
        self._served |= {*others, *served}
        return "\n\n".join(part for part in (*others.values(), text) if part) or "These pages are above."
