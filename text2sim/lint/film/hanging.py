"""Bodies that hang in the air with nothing to hold them when the film begins."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart, grown
from text2sim.lint.facts import Facts
from text2sim.lint.film.subjects import drawn
from text2sim.lint.film.unseen_subjects import (
    MAX_FILM_START,
    MIN_SHARE_INSIDE,
    camera_to_blame,
    opening_views,
    share_inside,
)
from text2sim.lint.motion.flight import flight_of
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

MIN_FALL = 1.0
"""Shortest fall that is reported, in diagonals of the body's box; what falls less seems to be let go."""
HOLDER_REACH = 0.5
"""Distance within which something that stays seems to hold or drop a body, in the same unit."""
IN_MOTION = 0.15
"""Time [s] from which a falling body is seen to fall: at 1.5 m/s, after 11 cm."""


def _hangs(facts: Facts) -> Iterator[Problem]:
    """Report each body once of which a camera of the author shows a copy at rest in the air as the film begins."""
    views = opening_views(facts)
    moved = {body_of(row.entity) for row in facts.rows.wrenches if row.start == 0.0}
    moved |= {body_of(row.entity) for row in facts.rows.velocities}
    moved |= {body_of(name) for name in facts.sprung}
    for name in facts.case.bodies if views and facts.pull else ():
        balls = drawn(facts, name)
        if not balls or name in moved or not any(share_inside(view, balls) >= MIN_SHARE_INSIDE for view in views):
            continue
        falls = [(fall, copy) for copy in facts.placed[name] if (fall := _unexplained_fall(facts, copy)) > 0.0]
        if falls:
            fall, copy = max(falls, key=lambda row: row[0])
            during = f"`render.during: [{IN_MOTION:g}, {facts.case.scene.duration:g}]`"
            text = (
                f"`{copy.name}` hangs in the air when the film begins, and nothing is seen that holds "
                f"it{more_copies(len(falls))}: it falls {length(fall)}; let the film begin while it falls ({during}, "
                "or `from` of the first shot), let it start in or on something that lets it go, or give it a start "
                "velocity"
            )
            yield facts.problem("hangs-in-air", camera_to_blame(views), text, key=True)


def _unexplained_fall(facts: Facts, copy: Copy) -> float:
    """Return how far [m] a copy falls from rest; 0 if that is little, or if something that stays is beside it."""
    flight, box = flight_of(facts, copy), facts.box(copy)
    if flight is None or box is None or not any(flight.acceleration):
        return 0.0
    size, fall = math.dist(*box), math.hypot(*flight.offset(flight.end))
    reach = grown(box, HOLDER_REACH * size)
    held = any(
        other.model.look.visible and not facts.loose(other) and not apart(reach, other_box)
        for other in facts.copies.values()
        if (other_box := facts.box(other)) is not None
    )
    return fall if fall > MIN_FALL * size and not held else 0.0


RULES = (
    Rule(
        id="hangs-in-air",
        title="A body hangs in the air with nothing to hold it when the film begins.",
        reason=f"""\
It starts at rest, with nothing below it, and falls from the first picture on by more than its own size: for a moment it
is seen to float. What begins within {HOLDER_REACH:g} of its size from something that stays (a chute, a gripper, a
shelf) does not count, nor what is attached, pushed or thrown at the start. The rule looks at the cameras that the case
gives, if they film the first {MAX_FILM_START:g} s.""",
        remedy="""\
Let the film begin while it falls, with `render.during` or `from` of the first shot. Or show what lets it go: a shelf
that is pulled away, a gripper whose `attach` ends in a `release`. If it is meant to hang there, waive the rule.""",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1.5]}}
render:
  cameras: {main: {kind: still, from: [0, -6, 1], look_at: [0, 0, 0.8]}}
""",
        fix="render: {during: [0.15, 1.0]}",
        run=_hangs,
    ),
)
