"""Joints of bodies whose links the case does not list can be named, as far as they are hinges or sliders."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: dolls
prompt: A doll falls, and a chain hangs.
scene: {duration: 0.5, statics: {floor: {shape: {kind: plane}}}}
bodies:
  doll: {kind: ragdoll, height: 1.0, pose: {pos: [0, 0, 1.2]}}
  chain: {kind: chain, links: 3, link_length: 0.1, radius: 0.01, pose: {pos: [2, 0, 1]}}
  loose: {kind: rope, length: 0.5, segments: 2, radius: 0.01, pose: {pos: [3, 0, 1]}, anchored: false}
actions:
"""


def problems(section: str, row: str, case: str = CASE) -> list[tuple[str | None, str]]:
    try:
        resolve_case(load_text(case + f"  {section}:\n    x: {row}\n"))
    except SpecError as error:
        return [(problem.rule, problem.message) for problem in error.problems]
    return []


@pytest.mark.parametrize(
    ("section", "row"),
    [
        ("measures", "{kind: joint_position, of: doll.forearm_l}"),
        ("measures", "{kind: joint_velocity, of: 'doll.shin_*', stat: max}"),
        ("measures", "{kind: bend, of: loose}"),  # of one joint
        ("events", "{kind: joint_limit, of: doll.shin_r}"),
    ],
)
def test_a_hinge_of_a_doll_is_a_joint_like_any_other(section: str, row: str) -> None:
    assert problems(section, row) == []


@pytest.mark.parametrize(
    ("section", "row", "rule", "words"),
    [
        ("measures", "{kind: joint_position, of: doll}", "no-joint", "name one: doll.forearm_l, doll.forearm_r"),
        ("measures", "{kind: joint_position, of: doll.arm_l}", "no-joint", "`doll.arm_l` has a ball joint"),
        ("measures", "{kind: joint_position, of: doll.pelvis}", "unknown-joint", "`pelvis`, which is a link"),
        ("measures", "{kind: joint_position, of: chain}", "no-joint", "`chain` (chain) has no hinge or slider"),
        ("measures", "{kind: bend, of: doll}", "needs-stat", "has 10 joints"),
        (
            "controls",
            "{kind: drive, joint: doll.shin_l, position: 1}",
            "no-actuator",
            "the joints of `doll` are passive",
        ),
    ],
)
def test_what_is_no_hinge_or_slider_is_told(section: str, row: str, rule: str, words: str) -> None:
    [(found, message)] = problems(section, row)
    assert found == rule
    assert words in message


def test_joints_that_only_the_compiler_knows_are_not_missed_beside_another_error() -> None:
    wrong = CASE.replace("duration: 0.5", "duration: -1")
    [(_, message)] = problems("measures", "{kind: joint_position, of: doll.forearm_l}", wrong)
    assert "duration" in message or "greater" in message, message
