"""Boxes and polyhedra that start on an edge: on a slope, on level ground, leaning on each other."""

from math import radians

import pytest
from lint_support import findings

from text2sim.compiler.shapes.rotation import quat_from_axis_angle, quat_multiply

SLOPE = """\
scene:
  statics:
    slope: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [0, 0, 0.6], euler_deg: [0, 20, 0]}}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.2, 0.3, 0.1]}, place: {on: slope, at: [0, 0], quat: %s}}
"""
LEAN, YAW = quat_from_axis_angle((0, 1, 0), radians(20)), quat_from_axis_angle((0, 0, 1), radians(30))


@pytest.mark.parametrize(
    ("quat", "tilted"),
    [
        (quat_multiply(LEAN, YAW), False),  # about its own normal, then as the slope: flush
        (quat_multiply(YAW, LEAN), True),  # the other way round: on a corner
        (YAW, True),
        (quat_multiply(LEAN, quat_from_axis_angle((1, 0, 0), radians(90))), False),  # on another face
    ],
)
def test_a_box_that_is_flush_on_a_slope_is_turned_about_its_normal_first(tmp_path, quat, tilted):
    found = findings(tmp_path, "on-edge", SLOPE % list(quat))
    assert [problem.path for problem in found] == ["/bodies/crate"] * tilted


LEVEL = """\
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, %s], euler_deg: [%s, 0, 0]}}
"""


@pytest.mark.parametrize(("height", "turn", "tilted"), [(0.1, 0, False), (0.1414, 45, True), (0.5, 45, False)])
def test_a_box_on_the_ground_and_one_in_the_air(tmp_path, height, turn, tilted):
    found = findings(tmp_path, "on-edge", LEVEL % (height, turn))
    assert len(found) == tilted
    assert all("45 deg" in problem.message for problem in found)


CARDS = """\
bodies:
  left: {kind: rigid, shape: {kind: box, size: [0.01, 0.2, 0.3]}, pose: {pos: [-0.043659, 0, %s], euler_deg: [0, 15, 0]}}
  right: {kind: rigid, shape: {kind: box, size: [0.01, 0.2, 0.3]}, pose: {pos: [%s, 0, %s], euler_deg: [0, -15, 0]}}
"""


@pytest.mark.parametrize(("x", "tilted"), [(0.043659, False), (0.0441, False), (0.2, True)])
def test_cards_whose_upper_edges_meet_lean_on_each_other(tmp_path, x, tilted):
    found = findings(tmp_path, "on-edge", CARDS % (0.146183, x, 0.146183))
    assert len(found) == 2 * tilted


WEDGE = "{kind: polyhedron, points: [[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0.8], [1, 1, 0.8]]}"
BLOCKS = {
    "box": "{kind: box, size: [0.2, 0.2, 0.2]}",
    "polyhedron": "{kind: polyhedron, points: [[-0.1, -0.1, -0.1], [0.1, -0.1, -0.1], [-0.1, 0.1, -0.1], "
    "[0.1, 0.1, -0.1], [-0.1, -0.1, 0.1], [0.1, -0.1, 0.1], [-0.1, 0.1, 0.1], [0.1, 0.1, 0.1]]}",
}
WEDGED = """\
scene: {statics: {wedge: {shape: %s}}}
bodies:
  block: {kind: rigid, shape: %s, place: {on: %s, at: [0, 0], %s}}
"""


@pytest.mark.parametrize("block", BLOCKS.values(), ids=BLOCKS)
@pytest.mark.parametrize(
    ("support", "turn", "tilt"),
    [
        ("wedge", "euler_deg: [0, 0, 30]", "21.8 deg"),
        ("wedge", "flush_deg: 30", None),
        ("floor", "euler_deg: [40, 0, 0]", "40 deg"),
        ("floor", "euler_deg: [0, 0, 40]", None),
    ],
)
def test_polyhedra_lie_and_carry_as_boxes_do(tmp_path, block, support, turn, tilt):
    text = WEDGED.replace("[0, 0], %s", "[3, 0], %s") if support == "floor" else WEDGED
    found = findings(tmp_path, "on-edge", text % (WEDGE, block, support, turn))
    assert len(found) == (tilt is not None)
    assert all(tilt in problem.message for problem in found)
