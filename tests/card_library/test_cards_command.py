"""The command `text2sim cards`, for people and programs."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from text2sim.cli.main import run

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Call:
    """Return a function that calls the command in a folder of its own: exit code, output, errors."""
    monkeypatch.chdir(tmp_path)

    def answer(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["text2sim", "cards", *arguments])
        with pytest.raises(SystemExit) as stopped:
            run()
        said = capsys.readouterr()
        return int(stopped.value.code or 0), said.out, said.err

    return answer


def test_the_list_is_the_index(call: Call) -> None:
    code, out, _ = call("list")
    assert code == 0
    assert len(out.splitlines()) >= 25
    assert any(line.startswith("grip-slips: ") for line in out.splitlines())


def test_a_card_is_shown_with_its_cases(call: Call) -> None:
    code, out, _ = call("show", "grip-slips")
    assert code == 0
    assert out.startswith("[grip-slips] ")
    assert "failing.yaml" in out
    code, out, _ = call("show", "grip-slips", "--json")
    assert json.loads(out)["evidence"]["repaired"]["outcome"] == "passed"


def test_a_card_that_is_not_there(call: Call) -> None:
    code, _, err = call("show", "grip-slip")
    assert code == 2
    assert "did you mean `grip-slips`?" in err


def test_find(call: Call) -> None:
    code, out, _ = call("find", "the brick slips out of the gripper", "--role", "actions", "--limit", "2", "--json")
    assert code == 0
    assert json.loads(out)["matches"][0]["id"] == "grip-slips"
    assert len(json.loads(out)["matches"]) <= 2
    code, _, err = call("find", "ball", "--role", "director")
    assert code == 2
    assert "director" in err
    code, _, err = call("find", "zyzzyva")
    assert code == 0
    assert "no card fits" in err


def test_verify_by_the_lint_alone(call: Call) -> None:
    code, out, _ = call("verify", "--lint-only", "--json", "grip-slips")
    assert code == 0
    assert json.loads(out)["cards"][0]["id"] == "grip-slips"
    code, _, err = call("verify", "no-such-card")
    assert code == 2
    assert "there is no card" in err


def test_verify_reports_cards_that_do_not_hold(call: Call, shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TEXT2SIM_CARDS", str(shelf))
    card = shelf / "falls-too-far" / "card.yaml"
    card.write_text(card.read_text("utf-8").replace("missed:slow", "lint:overlap"), "utf-8")
    code, out, _ = call("verify", "--lint-only", "falls-too-far")
    assert code == 1
    assert "FAIL  falls-too-far" in out


def test_invalid_cards_are_reported(call: Call, shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TEXT2SIM_CARDS", str(shelf))
    card = shelf / "falls-too-far" / "card.yaml"
    card.write_text(card.read_text("utf-8").replace("symptoms:", "symptom:"), "utf-8")
    code, out, err = call("list")
    assert code == 2
    assert "grip-slips: " in out
    assert "card.yaml:8:" in err
    assert "did you mean `symptoms`?" in err
