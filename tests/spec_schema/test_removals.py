"""What leaves the scene: what can, and what nobody may ask of it afterwards."""

import pytest

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

CASE = """\
text2sim: 2
name: leaving
scene: {duration: 2, statics: {floor: {shape: {kind: plane}}, lid: {shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [0, 0, 2]}}}%s}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, repeat: {kind: line, count: 3, step: [0.3, 0, 0]}}
  cube: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 2, 1]}}
  flag: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 3]}}
actions:
  controls:
    take: {kind: remove, %s}
    %s
  measures: {height: {kind: position, of: %s, axis: z, stat: max}}
  events: {falls: {kind: threshold, measure: height, below: 0.5}}
  expect:
    low: {measure: height, %s, below: 5}
"""


def problems(remove: str, other: str = "", at: str = "at: 0.5", scene: str = "", of: str = "cube") -> list[str]:
    found = check_references(load_text(CASE % (scene, remove, other, of, at)))
    assert all(problem.line and problem.column for problem in found)
    return [f"{problem.path} [{problem.rule}] {problem.message}" for problem in found]


def test_bodies_copies_and_statics_can_leave():
    for body in ("cube", "lid", '"crate[*]"', '"crate[1]"'):
        assert problems(f"body: {body}, at: 1") == []
        assert problems(f"body: {body}, on: falls") == []


@pytest.mark.parametrize(
    ("remove", "scene", "said"),
    [
        ("body: flag, at: 1", "", "/actions/controls/take/body [not-removable] `flag` deforms"),
        ("body: cub, at: 1", "", "/actions/controls/take/body [unknown-body] there is no body or static `cub`"),
        ("body: cube, on: fall", "", "/actions/controls/take/on [unknown-event] there is no event `fall`"),
        (
            "body: cube, at: 1",
            ", solver: {hibernation: true}",
            "/actions/controls/take/kind [not-removable] nothing can",
        ),
    ],
)
def test_what_cannot_leave_is_said(remove, scene, said):
    assert [line[: len(said)] for line in problems(remove, scene=scene)] == [said]


@pytest.mark.parametrize(
    "other",
    [
        "push: {kind: force, body: cube, force: [1, 0, 0], during: [1.2, 1.5]}",
        "knock: {kind: impulse, body: cube, impulse: [1, 0, 0], at: 1}",
        "grip: {kind: attach, body: 'crate[0]', to: cube, at: 1.5}",
    ],
)
def test_nothing_acts_on_what_has_left(other):
    (line,) = problems("body: cube, at: 1", other)
    assert "[after-removal] `cube` is no longer in the scene: `take` removes it at 1 s" in line
    assert problems("body: cube, at: 1.8", other) == []


def test_nothing_is_measured_of_what_has_left():
    for at in ("at: end", "at: 1.5", "during: all", "during: [0, 1.2]"):
        (line,) = problems("body: cube, at: 1", at=at)
        assert line.startswith("/actions/expect/low")
        assert "after-removal" in line
    assert problems("body: cube, at: 1", at="during: [0, 1]") == []
    assert problems("body: 'crate[*]', at: 1", at="at: end") == []


def test_a_list_is_measured_as_long_as_one_of_it_is_left():
    assert problems("body: cube, at: 1", at="at: end", of="[cube, 'crate[0]']") == []
    (line,) = problems("body: crate, at: 1", at="at: end", of="['crate[0]', 'crate[2]']")
    assert line.startswith("/actions/expect/low/at [after-removal] `crate[0]` is no longer in the scene")
