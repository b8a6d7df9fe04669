"""Judging of real method folders: material, scores, failures."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.conftest import PHYSICAL, VISUAL, Judge, fall, make_run
from text2sim.evaluation.judging import Judgement, Judging, read_judgements, scores_of_runs
from text2sim.evaluation.method_folder import read_method
from text2sim.evaluation.suite import read_suite
from text2sim.spec_schema.errors import RunError

Make = Callable[..., Path]


def judged(suite: Path, methods: list[Path], judge: Judge, out: Path, **options: Any) -> list[Judgement]:
    read, _ = read_suite(suite)
    judging = Judging(read, [read_method(folder) for folder in methods], [judge.model], out, **options)
    return judging.run(read.prompts, lambda line: None)


def of(rows: list[Judgement], prompt: str, kind: str) -> list[Judgement]:
    return [row for row in rows if (row.turn.prompt, row.turn.kind) == (prompt, kind)]


def test_scores_are_those_that_a_hand_works_out_from_the_kept_replies(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    rows = judged(suite, [make_method("ours")], judge, tmp_path / "out", repeats=2)
    (physical, again) = of(rows, "drop", "physical")
    # S 100; B (4 + 2/2) / 6; A 5 / 10; F (3 + 1/2) / 4, R = 0.7 F + 0.3 60; one of four weights of prohibitions.
    parts = (100, 100 * 5 / 6, 50, 0.7 * 87.5 + 0.3 * 60)
    total = 0.20 * parts[0] + 0.275 * parts[1] + 0.275 * parts[2] + 0.25 * parts[3] - 40 * 1 / 4
    assert physical.total == pytest.approx(total)
    assert physical.score is not None
    assert list(physical.score["parts"].values()) == pytest.approx(parts)
    assert again.total == physical.total
    assert [row.total for row in of(rows, "drop", "visual")] == [
        pytest.approx(0.3 * 80 + 0.3 * 60 + 0.25 * 40 + 0.15 * 20)
    ] * 2
    kept = tmp_path / "out" / "drop" / "ours" / "physical-1-1"
    (call,) = (kept / "calls").glob("*.json")
    assert PHYSICAL.strip() in json.loads(call.read_text())["reply"]["text"]
    assert json.loads((kept / "judgement.json").read_text())["total"] == physical.total


def test_scores_are_found_by_the_simulation_that_they_are_about(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    folder = make_method("ours")
    rows = judged(suite, [folder], judge, tmp_path / "out", repeats=2)
    digest = json.loads((folder / "drop/run/run.json").read_text())["key"]["sim_digest"]
    found = scores_of_runs(tmp_path / "out")
    assert {*found} == {digest}, "`sag` has a film alone"
    (visual, _) = of(rows, "drop", "visual")
    assert {"by": "visual judge 1, 1", "score": visual.total, "verdict": None} in found[digest]
    assert len(found[digest]) == 4


def test_a_judge_sees_the_list_the_case_records_facts_and_frames_but_no_name(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    rows = judged(suite, [make_method("secret_name")], judge, tmp_path / "out", repeats=1)
    (letter,) = judge.asked("physical")
    assert "`action.lands` (5): it reaches the floor" in letter
    assert "`through` (3): the ball does not pass through the floor" in letter
    assert "kind: sphere" in letter
    assert "height: " in letter.partition("<records>")[2]
    assert "body.red: true: `ball` is red" in letter
    assert "body.ball: FALSE: there are 1 `ball`, wanted 2" in letter
    assert "none has positions that no force explains" in letter
    assert "frame 10: 2.90 s" in letter
    shown = [part for part in judge.requests[1]["messages"][1]["content"] if part["type"] == "image_url"]
    assert len(shown) == 10
    (visual, _) = judge.asked("visual")
    for text in (letter, visual):
        assert "secret_name" not in text
        assert "methods/" not in text
    assert "requirements" not in visual
    assert "sphere" not in visual
    assert not judge.asked("sag")[0].partition("# The answer")[2].count("<program>")
    assert of(rows, "sag", "physical")[0].total == pytest.approx(75 + 0.25 * (70 + 15))


def test_nothing_is_judged_twice(suite: Path, make_method: Make, judge: Judge, tmp_path: Path) -> None:
    method = make_method("ours")
    first = judged(suite, [method], judge, tmp_path / "out")
    count = len(judge.requests)
    assert count == 2 * 2 * 3 + 1, "two kinds of two prompts, three times, and facts of one run"
    # As after a kill in the middle of writing:
    (tmp_path / "out" / "drop" / "ours" / "visual-1-2" / "judgement.json").unlink()
    second = judged(suite, [method], judge, tmp_path / "out")
    assert [row.total for row in second] == [row.total for row in first]
    assert len(judge.requests) == count
    assert len(read_judgements(tmp_path / "out")[1]) == len(first)


@pytest.mark.parametrize(
    "answer",
    [
        "This is a wonderful film!",
        VISUAL.replace("80", "200"),
        VISUAL.replace("content: 80\n", ""),
    ],
    ids=["prose", "200", "missing"],
)
def test_a_judge_without_a_usable_answer_leaves_the_case_as_not_judged(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, answer: str
) -> None:
    judge.replies["visual"] = answer
    rows = judged(suite, [make_method("ours")], judge, tmp_path / "out", repeats=1)
    (visual,) = of(rows, "drop", "visual")
    assert (visual.state, visual.total) == ("not_judged", None)
    assert "visual gave no usable answer" in visual.why
    assert of(rows, "drop", "physical")[0].state == "judged", "the rest goes on"
    assert len(judge.asked("visual")) == 2 * 3, "three tries for each film"


@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ("scene.floor: {mark: 1}", "scene.roof: {mark: 1}", "/requirements/scene.floor: is missing"),
        ('{mark: 0, evidence: "frame 10: it ends above the floor"}', "{mark: 0}", "has to cite what shows it"),
        ("frame 10:", "frame 99:", "there is no frame 99; 10 were shown"),
        ("mark: 0.5", "mark: 0.7", "is 1, 0.5 or 0, not 0.7"),
        ("usable", "unusable", "say what shows that it is unusable"),
    ],
)
def test_faults_of_a_judgement_are_returned_to_the_judge(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, wrong: str, right: str, said: str
) -> None:
    replies = iter([PHYSICAL.replace(wrong, right), PHYSICAL])
    judge.replies["physical"] = lambda: next(replies)
    rows = judged(suite, [make_method("ours")], judge, tmp_path / "out", repeats=1)
    assert of(rows, "drop", "physical")[0].state == "judged"
    assert said in judge.asked("physical")[1]


def test_a_film_that_does_not_decode_caps_and_counts_nothing(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    method = make_method("ours")
    (method / "drop" / "film.mp4").write_bytes(b"no film at all")
    judge.replies["physical"] = PHYSICAL.replace("frame ", "record ")
    rows = judged(suite, [method], judge, tmp_path / "out", repeats=1)
    (visual,) = of(rows, "drop", "visual")
    assert (visual.state, visual.total) == ("nothing", 0.0)
    assert "does not decode" in visual.why
    (physical,) = of(rows, "drop", "physical")
    assert physical.total == 20.0
    assert physical.score is not None
    assert physical.score["caps"] == (20.0,)


def test_a_prompt_without_a_result_is_reported_and_not_dropped(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    method = make_method("ours")
    for file in (method / "sag").iterdir():
        file.unlink()
    rows = judged(suite, [method], judge, tmp_path / "out", repeats=1)
    assert [row.total for row in rows if row.turn.prompt == "sag"] == [0.0, 0.0]
    (method / "sag").rmdir()
    rows = judged(suite, [method], judge, tmp_path / "out", repeats=1)
    assert [(row.state, row.total) for row in rows if row.turn.prompt == "sag"] == [("not_judged", None)] * 2


def test_keyframed_motion_caps_the_score_against_the_judge(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    method = make_method("ours")
    shutil.rmtree(method / "drop" / "run")
    make_run(tmp_path / "set", lambda run: fall(run, speed=0.0)).rename(method / "drop" / "run")
    judge.replies["physical"] = PHYSICAL.replace("mark: 0,", "mark: 1,").replace("violated: yes", "violated: no")
    rows = judged(suite, [method], judge, tmp_path / "out", repeats=1)
    assert of(rows, "drop", "physical")[0].total == 40.0
    assert "`ball` is moved by no force" in judge.asked("physical")[0]


def test_a_folder_that_answers_another_prompt_is_not_judged(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    method = make_method("ours")
    (method / "drop" / "prompt.txt").write_text("A blue cube floats.")
    rows = judged(suite, [method], judge, tmp_path / "out", repeats=1)
    assert [row.state for row in rows if row.turn.prompt == "drop"] == ["not_judged"] * 2
    assert "another prompt: A blue cube floats." in rows[0].why


def test_pending_judgements_count_as_not_judged(suite: Path, make_method: Make, judge: Judge, tmp_path: Path) -> None:
    judged(suite, [make_method("ours")], judge, tmp_path / "out", repeats=2)
    shutil.rmtree(tmp_path / "out" / "sag" / "ours" / "visual-1-2")
    missing = [row for row in read_judgements(tmp_path / "out")[1] if row.state == "not_judged"]
    assert [row.turn.code for row in missing] == [row.turn.code for row in missing if row.turn.prompt == "sag"]
    assert [row.why for row in missing] == ["nobody has judged it yet"]


@pytest.mark.parametrize("damage", ["{}", "[]", "{", '{"judged": 1}'])
def test_a_damaged_record_is_no_judging(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, damage: str
) -> None:
    (tmp_path / "judging.json").write_text(damage)
    with pytest.raises(RunError, match="nothing was judged here"):
        read_judgements(tmp_path)
    assert judged(suite, [make_method("ours")], judge, tmp_path, repeats=1)


@pytest.mark.parametrize("change", [{"total": "x"}, {"state": "lost"}, {"reply": 5}, {"turn": {}}])
def test_a_damaged_judgement_is_named(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, change: dict[str, Any]
) -> None:
    judged(suite, [make_method("ours")], judge, tmp_path, repeats=1)
    path = tmp_path / "drop" / "ours" / "visual-1-1" / "judgement.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(RunError, match="not a judgement; remove its folder"):
        read_judgements(tmp_path)


def test_a_judge_who_sees_no_pictures_is_refused(suite: Path, make_method: Make, judge: Judge, tmp_path: Path) -> None:
    read, _ = read_suite(suite)
    blind = judge.model.replace("vision=yes", "vision=no")
    judging = Judging(read, [read_method(make_method("ours"))], [blind], tmp_path / "out")
    with pytest.raises(RunError, match="does not accept pictures"):
        judging.run(read.prompts, lambda line: None)


@pytest.mark.parametrize("relative", [True, False])
def test_no_message_reveals_the_folder(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, relative: bool
) -> None:
    """What cannot be read is named by its path in messages, and in that stands the name of the method."""
    method = make_method("secret_name")
    (method / "drop" / "run" / "states" / "layout.json").unlink()
    (method / "drop" / "film.mp4").write_bytes(b"none")
    monkeypatch.chdir(tmp_path)
    judge.replies["physical"] = PHYSICAL.replace("frame ", "record ")
    judged(suite, [method.relative_to(tmp_path) if relative else method], judge, tmp_path / "out", repeats=1)
    for letter in judge.asked("physical"):
        assert "secret_name" not in letter
        assert "layout.json: nothing was recorded" in letter
