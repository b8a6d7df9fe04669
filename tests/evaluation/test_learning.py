"""Learning of cards: proposals, trials, merges, and the separation of sources."""

import itertools
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.agents.test_distilling import CASE
from tests.evaluation.conftest import PHYSICAL, Judge
from text2sim.agents.conversation import Wrong
from text2sim.agents.distilling import CardProposal, TriedAttempt, draft_card
from text2sim.card_library.library import BUILT_IN, load_library
from text2sim.card_library.retrieval import DUPLICATE_LIKENESS, likeness
from text2sim.evaluation.judging import judge_endpoint
from text2sim.evaluation.learning import Learning
from text2sim.evaluation.ledger import (
    CardDebt,
    CardRecord,
    check_split,
    count_offered_cards,
    digest_of,
    read_ledger,
    record_card,
)
from text2sim.evaluation.method_folder import CaseResult, MethodRecord, write_method, write_result
from text2sim.evaluation.methods import Allowance
from text2sim.evaluation.suite import Prompt, read_suite
from text2sim.spec_schema.errors import SpecError

CARD = """\
    id: {id}
    title: {title}
    applies: {{modes: [rigid], tags: [fall], roles: [planner, bodies]}}
    symptoms: [the event never happens]
    likely_causes: [a fall from h takes the root of 2 h / g]
    repair: [start lower]
    evidence:
      case: a ball over a floor
      failing: {{outcome: "{outcome}", observed: not down after 0.6 s}}
      repaired: {{outcome: passed, observed: down after 0.25 s}}
      measured_on: {{genesis-world: 1.4.5}}
"""
LESSON = """\
lesson:
  failure: The ball is still in the air at the end.
  evidence: "frame 10; attempt 1: lands missed"
  failing: 1
  repair: [{op: replace, path: /bodies/ball/pose/pos/2, value: %s}]
  edits: "%s"
  card:
""" + CARD.format(id="falls-from-too-high", title="A fall takes longer than the scene lasts", outcome="missed:lands")
GOOD = PHYSICAL.replace("mark: 0,", "mark: 1,").replace("violated: yes", "violated: no")
Learn = Callable[..., Learning]


def attempt(number: int = 1, height: str = "2.0", ok: bool = False) -> TriedAttempt:
    rows = {"lands": {"ok": ok, "wanted": "`touch` from 0.1 s to 0.5 s", "why": "it never happened"}}
    record = {"state": "finished", "cause": "first version", "changes": [], "expect": rows, "critique": None}
    return TriedAttempt(number, CASE % height, record)


@pytest.fixture
def learn(suite: Path, judge: Judge, recorded: Path, tmp_path: Path) -> Learn:
    """Return a function that makes a learning of `drop`; `dealt` are the cards that its loops are given."""

    def answer(read: Any, prompts: dict[str, Prompt], method: Any, *rest: Any, dealt: tuple[str, ...]) -> Path:
        folder = tmp_path / "work" / "rounds" / method.name
        write_method(folder, MethodRecord(name=method.name, suite=read.name))
        for name in prompts:
            if (folder / name).exists():
                continue
            shutil.copytree(recorded, folder / name)
            one = attempt()
            place = folder / name / "case" / "generation" / "attempts" / "01"
            place.mkdir(parents=True)
            (place / "case.yaml").write_text(one.text)
            (place / "attempt.json").write_text(json.dumps(one.record))
            known = [card for card in dealt if card in load_library([Path(method.library)]).entries]
            (place.parents[1] / "run.json").write_text(json.dumps({"cards": {"planner": known}}))
            result = CaseResult(prompt=name, status="finished", film="film.mp4", program="case/case.yaml", run="run")
            write_result(folder / name, result)
        return folder

    def make(dealt: tuple[str, ...] = ("falls-from-too-high",)) -> Learning:
        read, _ = read_suite(suite)
        return Learning(
            read, {"drop": read.prompts["drop"]}, tmp_path / "cards", tmp_path / "work", [], judge.model, Allowance(),
            print, repeats=1, answer=lambda *rest: answer(*rest, dealt=dealt),
        )  # fmt: skip

    judge.replies["lesson"] = LESSON % ("0.4", "")
    return make


