"""Tests whether everything is at rest until the script acts.

A body is at rest if its supports carry its centre of mass: level ground, or upright boxes that are at rest too. A
leaning domino does not count, nor a ball on a slope. A joint is at rest if gravity does not move it, or if its motor
holds it where it starts. Anything less simple may move at any time.
"""

from math import hypot

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts, once_per_case
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.motion.flight import MAX_RESTING_GAP
from text2sim.lint.parts import StandingPart
from text2sim.lint.start.escape import axis_aligned_box

MAX_BODIES = 300
"""Most bodies that are tested."""
SEARCH_SLOPE = 1e-4
"""Slope of the directions in which the corners of an underside are searched."""
MAX_CORNER_HEIGHT = 1e-4
"""Largest height [m] of a corner of an underside above the lowest point."""
MAX_OVERHANG = 1e-3
"""Largest distance [m] of a centre of mass from its support: a ball stands on a point."""
MAX_HOLDING_ERROR = {"hinge": 0.01, "slider": 0.001}
"""Largest error [rad, m] of a motor that holds a joint against gravity."""
_DIRECTIONS = tuple((x, y) for x in (-1, 0, 1) for y in (-1, 0, 1))

Rectangle = tuple[float, float, float, float]
"""Lowest and highest x, lowest and highest y [m]."""


@once_per_case
def all_still(facts: Facts) -> bool:
    """Return whether everything is at rest until the script acts."""
    case = facts.case
    x, y, z = case.scene.gravity
    bodies = [copy for name in case.bodies for copy in facts.placed[name]]
    if x or y or z > 0 or len(bodies) > MAX_BODIES or any(is_soft(body) for body in case.bodies.values()):
        return False
    if facts.plan.belts:
        return False
    loose = []
    for copy in bodies:
        mount = facts.mount(copy)
        if mount == "free":
            loose.append(copy)
        elif mount == "ball" or (mount == "tree" and not _joints_only(facts, copy)):
            return False
    joints = facts.once(Mechanics).joints()
    return all(_is_joint_held(facts, joint) for joint in joints) and (z == 0 or _all_stand(facts, loose))


def _joints_only(facts: Facts, copy: Copy) -> bool:
    """Return whether a tree has only hinges and sliders."""
    tree = facts.tree(copy)
    if tree is None or tree.loops:
        return False
    return all(joint.kind in ("hinge", "slider") for link in tree.links() for _, joint in link.all_joints())


def _is_joint_held(facts: Facts, joint: LoadedJoint) -> bool:
    """Return whether a joint stays where it starts until it is driven."""
    if joint.closed or joint.floating or joint.spec.velocity or (joint.spec.spring and joint.start):
        return False
    pull = abs(joint.gravity(joint.start))
    if pull <= joint.spec.friction + 1e-9:
        return True
    spans = spans_of(facts).get((joint.copy.name, joint.name), [])
    motor = joint.motor
    if motor is None or not spans or spans[0].mode != "position":
        return False
    strong = motor.max_force is None or motor.max_force > pull
    return strong and motor.stiffness > 0.0 and pull / motor.stiffness < MAX_HOLDING_ERROR[joint.spec.kind]


def _all_stand(facts: Facts, loose: list[Copy]) -> bool:
    """Return whether every free body stands on something, from the lowest to the highest."""
    tops = [part for copy in facts.copies.values() if not facts.moves(copy) for part in facts.parts(copy)]
    tops = [part for part in tops if axis_aligned_box(part)]
    for copy in sorted(loose, key=lambda copy: (facts.box(copy) or ((0, 0, 0),))[0][2]):
        if not _stands(facts, copy, tops):
            return False
        tops += [part for part in facts.parts(copy) if axis_aligned_box(part)]
    return True


def _stands(facts: Facts, copy: Copy, tops: list[StandingPart]) -> bool:
    parts = facts.parts(copy)
    if not parts or any(part.mesh is not None for part in parts):
        return False
    low = min(part.box[0][2] for part in parts)
    corners = [point for part in parts if part.box[0][2] <= low + MAX_CORNER_HEIGHT for point in _corners(part)]
    sole = _rectangle_around([(x, y) for x, y, z in corners if z <= low + MAX_CORNER_HEIGHT])
    cx, cy, _ = facts.once(Mechanics).inertial(copy).center
    for ground in facts.planes:
        if ground.up[2] > 1 - 1e-9 and abs(low - ground.level) < MAX_RESTING_GAP and ground.beside((cx, cy, low)) < 0.0:
            return _contains(sole, cx, cy)
    carried = []
    for part in tops:
        (a, b, _), (c, d, top) = part.box
        shared = (max(a, sole[0]), min(c, sole[1]), max(b, sole[2]), min(d, sole[3]))
        if abs(low - top) < MAX_RESTING_GAP and shared[0] <= shared[1] and shared[2] <= shared[3]:
            carried += [(shared[0], shared[2]), (shared[1], shared[3])]
    return bool(carried) and _contains(_rectangle_around(carried), cx, cy)


def _corners(part: StandingPart) -> list[tuple[float, float, float]]:
    """Return the points of a piece that are lowest if it leans slightly to any side."""
    found = []
    for x, y in _DIRECTIONS:
        size = hypot(1.0, SEARCH_SLOPE * x, SEARCH_SLOPE * y)
        a, b, c = part.solid.support((SEARCH_SLOPE * x / size, SEARCH_SLOPE * y / size, -1.0 / size))
        found.append((a, b, c - part.solid.rounding))
    return found


def _rectangle_around(points: list[tuple[float, float]]) -> Rectangle:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), max(xs), min(ys), max(ys)


def _contains(sole: Rectangle, x: float, y: float) -> bool:
    return (
        sole[0] - MAX_OVERHANG <= x <= sole[1] + MAX_OVERHANG and sole[2] - MAX_OVERHANG <= y <= sole[3] + MAX_OVERHANG
    )
