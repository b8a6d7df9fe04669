"""Subjects that leave every picture on the way that they will probably take."""

from collections.abc import Iterator
from itertools import dropwhile

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.cameras import blamed
from text2sim.lint.film.shots import shots
from text2sim.lint.film.subjects import drawn, subjects
from text2sim.lint.film.ways import MOMENTS, offset_of, way_seen
from text2sim.lint.motion.whereabouts import whereabouts
from text2sim.lint.rule import Rule
from text2sim.lint.words import vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.names.selectors import body_of

GONE = 0.5
"""Part of a way that may be out of the picture, of what comes back into it."""


def _leaves(facts: Facts) -> Iterator[Problem]:
    framed = {
        body_of(selector)
        for camera in facts.case.render.cameras.values()
        if getattr(camera, "within", None) is None
        for selector in getattr(camera, "frame", None) or ()
    }
    for name in subjects(facts) if facts.case.render.cameras else ():
        if name in facts.meant_to_leave or name in framed or not drawn(facts, name):
            continue
        for copy in facts.placed[name][:1]:
            if (found := _lost(facts, copy)) is not None:
                yield _leaving(facts, copy, *found)


def _lost(facts: Facts, copy: Copy) -> tuple[float, Vec] | None:
    """When [s] and where a copy leaves every camera's picture, if that is for a good part of its way."""
    render = facts.plan.render
    start, end = render["start"], min(whereabouts(facts).known_until(copy), render["end"])
    if end <= start or not facts.balls(copy):
        return None
    seen = [(t, there, shown) for t, there, shown in way_seen(facts, copy, start, end) if shown is not None]
    # What comes in from outside is not lost before it was there; what never comes is told elsewhere.
    seen = list(dropwhile(lambda moment: not moment[2], seen))
    lost = [(t, there) for t, there, shown in seen if not shown]
    if not lost:
        return None
    # Where it comes down it probably stays.
    stays = not seen[-1][2] and not isinstance(copy.model, Driven)
    if not stays and len(lost) <= GONE * MOMENTS:
        return None
    return lost[0]


def _leaving(facts: Facts, copy: Copy, t: float, there: Vec) -> Problem:
    driven = isinstance(copy.model, Driven)
    word = "is driven" if driven else "flies" if any(facts.velocities.get(copy.name, ())) else "falls"
    views = shots(facts, t, offset_of(facts))
    needed = [angle for shot in views if (angle := shot.needed(there)) is not None]
    text = (
        f"`{copy.name}`, which the script is about, {word} out of every camera's picture after {t:.2g} s, at "
        f"{vector(tuple(round(c, 2) for c in there))}; let a camera of kind `follow` look at it"
    )
    if needed and min(needed) < 90:
        text += f", or widen the field of view to {min(needed) * 1.1:.3g} deg or more"
    return facts.problem("leaves-picture", blamed(facts, views), text, key=True)


RULES = (
    Rule(
        id="leaves-picture",
        severity="warning",
        title="A body that the script is about will probably leave every picture.",
        reason=f"""\
Its way is known up to what it meets first: a throw or a fall under gravity, or the motion of a driven body. It is in no
camera's picture where it comes down, or for more than {GONE:.0%} of that way, after it has been in one: it may come in
from outside. What happens afterwards is not known here; the report of a run says what its cameras saw. A camera that
nobody placed is not judged, nor is one with a `frame` that names the body: it stands where it shows all that was
recorded.""",
        remedy="A camera of kind `follow`, a wider field of view, or one that looks at where it comes down.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
actions:
  controls: {throw: {kind: initial_velocity, body: ball, linear: [8, 0, 4]}}
render:
  cameras: {main: {kind: still, from: [0, -4, 1], look_at: [0, 0, 0.5]}}
""",
        fix="render: {cameras: {main: {from: null, look_at: null, kind: follow, body: ball, offset: [0, -4, 1]}}}",
        run=_leaves,
    ),
)
