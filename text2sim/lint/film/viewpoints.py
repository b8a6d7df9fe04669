"""Cameras that stand in a body or under the ground, or run into what they look at."""

import math
from collections.abc import Iterator

from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, vector_dot
from text2sim.lint.facts import Facts
from text2sim.lint.film.cameras import EARLY
from text2sim.lint.film.shots import shot, some, taken
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import inside
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

MOVING = ("orbit", "dolly", "keyframed")
MOMENTS = 13
"""Moments at which is asked where a camera is that moves by itself."""


def _inside(facts: Facts) -> Iterator[Problem]:
    views = [
        (frame.t, shot(facts, name, frame.t, part=frame.part))
        for name, pictures in taken(facts).items()
        for frame in some(pictures, MOMENTS if facts.plan.render["cameras"][name]["kind"] in MOVING else 1)
    ]
    told = set()
    for t, view in views:
        if view.name in told:
            continue
        where = ("render", "cameras", view.name)
        eye = StandingPart(Piece("sphere", size=(1e-4,)), view.pos, IDENTITY, False, None)
        for ground in facts.planes:
            below = ground.level - vector_dot(ground.up, view.pos)
            if below > 0 and ground.beside(view.pos) < 0:
                text = f"`{view.name}` is {length(below)} below `{ground.copy.name}`{_when(t)} and sees its underside"
                yield facts.problem("camera-inside", where, f"{text}; raise it", key=True)
                told.add(view.name)
        for copy in facts.copies.values():
            box = facts.box(copy)
            look = copy.model.look
            if box is None or not look.visible or look.opacity < 0.5 or apart(box, eye.box):
                continue
            if facts.moves(copy) and t > EARLY:
                continue
            if any(inside(eye, part) for part in facts.parts(copy) if _solid(part)):
                text = f"`{view.name}` is inside of `{copy.name}`{_when(t)} and sees nothing else; move it out"
                yield facts.problem("camera-inside", where, text, key=True)
                told.add(view.name)


def _when(t: float) -> str:
    return f" after {t:.2g} s" if t > EARLY else " at the start"


def _solid(part: StandingPart) -> bool:
    """Whether a piece is what is drawn: a mesh touches by its hull, and a camera may be in its hollow."""
    return part.piece.kind != "mesh" or part.mesh is not None


def _path(facts: Facts) -> Iterator[Problem]:
    for name, pictures in taken(facts).items():
        moving = facts.plan.render["cameras"][name]["kind"] in MOVING
        for frame in some(pictures, MOMENTS if moving else 1):
            view = shot(facts, name, frame.t, part=frame.part)
            if math.dist(view.pos, view.target) < 1e-6:
                text = f"`{name}` stands where it looks at, so that it looks nowhere; move it away"
                yield facts.problem("camera-path", ("render", "cameras", name, "look_at"), text)
                break


RULES = (
    Rule(
        id="camera-inside",
        severity="warning",
        title="A camera is inside of a body, or below the ground.",
        reason="""\
From inside a body, the picture shows its inner side and nothing else; from below a plane, its underside. The hull of a
mesh does not count, for a camera may stand in its hollow. Cameras that move by themselves are followed on their way;
bodies that move count only at the start.""",
        remedy="Move the camera out, or make what it stands in invisible (`look: {visible: false}`).",
        example="""\
scene: {statics: {room: {shape: {kind: box, size: [6, 6, 3]}, place: {on: floor}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [4, 0, 0.5]}}
render:
  cameras: {main: {kind: still, from: [2, -2, 2], look_at: [4, 0, 0.5]}}
""",
        fix="render: {cameras: {main: {from: [6, -4, 2]}}}",
        run=_inside,
    ),
    Rule(
        id="camera-path",
        severity="error",
        title="A camera stands at what it looks at.",
        reason="It has no direction then. Cameras that move by themselves are followed on their way.",
        remedy="Move the camera away from the point, or let it look at something else.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
render:
  cameras: {main: {kind: still, from: [0, 0, 0.5], look_at: ball}}
""",
        fix="render: {cameras: {main: {from: [0, -4, 0.5]}}}",
        run=_path,
    ),
)
