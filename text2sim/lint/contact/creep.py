"""Bodies that friction holds on a slope, and that creep all the same, as the pyramidal friction cone has it."""

import math
from collections.abc import Iterator
from itertools import combinations, islice

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.rotation import Vec, quat_rotate, vector_cross, vector_dot
from text2sim.compiler.slopes import tilted
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.contact.sliding import friction_between
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import RESTING
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import AXES

LOOKED_AT = 30
"""Free bodies that are looked at."""
LEAST = 1e-3
"""Way [m] until the end that is worth a word."""
STEEP = 0.0087
"""Slope [rad] from which on something is one."""
FLUSH = 0.0175
"""Angle [rad] up to which faces lie flat on each other."""
POINTS = 4
"""Contacts of a face."""
NOSLIP, LESS = 10, 0.5
"""Iterations against creeping that stop what needs less than this part of its friction."""
SOFT = (1 - 0.9) / 0.9 * 0.95 / 2
"""(1 - dmin) / dmin * dmax / 2 of the engine's contact parameters."""


def creep_speed(pull: float, slope: float, friction: float, timeconst: float) -> float:
    """Return the speed [m/s] at which a face creeps on a slope that holds it.

    Args:
        pull: Gravity [m/s2].
        slope: Angle [rad]; its tangent is less than the friction.
        friction: Coefficient.
        timeconst: Of contacts [s].
    """
    used = math.tan(slope) / friction
    share = used if used < 0.5 else 3 * used - 1
    return share * friction * (1 + friction**2) * pull * math.cos(slope) / POINTS * SOFT * timeconst


def _creeping(facts: Facts) -> Iterator[Problem]:
    yield from _leaning(facts)
    scene = facts.case.scene
    pull = math.hypot(*scene.gravity)
    if facts.settings.cone != "pyramidal" or not pull:
        return
    up = (-scene.gravity[0] / pull, -scene.gravity[1] / pull, -scene.gravity[2] / pull)
    supports = list(_supports(facts, up))
    for name in facts.case.bodies if supports else ():
        found: list[tuple[float, float, float, Copy, Copy]] = []
        for copy in facts.placed[name][:LOOKED_AT]:
            if is_soft(copy.model) or not facts.free(copy) or copy.name in facts.velocities:
                continue
            for other, normal in supports:
                slope = math.acos(min(1.0, vector_dot(normal, up)))
                friction = friction_between(facts, copy, other)
                stopped = scene.solver.noslip_iterations >= NOSLIP and math.tan(slope) < LESS * friction
                if math.tan(slope) < friction and not stopped and _lies_on(facts, copy, other, normal):
                    speed = creep_speed(pull, slope, friction, facts.settings.timeconst)
                    found.append((speed, slope, friction, copy, other))
                    break
        if found and (worst := max(found, key=lambda row: row[0]))[0] * scene.duration > LEAST:
            yield _finding(facts, *worst, len(found))


def _leaning(facts: Facts) -> Iterator[Problem]:
    """Free bodies that lean on each other."""
    if facts.settings.cone != "pyramidal":
        return
    free = (copy for copy in facts.copies.values() if not is_soft(copy.model) and facts.free(copy))
    leaning = list(islice(tilted(free, facts.case.scene.gravity), LOOKED_AT))
    for a, b in combinations(leaning, 2):
        one, other = facts.box(a), facts.box(b)
        if one is not None and other is not None and not apart(one, other, -RESTING):
            text = (
                f"`{a.name}` and `{b.name}` lean on each other: with the pyramidal friction cone they slide apart, two "
                "cards of 90 mm at 20 deg by 2 mm in 2 s; set `friction_cone: elliptic` in scene.contact"
            )
            yield facts.problem("creeps", ("bodies", a.body), text, key=True)
            return


