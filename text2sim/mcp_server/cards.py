"""Tool that looks up debug cards: earlier failures, their signatures and repairs."""

from text2sim.card_library.library import load_library
from text2sim.card_library.retrieval import find_cards
from text2sim.mcp_server.answers import ToolAnswer, paged, text_page

MAX_CARDS = 5
"""Largest number of complete cards in an answer."""


def cards(query: str, offset: int) -> ToolAnswer:
    """Return a card by its id, the cards that words describe best, or a line for each card.

    Args:
        query: Id, words, or nothing.
        offset: Beginning of the page.
    """
    library = load_library()
    words = query.strip()
    if not words:
        page = paged(library.index().splitlines(), offset)
        return ToolAnswer({"cards": page.pop("rows"), **page, "next": "ask with the id of one, or with words"})
    if words in library.entries:
        ids = [words]
    else:
        ids = [match.entry.id for match in find_cards(library, text=words, limit=MAX_CARDS)]
    text, page = text_page("\n\n".join(library.find(name).card.brief() for name in ids), offset)
    return ToolAnswer({"cards": ids, **page}, text)
