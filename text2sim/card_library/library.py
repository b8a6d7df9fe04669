"""Debug Cards on disk: a folder for each, with the card, the case that failed and the case that was repaired.

Cards of other people are data like any case: what is too large, leads out of its folder or does not fit the model is
said with its line, and nothing of it is executed.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from text2sim.card_library.model import Card
from text2sim.spec_schema.errors import Problem, SpecError, nearest
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.text.document import Document, parse_document
from text2sim.spec_schema.text.source import Source, check_source, read_source
from text2sim.spec_schema.vocabulary.diagnosis import diagnose

BUILT_IN = Path(__file__).resolve().parent / "cards"
VARIABLE = "TEXT2SIM_CARDS"
"""Environment variable with one more folder of cards."""
CARD_FILE, FAILING, REPAIRED = "card.yaml", "failing.yaml", "repaired.yaml"
MAX_CARD, MAX_CASE = 8_000, 64_000
"""Characters of a card, and of each of its cases."""
MAX_CARDS = 1000

_T = TypeVar("_T")


@dataclass(frozen=True)
class CardEntry:
    """A card of the library."""

    card: Card
    folder: Path

    @property
    def id(self) -> str:
        """The card's id."""
        return self.card.id

    @property
    def failing(self) -> Path:
        """The case that fails."""
        return self.folder / FAILING

    @property
    def repaired(self) -> Path:
        """The same, repaired."""
        return self.folder / REPAIRED


@dataclass
class CardLibrary:
    """All cards that could be read, and what is wrong with the rest."""

    entries: dict[str, CardEntry] = field(default_factory=dict)
    """By id, sorted."""
    problems: list[Problem] = field(default_factory=list)

    def index(self) -> str:
        """Return one line for each card: what a Planner chooses from."""
        return "\n".join(entry.card.index_line() for entry in self.entries.values())

    def find(self, name: str) -> CardEntry:
        """Return a card.

        Raises:
            SpecError: if there is none of that id.
        """
        if name in self.entries:
            return self.entries[name]
        hint = nearest(name, self.entries)
        raise SpecError([Problem("", f"there is no card `{name[:60]}`", file="cards", hint=hint, rule="unknown-card")])


def load_library(folders: list[Path] | None = None) -> CardLibrary:
    """Read the built-in cards and those of the user.

    Args:
        folders: Where to look instead: folders of folders of cards.

    Returns:
        The library; a card that is broken is left out, and its problems are told.
    """
    if folders is None:
        more = os.environ.get(VARIABLE)
        folders = [BUILT_IN, *([Path(more)] if more else [])]
    library, found = CardLibrary(), dict[str, CardEntry]()
    for folder in folders:
        for place in _card_folders(folder, library.problems):
            try:
                entry = CardEntry(_card(_read(place / CARD_FILE, MAX_CARD), place.name), place)
            except SpecError as error:
                library.problems += error.problems
                continue
            if entry.id in found:
                message = f"there is a card `{entry.id}` in {found[entry.id].folder.parent} already"
                library.problems.append(Problem("/id", message, file=str(place / CARD_FILE), rule="duplicate-card"))
            else:
                found[entry.id] = entry
    library.entries = dict(sorted(found.items()))
    return library


def check_card(
    text: str, *, failing: str, repaired: str, folder: Path = Path(), id: str | None = None
) -> tuple[Card, LoadedCase, LoadedCase]:
    """Check a card that is proposed, with its two cases, as far as that is possible without running them.

    Args:
        text: `card.yaml`.
        failing: The case that fails.
        repaired: The same, repaired.
        folder: Where the three would lie: assets of the cases are looked for there.
        id: The id that the card has to have, if that is known.

    Raises:
        SpecError: with everything that is wrong with any of the three.
    """
    problems: list[Problem] = []
    card = _attempt(problems, lambda: _card(_source(text, folder / CARD_FILE, MAX_CARD), id))
    bad = _attempt(problems, lambda: _case(failing, folder / FAILING))
    good = _attempt(problems, lambda: _case(repaired, folder / REPAIRED))
    if bad is not None and good is not None:
        problems += _same_expectations(bad, good)
    if card is not None and bad is not None:
        problems += _outcome_exists(card, bad, Source(text, str(folder / CARD_FILE)))
    if problems or card is None or bad is None or good is None:
        raise SpecError(problems)
    return card, bad, good