def say(judge: Judge, *physical: str) -> None:
    rows = itertools.chain(physical, itertools.repeat(physical[-1]))
    judge.replies["physical"] = lambda: next(rows)


@pytest.mark.usefixtures("engine")
def test_a_card_is_run_and_tried_and_kept_if_its_prompt_gets_better(
    learn: Learn, judge: Judge, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    say(judge, PHYSICAL, GOOD)
    wrong, right = LESSON % ("1.9", ""), LESSON % ("0.4", "")
    replies = iter([wrong, right])
    judge.replies["lesson"] = lambda: next(replies)
    learn().run()
    first, second = judge.asked("lesson")
    assert "action.lands: 0: frame 10: it ends above the floor" in first
    assert "Attempt 1" in first and "ball-falls-through-the-net" in first
    assert "the card does not hold: the repaired case is still `missed:lands`" in second
    (entry,) = load_library([tmp_path / "cards"]).entries.values()
    account = read_ledger(tmp_path / "cards").cards["falls-from-too-high"]
    assert (account.state, account.digest, account.owes[0].prompt) == ("kept", digest_of(entry), "drop")
    assert account.gain > 10 and account.tried[0].dealt
    count = len(judge.requests)
    learn().run()
    assert len(judge.requests) == count, "nothing is done twice"

    (tmp_path / "work" / "lessons" / "drop" / "lesson.json").unlink()
    judge.replies["lesson"] = right
    learn().run()
    assert "there is a card `falls-from-too-high` already" in judge.asked("lesson")[-1]
    shutil.rmtree(tmp_path / "work")
    say(judge, PHYSICAL, PHYSICAL.replace("aesthetics: 60", "aesthetics: 90"))
    judge.replies["lesson"] = LESSON.replace("start lower", "start nearer to the floor") % (
        "0.3",
        "falls-from-too-high",
    )
    learn().run()
    again = read_ledger(tmp_path / "cards").cards["falls-from-too-high"]
    assert again == account, "an edit that is better than no card, and worse than the card, leaves it as it was"
    assert "rejected: -" in capsys.readouterr().out


@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize(("dealt", "after", "shown"), [
    (("falls-from-too-high",), PHYSICAL.replace("aesthetics: 60", "aesthetics: 10"), "points where it was tested: WORSE"),
    ((), GOOD, "NEVER RETRIEVED where it was tested"),
])  # fmt: skip
def test_a_card_that_made_it_worse_or_that_nobody_was_given_is_not_kept_and_shown_as_such(
    learn: Learn, judge: Judge, tmp_path: Path, capsys: pytest.CaptureFixture[str], dealt: tuple[str, ...], after: str, shown: str
) -> None:  # fmt: skip
    from text2sim.cli.learned_cards import show_ledger

    say(judge, PHYSICAL, after)
    learn(dealt).run()
    assert not load_library([tmp_path / "cards"]).entries
    assert read_ledger(tmp_path / "cards").cards["falls-from-too-high"].state == "rejected"
    show_ledger(tmp_path / "cards", [tmp_path / "work"], False)
    said = capsys.readouterr().out
    assert "built-in cards NEVER RETRIEVED in 2 loops: aimed-without-gravity" in said
    assert shown in said
    assert "owes On falling balls (A. Nobody, 1999; drop): The ball is still in the air" in said


def shelve(cards: Path, id: str, title: str, source: str, prompts: dict[str, Prompt]) -> None:
    """Put a card on a shelf, and what it owes into the ledger."""
    proposal = CardProposal(failing=1, repaired=2, card={})
    text = CARD.format(id=id, title=title, outcome="missed:lands")
    import yaml

    proposal.card.update(yaml.safe_load(text))
    draft_card(proposal, {1: attempt(), 2: attempt(2, "0.4", True)}).write(cards / id)
    entry = load_library([cards]).find(id)
    debt = CardDebt(prompt=source, failure="it is still in the air", evidence="frame 10")
    record_card(cards, id, CardRecord(state="kept", digest=digest_of(entry), owes=[debt]), {source: prompts[source]})


def test_duplicate_cards_are_merged_with_their_debts(learn: Learn, suite: Path, judge: Judge, tmp_path: Path) -> None:
    prompts = read_suite(suite)[0].prompts
    shelve(tmp_path / "cards", "falls-from-too-high", "A fall takes longer than the scene lasts", "drop", prompts)
    shelve(tmp_path / "cards", "scene-ends-too-soon", "The scene ends before the fall does", "sag", prompts)
    judge.replies["merge"] = "keep: scene-ends-too-soon\ncard:\n" + CARD.format(
        id="other", title="A fall takes longer than the scene lasts, or the scene is short", outcome="lint:made-up"
    )
    learn().consolidate()
    (entry,) = load_library([tmp_path / "cards"]).entries.values()
    assert entry.id == "scene-ends-too-soon" and entry.card.title.endswith("short")
    assert entry.card.evidence.failing.outcome == "missed:lands", "facts stay"
    ledger = read_ledger(tmp_path / "cards")
    assert {debt.prompt for debt in ledger.cards["scene-ends-too-soon"].owes} == {"drop", "sag"}
    assert ledger.cards["falls-from-too-high"].state == "merged"
    document = read_suite(suite)[1]
    with pytest.raises(SpecError, match="On falling balls"):
        check_split(read_suite(suite)[0], document, tmp_path / "cards")


def test_no_suite_is_answered_with_cards_from_its_sources(suite: Path, tmp_path: Path) -> None:
    read, document = read_suite(suite)
    other = tmp_path / "other.yaml"
    text = (
        suite.read_text()
        .replace("On falling balls", "Of pendulums")
        .replace("A red ball falls onto", "Twelve pendulums hang over")
    )
    other.write_text(
        text.replace("On sagging cloths", "Of nets").replace("A cloth that hangs by", "Forty knots are held at")
    )
    apart, place = read_suite(other)
    cards = tmp_path / "cards"
    check_split(read, document, None)
    check_split(read, document, BUILT_IN)
    shelve(cards, "falls-from-too-high", "A fall takes longer than the scene lasts", "drop", read.prompts)
    check_split(apart, place, cards)
    for hostile in (suite.read_text(), suite.read_text().replace("On falling balls", "ON FALLING-BÄLLS!")):
        suite.write_text(hostile)
        with pytest.raises(SpecError) as caught:
            check_split(*read_suite(suite), cards)
        (problem,) = caught.value.problems
        assert (problem.rule, problem.line) == ("shared-source", 6)

    ledger = json.loads((cards / "ledger.json").read_text())
    (cards / "ledger.json").write_text(json.dumps(ledger | {"prompts": {}}))
    with pytest.raises(SpecError, match="the sources of drop are missing"):
        check_split(apart, place, cards)
    (cards / "ledger.json").write_text(json.dumps(ledger))
    (cards / "falls-from-too-high" / "failing.yaml").write_text(CASE % "2.5")
    with pytest.raises(SpecError, match="changed since"):
        check_split(apart, place, cards)
    (cards / "ledger.json").unlink()
    with pytest.raises(SpecError, match="it is not in the ledger"):
        check_split(apart, place, cards)


def test_a_repair_is_a_patch_if_no_attempt_succeeded() -> None:
    import yaml

    card = yaml.safe_load(CARD.format(id="a-card", title="A fall takes longer", outcome="missed:low"))
    measure = {
        "op": "add",
        "path": "/actions/measures",
        "value": {"height": {"kind": "position", "of": "ball", "axis": "z"}},
    }
    low = {"op": "add", "path": "/actions/expect/low", "value": {"measure": "height", "at": "end", "below": 0.3}}
    lower = {"op": "replace", "path": "/bodies/ball/pose/pos/2", "value": 0.4}
    attempts = {1: attempt(), 2: attempt(2, "0.5", True)}
    draft = draft_card(CardProposal(failing=1, expect=[measure, low], repair=[lower], card=card), attempts)
    assert "low:" in draft.failing and "2.0" in draft.failing
    assert "low:" in draft.repaired and "0.4" in draft.repaired
    for wrong, why in (
        (CardProposal(failing=1, card=card), "needs `repaired`, an attempt, or `repair`"),
        (CardProposal(failing=3, repair=[lower], card=card), "there are attempts 1, 2"),
        (CardProposal(failing=1, repair=[lower | {"path": "/bodies/bull/pose"}], card=card), "bull"),
        (
            CardProposal(failing=1, repair=[low | {"value": {"event": "touch", "within": [0, 1]}}], card=card),
            "expect the same",
        ),
    ):
        with pytest.raises(Wrong, match=why):
            draft_card(wrong, attempts)


def test_built_in_cards_are_no_duplicates() -> None:
    entries = [entry.card for entry in load_library([BUILT_IN]).entries.values()]
    most = max(likeness(one, other) for one, other in itertools.combinations(entries, 2))
    assert most < 0.3 < DUPLICATE_LIKENESS
    assert likeness(entries[0], entries[0]) == 1


def test_who_was_given_which_card(tmp_path: Path) -> None:
    for k, cards in enumerate(({"planner": ["a"], "bodies": ["a", "b"]}, {}, {"critic": ["a"]})):
        (tmp_path / str(k) / "generation").mkdir(parents=True)
        (tmp_path / str(k) / "generation" / "run.json").write_text(json.dumps({"cards": cards}))
    loops, dealt = count_offered_cards([tmp_path, tmp_path / "0"])
    assert loops == 3
    assert dealt == {"a": 2, "b": 1}


def test_commands_refuse_to_judge_cards_by_their_own_sources(
    suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from text2sim.cli.main import app

    shelve(tmp_path / "cards", "falls-from-too-high", "A fall takes longer", "drop", read_suite(suite)[0].prompts)
    monkeypatch.setenv("TEXT2SIM_CARDS", str(tmp_path / "cards"))
    words = ["evaluate", "run", str(suite), "--model", "mailbox:x", "--out", str(tmp_path / "out"), "--method"]
    for method in ("text2sim", "agent", "mine=true"):
        refused = CliRunner().invoke(app, [*words, method, "--allow-code"])
        assert isinstance(refused.exception, SpecError)
        assert "`the ledger of cards` uses this source" in str(refused.exception)
        assert not (tmp_path / "out").exists()
    for held_out, options in (("demonstrations", []), (str(suite), ["--apart-from", str(suite)])):
        words = [
            "cards",
            "distill",
            "--suite",
            held_out,
            *options,
            "--model",
            "mailbox:x",
            "--work",
            str(tmp_path / "w"),
        ]
        refused = CliRunner().invoke(app, words)
        assert isinstance(refused.exception, SpecError)
        assert not (tmp_path / "w").exists()


@pytest.mark.usefixtures("engine")
def test_another_model_writes_the_card_than_marks_the_answer(
    learn: Learn, judge: Judge, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, str]] = []

    def endpoint(model: str, what: str) -> Any:
        asked.append((model, what))
        return judge_endpoint(judge.model, what)

    monkeypatch.setattr("text2sim.evaluation.learning.judge_endpoint", endpoint)
    say(judge, PHYSICAL, GOOD)
    replace(learn(), reviewer="another").run()
    assert ("another", "lesson-drop") in asked
