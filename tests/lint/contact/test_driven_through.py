"""Driven bodies whose motion leads through the ground or through fixed bodies."""

from pathlib import Path

import pytest
from lint_support import expect_words

STAMP = """
scene: {{duration: {duration}, statics: {{wall: {{shape: {{kind: box, size: [0.1, 2, 1]}}, pose: {{pos: [1, 0, 0.5]}}}}}}}}
bodies:
  stamp:
    kind: driven
    shape: {{kind: box, size: [0.3, 0.3, 0.1]}}
    pose: {{pos: {pos}}}
    motion: {motion}
  {more}
"""


def stamp(motion: str, pos: str = "[0, 0, 0.5]", duration: float = 2.0, more: str = "") -> str:
    return STAMP.format(motion=f"{{{motion}}}", pos=pos, duration=duration, more=more)


def way(*positions: str) -> str:
    times = [0.5 * k for k in range(len(positions))]
    return f"kind: waypoints, times: {times}, positions: [{', '.join(positions)}]"


@pytest.mark.parametrize(
    ("case", "says"),
    [
        (stamp(way("[0, 0, 0]", "[0, 0, -0.6]")), "is driven 150 mm into `floor` by 0.5 s"),
        (stamp(way("[0, 0, 0]", "[0, 0, -0.45]")), ""),  # it comes down on it
        (stamp(way("[0, 0, 0]", "[0, 0, -0.6]", "[0, 0, 0]")), "150 mm into `floor` by 0.5 s"),
        (stamp(way("[0, 0, 0]", "[0, 0, -0.6]"), duration=0.1), ""),  # the run ends before
        (stamp(way("[0, 0, 0]", "[1.6, 0, 0]")), "mm into `wall`"),
        (stamp(way("[0, 0, 0]", "[0.8, 0, 0]")), ""),
        (stamp(way("[0, 0, 0]", "[0.82, 0, 0]")), "20 mm into `wall`"),
        (stamp(way("[0, 0, 0]", "[1.6, 0, 0]"), "[0, 1.2, 0.5]"), ""),  # past its end
        (stamp("kind: oscillate, axis: z, amplitude: 0.5, frequency: 1"), "50 mm into `floor` by 0.75 s"),
        (stamp("kind: oscillate, axis: z, amplitude: 0.5, frequency: 1", duration=0.4), ""),
        (stamp("kind: oscillate, axis: z, amplitude: 0.4, frequency: 1"), ""),
        (stamp("kind: oscillate, axis: x, amplitude: 0.9, frequency: 1"), "into `wall`"),
        # Its corner is 0.158 m from its middle.
        (stamp("kind: spin, axis: y, speed: 1", "[0, 0, 0.12]"), "into `floor`"),
        (stamp("kind: spin, axis: y, speed: 1", "[0, 0, 0.17]"), ""),
        (stamp("kind: spin, axis: y, speed: 0.05", "[0, 0, 0.12]"), ""),  # a tenth of a radian in all
        (stamp("kind: spin, axis: z, speed: 10", "[0, 0, 0.05]"), ""),
        # What starts inside is another matter: a piston in its guide, a lift in its pit.
        (stamp(way("[0, 0, 0]", "[0.4, 0, 0]"), "[0.9, 0, 0.5]"), ""),
        (stamp(way("[0, 0, 0]", "[0, 0, -0.1]"), "[0, 0, 0]"), ""),
        # What moves is pushed away.
        (
            stamp(
                way("[0, 0, 0]", "[0.5, 0, 0]"),
                more="box: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0.4, 0, 0.5]}}",
            ),
            "",
        ),
        (
            stamp(
                way("[0, 0, 0]", "[0.5, 0, 0]"),
                more="box: {kind: rigid, mount: {kind: fixed}, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0.4, 0, 0.5]}}",
            ),
            "into `box`",
        ),
    ],
)
def test_what_a_driven_body_goes_through(tmp_path: Path, case: str, says: str) -> None:
    expect_words(tmp_path, "driven-through", says, case, path="/bodies/stamp/motion")
