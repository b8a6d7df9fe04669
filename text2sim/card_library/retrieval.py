"""Finds the cards that fit a task or a failure: by role, then by tags, then by words."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from text2sim.card_library.library import CardEntry, CardLibrary
from text2sim.card_library.model import Card, Mode, Role

SIGNATURE_WEIGHT, MODE_WEIGHT, WORDS_WEIGHT = 3.0, 1.0, 2.0
"""What a shared signature counts, what a shared mode does, and the best match of words. A signature is what a run or
the lint has said; words are what somebody thought."""
DUPLICATE_LIKENESS = 0.35
"""From which likeness on (`likeness`) two cards say the same; of the built-in ones none are more alike than 0.26."""
MAX_TEXT = 4000
"""Characters of a query that are looked at."""

_WORD = re.compile(r"[a-z0-9]+")
_STOP_WORDS = frozenset(
    "a an and are as at be been but by can do does for from had has have how if in into is it its no not of on or so"
    " than that the their them then there these they this to was were what when where which while who will with".split()
)
_ENDINGS = ("ing", "ed", "es", "s", "e")
_SHORTEST = 3
"""A word keeps as many letters when its ending is taken off."""


@dataclass(frozen=True)
class Match:
    """A card that was found, and why."""

    entry: CardEntry
    score: float
    signatures: tuple[str, ...]
    """Signatures that it shares with the query."""
    modes: tuple[str, ...]
    """Modes that it shares."""
    words: float
    """How well its words fit, from 0 to 1 for the best card."""


def find_cards(
    library: CardLibrary,
    *,
    text: str,
    role: Role | None = None,
    modes: Collection[Mode] = (),
    signatures: Collection[str] = (),
    limit: int = 6,
) -> list[Match]:
    """Return the cards that fit, the best first; equals by their ids.

    Args:
        library: Where to look.
        text: The task or the failure, in words.
        role: Only cards for this role.
        modes: Physical modes of the scene; cards of others come later.
        signatures: What the lint and the run said: ids of rules, `diverged`, words of the evidence.
        limit: At most so many.

    Returns:
        Cards that share a signature or a word with the query. Without either, those that share a mode.
    """
    entries = [entry for entry in library.entries.values() if role is None or role in entry.card.applies.roles]
    query = index_words(text[:MAX_TEXT])
    ranks = _ranks([_text(entry) for entry in entries], query)
    asked = {_plain(signature): signature for signature in signatures}
    found = []
    for entry, rank in zip(entries, ranks, strict=True):
        applies = entry.card.applies
        shared = tuple(one for one in applies.signatures if _plain(one) in asked)
        same = tuple(mode for mode in applies.modes if mode in modes)
        if shared or rank > 0 or (same and not query and not asked):
            score = SIGNATURE_WEIGHT * len(shared) + MODE_WEIGHT * bool(same) + WORDS_WEIGHT * rank
            found.append(Match(entry, round(score, 6), shared, same, round(rank, 6)))
    return sorted(found, key=lambda match: (-match.score, match.entry.id))[: max(limit, 0)]


def index_words(text: str) -> list[str]:
    """Return the words of a text in lower case, without the commonest and without their endings."""
    return [_stem(word) for word in _WORD.findall(text.lower()) if word not in _STOP_WORDS]


def likeness(one: Card, other: Card) -> float:
    """Return how much two cards say the same: the part of their words that both have (Jaccard), 0 to 1."""
    mine, its = (
        set(index_words(" ".join([card.title, *card.symptoms, *card.likely_causes, *card.repair])))
        for card in (one, other)
    )
    return len(mine & its) / len(mine | its)


def _stem(word: str) -> str:
    """A word without its ending: enough for `tunnels`, `tunnelled` and `tunnelling` to meet."""
    for ending in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= _SHORTEST:
            word = word.removesuffix(ending)
            break
    # `slipping` has become `slipp`, and `slips` has become `slip`.
    return word[:-1] if len(word) > _SHORTEST and word[-1] == word[-2] else word


def _plain(signature: str) -> str:
    return " ".join(signature.lower().removeprefix("lint:").removeprefix("state:").split())


def _text(entry: CardEntry) -> str:
    """What is searched. The title and the tags count twice: they say in a word what the rest tells at length."""
    card = entry.card
    head = [card.title, *card.applies.tags, *card.applies.signatures, card.id]
    return " ".join([*head, *head, *card.symptoms, *card.likely_causes])


def _ranks(texts: Sequence[str], query: Sequence[str]) -> list[float]:
    """How well each text fits by BM25, over that of the best; 0 where no word is shared."""
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
