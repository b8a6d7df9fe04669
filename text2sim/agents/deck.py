"""The cards that a loop can deal: none of them, where it is asked to do without."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from text2sim.agents.journal import Emit

if TYPE_CHECKING:
    from text2sim.card_library.library import Library

ATTACHED = 2
"""Cards that go with one question."""
OFFERED = 6
"""Cards that are put before the Planner after a failure."""


@dataclass
class Deck:
    """The library, or nothing."""

    library: "Library | None"
    emit: Emit
    dealt: dict[str, set[str]] = field(default_factory=dict)
    """Cards that each role was given."""

    def index(self) -> str:
        """The names of all cards, for the Planner: they say what each is about."""
        return "" if self.library is None else ", ".join(sorted(self.library.entries))

    @property
    def dealing(self) -> bool:
        """Whether there are cards at all."""
        return self.library is not None

    def has(self, card: str) -> bool:
        """Whether there is such a card."""
        return self.library is not None and card in self.library.entries

    def pages(self, names: Iterable[str]) -> dict[str, str]:
        """The whole of those cards that go by some names, for the Planner."""
        if self.library is None:
            return {}
        return {name: self.library.entries[name].card.brief("planner") for name in names if self.has(name)}

    def deal(self, role: str, cards: Iterable[str], about: str) -> str:
        """Give cards to a role for one question, and keep that it had them.

        Args:
            role: Who gets them.
            cards: Their ids, as somebody chose them; what does not exist is left out.
            about: The question, for the record.
        """
        chosen = [card for card in dict.fromkeys(cards) if self.has(card)][:ATTACHED]
        if not chosen:
            return ""
        assert self.library is not None
        self.dealt.setdefault(role, set()).update(chosen)
        self.emit("cards", role=role, cards=chosen, about=about)
        reader: Any = role
        return "\n\n".join(self.library.entries[card].card.brief(reader) for card in chosen)

    def offer(self, text: str, modes: Collection[str], signatures: Collection[str]) -> str:
        """One line for each card that may fit a failure."""
        if self.library is None:
            return ""
        from text2sim.card_library.retrieval import find_cards

        known: Any = [mode for mode in modes if mode in _MODES]
        matches = find_cards(self.library, text=text, modes=known, signatures=signatures, limit=OFFERED)
        return "\n".join(f"- {match.entry.card.index_line()}" for match in matches)


_MODES = frozenset({"rigid", "articulated", "soft", "cloth", "rope", "granular", "liquid", "snow", "driven", "film"})
