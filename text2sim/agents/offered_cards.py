"""Debug Cards that a loop may hand to roles; an empty set when cards are switched off."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, get_args

from text2sim.agents.journal import Emit
from text2sim.agents.replies import Fragments
from text2sim.card_library.model import Mode

if TYPE_CHECKING:
    from text2sim.card_library.library import CardLibrary

MAX_GIVEN_CARDS = 2
"""Largest number of cards with one question."""
MIN_WORD_SCORE = 0.5
"""Smallest word score of a card without a matching signature, as a fraction of the best match."""
MAX_OFFERED_CARDS = 6
"""Largest number of cards that are offered to the Planner after a failure."""


@dataclass
class OfferedCards:
    """The card library, or an empty one."""

    library: "CardLibrary | None"
    emit: Emit
    offered: dict[str, set[str]] = field(default_factory=dict)
    """Ids of the cards that each role received."""

    def card_ids(self) -> str:
        """Return the ids of all cards, for the Planner; an id names the card's subject."""
        return "" if self.library is None else ", ".join(sorted(self.library.entries))

    @property
    def in_use(self) -> bool:
        """Whether cards are in use."""
        return self.library is not None

    def has(self, card: str) -> bool:
        """Whether a card of this id exists."""
        return self.library is not None and card in self.library.entries

    def pages(self, names: Iterable[str]) -> dict[str, str]:
        """Return the cards with these ids, in the form that Writers get."""
        if self.library is None:
            return {}
        return {name: self.library.entries[name].card.brief("bodies") for name in names if self.has(name)}

    def give(self, role: str, cards: Iterable[str], about: str) -> str:
        """Give cards to a role for one question, and record it.

        Args:
            role: Name of the role.
            cards: Ids of the cards; unknown ones are ignored.
            about: The question, for the record.
        """
        chosen = [card for card in dict.fromkeys(cards) if self.has(card)][:MAX_GIVEN_CARDS]
        if not chosen:
            return ""
        assert self.library is not None
        self.offered.setdefault(role, set()).update(chosen)
        self.emit("cards", role=role, cards=chosen, about=about)
        reader: Any = role
        return "\n\n".join(self.library.entries[card].card.brief(reader) for card in chosen)

    def offer(self, text: str, modes: Collection[str], signatures: Collection[str], about: str) -> str:
        """Return one line for each card that may fit a failure: matched by its signature, or by words.

        Args:
            text: Description of the failure.
            modes: Modes of the scene.
            signatures: Signatures of the failure, from the lint, the run and the expectations.
            about: Subject of the case: the text of the plan.
        """
        if self.library is None:
            return ""
        from text2sim.card_library.retrieval import find_cards, index_words

        known: Any = [mode for mode in modes if mode in _MODES]
        matches = find_cards(self.library, text=text, modes=known, signatures=signatures, limit=MAX_OFFERED_CARDS)
        subject_words = set(index_words(about))
        fitting = [
            match
            for match in matches
            if match.signatures
            or (
                match.modes
                and match.words >= MIN_WORD_SCORE
                and subject_words & set(index_words(" ".join(match.entry.card.applies.tags)))
            )
        ]
        return "\n".join(f"- {match.entry.card.index_line()}" for match in fitting)


def failure_signatures(checks: Fragments, expect: Mapping[str, Mapping[str, Any]], evidence: str) -> set[str]:
    """Return the signatures of a failure, by which cards are indexed.

    Args:
        checks: Measures, events and expectations of the plan.
        expect: Results of the expectations, by name.
        evidence: Text of the run's evidence.
    """
    found = {signature for wording, signature in _SIGNATURES_BY_WORDING.items() if wording in evidence}
    for name, row in expect.items():
        wanted = checks.expect.get(name, {})
        if row.get("ok") is True:
            continue
        if "event" in wanted:
            if "never happened" in str(row.get("why")):
                found.add("event never happens")
            elif "within" in wanted:
                found.add("event too early")
            continue
        measure = checks.measures.get(str(wanted.get("measure")), {})
        kind = "count" if measure.get("stat") == "count" else str(measure.get("kind"))
        too_small = "above" in wanted
        found |= (
            {"measure never crosses"} | _SIGNATURES_OF_SMALL.get(kind, set())
            if too_small
            else _SIGNATURES_OF_LARGE.get(kind, set())
        )
        if str(row.get("why", "")).startswith("0 "):
            found.add("measure is zero")
    return found


_SIGNATURES_BY_WORDING = {
    "leaves the picture": "leaves-picture",
    "never sees": "not visible",
    "- suspicions": "suspicion",
}
"""Signatures of cards by wording of the evidence."""
_SIGNATURES_OF_SMALL = {
    **dict.fromkeys(("extent", "position"), {"height too small"}),
    **dict.fromkeys(("count", "count_in", "contact_count"), {"count too small"}),
    "share_in": {"share too small"},
    "joint_position": {"joint does not move"},
    "displacement": {"falls short"},
}
"""Signatures of a measure that stays too small, by its kind."""
_SIGNATURES_OF_LARGE = {
    **dict.fromkeys(("extent", "position"), {"height too large", "jumps"}),
    **dict.fromkeys(("count", "count_in", "contact_count"), {"count too large"}),
    "distance": {"distance too large"},
    "penetration": {"penetration"},
    "energy": {"energy grows"},
    "displacement": {"creeps"},
}
"""Signatures of a measure that gets too large, by its kind."""
_MODES = frozenset(get_args(Mode))
