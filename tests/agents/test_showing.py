"""What the Critic is shown: little where nothing but looks can have changed."""

from pathlib import Path

import pytest

from text2sim.agents.attempt import Attempt
from text2sim.agents.critic_view import critic_exhibit, only_looks, what_holds
from text2sim.spec_schema.load import load_text

TEXT = (Path(__file__).parent / "recorded" / "edit_colour" / "base.yaml").read_text("utf-8")
FILE = Path("tin/case.yaml")


@pytest.mark.parametrize(
    ("old", "new", "looks"),
    [
        ("color: gold", "color: green", True),
        ("finish: painted", "finish: metal", True),
        ("color: gainsboro", "color: white", True),
        ("fps: 25", "fps: 30", True),
        ("density: 1200", "density: 1300", False),
        ("slope_deg: 15", "slope_deg: 16", False),
        ("pos: [-0.85, 0, 0.36]", "pos: [-0.8, 0, 0.36]", False),
    ],
)
def test_what_physics_could_feel_is_no_change_of_looks(old: str, new: str, looks: bool) -> None:
    assert old in TEXT
    assert only_looks(TEXT, TEXT.replace(old, new), FILE) is looks


def test_a_body_called_look_is_a_body() -> None:
    named = TEXT.replace("tin:", "look:").replace("of: tin", "of: look").replace("tin]", "look]")
    assert load_text(named, FILE).case.bodies["look"]
    assert not only_looks(named, named.replace("mass: 0.15", "mass: 0.25"), FILE)


def test_a_change_of_looks_is_shown_without_the_case() -> None:
    attempt = Attempt(1, TEXT.replace("color: gold", "color: green"), "as was wished", state="finished")
    attempt.expect = {"pushed": {"ok": True, "wanted": "w", "why": "0.3 m at 1.8 s"}}
    shown = critic_exhibit([attempt], "all the evidence", (), TEXT, FILE)
    assert shown.case == ""
    assert "green" in shown.evidence
    assert "all the evidence" not in shown.evidence
    assert critic_exhibit([attempt], "all the evidence", (), "", FILE).case == attempt.text
    attempt.expect["pushed"]["ok"] = False
    assert critic_exhibit([attempt], "all the evidence", (), TEXT, FILE).case == attempt.text, "something went wrong"


def test_owners_are_told_what_holds() -> None:
    attempt = Attempt(1, TEXT, "x")
    attempt.expect = {"pushed": {"ok": True, "why": "0.3 m"}, "late": {"ok": False, "why": "never"}}
    attempt.critique = {"requirements": {"red": {"mark": 1}, "fast": {"mark": 0.5}}}
    rows = what_holds(attempt)
    assert rows[:2] == ["pushed: 0.3 m", "requirement red is met"]
    assert not any("late" in row or "fast" in row for row in rows)
