"""Bodies that creep on a slope or in a grip although friction holds them, because of the pyramidal friction cone."""

import math
from collections.abc import Iterator
from itertools import combinations, islice

from text2sim.compiler.grips import grips
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.rotation import Vec, quat_rotate, vector_cross, vector_dot
from text2sim.compiler.slopes import tilted_copies
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.contact.sliding import friction_between
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import MAX_RESTING_GAP, flight_of
from text2sim.lint.rule import Rule
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import AXES

MAX_BODIES = 30
"""Most copies of a free body that are checked."""
MIN_CREEP = 1e-3
"""Shortest distance [m] over the run that is reported."""
MIN_SLOPE = 0.0087
"""Smallest slope [rad]."""
MAX_FLUSH_ANGLE = 0.0175
"""Largest angle [rad] between faces that lie flat on each other."""
CONTACTS_PER_FACE = 4
"""Contacts of a face."""
CONTACTS_PER_GRIP = 8
"""Contacts of a box between two jaws."""
NOSLIP, NOSLIP_SHARE = 10, 0.5
"""Noslip iterations that stop the creep of bodies that use less than this share of their friction."""
CONTACT_SOFTNESS = (1 - 0.9) / 0.9 * 0.95 / 2
"""(1 - dmin) / dmin * dmax / 2 of the engine's contact parameters."""


def creep_speed(pull: float, slope: float, friction: float, timeconst: float) -> float:
    """Return the speed [m/s] at which a face creeps on a slope that holds it.

    Args:
        pull: Gravity [m/s2].
        slope: Angle [rad]; its tangent is less than the friction.
        friction: Coefficient of friction.
        timeconst: Time constant [s] of contacts.
    """
    used = math.tan(slope) / friction
    share = used if used < 0.5 else 3 * used - 1
    return (
        share * friction * (1 + friction**2) * pull * math.cos(slope) / CONTACTS_PER_FACE * CONTACT_SOFTNESS * timeconst
    )


def grip_creep_speed(pull: float, friction: float, timeconst: float) -> float:
    """Return the speed [m/s] at which a box creeps down between jaws that press it with far more than its weight.

    Args:
        pull: Gravity [m/s2].
        friction: Coefficient of friction.
        timeconst: Time constant [s] of contacts.
    """
    return (1 + friction**2) * pull / CONTACTS_PER_GRIP * CONTACT_SOFTNESS * timeconst


def _creeping(facts: Facts) -> Iterator[Problem]:
    yield from _leaning(facts)
    yield from _gripped(facts)
    scene = facts.case.scene
    if facts.settings.cone != "pyramidal" or not facts.pull:
        return
    supports = list(_supports(facts))
    for name in facts.case.bodies if supports else ():
        found: list[tuple[float, float, float, Copy, Copy]] = []
        for copy in facts.placed[name][:MAX_BODIES]:
            if is_soft(copy.model) or not facts.free(copy) or copy.name in facts.velocities:
                continue
            for other, normal in supports:
                slope = math.acos(min(1.0, vector_dot(normal, facts.up)))
                friction = friction_between(facts, copy, other)
                stopped = scene.solver.noslip_iterations >= NOSLIP and math.tan(slope) < NOSLIP_SHARE * friction
                if math.tan(slope) < friction and not stopped and _lies_on(facts, copy, other, normal):
                    speed = creep_speed(facts.pull, slope, friction, facts.settings.timeconst)
                    found.append((speed, slope, friction, copy, other))
                    break
        if found and (worst := max(found, key=lambda row: row[0]))[0] * scene.duration > MIN_CREEP:
            yield _finding(facts, *worst, len(found))


def _leaning(facts: Facts) -> Iterator[Problem]:
    """Report free bodies that lean on each other while something carries both."""
    if facts.settings.cone != "pyramidal":
        return
    free = (copy for copy in facts.copies.values() if not is_soft(copy.model) and facts.free(copy))
    leaning = list(islice(tilted_copies(free, facts.case.scene.gravity), MAX_BODIES))
    gaps = Gaps(facts)
    for a, b in combinations(leaning, 2):
        if gaps.between(a, b, MAX_RESTING_GAP) < MAX_RESTING_GAP and _rests(facts, a) and _rests(facts, b):
            text = (
                f"`{a.name}` and `{b.name}` lean on each other and slide apart with the pyramidal friction cone (two "
                "cards of 90 mm at 20 deg: 2 mm in 2 s); set `friction_cone: elliptic` in scene.contact"
            )
            yield facts.problem("creeps", ("bodies", a.body), text, key=True)
            return


def _gripped(facts: Facts) -> Iterator[Problem]:
    """Report the first two jaws that close on each other, in a scene without deformable bodies, which they may hold."""
    scene, settings = facts.case.scene, facts.settings
    if settings.cone != "pyramidal" or settings.soft is not None or scene.solver.noslip_iterations >= NOSLIP:
        return
    for a, b in grips(facts.moving, facts.lowering.trees, facts.rows):
        jaws = [facts.copies[jaw.copy] for jaw in (a, b)]
        free = [copy for copy in facts.moving if facts.mount(copy) == "free"]
        friction = max(friction_between(facts, jaw, copy) for jaw in jaws for copy in free)
        speed = grip_creep_speed(facts.pull, friction, settings.timeconst)
        if speed * scene.duration > MIN_CREEP:
            text = (
                f"joints `{a.joint}` and `{b.joint}` close a grip; what friction holds in it creeps out with the "
                f"pyramidal friction cone, a box at about {1e3 * speed:.2g} mm/s, what has fewer contacts faster; set "
                f"`noslip_iterations: {NOSLIP}` in scene.solver, or `friction_cone: elliptic` in scene.contact if "
                "nothing hits chains or closed loops hard"
            )
            yield facts.problem("creeps", ("bodies", jaws[0].body), text, key=True)
            return


