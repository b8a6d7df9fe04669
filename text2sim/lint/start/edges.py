"""Boxes that start on an edge or a corner, on level ground or on a slope, and will tip."""

from collections.abc import Iterator
from itertools import product
from math import acos, degrees

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, quat_multiply, quat_rotate, vector_dot
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import RESTING
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.words import more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

TILT = 2.0
"""Largest angle [deg] between two faces at which a box counts as lying on its face."""
MIN_UPWARD = 0.5
"""Smallest cosine between the normal of a support and straight up."""
_AXES: tuple[Vec, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _edges(facts: Facts) -> Iterator[Problem]:
    x, y, z = facts.case.scene.gravity
    if x or y or z >= 0.0:
        return
    held = {body_of(c.body) for c in facts.case.actions.controls.values() if c.kind == "attach"}
    boxes = {
        copy.name: (name, copy, box)
        for name in facts.case.bodies
        if name not in held
        for copy in facts.placed[name]
        if facts.loose(copy) and (box := _single_box(facts, copy)) is not None
    }
    neighbours: dict[str, list[Copy]] = {name: [] for name in boxes}
    for one, other in facts.near(-RESTING) if boxes else ():
        for a, b in ((one, other), (other, one)):
            if a.name in boxes:
                neighbours[a.name].append(b)
    gaps = facts.own(Gaps)
    found: dict[str, list[tuple[Copy, Copy, float]]] = {}
    for name, copy, box in boxes.values():
        touching = [g.copy for g in facts.planes if abs(gaps.to_plane(copy, g, 1.0)) < RESTING]
        for one in neighbours[copy.name]:
            if len({copy.name for copy in touching}) > 1:
                break
            if gaps.between(copy, one, 2 * RESTING) < RESTING:
                touching.append(one)
        if len({one.name for one in touching}) != 1:
            continue  # in the air, or leaning on several
        tilt = _tilt(facts, box, touching[0])
        if tilt > TILT:
            found.setdefault(name, []).append((copy, touching[0], tilt))
    for name, rows in found.items():
        copy, support, tilt = rows[0]
        text = (
            f"`{copy.name}` touches `{support.name}` only with an edge or a corner{more_copies(len(rows))}: its "
            f"nearest face is at {tilt:.3g} deg to the support, so it tips at once; turn it so that its face lies on "
            "the support, or waive this rule if it is meant to fall"
        )
        yield facts.problem("on-edge", ("bodies", name), text, key=True)


def _single_box(facts: Facts, copy: Copy) -> StandingPart | None:
    parts = facts.parts(copy)
    return parts[0] if len(parts) == 1 and parts[0].piece.kind == "box" else None


def _axes(part: StandingPart) -> list[Vec]:
    turn = quat_multiply(part.quat, part.piece.quat)
    return [quat_rotate(turn, axis) for axis in _AXES]


def _tilt(facts: Facts, box: StandingPart, support: Copy) -> float:
    """Return the angle [deg] between the nearest faces of a box and of its support; 0 if that has no flat face."""
    axes = _axes(box)
    for ground in facts.planes:
        if ground.copy is support:
            return _angle(axes, ground.up)
    middle = _middle(box)
    corners = [
        tuple(
            m + sum(s * h / 2 * a[k] for s, h, a in zip(signs, box.piece.size, axes, strict=True))
            for k, m in enumerate(middle)
        )
        for signs in product((-1.0, 1.0), repeat=3)
    ]
    best: tuple[float, Vec] | None = None
    for part in facts.parts(support):
        if part.piece.kind != "box":
            return 0.0
        center = _middle(part)
        for axis, size in zip(_axes(part), part.piece.size, strict=True):
            for sign in (-1.0, 1.0):
                normal = (sign * axis[0], sign * axis[1], sign * axis[2])
                above = min(
                    sum(n * (p - c) for n, p, c in zip(normal, corner, center, strict=True)) for corner in corners
                )
                if best is None or above - size / 2 > best[0]:
                    best = (above - size / 2, normal)
    if best is None or abs(best[0]) > RESTING or best[1][2] < MIN_UPWARD:
        return 0.0
    return _angle(axes, best[1])


def _middle(part: StandingPart) -> Vec:
    offset = quat_rotate(part.quat, part.piece.pos)
    return part.pos[0] + offset[0], part.pos[1] + offset[1], part.pos[2] + offset[2]


def _angle(axes: list[Vec], normal: Vec) -> float:
    nearest = max(abs(vector_dot(axis, normal)) for axis in axes)
    return degrees(acos(min(nearest, 1.0)))


_SLOPE = """\
scene:
  statics:
    slope: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [0, 0, 0.6], euler_deg: [0, 20, 0]}}
bodies:
  crate:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    place: {on: slope, at: [0, 0], euler_deg: [0, %s, 0]}
"""

RULES = (
    Rule(
        id="on-edge",
        severity="warning",
        title="A box starts on an edge or a corner.",
        reason="""\
A box that touches its support only with an edge is not in balance: it tips before anything else happens. On a slope,
this is the result of `place: {on: slope}` if the box stays upright or is turned about the wrong axis.""",
        remedy="""\
Turn the box like its support (the same `euler_deg`; a turn about the normal of the slope comes first), or waive the
rule if it is meant to tip.""",
        example=_SLOPE % "0",
        fix=_SLOPE % "20",
        run=_edges,
    ),
)
