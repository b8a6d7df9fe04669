"""A small valid card, of which tests spoil one part at a time."""

from pathlib import Path

import pytest

CARD = """\
id: falls-too-far
title: A ball that is dropped from too high
applies:
  modes: [rigid]
  tags: [drop]
  signatures: [measure too large]
  roles: [actions, critic]
symptoms: [the ball lands too fast]
likely_causes: [it starts too high]
checks: [compare the height with the speed]
repair: [start lower]
forbidden: [a wider tolerance]
evidence:
  case: a ball over a floor
  failing: {outcome: "missed:slow", observed: "6.3 m/s"}
  repaired: {outcome: passed, observed: "2.8 m/s"}
  measured_on: {genesis-world: 1.4.5}
"""
CASE = """\
text2sim: 2
name: falls_too_far
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 2.1]}}
actions:
  measures:
    fast: {kind: speed, of: ball}
  expect:
    slow: {measure: fast, during: all, stat: max, below: 4}
"""


@pytest.fixture
def texts() -> dict[str, str]:
    """The three files of a card, by name."""
    return {"card.yaml": CARD, "failing.yaml": CASE, "repaired.yaml": CASE.replace("2.1]", "0.5]")}


@pytest.fixture
def shelf(tmp_path: Path, texts: dict[str, str]) -> Path:
    """A folder with this one card."""
    folder = tmp_path / "shelf" / "falls-too-far"
    folder.mkdir(parents=True)
    for name, text in texts.items():
        (folder / name).write_text(text, "utf-8")
    return folder.parent
