"""Cameras inside a body, below the ground, or at the point they look at."""

import math
from collections.abc import Iterator

from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, vector_dot
from text2sim.lint.facts import Facts
from text2sim.lint.film.case_cameras import CameraView, pictures_taken, spread_evenly, view_at
from text2sim.lint.film.unseen_subjects import MAX_FILM_START
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import overlapping
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

MOVING_KINDS = ("orbit", "dolly", "keyframed")
"""Kinds of cameras whose path is known; that of one that follows a body is known only at the start of its film."""
CAMERA_MOMENTS = 13
"""Moments at which the rules sample the path of a moving camera."""


def _sampled(facts: Facts) -> Iterator[tuple[float, CameraView]]:
    """Yield the author's cameras at sampled times [s] of the simulation."""
    for name, pictures in pictures_taken(facts).items():
        moving = facts.plan.render["cameras"][name]["kind"] in MOVING_KINDS
        for frame in spread_evenly(pictures, CAMERA_MOMENTS if moving else 1):
            yield frame.t, view_at(facts, name, frame.t, part=frame.part)


def _inside(facts: Facts) -> Iterator[Problem]:
    """Report each camera once, at the first of its moments at which it is below a ground or inside a body."""
    reported = set()
    for t, view in _sampled(facts):
        if view.name not in reported and (text := _enclosed(facts, t, view)):
            yield facts.problem("camera-inside", ("render", "cameras", view.name), text, key=True)
            reported.add(view.name)


def _enclosed(facts: Facts, t: float, view: CameraView) -> str | None:
    """Return a message if a camera is below a ground or inside a body at a time [s]."""
    for ground in facts.planes:
        below = ground.level - vector_dot(ground.up, view.pos)
        if below > 0 and ground.beside(view.pos) < 0:
            where = f"{length(below)} below `{ground.copy.name}`{_time_text(t)}"
            return f"`{view.name}` is {where} and sees its underside; raise it"
    eye = StandingPart(Piece("sphere", size=(1e-4,)), view.pos, IDENTITY, False, None)
    for copy in facts.copies.values():
        box = facts.box(copy)
        look = copy.model.look
        if box is None or not look.visible or look.opacity < 0.5 or apart(box, eye.box):
            continue
        if facts.moves(copy) and t > MAX_FILM_START:
            continue
        if any(overlapping(eye, part) for part in facts.parts(copy) if _solid(part)):
            return f"`{view.name}` is inside `{copy.name}`{_time_text(t)} and sees nothing else; move it out"
    return None


def _time_text(t: float) -> str:
    return f" after {t:.2g} s" if t > MAX_FILM_START else " at the start"


def _solid(part: StandingPart) -> bool:
    """Return whether a piece is drawn as it collides; the hull of a mesh may be hollow."""
    return part.piece.kind != "mesh" or part.mesh is not None


def _without_direction(facts: Facts) -> Iterator[Problem]:
    found = dict.fromkeys(view.name for _, view in _sampled(facts) if math.dist(view.pos, view.target) < 1e-6)
    for name in found:
        text = f"`{name}` is at the point it looks at, so it has no direction; move it away"
        yield facts.problem("camera-path", ("render", "cameras", name, "look_at"), text)


RULES = (
    Rule(
        id="camera-inside",
        title="A camera is inside a body, or below the ground.",
        reason="""\
From inside a body, the picture shows only its inner side; from below a plane, its underside. The hull of a mesh does
not count, because a camera may be in its hollow. The rule follows moving cameras, except those that follow a body,
which count at the start of their film; moving bodies count only at the start.""",
        remedy="Move the camera out, or make the body invisible (`look: {visible: false}`).",
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
        title="A camera is at the point it looks at.",
        reason="""\
Such a camera has no direction. The rule follows moving cameras along their path, except those that follow a body, which
count at the start of their film.""",
        remedy="Move the camera away from the point, or let it look at something else.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
render:
  cameras: {main: {kind: still, from: [0, 0, 0.5], look_at: ball}}
""",
        fix="render: {cameras: {main: {from: [0, -4, 0.5]}}}",
        run=_without_direction,
    ),
)
