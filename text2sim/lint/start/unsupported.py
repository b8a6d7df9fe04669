"""Bodies with nothing below them, and gravity that points up."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, apart, grown
from text2sim.compiler.shapes.rotation import vector_dot
from text2sim.lint.facts import Facts
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.lint.parts import lowest_of
from text2sim.lint.rule import Rule
from text2sim.lint.words import more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

MIN_FALL = 10.0
"""Shortest fall [m] in the run that is reported."""


def _falls_for_ever(facts: Facts) -> Iterator[Problem]:
    """Report each body once whose copies have nothing below them, as far as they may move."""
    fall = facts.pull * facts.case.scene.duration**2 / 2
    if fall < MIN_FALL:
        return
    if any(vector_dot(ground.up, facts.up) > 1e-6 for ground in facts.planes):
        return
    meant, held = facts.meant_to_leave, _held_bodies(facts)
    resting = [(copy, box) for copy in facts.copies.values() if not facts.loose(copy) and (box := facts.box(copy))]
    for name in facts.case.bodies:
        if name in meant or name in held:
            continue
        lost = [copy for copy in facts.placed[name] if facts.loose(copy) and not _caught(facts, copy, resting)]
        if lost:
            text = (
                f"nothing is below `{lost[0].name}`{more_copies(len(lost))}: it falls forever, {fall:.3g} m in "
                f"{facts.case.scene.duration:g} s; give the scene a floor "
                "(`statics: {floor: {shape: {kind: plane}}}`), or an event of kind `left_domain` if this is intended"
            )
            yield facts.problem("falls-for-ever", facts.where(name), text, key=True)


def _upward(facts: Facts) -> Iterator[Problem]:
    gravity = facts.case.scene.gravity
    if gravity[2] > 0.0 and any(ground.up[2] > 0.5 for ground in facts.planes):
        down = vector((gravity[0], gravity[1], -gravity[2]))
        ground = facts.planes[0].copy.name
        text = f"gravity points up, away from `{ground}`; the z axis points up, so bodies fall at {down}"
        yield facts.problem("upward-gravity", ("scene", "gravity"), text)


def _sideways(facts: Facts) -> Iterator[Problem]:
    gravity = facts.case.scene.gravity
    if gravity[2] == 0.0 and any(gravity) and (grounds := [ground for ground in facts.planes if ground.up[2] > 0.5]):
        down = vector((0.0, 0.0, -math.hypot(*gravity)))
        text = f"gravity acts along `{grounds[0].copy.name}`, not down; the z axis points up, so bodies fall at {down}"
        yield facts.problem("sideways-gravity", ("scene", "gravity"), text)


def _held_bodies(facts: Facts) -> set[str]:
    """Return the bodies that an attachment, a spring or a force may keep from falling."""
    names = [name for weld in facts.rows.welds for name in (weld.a, weld.b)]
    names += [wrench.entity for wrench in facts.rows.wrenches if wrench.end > wrench.start]
    return {body_of(name) for name in (*names, *facts.bonded, *facts.sprung)}


def _caught(facts: Facts, copy: Copy, resting: list[tuple[Copy, Bounds]]) -> bool:
    """Return whether a held body is lower than a copy and within its reach, generously estimated."""
    box = facts.box(copy)
    if box is None:
        return True
    # It may topple by its own length, and roll.
    whereabouts, up = facts.once(Whereabouts), facts.up
    reach = grown(whereabouts.box(copy), math.dist(*box))
    top = -lowest_of(box, (-up[0], -up[1], -up[2]))
    return any(lowest_of(held, up) < top and not apart(reach, whereabouts.box(other)) for other, held in resting)


RULES = (
    Rule(
        id="upward-gravity",
        title="Gravity lifts bodies from the ground.",
        reason="""\
The z axis points up, so gravity has a negative z component: the default is [0, 0, -9.81]. With a positive one all free
bodies leave the ground and never come back.""",
        remedy="Change the sign, or leave `scene.gravity` out.",
        example="""\
scene: {gravity: [0, 0, 9.81]}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor}}
""",
        fix="scene: {gravity: [0, 0, -1.62]}",
        run=_upward,
    ),
    Rule(
        id="sideways-gravity",
        severity="warning",
        title="Gravity is horizontal, and there is a ground.",
        reason="""\
The z axis points up. Gravity along y, as in programs in which y points up, makes all free bodies fall along the ground.
The rule skips scenes without a plane that faces up, and gravity with a part along z, as on a slope.""",
        remedy="Use `[0, 0, -9.81]`, which is the default.",
        example="""\
scene: {gravity: [0, -9.81, 0]}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor}}
""",
        fix="scene: {gravity: [0, 0, -9.81]}",
        run=_sideways,
    ),
    Rule(
        id="falls-for-ever",
        title="A free body has nothing below it to rest on.",
        reason=f"""\
There is gravity and no plane, and nothing that is held is below the body within its reach. It falls by half of gravity
times the square of the duration. The rule skips falls of less than {MIN_FALL:g} m, bodies with an attachment or a
force, and bodies with an event of kind `left_domain` or `leaves`.""",
        remedy="Give the scene a floor, or put something below the body; in space, set `gravity: [0, 0, 0]`.",
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
