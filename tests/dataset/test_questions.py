"""Questions: answers agree with the states, and words alone do not give them away."""

import json
from collections import Counter
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
import yaml
from crates import Take

from text2sim.cli.dataset import review
from text2sim.dataset.balance import balanced_questions, guess_by_words
from text2sim.dataset.questions import ItemScene, candidate_questions, cause_in_words, what_if
from text2sim.dataset.review import read_decisions, write_review
from text2sim.spec_schema.errors import RunError, SpecError

HIT = {"kind": "contact", "name": None, "between": ["crate", "ball"], "time": 0.5, "end": 0.6}


def asked(take: Take, *events: dict, speed: float = 1.0, key: str = "a") -> dict[str, dict]:
    item = take(key, speed=speed)
    (item.folder / "events.jsonl").write_text("".join(json.dumps(event) + "\n" for event in events))
    return {row["question"]: row for row in candidate_questions(item.row, item.frames, item.folder)}


def test_answers_and_evidence_are_those_of_the_recording(take: Take) -> None:
    found = asked(take, HIT)
    will = found["You see pictures 0 to 2 only. Will “ball” touch “crate” later on?"]
    assert will["right"] == "yes" and json.loads(will["evidence"])["first_contact"] == 0.5
    by = {k: found.get(f"Have “ball” and “crate” touched by picture {k} of 8?") for k in (2, 4, 5)}
    assert by[2] is not None and by[2]["right"] == "no"
    assert by[4] is None and by[5] is None, "pictures near the moment are not asked about"
    assert found["What does “ball” touch first after the start?"]["right"] == "“crate”"
    nothing = asked(take, key="b")
    assert nothing["You see pictures 0 to 2 only. Will “ball” touch “crate” later on?"]["right"] == "no"
    assert not any("move first" in text for text in nothing), "the ball never moves"


def test_a_slower_body_that_starts_at_the_same_time_does_not_start_later(take: Take) -> None:
    question = "Which starts to move first, “ball” or “crate”?"
    for wait, speed, asked_about in ((0, 0.2, False), (5, 0.5, True)):
        item = take(f"wait{wait}")
        with np.load(item.folder / "states.npz") as arrays:
            states = dict(arrays)
        late = np.maximum(states["time"] - 0.1 * wait, 0)
        states["pos"][:, 2, 2] = 0.3 + speed * late  # slower than the crate
        np.savez(item.folder / "states.npz", **states)
        rows = {row["question"]: row for row in candidate_questions(item.row, item.frames, item.folder)}
        assert (question in rows) == asked_about
    assert rows[question]["right"] == "“crate”"


def test_a_support_is_not_the_first_contact(take: Take) -> None:
    lies = [HIT | {"between": ["crate", "floor"], "time": time, "end": time} for time in (0.0, 0.2)]
    found = asked(take, *lies, HIT)
    assert found["What does “crate” touch first after the start?"]["right"] == "“ball”"


def test_there_are_no_questions_about_films_with_a_replay(take: Take) -> None:
    item = take("a")
    (item.folder / "events.jsonl").write_text(json.dumps(HIT) + "\n")
    assert candidate_questions(item.row, item.frames, item.folder)
    item.frames[7]["time"] = 0.2
    assert not candidate_questions(item.row, item.frames, item.folder)


def test_only_tall_bodies_fall_over(take: Take) -> None:
    item = take("a")
    layout = json.loads((item.folder / "layout.json").read_text())
    for inertia, tall in (((1, 1, 1), False), ((2, 2, 0.5), True), ((2, 0.5, 2), False)):
        layout["links"][1]["inertia"] = np.diag(inertia).tolist()
        (item.folder / "layout.json").write_text(json.dumps(layout))
        assert ItemScene(item.row, item.frames, item.folder).is_tall("crate") == tall


def test_there_are_no_questions_about_contacts_that_no_picture_shows(take: Take) -> None:
    item = take("a")
    (item.folder / "events.jsonl").write_text(json.dumps(HIT) + "\n")
    for thing in item.frames[5]["objects"]:
        thing["share"] = 0.0
    rows = candidate_questions(item.row, item.frames, item.folder)
    assert "yes" not in {row["right"] for row in rows}
    assert not any("Will “ball” touch “crate”" in row["question"] for row in rows)


def test_there_are_no_questions_about_hidden_bodies(take: Take) -> None:
    item = take("a")
    (item.folder / "events.jsonl").write_text(json.dumps(HIT) + "\n")
    for frame in item.frames:
        for thing in frame["objects"]:
            thing["hidden"] = 0.9 if thing["name"] == "ball" else thing["hidden"]
    assert not any("ball" in row["question"] for row in candidate_questions(item.row, item.frames, item.folder))


