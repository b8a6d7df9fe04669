"""Driven bodies whose motion leads through the ground or through fixed bodies.

Nothing stops a driven body, and it does not collide with fixed bodies (`clear_the_way` in its program). The rule
samples its motion in steps of half the thickness of its pieces, and turns in steps of some degrees.
"""

from collections.abc import Iterator
from dataclasses import replace

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import Moment, moments
from text2sim.compiler.shapes.boxes import apart, union
from text2sim.compiler.shapes.rotation import frame_apply, quat_multiply, vector_minus, vector_plus
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import Effort, overlap_of, overlapping
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven

MAX_COPIES = 8
"""Most copies of a driven body that are checked."""
CLOSE_FIT, CLOSE_FIT_SHARE = 0.002, 0.05
"""Depth that counts as a close fit: in metres, and as a share of the thickness of a piece."""
MAX_DISTANCE_TESTS = 4000
"""Budget of distance tests for a case."""


def _driven_through(facts: Facts) -> Iterator[Problem]:
    effort = Effort(MAX_DISTANCE_TESTS)
    for name, body in facts.case.bodies.items():
        if not isinstance(body, Driven):
            continue
        seen: set[str] = set()
        for copy in facts.placed[name][:MAX_COPIES]:
            for other, t, depth in _entered_copies(facts, copy, effort):
                if other.body in seen:
                    continue
                seen.add(other.body)
                text = (
                    f"`{copy.name}` is driven {length(depth)} into `{other.name}` by {t:.3g} s: nothing stops a driven "
                    "body, and the film shows it pass through; end its motion earlier, or start it farther away"
                )
                yield facts.problem("driven-through", facts.where(name, "motion"), text)


def _entered_copies(facts: Facts, copy: Copy, effort: Effort) -> Iterator[tuple[Copy, float, float]]:
    """Yield the fixed copies that a driven copy enters, with the time [s] of the largest depth, and that depth [m]."""
    parts = facts.parts(copy)
    if not parts:
        return
    stride = min(part.thickness for part in parts) / 2
    path = list(moments(copy.model.motion, facts.case.scene.duration, stride))
    if not path:
        return
    allowed = max(CLOSE_FIT, CLOSE_FIT_SHARE * min(part.thickness for part in parts))
    for ground in facts.planes:
        depths = [(max(ground.depth(part) for part in _parts_at(copy, parts, moment)), -moment[0]) for moment in path]
        depth, t = max(depths)
        under = max(ground.depth(part) for part in parts)
        if depth > allowed and under <= allowed and ground.beside(copy.pos) < 0.0:
            yield ground.copy, -t, depth
    path_box = union(part.box for moment in path[:: max(1, len(path) // 12)] for part in _parts_at(copy, parts, moment))
    for other in facts.copies.values():
        box = facts.box(other)
        if other is copy or facts.mount(other) not in ("static", "fixed"):
            continue
        if box is None or apart(path_box, box):
            continue
        others = facts.parts(other)
        if any(overlapping(a, b) for a in parts for b in others):
            continue
        found = (_depth(copy, parts, moment, others, effort) for moment in path)
        depth, t = max(((depth, -moment[0]) for depth, moment in zip(found, path, strict=True)), default=(0.0, 0.0))
        if depth > allowed:
            yield other, -t, depth


def _depth(copy: Copy, parts: list[StandingPart], moment: Moment, others: list[StandingPart], effort: Effort) -> float:
    """Return how deep [m] a copy is in another at a moment."""
    moved = _parts_at(copy, parts, moment)
    pairs = [(a, b) for a in moved for b in others if overlapping(a, b)]
    if not pairs or effort.left < 0:
        return 0.0
    return overlap_of(moved, others, pairs[:4], effort).depth


def _parts_at(copy: Copy, parts: list[StandingPart], moment: Moment) -> list[StandingPart]:
    """Return the pieces of a copy at a moment."""
    _, step, turn = moment
    origin = vector_plus(copy.pos, step)
    return [
        replace(
            part,
            pos=frame_apply(origin, turn, vector_minus(part.pos, copy.pos)),
            quat=quat_multiply(turn, part.quat),
        )
        for part in parts
    ]


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
        title="The motion of a driven body leads through the ground or through a fixed body.",
        reason=f"""\
A driven body follows its motion and pushes movable bodies out of the way. The ground, statics and bodies with a fixed
mount cannot move, so it passes through them: there is no contact between them. The rule reports a body that starts
outside and gets deeper than {CLOSE_FIT * 1e3:g} mm and {CLOSE_FIT_SHARE:.0%} of its thinnest piece.""",
        remedy="End the motion earlier, start it farther away, or use a motor, which can be stopped.",
        example=_STAMP % "-0.6",
        fix=_STAMP % "-0.44",
        run=_driven_through,
    ),
)
