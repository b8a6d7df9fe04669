"""The words of a request reach the loop whatever they are, from wherever they come."""

import json
import string
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from text2sim.agents.assembly import case_text
from text2sim.agents.replies import CasePlan
from text2sim.cli.main import app
from text2sim.spec_schema.load import load_text

LONG = "A paper boat drifts down a gutter and is caught by a grating. " * 40
MODEL = ["--model", "mailbox:{case}/mail"]


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs a command in an empty folder and returns what the loop would be asked, by the folder of the case."""
    monkeypatch.chdir(tmp_path)
    begun: list[Any] = []
    monkeypatch.setattr(
        "text2sim.cli.generate._run_session", lambda session, as_json, film, minutes: begun.append(session)
    )

    def run(*arguments: str, typed: str | None = None) -> tuple[str, str]:
        done = CliRunner().invoke(app, [*arguments, *MODEL], input=typed)
        assert done.exit_code == 0, done.output + repr(done.exception)
        session = begun.pop()
        kept = json.loads((session.case / "generation" / "request.json").read_text("utf-8"))
        return session.case.name, kept["text"]

    return run


def test_of_any_length(asked: Any) -> None:
    assert asked("generate", LONG)[1] == LONG
    assert asked("generate", "x" * 5000)[1] == "x" * 5000


def test_words_that_are_the_name_of_a_file(asked: Any) -> None:
    Path("marble.txt").write_text("secret")
    assert asked("generate", "marble.txt")[1] == "marble.txt"
    assert asked("generate", ".")[1] == "."


def test_from_a_file_and_from_standard_input(asked: Any) -> None:
    Path("wish.md").write_text("\ufeff" + LONG, "utf-8")
    assert asked("generate", "--file", "wish.md")[1] == LONG
    assert asked("generate", "-", typed=LONG)[1] == LONG


def test_wishes_about_a_case_too(asked: Any) -> None:
    Path("mine").mkdir()
    Path("mine/case.yaml").write_text("text2sim: 2\nname: mine\n")
    assert asked("edit", "mine", "-", typed=LONG) == ("mine", LONG)
    Path("other").mkdir()
    Path("other/case.yaml").write_text("text2sim: 2\nname: other\n")
    Path("wrong.txt").write_text(LONG)
    assert asked("repair", "other", "--file", "wrong.txt") == ("other", LONG)


def test_the_same_first_words_go_to_a_folder_of_their_own(asked: Any) -> None:
    Path("cases/cork_pops_out_bottle").mkdir(parents=True)
    Path("cases/cork_pops_out_bottle/case.yaml").write_text("text2sim: 2\n")
    assert asked("generate", "A cork pops out of the bottle.")[0] == "cork_pops_out_bottle_2"
    assert asked("generate", "A cork pops out of the bottle!")[0] == "cork_pops_out_bottle_3"
    assert Path("cases/cork_pops_out_bottle/case.yaml").read_text() == "text2sim: 2\n"


def test_what_cannot_be_read_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("latin.txt").write_bytes(b"caf\xe9")
    for given, word in ((["--file", "nowhere.txt"], "nowhere.txt"), (["--file", "latin.txt"], "UTF-8")):
        done = CliRunner().invoke(app, ["generate", *given, *MODEL])
        assert done.exit_code != 0
        assert word in str(done.exception)
    assert "not both" in str(CliRunner().invoke(app, ["generate", "words", "--file", "latin.txt", *MODEL]).exception)


@pytest.mark.parametrize(
    "words", ["a price of ${price} each", "an open ${", "a bell \x07 rings", "a lone \ud800", *string.punctuation]
)
def test_no_wording_makes_a_case_that_cannot_be_read(words: str) -> None:
    plan = CasePlan.model_validate({"name": "x", "event": "e"})
    ball = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}, "pose": {"pos": [0, 0, 1]}}
    text = case_text(plan, words, {}, {"scene": {"duration": 1}, "bodies": {"ball": ball}})
    prompt = load_text(text).case.prompt
    assert prompt == words or not words.isprintable()
