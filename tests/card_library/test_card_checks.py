"""Checks of cards without running them, with located problems."""

import json
from pathlib import Path

import pytest

from text2sim.card_library.library import MAX_CARD, MAX_CASE, check_card, load_library
from text2sim.card_library.model import Card, card_schema
from text2sim.spec_schema.errors import Problem, SpecError

Texts = dict[str, str]


def problems_of(texts: Texts) -> list[Problem]:
    with pytest.raises(SpecError) as raised:
        check_card(texts["card.yaml"], failing=texts["failing.yaml"], repaired=texts["repaired.yaml"])
    return raised.value.problems


def only_problem(texts: Texts) -> Problem:
    (problem,) = problems_of(texts)
    return problem


def test_a_card_that_is_right(texts: Texts) -> None:
    card, failing, repaired = check_card(
        texts["card.yaml"], failing=texts["failing.yaml"], repaired=texts["repaired.yaml"], id="falls-too-far"
    )
    assert card.evidence.failing.outcome == "missed:slow"
    assert failing.case.bodies["ball"].pose != repaired.case.bodies["ball"].pose


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("symptoms:", "symptom:", 8, "symptom"),
        ("roles: [actions, critic]", "roles: [actions, critics]", 7, "critics"),
        ("modes: [rigid]", "modes: []", 4, "modes"),
        ("outcome: passed", 'outcome: "missed:slow"', 13, "the repaired case must have passed"),
        ('outcome: "missed:slow"', "outcome: boom", 15, "`boom` is not an outcome"),
        ("id: falls-too-far", "id: Falls", 1, "is not a card's id"),
    ],
)
def test_problems_of_a_card_are_located(texts: Texts, old: str, new: str, line: int, words: str) -> None:
    texts["card.yaml"] = texts["card.yaml"].replace(old, new)
    found = [problem for problem in problems_of(texts) if problem.line == line]
    assert found, problems_of(texts)
    assert found[0].file == "card.yaml"
    assert words in found[0].message or words in found[0].path


def test_a_card_that_costs_too_much(texts: Texts) -> None:
    long = "very " * 55
    texts["card.yaml"] = texts["card.yaml"].replace(
        "[start lower]", "[" + ", ".join(f"{long}{n}" for n in range(4)) + "]"
    )
    texts["card.yaml"] = texts["card.yaml"].replace("[it starts too high]", f"[{long}high, {long}fast]")
    assert "at most 350 tokens" in only_problem(texts).message


def test_problems_of_its_cases_are_located(texts: Texts) -> None:
    texts["failing.yaml"] = texts["failing.yaml"].replace("of: ball", "of: bell")
    problem = only_problem(texts)
    assert (problem.file, problem.line, problem.hint) == ("failing.yaml", 8, "ball")


def test_all_three_files_are_judged_at_once(texts: Texts) -> None:
    texts["card.yaml"] = texts["card.yaml"].replace("symptoms:", "symptom:")
    texts["failing.yaml"] = texts["failing.yaml"].replace("radius: 0.1", "radius: -1")
    texts["repaired.yaml"] = "["
    assert {problem.file for problem in problems_of(texts)} == {"card.yaml", "failing.yaml", "repaired.yaml"}


def test_a_repair_must_not_ask_for_less(texts: Texts) -> None:
    texts["repaired.yaml"] = texts["failing.yaml"].replace("below: 4", "below: 40")
    problem = only_problem(texts)
    assert (problem.rule, problem.file) == ("other-expectations", "repaired.yaml")


def test_an_outcome_names_an_existing_rule_or_expectation(texts: Texts) -> None:
    texts["card.yaml"] = texts["card.yaml"].replace("missed:slow", "missed:slwo")
    assert (only_problem(texts).rule, only_problem(texts).hint) == ("unknown-outcome", "slow")
    texts["card.yaml"] = texts["card.yaml"].replace("missed:slwo", "lint:overlapp")
    assert only_problem(texts).hint == "overlap"


@pytest.mark.parametrize(("name", "limit"), [("card.yaml", MAX_CARD), ("failing.yaml", MAX_CASE)])
def test_texts_are_limited(texts: Texts, name: str, limit: int) -> None:
    texts[name] += "#" * limit
    assert only_problem(texts).rule == "too-large"


def test_the_schema_is_small_and_rejects_other_data(texts: Texts) -> None:
    import jsonschema
    import yaml

    schema = card_schema()
    assert len(json.dumps(schema)) < 4000
    assert "$ref" not in json.dumps(schema)
    data = yaml.safe_load(texts["card.yaml"])
    jsonschema.validate(data, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data | {"title": 1}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data | {"code": "x"}, schema)


def test_cards_of_the_user(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TEXT2SIM_CARDS", str(shelf))
    library = load_library()
    assert library.problems == []
    assert "falls-too-far" in library.entries
    assert len(library.entries) > 20


def test_invalid_cards_are_left_out_and_reported(shelf: Path, texts: Texts, tmp_path: Path) -> None:
    secret = tmp_path / "secret.yaml"
    secret.write_text(texts["card.yaml"], "utf-8")
    for name in ("linked", "empty", "misnamed"):
        (shelf / name).mkdir()
    (shelf / "linked" / "card.yaml").symlink_to(secret)
    (shelf / "misnamed" / "card.yaml").write_text(texts["card.yaml"], "utf-8")
    (shelf / "outside").symlink_to(tmp_path, target_is_directory=True)
    library = load_library([shelf])
    assert list(library.entries) == ["falls-too-far"]
    told = {Path(problem.file).parent.name: problem.rule for problem in library.problems}
    assert told == {"linked": "unreadable", "empty": "unreadable", "misnamed": "card-id"}


def test_a_built_in_card_is_not_replaced(shelf: Path, texts: Texts) -> None:
    other = shelf.parent / "other" / "falls-too-far"
    other.mkdir(parents=True)
    (other / "card.yaml").write_text(texts["card.yaml"].replace("too high", "too low"), "utf-8")
    library = load_library([shelf, other.parent])
    assert library.entries["falls-too-far"].folder.parent == shelf
    assert [problem.rule for problem in library.problems] == ["duplicate-card"]


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    library = load_library([tmp_path / "nowhere"])
    assert [problem.rule for problem in library.problems] == ["unreadable"]


def test_the_text_for_writers_omits_what_only_a_critic_needs(texts: Texts) -> None:
    import yaml

    card = Card.model_validate(yaml.safe_load(texts["card.yaml"]))
    assert "compare the height" in card.brief("critic")
    assert "compare the height" not in card.brief("actions")
    for role in ("critic", "actions"):
        assert all(words in card.brief(role) for words in ("start lower", "a wider tolerance"))
        assert ("6.3 m/s" in card.brief(role)) == ("2.8 m/s" in card.brief(role)) == (role == "critic")
