"""Mass and inertia beyond a joint."""

import pytest
from lint_support import facts_of

from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.lint.joints.mechanics import Mechanics

WEDGE = """
bodies:
  wedge:
    kind: rigid
    shape:
      kind: sculpt
      parts:
        body: {kind: ellipsoid, radii: [0.2, 0.1, 0.1]}
        nose: {kind: ellipsoid, radii: [0.1, 0.1, 0.1], pose: {pos: [0.15, 0, 0]}}
        tip: {kind: ellipsoid, radii: [0.1, 0.05, 0.05], pose: {pos: [0.25, 0, 0]}}
    material: {density: 500}
    pose: {pos: [0, 0, 1]}
    mount: {kind: hinge, axis: y}
"""


def test_a_sculpt_has_the_inertia_of_its_surface_not_of_its_parts_that_overlap() -> None:
    facts = facts_of(WEDGE)
    [joint] = facts.once(Mechanics).joints()
    made = sculpted(joint.copy.shape)
    x, _, z = made.center
    # Steiner: the hinge is at the origin of the shape.
    assert joint.inertia == pytest.approx(joint.mass * (made.inertia[1] / made.volume + x**2 + z**2), rel=1e-9)
    assert facts.once(Mechanics).inertial(joint.copy).center == pytest.approx((x, 0.0, 1.0 + z), abs=1e-4)
