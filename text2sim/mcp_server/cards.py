"""The tool that looks up debug cards: what went wrong before, how it is told apart, and what fixed it."""

from text2sim.card_library.library import CardLibrary, load_library
from text2sim.mcp_server.answers import ToolAnswer, paged, text_page

MOST = 5
"""Cards that an answer has in full."""


def cards(query: str, offset: int) -> ToolAnswer:
    """Return a card by its id, those that words describe best, or a line for each.

    Args:
        query: Id, words, or nothing.
        offset: Where the page of the list begins.
    """
    library = load_library()
    words = query.strip()
    if not words:
        page = paged(library.index().splitlines(), offset)
        return ToolAnswer({"cards": page.pop("rows"), **page, "next": "ask with the id of one, or with words"})
    if words in library.entries:
        return _told(library, [words], offset)
    from text2sim.card_library.retrieval import find_cards

    return _told(library, [match.entry.id for match in find_cards(library, text=words, limit=MOST)], offset)


def _told(library: CardLibrary, ids: list[str], offset: int) -> ToolAnswer:
    text, said = text_page("\n\n".join(library.find(name).card.brief() for name in ids), offset)
    return ToolAnswer({"cards": ids, **said}, text)
