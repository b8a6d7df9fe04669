"""Retrieval of cards that fit a task or a failure: by role, signatures, words, and mode."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from text2sim.card_library.library import CardEntry, CardLibrary
from text2sim.card_library.model import Card, Mode, Role

SIGNATURE_WEIGHT, MODE_WEIGHT, WORDS_WEIGHT = 3.0, 1.0, 2.0
"""Scores of a shared signature, of a shared mode, and of the best match of words. Signatures count most, because they
come from a run or the lint."""
DUPLICATE_LIKENESS = 0.35
"""Smallest `likeness` of duplicates; that of different built-in cards is 0.26 at most."""
MAX_TEXT = 4000
"""Largest number of characters of a query that are used."""

_WORD = re.compile(r"[a-z0-9]+")
_STOP_WORDS = frozenset(
    "a an and are as at be been but by can do does for from had has have how if in into is it its no not of on or so"
    " than that the their them then there these they this to was were what when where which while who will with".split()
)
_ENDINGS = ("ing", "ed", "es", "s", "e")
_SHORTEST = 3
"""Smallest number of letters that remain of a word without its ending."""


@dataclass(frozen=True)
class Match:
    """A card that fits, and the reasons."""

    entry: CardEntry
    score: float
    signatures: tuple[str, ...]
    """Signatures that it shares with the query."""
    modes: tuple[str, ...]
    """Modes that it shares with the query."""
    words: float
    """Match of its words, relative to the best card, 0 to 1."""


def find_cards(
    library: CardLibrary,
    *,
    text: str,
    role: Role | None = None,
    modes: Collection[Mode] = (),
    signatures: Collection[str] = (),
    limit: int = 6,
) -> list[Match]:
    """Return the cards that fit, the best first; cards with equal scores are sorted by id.

    Args:
        library: The library.
        text: The task or the failure, in words.
        role: Role that the cards must be for; any if None.
        modes: Physical modes of the scene; cards for other modes come later.
        signatures: Signs of the failure in lint and run: ids of rules, `diverged`, words of the evidence.
        limit: Largest number of cards.

    Returns:
        Cards that share a signature or a word with the query; if the query has neither, cards that share a mode.
    """
    entries = [entry for entry in library.entries.values() if role is None or role in entry.card.applies.roles]
    query = index_words(text[:MAX_TEXT])
    ranks = _ranks([_text(entry) for entry in entries], query)
    asked = {_plain(signature): signature for signature in signatures}
    found = []
    for entry, rank in zip(entries, ranks, strict=True):
        applies = entry.card.applies
        shared = tuple(signature for signature in applies.signatures if _plain(signature) in asked)
        same = tuple(mode for mode in applies.modes if mode in modes)
        if shared or rank > 0 or (same and not query and not asked):
            score = SIGNATURE_WEIGHT * len(shared) + MODE_WEIGHT * bool(same) + WORDS_WEIGHT * rank
            found.append(Match(entry, round(score, 6), shared, same, round(rank, 6)))
    return sorted(found, key=lambda match: (-match.score, match.entry.id))[: max(limit, 0)]


def index_words(text: str) -> list[str]:
    """Return the words of a text in lower case, without stop words and without endings."""
    return [_stem(word) for word in _WORD.findall(text.lower()) if word not in _STOP_WORDS]


def likeness(one: Card, other: Card) -> float:
    """Return the similarity of the words of two cards (Jaccard index), 0 to 1."""
    mine, its = (
        set(index_words(" ".join([card.title, *card.symptoms, *card.likely_causes, *card.repair])))
        for card in (one, other)
    )
    return len(mine & its) / len(mine | its)


def _stem(word: str) -> str:
    """A word without its ending, such that `tunnels`, `tunnelled` and `tunnelling` become equal."""
    for ending in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= _SHORTEST:
            word = word.removesuffix(ending)
            break
    # `slipping` becomes `slipp` above, and must match `slip`.
    return word[:-1] if len(word) > _SHORTEST and word[-1] == word[-2] else word


def _plain(signature: str) -> str:
    return " ".join(signature.lower().removeprefix("lint:").removeprefix("state:").split())


def _text(entry: CardEntry) -> str:
    """Text of a card that is searched; title, tags and signatures, which are concise, count twice."""
    card = entry.card
    head = [card.title, *card.applies.tags, *card.applies.signatures, card.id]
    return " ".join([*head, *head, *card.symptoms, *card.likely_causes])


def _ranks(texts: Sequence[str], query: Sequence[str]) -> list[float]:
    """BM25 score of each text, relative to the best; 0 without a shared word."""
    corpus = [index_words(text) for text in texts]
    known = {word for row in corpus for word in row}
    asked = list(dict.fromkeys(word for word in query if word in known))
    if not asked:
        return [0.0] * len(corpus)
    import bm25s

    ranker = bm25s.BM25()
    ranker.index(corpus, show_progress=False)
    scores = [float(score) for score in ranker.get_scores(asked)]
    best = max(scores)
    return [max(score, 0.0) / best if best > 0 else 0.0 for score in scores]