def check_entry(entry: CardEntry) -> tuple[Card, LoadedCase, LoadedCase]:
    """Check a card of the library with its two cases; see `check_card`.

    Raises:
        SpecError: with everything that is wrong with it.
    """
    texts = [
        _read(path, limit).text
        for path, limit in (
            (entry.folder / CARD_FILE, MAX_CARD),
            (entry.failing, MAX_CASE),
            (entry.repaired, MAX_CASE),
        )
    ]
    return check_card(texts[0], failing=texts[1], repaired=texts[2], folder=entry.folder, id=entry.id)


def _card_folders(folder: Path, problems: list[Problem]) -> list[Path]:
    """Folders below a folder of cards, sorted by name."""
    try:
        with os.scandir(folder) as entries:
            rows = [(row.name, row.is_dir(follow_symlinks=False)) for _, row in zip(range(MAX_CARDS), entries)]  # noqa: B905
    except OSError as error:
        reason = error.strerror or type(error).__name__
        problems.append(Problem("", f"cannot read the folder: {reason}", file=str(folder), rule="unreadable"))
        return []
    return [folder / name for name, is_folder in sorted(rows) if is_folder and not name.startswith((".", "__"))]


def _read(path: Path, limit: int) -> Source:
    """Read a file of a card; links are refused, since they could lead anywhere."""
    if path.is_symlink():
        raise SpecError([Problem("", "a file of a card must not be a link", file=str(path), rule="unreadable")])
    return _source(read_source(path).text, path, limit)


def _source(text: str, path: Path, limit: int) -> Source:
    source = Source(text, str(path))
    if len(text) > limit:
        raise source.error(0, f"the text is longer than {limit} characters", "too-large")
    return check_source(source)


def _card(source: Source, id: str | None) -> Card:
    document = parse_document(source)
    data: Any = document.data
    if not isinstance(data, dict):
        raise SpecError([document.problem((), "a card is a mapping with the keys id, title, applies, …", rule="type")])
    model: type[BaseModel] = Card
    try:
        card = Card.model_validate(data)
    except ValidationError as error:
        raise SpecError(diagnose(document, error, model, data)) from None
    if id is not None and card.id != id:
        raise SpecError([document.problem(("id",), f"the card has to be called `{id}`, as its folder", rule="card-id")])
    return card


def _case(text: str, path: Path) -> LoadedCase:
    from text2sim.spec_schema.names.references import check_references

    loaded = load_text(_source(text, path, MAX_CASE).text, path)
    if problems := [problem for problem in check_references(loaded) if problem.severity == "error"]:
        raise SpecError(problems)
    return loaded


def _same_expectations(bad: LoadedCase, good: LoadedCase) -> list[Problem]:
    """A repair that asks for something else is none."""
    if not good.case.actions.expect:
        return [good.problem("/actions", "a card's cases need expectations, to tell success", rule="no-expectation")]
    if bad.case.actions.expect == good.case.actions.expect:
        return []
    message = "both cases of a card must expect the same: a repair does not change what is asked for"
    return [good.problem("/actions/expect", message, key=True, rule="other-expectations")]


def _outcome_exists(card: Card, bad: LoadedCase, source: Source) -> list[Problem]:
    """The rule or the expectation that an outcome names must be there."""
    kind, _, name = card.evidence.failing.outcome.partition(":")
    if kind == "missed":
        known, what = list(bad.case.actions.expect), f"{FAILING} has no expectation"
    elif kind == "lint":
        from text2sim.lint.rules import EARLIER_RULES, RULES

        known, what = [*(rule.id for rule in RULES), *EARLIER_RULES], "the lint has no rule"
    else:
        return []
    if name in known:
        return []
    document: Document = parse_document(source)
    place = ("evidence", "failing", "outcome")
    return [document.problem(place, f"{what} `{name}`", rule="unknown-outcome", hint=nearest(name, known))]


def _attempt(problems: list[Problem], read: Callable[[], _T]) -> _T | None:
    try:
        return read()
    except SpecError as error:
        problems += error.problems
        return None
