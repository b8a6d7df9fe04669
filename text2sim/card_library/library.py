"""Debug Cards on disk: each has a folder with the card, the failing case, and the repaired case.

Cards from other people are untrusted data, like any case. Cards that are too large, contain links, or do not fit the
model are reported with their lines. Nothing of a card is executed.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from text2sim.card_library.model import Card
from text2sim.spec_schema.errors import Problem, SpecError, nearest
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source, read_source
from text2sim.spec_schema.vocabulary.typed_document import model_of

BUILT_IN = Path(__file__).resolve().parent / "cards"
VARIABLE = "TEXT2SIM_CARDS"
"""Environment variable of an additional folder of cards."""
CARD_FILE, FAILING, REPAIRED = "card.yaml", "failing.yaml", "repaired.yaml"
MAX_CARD, MAX_CASE = 8_000, 64_000
"""Largest numbers of characters of a card, and of each of its cases."""
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
        """The failing case."""
        return self.folder / FAILING

    @property
    def repaired(self) -> Path:
        """The repaired case."""
        return self.folder / REPAIRED


@dataclass
class CardLibrary:
    """The cards that could be read, and the problems of the others."""

    entries: dict[str, CardEntry] = field(default_factory=dict)
    """Cards by id, sorted."""
    problems: list[Problem] = field(default_factory=list)

    def index(self) -> str:
        """Return one line for each card, from which a Planner chooses."""
        return "\n".join(entry.card.index_line() for entry in self.entries.values())

    def find(self, name: str) -> CardEntry:
        """Return a card.

        Raises:
            SpecError: if there is no card with this id.
        """
        if name in self.entries:
            return self.entries[name]
        hint = nearest(name, self.entries)
        raise SpecError([Problem("", f"there is no card `{name[:60]}`", file="cards", hint=hint, rule="unknown-card")])


def load_library(folders: list[Path] | None = None) -> CardLibrary:
    """Read the built-in cards and those of the user.

    Args:
        folders: Folders of cards to read instead.

    Returns:
        The library, with the problems of invalid cards, which are left out.
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
    """Check a proposed card with its two cases, without running them.

    Args:
        text: Text of `card.yaml`.
        failing: Text of the failing case.
        repaired: Text of the repaired case.
        folder: Folder of the three files, in which assets of the cases are searched.
        id: Required id of the card, if it is known.

    Raises:
        SpecError: with all problems of the three.
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
        SpecError: with all problems of the three.
    """
    text = _read(entry.folder / CARD_FILE, MAX_CARD).text
    failing, repaired = (_read(path, MAX_CASE).text for path in (entry.failing, entry.repaired))
    return check_card(text, failing=failing, repaired=repaired, folder=entry.folder, id=entry.id)


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
    card = model_of(document, Card, "a card is a mapping with the keys id, title, applies, …")
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
    """Problems of the expectations, which both cases must share: a repair does not change the task."""
    if not good.case.actions.expect:
        return [good.problem("/actions", "a card's cases need expectations, to tell success", rule="no-expectation")]
    if bad.case.actions.expect == good.case.actions.expect:
        return []
    message = "both cases of a card must expect the same: a repair does not change what is asked for"
    return [good.problem("/actions/expect", message, key=True, rule="other-expectations")]


def _outcome_exists(card: Card, bad: LoadedCase, source: Source) -> list[Problem]:
    """Problems of the failing outcome, whose lint rule or expectation must exist."""
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
    place = ("evidence", "failing", "outcome")
    return [
        parse_document(source).problem(place, f"{what} `{name}`", rule="unknown-outcome", hint=nearest(name, known))
    ]


def _attempt(problems: list[Problem], read: Callable[[], _T]) -> _T | None:
    try:
        return read()
    except SpecError as error:
        problems += error.problems
        return None
