"""Gears between joints: what they need, said to the author."""

import pytest

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

CASE = """\
text2sim: 2
name: clock
scene: {{duration: 1}}
bodies:
  clock:
    kind: articulated
    links:
      frame: {{shape: {{kind: box, size: [0.02, 0.02, 0.02]}}}}
      rack: {{parent: frame, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, joint: {{kind: slider, axis: z}}}}
      pinion: {{parent: frame, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, joint: {{kind: hinge, axis: z}}}}
    initial: {initial}
    loops: {{teeth: {loop}}}
"""


def problems(loop: str, initial: str = "{}") -> list[str]:
    try:
        loaded = load_text(CASE.format(loop=loop, initial=initial))
    except SpecError as error:
        return [problem.message for problem in error.problems]
    return [problem.message for problem in check_references(loaded)]


@pytest.mark.parametrize("initial", ["{}", "{rack: 0.1, pinion: -2}"])
def test_a_gear_that_fits(initial: str) -> None:
    assert problems("{kind: gear, between: [pinion, rack], ratio: -20}", initial) == []


@pytest.mark.parametrize(
    ("loop", "message"),
    [
        ("{kind: gear, between: [pinion, rack]}", "gear needs a ratio other than 0"),
        ("{kind: gear, between: [pinion, rack], ratio: 0}", "gear needs a ratio other than 0"),
        ("{kind: gear, between: [pinion, rack], ratio: 2, anchor: [0, 0, 1]}", "has no anchor"),
        ("{between: [pinion, rack], ratio: 2}", "ratio belongs to kind gear"),
        ("{kind: gear, between: [pinion, frame], ratio: 2}", "`frame` has no hinge or slider"),
        ("{kind: gear, between: [pinion, world], ratio: 2}", "`world` has no hinge or slider"),
        ("{kind: gear, between: [pinion, rakc], ratio: 2}", "there is no link `rakc`"),
    ],
)
def test_what_a_gear_lacks_is_said(loop: str, message: str) -> None:
    assert [found for found in problems(loop) if message in found]


def test_joints_start_as_their_gear_has_them() -> None:
    (found,) = problems("{kind: gear, between: [pinion, rack], ratio: 10}", "{rack: 0.1}")
    assert "`pinion` starts at 0 and `rack` at 0.1, which a ratio of 10 takes to 1" in found
