"""Cards from a finished loop."""

import json
import resource
import shutil
from pathlib import Path

import pytest
import yaml

from tests.agents.scripted import Scripted, chat, fenced
from text2sim.agents.conversation import Wrong
from text2sim.agents.distilling import CardProposal, TriedAttempt, attempts_of, attempts_text, distill, draft_card
from text2sim.card_library.library import load_library
from text2sim.spec_schema.errors import RunError

CASE = """\
text2sim: 2
name: drop
scene: {duration: 0.6, statics: {floor: {shape: {kind: plane}}}}
bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, %s]}}}
actions:
  events: {touch: {kind: contact, between: [ball, floor]}}
  expect: {lands: {event: touch, within: [0.1, 0.5]}}
"""
CARD = """\
cards:
  - failing: {failing}
    repaired: {repaired}
    card:
      id: falls-from-too-high
      title: A fall takes longer than the scene lasts
      applies: {{modes: [rigid], tags: [fall], roles: [planner, bodies]}}
      symptoms: [the event never happens]
      likely_causes: [a fall from h takes the root of 2 h / g]
      repair: [start lower]
      evidence:
        case: a ball over a floor
        failing: {{outcome: passed, observed: not down after 0.6 s}}
        repaired: {{observed: down after 0.25 s}}
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    for number, height, ok in ((1, "2.0", False), (2, "0.4", True)):
        folder = tmp_path / "drop" / "generation" / "attempts" / f"{number:02}"
        folder.mkdir(parents=True)
        (folder / "case.yaml").write_text(CASE % height)
        expect = {"lands": {"ok": ok, "wanted": "`touch` from 0.1 s to 0.5 s", "why": "never"}}
        record = {"state": "finished", "cause": "first", "changes": ["~ pos"], "expect": expect, "critique": None}
        (folder / "attempt.json").write_text(json.dumps(record))
    return tmp_path / "drop"


def test_a_card_says_what_came_of_the_attempts_whatever_the_model_says(tmp_path: Path, case: Path) -> None:
    wrong, right = (fenced(CARD.format(failing=a, repaired=b)) for a, b in ((2, 1), (1, 2)))
    model = Scripted({"distiller": [wrong, right]})
    assert distill(chat(tmp_path, model), case, tmp_path / "cards") == ["falls-from-too-high"]
    assert "attempt 2 did not fail" in model.questions("distiller")[1]
    library = load_library([tmp_path / "cards"])
    assert not library.problems
    card = library.find("falls-from-too-high").card
    assert card.evidence.failing.outcome == "missed:lands"
    assert card.evidence.repaired.outcome == "passed"


def test_a_loop_without_a_mended_failure_teaches_nothing(tmp_path: Path, case: Path) -> None:
    record = case / "generation" / "attempts" / "02" / "attempt.json"
    record.write_text(record.read_text().replace('"ok": true', '"ok": false'))
    with pytest.raises(RunError, match="nothing to learn"):
        distill(chat(tmp_path, Scripted({})), case, tmp_path / "cards")


def test_what_a_full_disk_left_of_a_card_is_completed_and_nothing_is_asked_again(tmp_path: Path, case: Path) -> None:
    model, card = (
        Scripted({"distiller": [fenced(CARD.format(failing=1, repaired=2))]}),
        tmp_path / "cards/falls-from-too-high",
    )
    distill(chat(tmp_path, model), case, tmp_path / "cards")
    whole = {path.name: path.read_bytes() for path in card.iterdir()}
    for path in card.iterdir():
        path.unlink()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole["card.yaml"]) - 1, hard))
    try:
        with pytest.raises(OSError, match="File too large") as met:
            distill(chat(tmp_path, model), case, tmp_path / "cards")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert met.value.filename == str(card / "card.yaml")
    assert {path.name for path in card.iterdir()} == {"failing.yaml", "repaired.yaml"}
    distill(chat(tmp_path, model), case, tmp_path / "cards")
    assert {path.name: path.read_bytes() for path in card.iterdir()} == whole
    assert len(model.asked) == 1
    (card / "failing.yaml").write_text("another")
    with pytest.raises(RunError, match="exists already"):
        distill(chat(tmp_path, model), case, tmp_path / "cards")


@pytest.fixture
def changed(case: Path) -> dict[int, TriedAttempt]:
    """Attempts at an existing case, which was run first as it was: that is attempt 0."""
    first, second = case / "generation" / "attempts" / "00", case / "generation" / "attempts" / "01"
    shutil.copytree(second, first)
    (first / "case.yaml").write_text(CASE.replace("duration: 0.6", "duration: 0.7") % "2.0")
    record = json.loads((second / "attempt.json").read_text())
    (second / "attempt.json").write_text(json.dumps(record | {"changes": []}))
    return attempts_of(case)


def test_a_repair_by_a_patch_starts_from_the_failing_attempt(changed: dict[int, TriedAttempt]) -> None:
    card = yaml.safe_load(CARD.format(failing=1, repaired=2))["cards"][0]["card"]
    card["evidence"]["repaired"]["outcome"] = "passed"
    card["evidence"]["failing"]["outcome"] = "missed:lands"
    repair = [{"op": "replace", "path": "/bodies/ball/pose/pos/2", "value": 0.3}]
    draft = draft_card(CardProposal(failing=1, repair=repair, card=card), changed)
    assert "duration: 0.6" in draft.failing
    assert "duration: 0.6" in draft.repaired
    with pytest.raises(Wrong, match="attempts 2 and 0: attempt 2 did not fail"):
        draft_card(CardProposal(failing=2, repaired=0, card=card), changed)


def test_an_attempt_without_recorded_changes_is_shown_whole(changed: dict[int, TriedAttempt]) -> None:
    assert attempts_text(changed).count("```yaml") == 2


@pytest.mark.parametrize("record", ["[]", "{}", '{"state": "finished", "expect": [], "cause": "", "changes": []}'])
def test_a_damaged_attempt_is_left_out(case: Path, record: str) -> None:
    (case / "generation" / "attempts" / "01" / "attempt.json").write_text(record)
    assert list(attempts_of(case)) == [2]


def test_two_cards_of_one_name_go_back(tmp_path: Path, case: Path) -> None:
    right = CARD.format(failing=1, repaired=2)
    model = Scripted({"distiller": [fenced(right + right.partition("cards:\n")[2]), fenced(right)]})
    assert distill(chat(tmp_path, model), case, tmp_path / "cards") == ["falls-from-too-high"]
    assert "an `id` of its own" in model.questions("distiller")[1]
