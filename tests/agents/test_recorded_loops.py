"""Loops that were played once, from words to their end, played again from their letters: checker and engine are real.

Each folder of `recorded` has the request, the replies as a mailbox leaves them, and how it ended.
"""

import json
from pathlib import Path

import pytest

from text2sim.agents.session import Session, SessionWish

RECORDED = sorted((Path(__file__).parent / "recorded").glob("*/expected.json"))
# Five minutes for its letters, and for each run.
PLAYED = [(file, json.loads(file.read_text("utf-8"))) for file in RECORDED]
REPLAYED = [
    pytest.param(file, marks=pytest.mark.timeout(300 * (1 + played["runs"])), id=file.parent.name)
    for file, played in PLAYED
    if played["replayed"]
]
"""The others take too long for a test; `benchmarks/recorded_loops.py --replay NAME` plays any of them."""

MOST = {
    "anchor": 40_000,
    "bolt_into_nut": 130_000,
    "card_house": 75_000,
    "edit_colour": 6_000,
    "gear_train": 95_000,
    "perpetual": 9_000,
}
"""Tokens that a replay may take: letters that grow are noticed."""


@pytest.mark.usefixtures("engine", "tracer")
@pytest.mark.parametrize("file", REPLAYED)
def test_a_recorded_loop_ends_as_it_did(file: Path, tmp_path: Path) -> None:
    expected = json.loads(file.read_text("utf-8"))
    base = file.parent / "base.yaml"
    wish = SessionWish(
        expected.get("kind", "generate"), expected["request"], {"": f"replay:{file.parent}"},
        attempts=expected["attempts"], base=base.read_text("utf-8") if base.is_file() else "",
    )  # fmt: skip
    happened: list[str] = []
    session = Session.begin(tmp_path / "case", wish, [], [])
    outcome = session.run(lambda event, what: happened.append(event))
    assert outcome.state == expected["state"], (outcome.why, outcome.unresolved)
    assert (outcome.best.number if outcome.best else None) == expected["best"]
    assert happened.count("running") == expected["runs"]
    assert session.account.total().tokens < MOST.get(file.parent.name, 50_000)
    if outcome.state == "accepted":
        assert outcome.best is not None
        assert outcome.best.missed(list(outcome.best.expect)) == ()
