"""Ledger of learned cards: the source of each card's lesson, and its effect when it was tried.

It is CARDS/ledger.json. No suite is answered with cards that were learned from its sources, nor with cards of unknown
origin.
"""

from collections import Counter
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from text2sim.card_library.library import BUILT_IN, CardEntry, load_library
from text2sim.card_library.model import CardId
from text2sim.evaluation.documents import read_model
from text2sim.evaluation.suite import Prompt, Suite, shared_sources
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.text.document import Document
from text2sim.spec_schema.whole_files import write_json

LEDGER_FILE = "ledger.json"
Sentence = Annotated[str, StringConstraints(min_length=3, max_length=2000)]


class CardDebt(Model):
    """The prompt, and so the source, that a card was learned from."""

    prompt: Name
    failure: Sentence
    evidence: Sentence


class CardTrial(Model):
    """A prompt that was answered again with the card."""

    prompt: Name
    before: float
    after: float
    dealt: bool
    """Whether a role received the card."""


class CardRecord(Model):
    """Record of a card."""

    state: Literal["kept", "rejected", "merged"]
    digest: str
    """SHA-256 of its files."""
    owes: Annotated[list[CardDebt], Field(min_length=1)]
    tried: list[CardTrial] = []

    @property
    def gain(self) -> float:
        """Mean change of the scores of the prompts that were answered again with the card."""
        return sum(trial.after - trial.before for trial in self.tried) / max(1, len(self.tried))


class CardLedger(Model):
    """Records of all learned cards, including rejected ones."""

    format: Literal[1] = 1
    prompts: dict[Name, Prompt] = {}
    """Prompts from which cards were learned, with their sources."""
    cards: dict[CardId, CardRecord] = {}


def read_ledger(cards: Path) -> CardLedger:
    """Read the ledger of a folder of cards; empty if there is none."""
    return (
        read_model(cards / LEDGER_FILE, CardLedger, "a ledger")[0] if (cards / LEDGER_FILE).exists() else CardLedger()
    )


def record_card(cards: Path, card: str, record: CardRecord, prompts: dict[str, Prompt]) -> None:
    """Update the record of a card; its earlier debts stay.

    Args:
        cards: Folder of the cards.
        card: Id of the card.
        record: The new record.
        prompts: Prompts that it was learned from, by name.
    """
    ledger = read_ledger(cards)
    if (previous := ledger.cards.get(card)) is not None:
        debts = [*previous.owes, *(debt for debt in record.owes if debt not in previous.owes)]
        record = record.model_copy(update={"owes": debts})
    sources = ledger.prompts | {
        name: prompt.model_copy(update={"requirements": None}) for name, prompt in prompts.items()
    }
    updated = CardLedger(prompts=sources, cards=ledger.cards | {card: record})
    write_json(cards / LEDGER_FILE, updated.model_dump(mode="json"))


def digest_of(entry: CardEntry) -> str:
    """Return the SHA-256 of a card's three files."""
    files = (entry.folder / "card.yaml", entry.failing, entry.repaired)
    return sha256(b"\0".join(file.read_bytes() for file in files)).hexdigest()


def check_split(suite: Suite, document: Document, cards: Path | None) -> None:
    """Reject cards that were learned from the sources of a suite.

    Args:
        suite: The suite.
        document: Its source document.
        cards: Folder of additional cards; None without one.

    Raises:
        SpecError: If a card was learned from a source of the suite, or its files do not match the ledger.
    """
    if cards is None or cards.resolve() == BUILT_IN:
        return
    ledger, file = read_ledger(cards), str(cards / LEDGER_FILE)
    problems = []
    for entry in load_library([cards]).entries.values():
        record = ledger.cards.get(entry.id)
        if record is None or record.digest != digest_of(entry):
            what = "it is not in the ledger" if record is None else "it has changed since it was entered"
            problems.append(Problem("/cards", f"`{entry.id}`: {what}", file=file, rule="unknown-source"))
    problems += shared_sources(suite, learned_from(ledger, cards), document)
    if problems:
        raise SpecError(problems)


def learned_from(ledger: CardLedger, cards: Path) -> Suite:
    """Return the prompts from which the active cards were learned, as a suite.

    Raises:
        SpecError: If a prompt is missing.
    """
    active = {entry.id for entry in load_library([cards]).entries.values()}
    prompts = [debt.prompt for name, record in ledger.cards.items() if name in active for debt in record.owes]
    if missing := [name for name in prompts if name not in ledger.prompts]:
        what = f"the sources of {', '.join(missing)} are missing"
        raise SpecError([Problem("/prompts", what, file=str(cards / LEDGER_FILE), rule="unknown-source")])
    # An empty suite is invalid; this one is compared with others and never answered.
    return Suite.model_construct(name="the ledger of cards", prompts={name: ledger.prompts[name] for name in prompts})


def count_offered_cards(folders: Iterable[Path]) -> tuple[int, Counter[str]]:
    """Return the number of loops below some folders, and the number of them in which each card was offered."""
    runs, offered = 0, Counter[str]()
    for file in sorted({file for folder in folders for file in folder.rglob("generation/run.json")}):
        record = read_json(file)
        cards = record.get("cards") if isinstance(record, dict) else None
        if isinstance(cards, dict):
            runs += 1
            offered.update({str(card) for row in cards.values() if isinstance(row, list) for card in row})
    return runs, offered
