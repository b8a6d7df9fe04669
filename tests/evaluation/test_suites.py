"""Suites: located problems, disjoint built-in suites, drafting and freezing."""

from collections import Counter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.agents.models.chat_server import ChatServer, completion
from tests.evaluation.conftest import SUITE
from text2sim.cli.main import app
from text2sim.evaluation.drafting import suite_text, write_frozen
from text2sim.evaluation.suite import Suite, read_suite, select_prompts, shared_sources
from text2sim.spec_schema.errors import SpecError


def changed(tmp_path: Path, old: str, new: str) -> Path:
    assert old in SUITE
    path = tmp_path / "changed.yaml"
    path.write_text(SUITE.replace(old, new))
    return path


def test_the_suites_that_come_along_are_complete_frozen_and_apart() -> None:
    demonstrations, document = read_suite(Path("demonstrations"))
    learning, _ = read_suite(Path("learning"))
    families = Counter(prompt.family for prompt in demonstrations.prompts.values())
    assert families == {"rigid": 10, "deformable": 18, "cloth": 14}
    assert len(learning.prompts) >= 20
    for suite in (demonstrations, learning):
        assert suite.frozen == suite.digest()
        assert all(prompt.requirements is not None for prompt in suite.prompts.values())
    assert shared_sources(demonstrations, learning, document) == []


@pytest.mark.parametrize(
    ("old", "new", "line", "said", "hint"),
    [
        ("family: cloth", "family: clot", 24, "clot", "cloth"),
        ("importance: 5}\n        lands", "importanse: 5}\n        lands", 15, "importanse", "importance"),
        ("floor\", importance: 3", "floor\", importance: 6", 10, "5", None),
        ("      render:\n        seen: {what: \"the whole", "      rendr:\n        seen: {what: \"the whole", 17, "rendr", "render"),
        ("year: 1999, ", "", 6, "year", None),
        ("name: small", "name: small\nfrozen: " + "f" * 64, 3, "have changed since it was frozen", None),
    ],
)  # fmt: skip
def test_problems_are_located(tmp_path: Path, old: str, new: str, line: int, said: str, hint: str | None) -> None:
    with pytest.raises(SpecError) as caught:
        read_suite(changed(tmp_path, old, new))
    assert (line, hint) in [(p.line, p.hint) for p in caught.value.problems if said in p.message]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("On falling balls", "ON FALLING  BALLS."),
        ("On falling balls", "Ôn Falling-Balls"),
        ("On falling balls", "On falling bals"),
        ("On falling balls", "On falling balls, and on what becomes of them"),
    ],
    ids=["case", "accents", "slip", "subtitle"],
)
def test_a_source_is_the_same_however_it_is_cited(suite: Path, tmp_path: Path, old: str, new: str) -> None:
    other = changed(tmp_path, old, new)
    other.write_text(
        other.read_text()
        .replace("A red ball falls onto a flat floor", "Rain on a window")
        .replace("On sagging", "Of wet")
    )
    other.write_text(other.read_text().replace("A cloth that hangs by two corners sags", "Leaves drift over a lawn"))
    read, document = read_suite(suite)
    problems = shared_sources(read, read_suite(other)[0], document)
    assert [problem.path for problem in problems] == ["/prompts/drop/source/title"]
    assert problems[0].line == 6


def test_a_prompt_is_the_same_under_another_source(suite: Path, tmp_path: Path) -> None:
    other = changed(tmp_path, "On falling balls", "Gravity")
    other.write_text(
        other.read_text().replace("On sagging cloths", "Textiles").replace("onto a flat", "on to the flat")
    )
    read, document = read_suite(suite)
    problems = shared_sources(read, read_suite(other)[0], document)
    assert [problem.path for problem in problems] == ["/prompts/drop/prompt", "/prompts/sag/prompt"]


def test_the_command_refuses_suites_that_share_a_source(suite: Path, tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["evaluate", "check", str(suite), "--apart-from", str(suite)])
    assert isinstance(answer.exception, SpecError)
    answer = CliRunner().invoke(app, ["evaluate", "check", "demonstrations", "--apart-from", "learning"])
    assert answer.exit_code == 0
    assert "42 prompts (10 rigid, 18 deformable, 14 cloth), frozen" in answer.output


def test_an_unknown_prompt_is_reported_with_the_nearest(suite: Path) -> None:
    with pytest.raises(SpecError) as caught:
        select_prompts(read_suite(suite)[0], ["drip"])
    assert caught.value.problems[0].hint == "drop"


def test_requirements_are_drafted_from_the_prompt_alone_and_frozen(tmp_path: Path) -> None:
    head, _, rest = SUITE.partition("    requirements:\n      scene:\n        posts")
    assert rest
    (tmp_path / "part.yaml").write_text(head)
    answer = """requirements:
  scene: {posts: {what: "two posts", importance: 2}}
  body: {cloth: {what: "a cloth", importance: 5}}
  action: {sags: {what: "it sags", importance: %s}}
  render: {seen: {what: "it is seen", importance: 4}}"""
    out = tmp_path / "frozen.yaml"
    words = ["evaluate", "draft", str(tmp_path / "part.yaml"), "--out", str(out)]
    refused = CliRunner().invoke(app, words, env={"TEXT2SIM_MODEL": ""})
    assert isinstance(refused.exception, SpecError)
    assert refused.exception.problems[0].path == "/prompts/sag"
    replies = [completion(f"```yaml\n{answer % importance}\n```") for importance in (9, 5)]
    with ChatServer(*replies) as server:
        assert CliRunner().invoke(app, [*words, "--model", f"openai/m@{server.url}"]).exit_code == 0
    first = server.requests[0]["messages"]
    assert "A cloth that hangs by two corners sags." in first[1]["content"]
    assert "Nobody" not in str(first), "no source, and no other prompt"
    assert "importance" in server.requests[1]["messages"][-1]["content"], "what was wrong went back"
    frozen, _ = read_suite(out)
    assert frozen.frozen == frozen.digest()
    assert frozen.prompts["sag"].requirements is not None
    assert frozen.prompts["drop"] == read_suite(tmp_path / "part.yaml")[0].prompts["drop"]
    out.write_text(out.read_text().replace("two posts", "three posts"))
    with pytest.raises(SpecError, match="since it was frozen"):
        read_suite(out)


def test_a_suite_is_written_as_it_was_read(suite: Path, tmp_path: Path) -> None:
    read: Suite = read_suite(suite)[0]
    write_frozen(read, tmp_path / "again.yaml")
    again = read_suite(tmp_path / "again.yaml")[0]
    assert again.prompts == read.prompts
    assert suite_text(again) == (tmp_path / "again.yaml").read_text()
