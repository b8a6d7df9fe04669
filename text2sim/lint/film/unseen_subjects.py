"""Subjects that the film does not show: out of the picture, hidden, tiny, or cut off."""

import math
from collections.abc import Iterator

from text2sim.compiler.looks import hides
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, crosses
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts, once_per_case
from text2sim.lint.film.body_paths import comes_in
from text2sim.lint.film.case_cameras import CameraView, pictures_taken, point_for, view_at
from text2sim.lint.film.subjects import Balls, center_of, drawn, subjects
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.shapes import Compound
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path

MIN_PICTURE_SHARE = 0.001
"""Share of the picture below which a subject is not recognisable: 30 x 30 pixels of 1280 x 720."""
MIN_FRAMED_SHARE = 0.00025
"""The same for one of several that a camera frames: no nearer place shows all of them. 15 x 15 pixels."""
MIN_APPROACH = 0.2
"""Share of a camera's distance; nearer than that it shows a different picture."""
MIN_SHARE_INSIDE = 0.5
"""Share of a subject, by the area of its balls, that has to be in the picture."""
MAX_FILM_START = 0.1
"""Latest start [s] of a film that shows bodies where they start."""
TESTED_POINTS = 6
"""Points of a subject that are tested."""


@once_per_case
def opening_views(facts: Facts) -> list[CameraView]:
    """Return the author's cameras that film the start; none if the camera is derived."""
    return [
        view_at(facts, name, 0.0)
        for name, pictures in pictures_taken(facts).items()
        if pictures and pictures[0].t <= MAX_FILM_START
    ]


def share_inside(view: CameraView, balls: Balls) -> float:
    """Return the share of the balls, by their area, whose centre is in the picture."""
    area = sum(radius**2 for _, radius in balls)
    return sum(radius**2 for center, radius in balls if view.shows(center)) / area


def camera_to_blame(views: list[CameraView]) -> Path:
    """Return the camera to blame: the only one, or all of them."""
    return ("render", "cameras", views[0].name) if len(views) == 1 else ("render", "cameras")


def _who_does_not_see(views: list[CameraView]) -> str:
    return f"camera `{views[0].name}` does not see" if len(views) == 1 else "no camera sees"


def _filmed_subjects(facts: Facts) -> Iterator[tuple[str, Balls, list[CameraView]]]:
    """Yield the visible subjects with the balls around them, and the cameras that see part of them at the start."""
    views = opening_views(facts)
    for name in subjects(facts) if views else ():
        if balls := drawn(facts, name):
            yield name, balls, [view for view in views if any(view.shows(*ball) for ball in balls)]


def _unseen(facts: Facts) -> Iterator[Problem]:
    views = opening_views(facts)
    for name, balls, seeing in _filmed_subjects(facts):
        why = ""
        if not seeing:
            why = "" if comes_in(facts, name) else _way_in(facts, views[0], balls)
        elif all(maybe_hidden(facts, view, name, balls) for view in seeing):
            why = hidden_behind(facts, seeing, name)
        if why:
            text = f"{_who_does_not_see(views)} `{name}`, a subject of the script, at the start: {why}"
            yield facts.problem("unseen-subject", camera_to_blame(views), text, key=True)


def _way_in(facts: Facts, view: CameraView, balls: Balls) -> str:
    """Return why a subject is not in the picture of a camera, and what would bring it there."""
    center = center_of(balls)
    needed = view.fov_to_show(center)
    point, frame = point_for(facts, view.name, center)
    look = f"set look_at to {vector(tuple(round(c, 2) for c in point))}{frame}"
    if needed is None:
        return f"it is behind the camera; {look}"
    if needed >= 100:
        return f"it is outside the picture; {look}"
    fov = 2 * math.degrees(math.atan(view.tan_half_height))
    return f"it is outside the picture; {look}, or widen the field of view from {fov:.3g} to {needed * 1.1:.3g} deg"


def _small(facts: Facts) -> Iterator[Problem]:
    for name, balls, seeing in _filmed_subjects(facts):
        if not seeing:
            continue
        share, best = max((view.share(balls), -index) for index, view in enumerate(seeing))
        view = seeing[-best]
        together = _is_framed_with_others(facts, view.name, name)
        if share < (MIN_FRAMED_SHARE if together else MIN_PICTURE_SHARE):
            away, nearer = math.dist(view.pos, center_of(balls)), math.sqrt(share / (4 * MIN_PICTURE_SHARE))
            text = (
                f"`{name}`, a subject of the script, fills less than {100 * share:.1g} % of the picture at the "
                f"start: camera `{view.name}` is {length(away)} away; "
            )
            if nearer > MIN_APPROACH and not together:
                text += f"move it to {length(away * nearer)}"
            else:
                text += f"add a second camera at {length(away * nearer)}, with a shot of its own"
            yield facts.problem("small-subject", ("render", "cameras", view.name), text, key=True)


def _is_framed_with_others(facts: Facts, camera: str, name: str) -> bool:
    framed = {body_of(selector) for selector in getattr(facts.case.render.cameras[camera], "frame", None) or ()}
    return name in framed and len(framed) > 1


def _cut_off(facts: Facts) -> Iterator[Problem]:
    views = opening_views(facts)
    for name, balls, seeing in _filmed_subjects(facts):
        if not seeing:
            continue
        share, best = max((share_inside(view, balls), -index) for index, view in enumerate(views))
        if share < MIN_SHARE_INSIDE:
            view = views[-best]
            text = (
                f"only {share:.0%} of `{name}`, a subject of the script, is in the picture of camera `{view.name}` "
                f"at the start; {_step_back(view, balls)}"
            )
            yield facts.problem("cut-off-subject", ("render", "cameras", view.name), text, key=True)


