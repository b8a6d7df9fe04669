"""Bodies with nothing to come to rest on."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, apart, grown
from text2sim.compiler.shapes.rotation import Vec, vector_dot
from text2sim.lint.facts import Facts
from text2sim.lint.motion.whereabouts import whereabouts
from text2sim.lint.parts import lowest_of
from text2sim.lint.rule import Rule
from text2sim.lint.words import more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

FAR = 10.0
"""Fall [m] from which on it counts that nothing is below."""


def _falls_for_ever(facts: Facts) -> Iterator[Problem]:
    """One finding for each body whose copies have nothing below them, as far as they may get."""
    gravity = facts.case.scene.gravity
    pull = math.hypot(*gravity)
    fall = pull * facts.case.scene.duration**2 / 2
    if fall < FAR:
        return
    down: Vec = (gravity[0] / pull, gravity[1] / pull, gravity[2] / pull)
    if any(vector_dot(ground.up, down) < -1e-6 for ground in facts.planes):
        return
    up: Vec = (-down[0], -down[1], -down[2])
    meant, held = facts.meant_to_leave, _held(facts)
    resting = [(copy, box) for copy in facts.copies.values() if not facts.loose(copy) and (box := facts.box(copy))]
    for name in facts.case.bodies:
        if name in meant or name in held:
            continue
        lost = [copy for copy in facts.placed[name] if facts.loose(copy) and not _caught(facts, copy, up, resting)]
        if lost:
            text = (
                f"nothing is below `{lost[0].name}`{more_copies(len(lost))}: it falls for ever, {fall:.3g} m in "
                f"{facts.case.scene.duration:g} s; give the scene a floor "
                "(`statics: {floor: {shape: {kind: plane}}}`), or an event of kind `left_domain` if that is meant"
            )
            yield facts.problem("falls-for-ever", facts.where(name), text, key=True)


def _upward(facts: Facts) -> Iterator[Problem]:
    gravity = facts.case.scene.gravity
    if gravity[2] > 0.0 and any(ground.up[2] > 0.5 for ground in facts.planes):
        down = vector((gravity[0], gravity[1], -gravity[2]))
        ground = facts.planes[0].copy.name
        text = f"gravity points up, away from `{ground}`; z points up here, so that bodies fall at {down}"
        yield facts.problem("upward-gravity", ("scene", "gravity"), text)


def _held(facts: Facts) -> set[str]:
    """Bodies that something else may keep from falling: what they are attached to, or a force."""
    names = [name for weld in facts.rows.welds for name in (weld.a, weld.b)]
    names += [wrench.entity for wrench in facts.rows.wrenches if wrench.end > wrench.start]
    return {body_of(name) for name in names}


def _caught(facts: Facts, copy: Copy, up: Vec, resting: list[tuple[Copy, Bounds]]) -> bool:
    """Whether something that is held lies lower than a copy, and where it may get; judged generously."""
    box = facts.box(copy)
    if box is None:
        return True
    # It may topple by its own length, and roll.
    reach, top = grown(whereabouts(facts).box(copy), math.dist(*box)), -lowest_of(box, (-up[0], -up[1], -up[2]))
    return any(lowest_of(held, up) < top and not apart(reach, whereabouts(facts).box(other)) for other, held in resting)


RULES = (
    Rule(
        id="upward-gravity",
        severity="warning",
        title="Gravity lifts bodies from the ground.",
        reason="""\
The z axis points up, so that gravity has a negative z: it is [0, 0, -9.81] if left out. With a positive one everything
that is free leaves the ground and never comes back.""",
        remedy="Turn the sign, or leave `scene.gravity` out.",
        example="""\
scene: {gravity: [0, 0, 9.81]}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor}}
""",
        fix="scene: {gravity: [0, 0, -1.62]}",
        run=_upward,
    ),
    Rule(
        id="falls-for-ever",
        severity="warning",
        title="A free body has nothing below it on which it could come to rest.",
        reason=f"""\
There is gravity and no plane, and nothing that is held lies below the body as far to the side as it may get. It falls
by half of gravity times the square of the duration; less than {FAR:g} m are not reported, nor is a body that something
is attached to, that a force acts on, or that an event of kind `left_domain` or `leaves` is about.""",
        remedy="Give the scene a floor, or something below the body; for a scene in space, set `gravity: [0, 0, 0]`.",
        example="""\
scene:
  duration: 3.0
  statics: {floor: null, table: {shape: {kind: box, size: [1, 1, 0.05]}, pose: {pos: [0, 0, 0.7]}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [2, 0, 1]}}
""",
        fix="scene: {statics: {table: null, floor: {shape: {kind: plane}}}}",
        run=_falls_for_ever,
    ),
)
