"""Targets of the end of an arm become targets of its joints."""

import math

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.trees.tree import tree_links
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

ARM = """\
text2sim: 2
name: reaching
scene: {duration: 3}
bodies:
  arm:
    kind: articulated
    pose: {pos: [1, 2, 0.5]}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      turret: {parent: base, pose: {pos: [0, 0, 0.1]}, shape: {kind: box, size: [0.1, 0.1, 0.1]}, joint: {kind: hinge, axis: z, actuator: {stiffness: 500, damping: 20}}}
      upper: {parent: turret, pose: {pos: [0, 0, 0.1]}, shape: {kind: box, size: [0.04, 0.04, 0.4]}, joint: {kind: hinge, axis: y, range_deg: [-120, 120], actuator: {stiffness: 500, damping: 20}}}
      lower: {parent: upper, pose: {pos: [0, 0, 0.4]}, shape: {kind: box, size: [0.04, 0.04, 0.3]}, joint: {kind: hinge, axis: y, actuator: {stiffness: 500, damping: 20}}}
actions:
  controls:
    grab: {kind: reach, body: arm.lower, point: [0, 0, 0.3], times: [1, 2], positions: %s%s}
"""


def resolved(positions: str, more: str = ""):
    return resolve_case(load_text(ARM % (positions, more)))


def test_the_tip_is_where_it_is_told_to_be():
    """The elbow's angle follows from the law of cosines: 0.5^2 = 0.4^2 + 0.3^2 at a right angle."""
    found = resolved("[[1.3, 2.3, 0.8], [1.0, 1.5, 0.7]]")
    tree = found.lowering.trees["arm"]
    ends = {joint: rows[-1][2].to for (_, joint), rows in found.rows.joints.targets.items()}
    assert abs(ends["lower"]) == pytest.approx(math.pi / 2, abs=0.005)
    tree.initial.update(ends)
    (tip,) = [one for one in tree_links(tree, (1, 2, 0.5)) if one.link.name == "lower"]
    reached = [p + 0.3 * a for p, a in zip(tip.pos, _up(tip.quat), strict=True)]
    assert reached == pytest.approx([1.0, 1.5, 0.7], abs=5e-4)
    drives = {drive.joint: [segment.start for segment in drive.segments] for drive in found.plan.drives}
    assert drives == {"turret": [0.0, 1.0], "upper": [0.0, 1.0], "lower": [0.0, 1.0]}


def test_how_it_is_turned_is_part_of_it():
    """Straight up at the height of 1.4 m less the bend of both joints: only one way is left, turned by 30 deg."""
    found = resolved("[[1.0, 2.0, 1.4], [1.0, 2.0, 1.4]]", ", euler_deg: [[0, 0, 0], [0, 0, 30]]")
    ends = {joint: rows[-1][2].to for (_, joint), rows in found.rows.joints.targets.items()}
    assert ends["turret"] == pytest.approx(math.radians(30), abs=0.01)
    assert abs(ends["upper"]) + abs(ends["lower"]) < 0.05


@pytest.mark.parametrize(
    ("positions", "more", "where", "said"),
    [
        (
            "[[1.3, 2.0, 0.8], [1.0, 2.0, 1.9]]",
            "",
            "positions/1",
            "cannot get there: the nearest it comes is 0.5 m off",
        ),
        ("[[1.3, 2.0, 0.8], [1.3, 2.0, 0.8]]", ", euler_deg: [90, 0, 0]", "positions/0", "deg askew"),
    ],
)
def test_what_is_out_of_reach_is_said_where_it_stands(positions, more, where, said):
    with pytest.raises(SpecError) as caught:
        resolved(positions, more)
    (problem,) = caught.value.problems
    assert problem.path == f"/actions/controls/grab/{where}"
    assert said in problem.message
    assert problem.rule == "out-of-reach"


def test_a_joint_without_a_motor_cannot_reach():
    text = ARM.replace("range_deg: [-120, 120], actuator: {stiffness: 500, damping: 20}", "range_deg: [-120, 120]")
    with pytest.raises(SpecError) as caught:
        resolve_case(load_text(text % ("[[1.3, 2.0, 0.8], [1.0, 2.0, 0.9]]", "")))
    assert "`arm.upper` moves `lower`, and has no actuator" in str(caught.value)


def _up(quat):
    w, x, y, z = quat
    return (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