def _step_back(view: CameraView, balls: Balls) -> str:
    needed = [view.fov_to_show(center) for center, _ in balls]
    if None in needed:
        return "move the camera back: part of the body is behind it"
    widest = max(angle for angle in needed if angle is not None) * 1.1
    fov = 2 * math.degrees(math.atan(view.tan_half_height))
    if widest < 100:
        return f"widen its field of view from {fov:.3g} to {widest:.3g} deg, or move it back"
    return "move it back"


def maybe_hidden(facts: Facts, view: CameraView, name: str, balls: Balls) -> bool:
    """Return whether the boxes of other bodies block the line of sight to every tested point of a subject.

    Args:
        facts: The case.
        view: The camera at a time.
        name: Name of the subject.
        balls: Balls around its parts: centre [m], radius [m].
    """
    step = max(len(balls) // TESTED_POINTS, 1)
    others = [
        (copy, box) for copy in facts.copies.values() if copy.body != name and (box := facts.box(copy)) is not None
    ]

    def between(center: Vec) -> bool:
        return any(
            crosses(box, view.pos, center) and any(crosses(part, view.pos, center) for part in _boxes(facts, copy, box))
            for copy, box in others
        )

    return all(between(center) for center, _ in balls[::step])


def _boxes(facts: Facts, copy: Copy, whole: Bounds) -> list[Bounds]:
    """Return the boxes around the opaque parts of a compound; of any other copy, the box around the whole."""
    if is_soft(copy.model) or not isinstance(copy.shape, Compound):
        return [whole]
    looks = {name: part.look for name, part in copy.shape.parts.items()}
    clear = {name for name, look in looks.items() if look is not None and not hides(look.opacity, look.finish)}
    return [part.box for part in facts.parts(copy) if part.piece.part not in clear]


def hidden_behind(facts: Facts, seeing: list[CameraView], name: str) -> str:
    """Return what hides a subject from all these cameras; empty if one sees part of it.

    Args:
        facts: The case.
        seeing: Cameras that look towards the subject.
        name: Name of the subject.
    """
    from text2sim.legibility.layout import at_start

    copies = {copy.name for copy in facts.placed[name]}
    first = None
    for view in seeing:
        layout = at_start(facts.resolution, view.name)
        if copies & layout.shares.keys():
            return ""
        first = first or layout
    blocking = first.hider(copies) if first else ""
    return f"it is hidden behind `{blocking}`; move the camera" if blocking else "it is hidden; move the camera"


RULES = (
    Rule(
        id="unseen-subject",
        title="No camera sees a subject of the script at the start.",
        reason=f"""\
Subjects are the bodies that controls act on and that expectations, their measures and events name. One of them is not
in any camera's picture at the start, or something hides it in all of them; invisible bodies do not count. Viewers of
the film cannot see what is expected. Driven bodies, and bodies whose start velocity probably brings them into a
picture, may come in later. The rule skips films that begin later than {MAX_FILM_START:g} s and derived cameras, which
are placed to see everything that moves.""",
        remedy="Let a camera look at it, widen the field of view, or move the camera around the obstacle.",
        example="""\
scene: {statics: {wall: {shape: {kind: box, size: [2, 0.1, 1]}, place: {on: floor}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 1, 0.5]}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 0.2}}
render:
  cameras: {main: {kind: still, from: [0, -4, 0.5], look_at: [0, 0, 0.5]}}
""",
        fix="render: {cameras: {main: {from: [0, -4, 3]}}}",
        run=_unseen,
    ),
    Rule(
        id="small-subject",
        title="A subject of the script is tiny in every picture.",
        reason=f"""\
It fills less than {MIN_PICTURE_SHARE:.1%} of the picture of every camera at the start, less than 30 by 30 pixels of
1280 by 720. Viewers cannot recognise what happens to it. For one of several bodies that a camera frames the bound is a
quarter of that: no nearer place shows all of them.""",
        remedy="Move the camera nearer, as the message says, or narrow its field of view.",
        example="""\
scene: {statics: {wall: {shape: {kind: box, size: [2, 0.1, 1]}, place: {on: floor}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, -1, 0.5]}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 0.2}}
render:
  cameras: {main: {kind: still, from: [0, -25, 2], look_at: [0, 0, 0.5]}}
""",
        fix="render: {cameras: {main: {from: [0, -4, 2]}}}",
        run=_small,
    ),
    Rule(
        id="cut-off-subject",
        title="Less than half of a subject of the script is in any picture.",
        reason="""\
In every camera's picture at the start, most of the body (or of its copies) lies outside the edges.""",
        remedy="Move the camera back, or widen its field of view as the message says.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor},
         repeat: {kind: line, count: 12, step: [0.5, 0, 0]}}
actions:
  measures: {shift: {kind: displacement, of: ball, stat: max}}
  expect: {stay: {measure: shift, at: end, below: 0.01}}
render:
  cameras: {main: {kind: still, from: [0, -2, 1], look_at: [0, 0, 0]}}
""",
        fix="render: {cameras: {main: {from: [2.75, -5, 2], look_at: [2.75, 0, 0]}}}",
        run=_cut_off,
    ),
)
