"""Patterns of names fit what a regular expression would fit, in a time that does not explode."""

import re
from itertools import product

import pytest
from small_case import small

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.names.selectors import named_by


def test_a_pattern_fits_what_a_regular_expression_fits() -> None:
    names = ["".join(letters) for n in range(1, 5) for letters in product("ab", repeat=n)]
    for pattern in ("".join(letters) for n in range(1, 6) for letters in product("ab*", repeat=n)):
        form = re.compile(pattern.replace("*", ".*"))
        assert named_by(pattern, names) == [name for name in names if form.fullmatch(name)]


def test_a_hostile_pattern_takes_no_time() -> None:
    assert named_by("*a" * 23 + "*b", ["a" * 48]) == []  # a regular expression takes years


def test_a_part_of_a_selector_is_no_longer_than_a_name() -> None:
    actions = "actions: {{measures: {{m: {{kind: speed, of: ball.{}}}}}}}"
    load_text(small(top=actions.format("l" * 48)))
    with pytest.raises(SpecError):
        load_text(small(top=actions.format("l" * 49)))


DOG = """\
text2sim: 2
name: dog
scene: {duration: 1}
bodies:
  dog:
    kind: articulated
    links:
      trunk: {shape: {kind: sphere, radius: 0.1}}
      fl_hip: {parent: trunk, shape: {kind: sphere, radius: 0.1}, joint: {kind: hinge, axis: y}}
      fr_hip: {parent: trunk, shape: {kind: sphere, radius: 0.1}, joint: {kind: hinge, axis: y}}
actions:
  measures: {swing: {kind: joint_position, of: "dog.%s", stat: max}}
"""


@pytest.mark.parametrize(("part", "hint"), [("*_hp", "*_hip"), ("fr_*_hp", "fr_*"), ("f_hip", "fr_hip")])
def test_the_hint_for_a_pattern_is_a_pattern(part: str, hint: str) -> None:
    assert [problem.hint for problem in check_references(load_text(DOG % part))] == [hint]
