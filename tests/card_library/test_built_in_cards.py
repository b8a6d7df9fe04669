"""The built-in cards: complete, small enough, each with two cases that differ in little."""

import difflib
from pathlib import Path

import pytest
from freshness import assert_fresh

from text2sim.card_library.library import BUILT_IN, CardEntry, check_entry, load_library
from text2sim.card_library.model import MAX_INDEX_TOKENS, MAX_TOKENS, count_tokens
from text2sim.card_library.reference import cards_reference
from text2sim.spec_schema.text.canonical import format_text

LIBRARY = load_library([BUILT_IN])
ENTRIES = list(LIBRARY.entries.values())


@pytest.fixture(params=ENTRIES, ids=lambda entry: entry.id)
def entry(request: pytest.FixtureRequest) -> CardEntry:
    return request.param


def test_all_of_them_can_be_read() -> None:
    assert LIBRARY.problems == []
    assert len(ENTRIES) >= 25
    assert {folder.name for folder in BUILT_IN.iterdir() if folder.is_dir()} == set(LIBRARY.entries)


def test_card_and_cases_are_valid(entry: CardEntry) -> None:
    card, failing, repaired = check_entry(entry)
    name = card.id.replace("-", "_")
    assert (failing.case.name, repaired.case.name) == (name, name), "the `name` of both cases is the card's id with `_`"
    assert failing.case.actions.expect == repaired.case.actions.expect


def test_a_card_is_cheap(entry: CardEntry) -> None:
    card = entry.card
    assert count_tokens(card.brief()) <= MAX_TOKENS
    assert count_tokens(card.index_line()) <= MAX_INDEX_TOKENS
    assert len(card.brief("scene")) <= len(card.brief())


def test_the_cases_differ_only_in_the_repair(entry: CardEntry) -> None:
    before, after = (path.read_text("utf-8").splitlines() for path in (entry.failing, entry.repaired))
    changed = [row for row in difflib.ndiff(before, after) if row[:2] in ("- ", "+ ")]
    assert 0 < len(changed) <= 20, "a reader must see at once what the repair is"


def test_cases_are_in_canonical_form(entry: CardEntry) -> None:
    for path in (entry.failing, entry.repaired):
        text = path.read_text("utf-8")
        assert text == format_text(text), f"text2sim fmt {path}"


def test_every_role_and_many_modes_have_cards() -> None:
    roles = {role for entry in ENTRIES for role in entry.card.applies.roles}
    modes = {mode for entry in ENTRIES for mode in entry.card.applies.modes}
    assert roles >= {"planner", "scene", "bodies", "actions", "render", "critic", "articulation", "mesh"}
    assert modes >= {"rigid", "articulated", "soft", "cloth", "rope", "liquid", "driven", "film"}


def test_the_page_of_the_documentation_is_theirs() -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "cards.md"
    assert_fresh(page, cards_reference(), "python -m text2sim.card_library.reference > docs/cards.md")
