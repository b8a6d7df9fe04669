"""Driven bodies that are sent through the ground, or through what never moves.

Nothing stops a driven body, and it collides with nothing that never moves (`clear_the_way` in its program). Its way is
looked at in steps of half the thickness of its pieces, turns in steps of some degrees.
"""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import Moment, moments
from text2sim.compiler.shapes.boxes import apart, union
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    quat_multiply,
    quat_rotate,
)
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import Effort, inside, overlap_of
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven

LOOKED_AT = 8
"""Copies of a driven body that are looked at."""
SLACK = 0.002
"""Depth [m] that is a close fit, no blunder; and as a part of the thickness of a piece:"""
CLOSE = 0.05
EFFORT = 4000
"""Steps that depths may take in a case."""


def _driven_through(facts: Facts) -> Iterator[Problem]:
    effort = Effort(EFFORT)
    for name, body in facts.case.bodies.items():
        if not isinstance(body, Driven):
            continue
        seen: set[str] = set()
        for copy in facts.placed[name][:LOOKED_AT]:
            for other, t, depth in _struck(facts, copy, effort):
                if other.body in seen:
                    continue
                seen.add(other.body)
                text = (
                    f"`{copy.name}` is driven {length(depth)} into `{other.name}` by {t:.3g} s: nothing stops a driven "
                    "body, and the film shows it pass through; end its motion before, or start it farther away"
                )
                yield facts.problem("driven-through", facts.where(name, "motion"), text)


def _struck(facts: Facts, copy: Copy, effort: Effort) -> Iterator[tuple[Copy, float, float]]:
    """What a driven copy is sent into, when it is there deepest [s], and how deep [m]."""
    parts = facts.parts(copy)
    if not parts:
        return
    stride = min(part.thickness for part in parts) / 2
    path = list(moments(copy.model.motion, facts.case.scene.duration, stride))
    if not path:
        return
    allowed = max(SLACK, CLOSE * min(part.thickness for part in parts))
    for ground in facts.planes:
        depths = [(max(ground.depth(part) for part in _moved(copy, parts, moment)), -moment[0]) for moment in path]
        depth, t = max(depths)
        under = max(ground.depth(part) for part in parts)
        if depth > allowed and under <= allowed and ground.beside(copy.pos) < 0.0:
            yield ground.copy, -t, depth
    way = union(part.box for moment in path[:: max(1, len(path) // 12)] for part in _moved(copy, parts, moment))
    for other in _fixtures(facts, copy):
        box = facts.box(other)
        if box is None or way is None or apart(way, box):
            continue
        theirs = facts.parts(other)
        if any(inside(a, b) for a in parts for b in theirs):
            continue
        found = (_depth(copy, parts, moment, theirs, effort) for moment in path)
        depth, t = max(((depth, -moment[0]) for depth, moment in zip(found, path, strict=True)), default=(0.0, 0.0))
        if depth > allowed:
            yield other, -t, depth


def _fixtures(facts: Facts, mover: Copy) -> Iterator[Copy]:
    """Copies that never move."""
    for copy in facts.copies.values():
        if copy is not mover and facts.mount(copy) in ("static", "fixed"):
            yield copy


def _depth(copy: Copy, parts: list[StandingPart], moment: Moment, others: list[StandingPart], effort: Effort) -> float:
    """How deep [m] a copy is in another at a moment."""
    moved = _moved(copy, parts, moment)
    pairs = [(a, b) for a in moved for b in others if inside(a, b)]
    if not pairs or effort.left < 0:
        return 0.0
    return overlap_of(moved, others, pairs[:4], effort).depth


def _moved(copy: Copy, parts: list[StandingPart], moment: Moment) -> list[StandingPart]:
    """The pieces of a copy at a moment."""
    _, (x, y, z), turn = moment
    found = []
    for part in parts:
        (a, b, c), quat = part.pos, part.quat
        if turn != IDENTITY:
            p, q, r = copy.pos
            d, e, f = quat_rotate(turn, (a - p, b - q, c - r))
            (a, b, c), quat = (p + d, q + e, r + f), quat_multiply(turn, quat)
        found.append(StandingPart(part.piece, (a + x, b + y, c + z), quat, part.moves, part.link, part.mesh))
    return found


_STAMP = """\
bodies:
  stamp:
    kind: driven
    shape: {kind: box, size: [0.3, 0.3, 0.1]}
    pose: {pos: [0, 0, 0.5]}
    motion: {kind: waypoints, times: [0, 0.5], positions: [[0, 0, 0], [0, 0, %s]]}
"""

RULES = (
    Rule(
        id="driven-through",
        severity="warning",
        title="A driven body is sent through the ground, or through what never moves.",
        reason=f"""\
A driven body goes where its motion says, and pushes what can move out of its way. The ground, statics and bodies with
a fixed mount cannot, and so it passes through them: between them there is no contact. Reported is what gets deeper than
{SLACK * 1e3:g} mm and {CLOSE:.0%} of its thinnest piece, if it starts outside.""",
        remedy="End the motion before, start it farther away, or let a motor move it, which can be stopped.",
        example=_STAMP % "-0.6",
        fix=_STAMP % "-0.44",
        run=_driven_through,
    ),
)
