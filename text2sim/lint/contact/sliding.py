"""Bodies that start to slide fast along their support, and are thrown into the air by the friction cone."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from text2sim.compiler.action_rows import StartVelocity
from text2sim.compiler.belts import carries
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart, sides
from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_dot
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import MAX_RESTING_GAP, is_just_above
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven

BALL_INVERSE_MASS_RATIO = 3.5
"""Tangential inverse mass at the surface of a ball over that at its centre: 1 + m r2 / I."""
MIN_HOP_SHARE, MIN_HOP = 0.02, 0.001
"""Smallest hop that is reported: as a share of the body's size, and in metres."""


class _Slide(NamedTuple):
    """A body that starts to slide."""

    copy: Copy
    support: Copy
    row: StartVelocity
    slip: float
    """Speed [m/s] of its lowest point along the support."""
    friction: float
    lift: float
    """Speed [m/s] at which it is thrown up."""


def _sliding(facts: Facts) -> Iterator[Problem]:
    pull = facts.pull
    if facts.settings.cone != "pyramidal" or not pull:
        return
    found: dict[str, list[_Slide]] = {}
    for row in facts.rows.velocities:
        slide = _slide(facts, row)
        if slide is not None:
            box = facts.box(slide.copy)
            size = min(sides(box)) if box is not None else 0.0
            if slide.lift**2 / (2 * pull) > max(MIN_HOP_SHARE * size, MIN_HOP):
                found.setdefault(row.control, []).append(slide)
    for control, slides in found.items():
        slide = max(slides, key=lambda slide: slide.lift)
        text = (
            f"`{slide.copy.name}` starts to slide along `{slide.support.name}` at {slide.slip:.3g} m/s (friction "
            f"{slide.friction:g}){more_copies(len(slides))}: the pyramidal friction cone throws it up at "
            f"{slide.lift:.2g} m/s, {length(slide.lift**2 / (2 * pull))} high; set `friction_cone: elliptic` in "
            f"scene.contact, or start it in the air{_rolling(slide)}"
        )
        yield facts.problem("sliding-start", ("actions", "controls", control), text, key=True)


def _rolling(slide: _Slide) -> str:
    """Return the advice to let a ball roll, with its spin."""
    shape = slide.copy.shape
    if getattr(shape, "kind", None) != "sphere":
        return ""
    x, y, _ = slide.row.linear
    return f", or let it roll: `angular: {vector((-y / shape.radius, x / shape.radius, 0.0))}`"


def _slide(facts: Facts, row: StartVelocity) -> _Slide | None:
    copy = facts.copies[row.entity]
    if is_soft(copy.model):  # the friction cone is that of rigid contacts
        return None
    support, normal = _support(facts, copy)
    if support is None or _moves_by_itself(facts, support):
        return None
    low = min(part.lowest(normal) for part in facts.parts(copy))
    height = vector_dot(copy.pos, normal) - low
    arm = (-height * normal[0], -height * normal[1], -height * normal[2])
    velocity = tuple(v + w for v, w in zip(row.linear, vector_cross(row.angular, arm), strict=True))
    rising = vector_dot(row.linear, normal)
    if rising > 0.05:
        return None
    slip = math.hypot(*(v - rising * n for v, n in zip(velocity, normal, strict=True)))
    friction = friction_between(facts, copy, support)
    ease = BALL_INVERSE_MASS_RATIO if getattr(copy.shape, "kind", None) == "sphere" else 1.0
    return _Slide(copy, support, row, slip, friction, friction * slip / (1 + ease * friction**2))


def _moves_by_itself(facts: Facts, support: Copy) -> bool:
    """Return whether a support moves by itself, so that what moves with it does not slide, as a load on a cart."""
    moving = {drive.entity for drive in facts.rows.drives} | facts.lowering.joint_velocities.keys()
    return isinstance(support.model, Driven) or carries(support.model) or support.name in moving


def friction_between(facts: Facts, one: Copy, other: Copy) -> float:
    """Return the coefficient of friction of two copies: that of the pair, or the larger of theirs.

    Args:
        facts: The case.
        one: A copy.
        other: Another copy.
    """
    for pair in reversed(facts.plan.frictions):
        both = ((one.name, other.name), (other.name, one.name))
        if pair.first_link is pair.second_link is None and any(a in pair.first and b in pair.second for a, b in both):
            return pair.friction
    materials = (getattr(copy.model, "material", None) for copy in (one, other))
    return max(material.friction if material is not None else 0.0 for material in materials)


def _support(facts: Facts, copy: Copy) -> tuple[Copy | None, Vec]:
    """Return the support of a copy, and the normal of its surface."""
    parts, box = facts.parts(copy), facts.box(copy)
    for ground in facts.planes:
        if any(-MAX_RESTING_GAP < ground.depth(part) for part in parts) and ground.beside(copy.pos) < 0:
            return ground.copy, ground.up
    for other in facts.copies.values():
        other_box = facts.box(other)
        if other is copy or is_soft(other.model) or other_box is None or box is None:
            continue
        if not apart(box, other_box, -MAX_RESTING_GAP) and is_just_above(facts, copy, other):
            return other, facts.up
    return None, facts.up


RULES = (
    Rule(
        id="sliding-start",
        title="A body starts to slide along its support and will be thrown into the air.",
        reason="""\
The pyramidal friction cone, the default in scenes without slopes, treats fast sliding as approach and turns a part of
it into lift: a body that slides at the speed v with the friction m is thrown up at `m v / (1 + m^2)` within a step, a
ball at `m v / (1 + 3.5 m^2)` (measured to 5 %, 1 to 12 m/s, friction 0.2 to 0.8: a box with friction 0.5 at 5 m/s flies
0.22 m high). The elliptic cone does not. The rule reports bodies that rise by more than 2 % of their size.""",
        remedy="""\
Set `scene.contact.friction_cone: elliptic`; start the body a few millimetres in the air if it flies anyway; or give a
ball the spin with which it rolls.""",
        example="""\
bodies:
  puck: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.1]}, place: {on: floor}}
actions:
  controls: {push: {kind: initial_velocity, body: puck, linear: [5, 0, 0]}}
""",
        fix="scene: {contact: {friction_cone: elliptic}}",
        run=_sliding,
        own_contact=True,
    ),
)