def _rests(facts: Facts, copy: Copy) -> bool:
    """Return whether a free copy starts neither in flight nor in free fall."""
    flight = flight_of(facts, copy)
    return flight is not None and not flight.moves


def _finding(facts: Facts, speed: float, slope: float, friction: float, copy: Copy, other: Copy, count: int) -> Problem:
    used = math.tan(slope) / friction
    text = (
        f"friction holds `{copy.name}` on `{other.name}` ({math.degrees(slope):.3g} deg, friction {friction:g})"
        f"{more_copies(count)}, but it creeps at {'about' if used < 0.9 else 'at least'} {1e3 * speed:.2g} mm/s, "
        f"{length(speed * facts.case.scene.duration)} in the run, because of the pyramidal friction cone; set "
        "`friction_cone: elliptic` in scene.contact"
    )
    text += f", or `noslip_iterations: {NOSLIP}` in scene.solver" if used < NOSLIP_SHARE else ", or use more substeps"
    return facts.problem("creeps", ("bodies", copy.body), text, key=True)


def _supports(facts: Facts) -> Iterator[tuple[Copy, Vec]]:
    """Yield slopes that do not move, with the normals of their upper faces."""
    up = facts.up
    for ground in facts.planes:
        if math.hypot(*vector_cross(ground.up, up)) > MIN_SLOPE:
            yield ground.copy, ground.up
    for copy in facts.copies.values():
        if facts.mount(copy) in ("static", "fixed", "driven") and getattr(copy.shape, "kind", "") == "box":
            turned = [quat_rotate(copy.quat, axis) for axis in AXES.values()]
            faces = [face for x, y, z in turned for face in ((x, y, z), (-x, -y, -z))]
            top = max(faces, key=lambda face: vector_dot(face, up))
            if math.hypot(*vector_cross(top, up)) > MIN_SLOPE:
                yield copy, top


def _lies_on(facts: Facts, copy: Copy, other: Copy, normal: Vec) -> bool:
    """Return whether a face of a copy lies flat on a slope."""
    kind = getattr(copy.shape, "kind", "")
    axes = ("x", "y", "z") if kind == "box" else ("z",) if kind in ("cylinder", "cup", "tube") else ()
    if not any(math.hypot(*vector_cross(quat_rotate(copy.quat, AXES[a]), normal)) < MAX_FLUSH_ANGLE for a in axes):
        return False
    low = min(part.lowest(normal) for part in facts.parts(copy))
    if (ground := facts.ground(other)) is not None:
        return abs(low - ground.level) < MAX_RESTING_GAP and ground.beside(copy.pos) < 0
    box, other_box = facts.box(copy), facts.box(other)
    if box is None or other_box is None or apart(box, other_box, -MAX_RESTING_GAP):
        return False
    top = -min(part.lowest((-normal[0], -normal[1], -normal[2])) for part in facts.parts(other))
    return abs(low - top) < MAX_RESTING_GAP


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
        title="A body that friction holds on a slope or in a grip creeps.",
        reason=f"""\
Contacts are regularised: static friction needs a little sliding, and with the pyramidal cone it is visible. A slope of
angle s uses the share u = tan(s) / m of the friction m. A face, which has {CONTACTS_PER_FACE} contacts, creeps at
`k m (1 + m^2) g cos(s) / {CONTACTS_PER_FACE}`, times u up to one half and 3 u - 1 above, with k =
{CONTACT_SOFTNESS:.3g} timeconst (measured to 15 %, friction 0.45 to 2, slopes of 5 and 20 deg; above u = 0.9 it slips
now and then, up to six times as fast). With the elliptic cone the creep is a hundredth of that. Scenes of free bodies
with slopes get the elliptic cone by default; trees of links, piles with cg, and bouncing bodies do not. In a grip, two
parts of mechanisms that motors close on each other, a box creeps at `k (1 + m^2) g / {CONTACTS_PER_GRIP}`, however firm
the grip (0.3 kg in a `clamp` of 25 N: 2.2 mm in 1.5 s; with the elliptic cone 0.009 mm); scenes with a grip and a free
body get the elliptic cone by default, unless something bounces, deforms, or has ball joints or closed loops. Cards
that lean on each other touch with one contact and slide apart by 1.9 mm in 2 s with the pyramidal cone; with the
elliptic one they stay within 10 micrometres (`tests/physics/test_friction.py`). Bodies that fall or fly do not
count.""",
        remedy="""\
Set `scene.contact.friction_cone: elliptic`. Otherwise set `solver: {noslip_iterations: 10}`, which stops bodies that
use less than half of their friction, or use more substeps: the creep is proportional to the time constant.""",
        example=_RAMP % "pyramidal",
        fix=_RAMP % "elliptic",
        run=_creeping,
        own_contact=True,
    ),
)
