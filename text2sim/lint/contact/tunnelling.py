"""Bodies so fast that they pass through others before the engine detects the contact."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import strokes
from text2sim.compiler.schedules import extremes
from text2sim.compiler.shapes.boxes import Bounds, apart, grown, swept
from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_dot, vector_minus, vector_times, vector_unit
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.contact.passing import Pass, hardest, stopping_time, width
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import flight_of
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import AXES
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.motion import Spin
from text2sim.spec_schema.text.document import Path

MAX_BODIES = 24
"""Most bodies whose path is followed; the fastest come first."""
MAX_COPIES = 24
"""Most copies of a driven body that are checked."""


def _tunnelling(facts: Facts) -> Iterator[Problem]:
    """Report each pair of bodies once."""
    found: dict[tuple[str, str], list[Pass]] = {}
    for row in (*_flying(facts), *sweeping(facts)):
        found.setdefault((row.mover.body, row.other.body), []).append(row)
    for rows in found.values():
        row = max(rows, key=lambda row: row.speed / row.room)
        yield facts.problem("tunnelling", row.where, _text(facts, row, len(rows)), key=True)


def _text(facts: Facts, row: Pass, count: int) -> str:
    settings, dt = facts.settings, facts.case.scene.dt
    h = facts.substep
    text = (
        f"`{row.mover.name}` meets `{row.other.name}` at {row.speed:.3g} m/s{more_copies(count)} and moves "
        f"{length(row.speed * stopping_time(facts))} before the contact holds it (substep {h:.3g} s, timeconst "
        f"{settings.timeconst:.3g} s), but is past its middle after {length(row.room)}: it may pass through; "
    )
    # Substeps of this length, and a timeconst of two of them, stop it in time.
    needed = math.ceil(dt * row.speed / row.room)
    if needed > 200 or max(0.002, 2 * dt / needed) / math.e * row.speed > row.room:
        more = 2 * (max(0.002 / math.e, h) * row.speed - row.room)
        return text + f"make one of them {length(more)} thicker, or make it slower"
    if facts.case.scene.contact.timeconst is None:
        return text + f"use scene.substeps of {max(needed, settings.substeps + 1)} or more"
    return text + f"use scene.substeps of {needed} or more and a shorter scene.contact.timeconst"


def _flying(facts: Facts) -> Iterator[Pass]:
    """Yield the bodies that are thrown or fall."""
    for copy in _fastest(facts):
        flight = flight_of(facts, copy)
        if flight is None or flight.meeting is None:
            continue
        meeting, parts = flight.meeting, facts.parts(copy)
        other = meeting.other
        if is_soft(other.model):  # see `lint.soft`
            continue
        if meeting.part is None:
            ground = facts.ground(other)
            assert ground is not None
            speed = -vector_dot(meeting.velocity, ground.up)
            room = width(parts, ground.up)
        else:
            speed, room = hardest(parts, meeting.part, meeting.velocity)
        if speed * stopping_time(facts) > room:
            yield Pass(copy, other, speed, room, _blame(facts, copy))


def _fastest(facts: Facts) -> list[Copy]:
    """Return the free bodies that may become fast enough to pass anything, the fastest first."""
    pull, tau, duration = facts.pull, stopping_time(facts), facts.case.scene.duration
    lowest = _lowest(facts)
    found = []
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            if not facts.free(copy):
                continue
            start = math.hypot(*facts.velocities.get(copy.name, (0.0, 0.0, 0.0)))
            fall = max(vector_dot(facts.up, copy.pos) - lowest, 0.0) if pull else 0.0
            speed = min(math.sqrt(start**2 + 2 * pull * fall), start + pull * duration)
            if speed * tau > facts.thinnest(copy) / 2:
                found.append((speed, len(found), copy))
    return [copy for _, _, copy in sorted(found, reverse=True)[:MAX_BODIES]]


def _lowest(facts: Facts) -> float:
    """Return the height [m] against gravity below which there is nothing to meet; 0 without gravity."""
    if not facts.pull:
        return 0.0
    corners = [corner for copy in facts.copies.values() if (box := facts.box(copy)) is not None for corner in box]
    points = [*(ground.copy.pos for ground in facts.planes), *corners]
    return min((vector_dot(facts.up, point) for point in points), default=0.0)


def _blame(facts: Facts, copy: Copy) -> Path:
    """Return the path of the control that gives a body its speed; else of the pose that puts it so high."""
    rows = [row for row in facts.rows.velocities if row.entity == copy.name]
    return ("actions", "controls", rows[0].control) if rows else facts.first_given(copy.body, "pose", "place", "repeat")


def sweeping(facts: Facts) -> Iterator[Pass]:
    """Yield the driven bodies that may pass through free ones, which are in their way at the start."""
    free = [copy for name in facts.case.bodies for copy in facts.placed[name] if facts.free(copy)]
    for name, body in facts.case.bodies.items():
        if not isinstance(body, Driven) or not free:
            continue
        for copy in facts.placed[name][:MAX_COPIES]:
            yield from _sweeping(facts, copy, free)


def _sweeping(facts: Facts, copy: Copy, free: list[Copy]) -> Iterator[Pass]:
    for part in facts.parts(copy):
        for velocity, around in _motions(copy, part):
            quick = math.hypot(*velocity)
            if quick * stopping_time(facts) <= part.thickness / 2:
                continue
            for other in free:
                box = facts.box(other)
                if box is None or apart(around, box):
                    continue
                for piece in facts.parts(other):
                    speed, room = hardest([part], piece, velocity)
                    if speed * stopping_time(facts) > room:
                        yield Pass(copy, other, speed, room, facts.where(copy.body, "motion"))
                        break


def _motions(copy: Copy, part: StandingPart) -> Iterator[tuple[Vec, Bounds]]:
    """Yield the highest velocities [m/s] of a piece of a driven body, each with the box that it sweeps."""
    motion = copy.model.motion
    if isinstance(motion, Spin):
        axis, rate = vector_unit(motion.axis), max(map(abs, extremes(motion.speed)))
        for direction in AXES:  # in which its ends are
            arm = vector_minus(part.solid.support(direction), copy.pos)
            reach = math.hypot(*arm) + part.solid.rounding
            velocity = vector_times(vector_cross(axis, arm), rate)
            if any(velocity):
                yield velocity, grown((copy.pos, copy.pos), reach)
        return
    for velocity, displacements in strokes(motion):
        yield velocity, swept(part.box, displacements)


RULES = (
    Rule(
        id="tunnelling",
        title="A body is so fast that it may pass through another.",
        reason="""\
The engine detects contacts once per substep. A contact holds a body only after a substep, or after its timeconst over
e, whichever is longer. A body that moves farther in that time than half of both thicknesses is past the middle and is
pushed out on the far side (measured: balls and cubes of 40 mm against plates of 2 to 50 mm; up to that bound none
passes, at 1.15 times as much a quarter does, at 1.7 times half of them). A body passes a plane if it is entirely below
it when the contact is first detected.

The rule follows bodies that are thrown or fall up to the first body they meet, and checks driven bodies against those
in their way at the start. Substeps that the compiler derives take start velocities and impulses into account, but not
falls.""",
        remedy="""\
Use more `scene.substeps`; the timeconst follows unless the case gives it. Or make one of the two bodies thicker.""",
        example="""\
scene: {dt: 0.01, substeps: 2, statics: {plate: {shape: {kind: box, size: [1, 0.01, 1]}, pose: {pos: [0, 2, 0.5]}}}}
bodies:
  shot: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.8]}}
actions:
  controls:
    launch: {kind: initial_velocity, body: shot, linear: [0, 12, 0]}
""",
        fix="scene: {substeps: 8}",
        run=_tunnelling,
        own_contact=True,
    ),
)
