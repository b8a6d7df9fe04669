"""Verification of cards: two in the engine, all outcomes of the lint."""

from pathlib import Path

import pytest

from text2sim.card_library.library import BUILT_IN, CardEntry, load_library
from text2sim.card_library.verify import verify_card, verify_cards
from text2sim.runtime.stop import Stop

LIBRARY = load_library([BUILT_IN])
CHEAP = ("threshold-on-the-wrong-side", "friction-is-the-larger-of-two")
BY_LINT = [e for e in LIBRARY.entries.values() if e.card.evidence.failing.outcome.startswith("lint:")]


@pytest.mark.usefixtures("engine")
def test_failures_and_repairs_in_the_engine(tmp_path: Path) -> None:
    entries = [LIBRARY.find(name) for name in CHEAP]
    verdicts = list(verify_cards(entries, runs=tmp_path, jobs=1))
    assert [(v.id, v.ok, v.repaired, v.message) for v in verdicts] == [(name, True, "passed", "") for name in CHEAP]
    assert [v.failing for v in verdicts] == [entry.card.evidence.failing.outcome for entry in entries]


@pytest.mark.parametrize("entry", BY_LINT, ids=lambda entry: entry.id)
def test_outcomes_of_the_lint(entry: CardEntry, tmp_path: Path) -> None:
    verdict = verify_card(entry, runs=tmp_path, simulate=False)
    assert verdict.ok, verdict.message
    assert verdict.failing == entry.card.evidence.failing.outcome


def test_a_card_that_does_not_hold(shelf: Path, tmp_path: Path) -> None:
    folder = shelf / "falls-too-far"
    card = folder / "card.yaml"
    card.write_text(card.read_text("utf-8").replace("missed:slow", "lint:overlap"), "utf-8")
    entry = load_library([shelf]).find("falls-too-far")
    verdict = verify_card(entry, runs=tmp_path, simulate=False)
    assert not verdict.ok
    assert "should be `lint:overlap`" in verdict.message


def test_cases_that_broke_since_the_library_was_read(shelf: Path, tmp_path: Path) -> None:
    entry = load_library([shelf]).find("falls-too-far")
    entry.repaired.write_text("text2sim: 2\n", "utf-8")
    verdict = verify_card(entry, runs=tmp_path)
    assert not verdict.ok
    assert "repaired.yaml" in verdict.message
    assert not list(tmp_path.glob("falls_too_far*")), "nothing is run of a card that is not valid"


def test_after_a_request_to_stop_nothing_is_begun(tmp_path: Path) -> None:
    stop = Stop()
    stop.request()
    verdict = verify_card(LIBRARY.find(CHEAP[0]), runs=tmp_path, stop=stop)
    assert (verdict.ok, verdict.failing) == (False, "state:interrupted")
    assert not list(tmp_path.iterdir())
