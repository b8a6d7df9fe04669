"""Driven bodies that sweep through free ones faster than a contact can hold."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import strokes
from text2sim.compiler.schedules import extremes
from text2sim.compiler.shapes.boxes import Bounds, apart, grown, swept
from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_minus, vector_times, vector_unit
from text2sim.lint.contact.passing import Pass, hardest, stopping_time
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.start.escape import AXES
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.motion import Spin

MAX_COPIES = 24
"""Most copies of a driven body that are checked."""


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
    for velocity, ways in strokes(motion):
        yield velocity, swept(part.box, ways)
