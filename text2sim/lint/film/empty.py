"""Cameras in whose pictures there is nothing but ground and sky."""

import math
from collections.abc import Iterator
from functools import partial

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.shots import Shot, shot, some, taken
from text2sim.lint.film.subjects import Balls, offset_of, subjects
from text2sim.lint.rule import Rule
from text2sim.lint.words import vector
from text2sim.spec_schema.errors import Problem

MOMENTS = 9
"""Moments of the film at which is asked what a camera sees."""


def _empty(facts: Facts) -> Iterator[Problem]:
    given = list(facts.case.render.cameras)
    things = [(copy, balls) for copy in facts.copies.values() if (balls := _drawn(facts, copy))]
    if not given or not any(facts.moves(copy) for copy, _ in things):
        return
    if len(given) == 1 and subjects(facts):
        return  # a subject that no camera sees is said by `unseen-subject`
    for name, pictures in taken(facts).items():
        if not pictures or "frame" in facts.plan.render["cameras"][name]:
            continue  # one with a frame will stand where it sees its bodies
        for frame in some(pictures, MOMENTS):
            offsets = {copy.name: offset_of(facts, copy.name, frame.t) for copy, _ in things if facts.moves(copy)}
            known = partial(_known, offsets)
            if _sees(shot(facts, name, frame.t, known, frame.part), things, offsets):
                break
        else:
            view = shot(facts, name, pictures[0].t, part=pictures[0].part)
            text = (
                f"camera `{name}` sees nothing at all, now or on the ways that things will probably take: it "
                f"looks from {vector(_round(view.pos))} at {vector(_round(view.target))}; let it look at a body, or "
                "leave it out"
            )
            yield facts.problem("empty-camera", ("render", "cameras", name), text, key=True)


def _known(offsets: dict[str, Vec], name: str, t: float) -> Vec:
    return offsets.get(name, (0.0, 0.0, 0.0))


def _drawn(facts: Facts, copy: Copy) -> Balls:
    """Balls around what is drawn of a copy; none for a plane."""
    look = getattr(copy.model, "look", None)
    if look is not None and not (look.visible and look.opacity > 0):
        return []
    balls, box = facts.balls(copy), facts.box(copy)
    if balls or box is None:
        return balls
    (a, b, c), (d, e, f) = box
    return [(((a + d) / 2, (b + e) / 2, (c + f) / 2), math.dist(*box) / 2)]


def _sees(shot: Shot, things: list[tuple[Copy, Balls]], offsets: dict[str, Vec]) -> bool:
    for copy, balls in things:
        x, y, z = offsets.get(copy.name, (0.0, 0.0, 0.0))
        if any(shot.shows((a + x, b + y, c + z), radius) for (a, b, c), radius in balls):
            return True
    return False


def _round(point: Vec) -> Vec:
    x, y, z = (round(c, 2) for c in point)
    return x, y, z


_PAIR = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
render:
  cameras:
    main: {kind: still, from: [0, -4, 1], look_at: ball}
    side: {kind: still, from: [4, 0, 1], look_at: %s}
"""

RULES = (
    Rule(
        id="empty-camera",
        severity="warning",
        title="A camera sees nothing but the ground and the sky.",
        reason="""\
Each camera makes a film of its own. In this one's picture there is no body and no static but planes, neither at the
start nor while things fall, fly or are driven where they will probably go. Whoever judges the film sees nothing.""",
        way_out="Let it look at a body (`look_at: ball`), or leave it out.",
        example=_PAIR % "[9, 0, 1]",
        mended=_PAIR % "ball",
        run=_empty,
    ),
)