def test_a_counterfactual_answers_what_if(take: Take) -> None:
    base, other = take("a"), take("a-heavy", speed=0.5, counterfactual_of="a", cause="bodies.crate.material.density")
    for item, count in ((base, 1), (other, 0)):
        item.row["events"] = [{"name": "reaches_ball", "count": count, "first": None, "last": None}]
    words = cause_in_words("bodies.crate.material.density", 5000, 1000.0)
    assert words == "the density of “crate” were much larger"
    assert cause_in_words("params.speed", 5, 6.0) == "“speed” were smaller"
    (row,) = what_if(base.row, other.row, words, base.frames, base.folder)
    assert (row["right"], row["key"]) == ("no", "a")
    assert json.loads(row["evidence"])["item"] == "a-heavy"
    assert row["question"] == "If the density of “crate” were much larger, would this happen: “reaches ball”?"
    case = yaml.safe_load((base.folder / "case.yaml").read_text())
    case["actions"] = {"events": {"reaches_ball": {"kind": "contact", "between": ["crate", "ball"]}}}
    (base.folder / "case.yaml").write_text(yaml.safe_dump(case))
    (row,) = what_if(base.row, other.row, words, base.frames, base.folder)
    assert row["question"] == "If the density of “crate” were much larger, would “crate” touch “ball”?"


def lopsided() -> list[dict]:
    """Questions of ten cases of which some texts have one answer nearly always, and one has it always."""
    rows = []
    for k in range(600):
        kind, often = ("ball", 0.9) if k % 3 == 0 else ("crate", 0.1) if k % 3 == 1 else ("door", 1.0)
        right = "yes" if (k * 7919 % 100) / 100 < often else "no"
        rows.append({"split": "train", "case": f"c{k % 10}", "key": f"i{k}", "kind": "will", "question":
                     f"Will the {kind} reach?", "right": right, "evidence": "{}"})  # fmt: skip
    return rows


def count(rows: list[dict]) -> dict[tuple[str, str, str], Counter]:
    counts: dict[tuple[str, str, str], Counter] = {}
    for row in rows:
        counts.setdefault((row["split"], row["case"], row["question"]), Counter())[row["right"]] += 1
    return counts


def test_answers_of_another_case_are_no_distractors() -> None:
    row = {"split": "train", "kind": "touches_first", "question": "What does it touch first?", "evidence": "{}"}
    rows = [row | {"case": case, "key": case, "right": right} for case, right in (("a", "cue"), ("b", "box"))]
    assert not [*balanced_questions(rows, count(rows), 1)]
    rows.append(rows[0] | {"key": "c", "right": "floor"})
    assert [{*one["choices"]} for one in balanced_questions(rows, count(rows), 1)] == [{"cue", "floor"}] * 2


def test_words_alone_are_no_better_than_chance() -> None:
    rows = lopsided()
    case_of = {row["key"]: row["case"] for row in rows}
    plain = [row | {"choices": ["no", "yes"], "answer": int(row["right"] == "yes")} for row in rows]
    found = guess_by_words(plain, [row["case"] for row in rows])
    assert found["by_words"] > 0.85, "the classifier finds what there is to be found"
    assert found["by_wording"] > 0.9 and found["by_chance"] == 0.5
    kept = list(balanced_questions(rows, count(rows), 1))
    assert len(kept) > 40
    assert not any("door" in row["question"] for row in kept), "what has one answer only is not asked"
    found = guess_by_words(kept, [case_of[row["key"]] for row in kept])
    # Every answer is right equally often for every wording of a case: no function of the words is right more often.
    assert found["by_wording"] == found["by_chance"] == 0.5
    assert found["by_words"] == pytest.approx(0.5, abs=0.1)
    assert 0.35 < sum(row["answer"] == 0 for row in kept) / len(kept) < 0.65, "nor does the place of an answer"


def test_a_few_questions_of_one_case_are_judged_by_chance() -> None:
    """A classifier that is trained on what is left of balanced answers names the other ones, always."""
    rows = [
        {"question": "Does it fall?", "choices": ["no", "yes"], "answer": k % 2, "key": str(k)} for k in range(4)
    ]  # fmt: skip
    assert guess_by_words(rows, ["a"] * 4) == {"by_words": 0.5, "by_wording": 0.5, "by_chance": 0.5}
    assert guess_by_words([], [])["by_chance"] == 0.0


def test_the_review_shows_doubtful_items_and_decisions_are_read_back(dataset: Path, tmp_path: Path) -> None:
    assert write_review(dataset, tmp_path / "page.html", {}) == 0
    assert write_review(dataset, tmp_path / "page.html", {}, everything=True) == 3
    with chdir(dataset):
        review(Path("."), everything=True)
    assert dataset.with_name(f"{dataset.name}-review.html").is_file()
    page = (tmp_path / "page.html").read_text()
    assert page.count("data:image/jpeg") == 12 and "A crate slides." in page
    (tmp_path / "review.yaml").write_text('review:\n  a: {decision: drop, note: "dark"}\n')
    assert read_decisions(tmp_path / "review.yaml")["a"].note == "dark"
    (tmp_path / "review.yaml").write_text("review:\n  a: {decision: dorp}\n")
    with pytest.raises(SpecError, match=r"review.yaml:2:\d+: error"):
        read_decisions(tmp_path / "review.yaml")
    for path, words in (
        ("shards/train-00000.tar", "train-00000.tar: cannot be read"),
        ("items/train-00000.parquet", "Parquet"),
    ):
        (dataset / path).write_bytes(b"no such file " * 100)
        with pytest.raises(RunError, match=words):
            write_review(dataset, tmp_path / "page.html", {}, everything=True)
