"""Subjects that leave every picture on their predicted path."""

from collections.abc import Iterator
from itertools import dropwhile

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.body_paths import PATH_MOMENTS, offset_of, way_seen
from text2sim.lint.film.case_cameras import views_at
from text2sim.lint.film.subjects import drawn, subjects
from text2sim.lint.film.unseen_subjects import camera_to_blame
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.lint.rule import Rule
from text2sim.lint.words import vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.names.selectors import body_of

MAX_SHARE_OUTSIDE = 0.5
"""Share of its path that a body may be out of the picture if it comes back."""


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
            if (found := _when_lost(facts, copy)) is not None:
                yield _leaving(facts, copy, *found)


def _when_lost(facts: Facts, copy: Copy) -> tuple[float, Vec] | None:
    """Return when [s] and where a copy leaves every camera's picture, if for a large part of its path."""
    render = facts.plan.render
    start, end = render["start"], min(facts.once(Whereabouts).known_until(copy), render["end"])
    if end <= start or not facts.balls(copy):
        return None
    seen = [(t, center, shown) for t, center, shown in way_seen(facts, copy, start, end) if shown is not None]
    # A body may come in from outside; one that never does is reported by another rule.
    seen = list(dropwhile(lambda moment: not moment[2], seen))
    lost = [(t, center) for t, center, shown in seen if not shown]
    if not lost:
        return None
    # It probably stays where it comes down.
    stays = not seen[-1][2] and not isinstance(copy.model, Driven)
    if not stays and len(lost) <= MAX_SHARE_OUTSIDE * PATH_MOMENTS:
        return None
    return lost[0]


def _leaving(facts: Facts, copy: Copy, t: float, left_at: Vec) -> Problem:
    driven = isinstance(copy.model, Driven)
    word = "is driven" if driven else "flies" if any(facts.velocities.get(copy.name, ())) else "falls"
    views = views_at(facts, t, offset_of(facts))
    needed = [angle for view in views if (angle := view.fov_to_show(left_at)) is not None]
    text = (
        f"`{copy.name}`, a subject of the script, {word} out of every camera's picture after {t:.2g} s, at "
        f"{vector(tuple(round(c, 2) for c in left_at))}; use a camera of kind `follow`"
    )
    if needed and min(needed) < 90:
        text += f", or widen the field of view to {min(needed) * 1.1:.3g} deg or more"
    return facts.problem("leaves-picture", camera_to_blame(views), text, key=True)


RULES = (
    Rule(
        id="leaves-picture",
        title="A subject of the script will probably leave every picture.",
        reason=f"""\
Its path is known up to the first body it meets: a throw or a fall under gravity, or the motion of a driven body. After
it has been in a picture, it is in none where it comes down, or for more than {MAX_SHARE_OUTSIDE:.0%} of that path. The
rule does not predict later motion; the report of a run says what its cameras saw. It skips derived cameras, and cameras
with a `frame` that names the body, which show everything that was recorded.""",
        remedy="Use a camera of kind `follow`, a wider field of view, or a camera that looks at where it comes down.",
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