def _finding(facts: Facts, speed: float, slope: float, friction: float, copy: Copy, other: Copy, count: int) -> Problem:
    used = math.tan(slope) / friction
    text = (
        f"`{copy.name}` is held by friction on `{other.name}` ({math.degrees(slope):.3g} deg, {friction:g})"
        f"{more_copies(count)}, and creeps at {'about' if used < 0.9 else 'no less than'} {1e3 * speed:.2g} mm/s, "
        f"{length(speed * facts.case.scene.duration)} until the end: the pyramidal friction cone lets it; set "
        "`friction_cone: elliptic` in scene.contact"
    )
    text += f", or `noslip_iterations: {NOSLIP}` in scene.solver" if used < LESS else ", or take more substeps"
    return facts.problem("creeps", ("bodies", copy.body), text, key=True)


def _supports(facts: Facts, up: Vec) -> Iterator[tuple[Copy, Vec]]:
    """Slopes that do not move, with the directions of their upper faces."""
    for ground in facts.planes:
        if math.hypot(*vector_cross(ground.up, up)) > STEEP:
            yield ground.copy, ground.up
    for copy in facts.copies.values():
        if facts.mount(copy) in ("static", "fixed", "driven") and getattr(copy.shape, "kind", "") == "box":
            turned = [quat_rotate(copy.quat, AXES[axis]) for axis in ("x", "y", "z")]
            faces = [face for x, y, z in turned for face in ((x, y, z), (-x, -y, -z))]
            steepest = max(faces, key=lambda face: vector_dot(face, up))
            if math.hypot(*vector_cross(steepest, up)) > STEEP:
                yield copy, steepest


def _lies_on(facts: Facts, copy: Copy, other: Copy, normal: Vec) -> bool:
    """Whether a face of a copy lies flat on a slope."""
    kind = getattr(copy.shape, "kind", "")
    axes = ("x", "y", "z") if kind == "box" else ("z",) if kind in ("cylinder", "cup", "tube") else ()
    if not any(math.hypot(*vector_cross(quat_rotate(copy.quat, AXES[a]), normal)) < FLUSH for a in axes):
        return False
    low = min(part.lowest(normal) for part in facts.parts(copy))
    for ground in facts.planes:
        if ground.copy is other:
            return abs(low - ground.level) < RESTING and ground.beside(copy.pos) < 0
    box, its = facts.box(copy), facts.box(other)
    if box is None or its is None or apart(box, its, -RESTING):
        return False
    top = -min(part.lowest((-normal[0], -normal[1], -normal[2])) for part in facts.parts(other))
    return abs(low - top) < RESTING


_RAMP = """\
scene:
  duration: 5.0
  contact: {friction_cone: %s}
  statics:
    ramp:
      shape: {kind: box, size: [2, 1, 0.05]}
      material: {friction: 0.6}
      pose: {pos: [0, 0, 1], euler_deg: [0, 15, 0]}
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.3, 0.3, 0.2]}, place: {on: ramp, at: [0, 0], euler_deg: [0, 15, 0]}}
"""

RULES = (
    Rule(
        id="creeps",
        severity="warning",
        title="A body that friction holds on a slope creeps, as the friction cone has it.",
        reason=f"""\
Contacts are regularised: friction that holds needs a little sliding, and with the pyramidal cone that is seen. Of the
friction m, a slope of angle s uses u = tan(s) / m. A face, which has {POINTS} contacts, creeps at
`k m (1 + m^2) g cos(s) / {POINTS}`, times u up to one half and 3 u - 1 above, with k = {SOFT:.3g} timeconst (measured
to 15 %, friction 0.45 to 2, slopes of 5 and 20 deg; from u = 0.9 on it slips by turns, up to six times as fast). With
the elliptic cone it is a hundredth. Scenes of free bodies with slopes get that cone by themselves; trees of links,
piles with cg, and what bounces do not. Cards that lean on each other touch with one contact, and part by 1.9 mm in 2 s
with the pyramidal cone; with the elliptic one they stay within 10 micrometres (`tests/physics/test_friction.py`).""",
        remedy="""\
Set `scene.contact.friction_cone: elliptic`; where that cannot be, `solver: {noslip_iterations: 10}`, which stops what
uses less than half of its friction, or more substeps: the creep goes with the time constant.""",
        example=_RAMP % "pyramidal",
        fix=_RAMP % "elliptic",
        run=_creeping,
        own_contact=True,
    ),
)
