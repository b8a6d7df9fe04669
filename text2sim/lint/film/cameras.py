"""Rules about subjects that the film does not show: out of the picture, hidden, tiny, or cut off."""

import math
from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.film.hiding import hidden_behind, maybe_hidden
from text2sim.lint.film.shots import ShotView, shot, taken
from text2sim.lint.film.subjects import Balls, drawn, middle_of, subjects
from text2sim.lint.film.ways import comes_in
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.text.document import Path

SMALL = 0.001
"""Part of the picture below which a subject is not recognised: 30 x 30 pixels of 1280 x 720."""
APART = 0.2
"""Part of a camera's distance; from nearer than that it shows something else."""
CUT = 0.5
"""Part of a subject, by the area of its balls, that has to be in the picture."""
EARLY = 0.1
"""A film that starts later [s] than this shows bodies where they have gone."""


def _views(facts: Facts) -> list[ShotView]:
    """The author's cameras that film the start; none if the camera is derived."""
    return [shot(facts, name, 0.0) for name, pictures in taken(facts).items() if pictures and pictures[0].t <= EARLY]


def _share_inside(shot: ShotView, balls: Balls) -> float:
    """Part of the balls, by their area, whose middle is in the picture."""
    area = sum(radius**2 for _, radius in balls)
    return sum(radius**2 for center, radius in balls if shot.shows(center)) / area


def blamed(facts: Facts, views: list[ShotView]) -> Path:
    """Return the camera to blame: the only one, or all of them."""
    return ("render", "cameras", views[0].name) if len(views) == 1 else ("render", "cameras")


def _none(views: list[ShotView]) -> str:
    return f"camera `{views[0].name}` does not see" if len(views) == 1 else "no camera sees"


def _unseen(facts: Facts) -> Iterator[Problem]:
    views = _views(facts)
    for name in subjects(facts) if views else ():
        balls = drawn(facts, name)
        if not balls:
            continue
        seeing = [view for view in views if any(view.shows(*ball) for ball in balls)]
        why = ""
        if not seeing:
            why = "" if comes_in(facts, name) else _way_in(views[0], balls)
        elif all(maybe_hidden(facts, view, name, balls) for view in seeing):
            why = hidden_behind(facts, seeing, name)
        if why:
            text = f"{_none(views)} `{name}` at the start, which the script is about: {why}"
            yield facts.problem("unseen-subject", blamed(facts, views), text, key=True)


def _way_in(shot: ShotView, balls: Balls) -> str:
    """Why a subject is not in the picture of a camera, and what would bring it there."""
    middle = middle_of(balls)
    needed = shot.needed(middle)
    fov = 2 * math.degrees(math.atan(shot.tall))
    look = f"let it look at {vector(tuple(round(c, 2) for c in middle))}"
    if needed is None:
        return f"it is behind the camera; {look}"
    if needed < 100:
        return f"it is beside the picture; {look}, or widen its field of view from {fov:.3g} to {needed * 1.1:.3g} deg"
    return f"it is beside the picture; {look}"


def _small(facts: Facts) -> Iterator[Problem]:
    views = _views(facts)
    for name in subjects(facts) if views else ():
        balls = drawn(facts, name)
        seeing = [view for view in views if any(view.shows(*ball) for ball in balls)]
        if not seeing:
            continue
        share, best = max((view.share(balls), -index) for index, view in enumerate(seeing))
        if share < SMALL:
            view = seeing[-best]
            away, nearer = math.dist(view.pos, middle_of(balls)), math.sqrt(share / (4 * SMALL))
            text = (
                f"`{name}`, which the script is about, fills less than {100 * share:.1g} % of the picture at the "
                f"start: camera `{view.name}` is {length(away)} away; "
            )
            if nearer > APART:
                text += f"{length(away * nearer)} would show it"
            else:
                there = f"from {length(away * nearer)}"
                text += (
                    f"what shows it, {there}, shows little else: a second camera there, with a shot of its own, would"
                )
            yield facts.problem("small-subject", ("render", "cameras", view.name), text, key=True)


def _cut_off(facts: Facts) -> Iterator[Problem]:
    views = _views(facts)
    for name in subjects(facts) if views else ():
        balls = drawn(facts, name)
        if not balls or not any(view.shows(*ball) for view in views for ball in balls):
            continue
        share, best = max((_share_inside(view, balls), -index) for index, view in enumerate(views))
        if share < CUT:
            view = views[-best]
            text = (
                f"only {share:.0%} of `{name}`, which the script is about, is in the picture of camera `{view.name}` "
                f"at the start; {_step_back(view, balls)}"
            )
            yield facts.problem("cut-off-subject", ("render", "cameras", view.name), text, key=True)


def _step_back(shot: ShotView, balls: Balls) -> str:
    needed = [shot.needed(center) for center, _ in balls]
    if None in needed:
        return "move the camera back: a part is behind it"
    widest = max(angle for angle in needed if angle is not None) * 1.1
    fov = 2 * math.degrees(math.atan(shot.tall))
    if widest < 100:
        return f"widen its field of view from {fov:.3g} to {widest:.3g} deg, or move it back"
    return "move it back"


RULES = (
    Rule(
        id="unseen-subject",
        severity="warning",
        title="No camera sees a body at the start that the script is about.",
        reason=f"""\
Subjects are the bodies that controls act on and that expectations, their measures and events name. One of them is not
in any camera's picture at the start, or something hides it in all of them; bodies that are invisible do not count.
Who judges the film sees nothing of what is expected. What is driven, or starts with a velocity that will probably
bring it into a picture, may come in later. A film that begins later than {EARLY:g} s is not judged, nor is a camera
that nobody placed: it is put where it sees everything that moves.""",
        remedy="Let a camera look at it, widen the field of view, or move the camera round what is in the way.",
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
        severity="warning",
        title="A body that the script is about is tiny in every picture.",
        reason=f"""\
It fills less than {SMALL:.1%} of the picture of every camera at the start, less than 30 by 30 pixels of 1280 by 720.
What happens to it is not recognised.""",
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
        severity="warning",
        title="Less than half of a body that the script is about is in any picture.",
        reason="""\
In every camera's picture at the start, most of the body (or of its copies) lies beyond the edges.""",
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
