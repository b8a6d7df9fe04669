"""Beams that are too stiff for the time step."""

import math
from collections.abc import Iterator

from text2sim.compiler.settings import SPRING_STEP
from text2sim.compiler.trees.beams import first_frequency, shaking_frequency
from text2sim.lint.facts import Facts
from text2sim.lint.joints.ropes import MAX_SUBSTEPS
from text2sim.lint.rule import Rule
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.soft_bodies import Beam
from text2sim.spec_schema.rounding import at_least

MAX_PHASE = 1.6
"""Largest substep times angular frequency at which a beam is trusted. The theory's limit is 2: the steel ruler of the
example diverged at 2.2 and held at 1.9."""


def _shaken(facts: Facts) -> Iterator[Problem]:
    dt, step = facts.case.scene.dt, facts.substep
    for name in facts.case.bodies:
        beam = facts.placed[name][0].model if facts.placed[name] else None
        if not isinstance(beam, Beam) or shaking_frequency(beam) * step <= MAX_PHASE:
            continue
        frequency = shaking_frequency(beam)
        wanted = math.ceil(dt * frequency / SPRING_STEP)
        steps = f"scene.substeps of {wanted}"
        if wanted > MAX_SUBSTEPS:
            steps = f"scene.dt of {MAX_SUBSTEPS * SPRING_STEP / frequency:.1g} s with scene.substeps of {MAX_SUBSTEPS}"
        ratio = step * first_frequency(beam) / 2 / SPRING_STEP
        damped = f", a damping_ratio of {at_least(ratio)}" if ratio <= 1 else ""
        text = (
            f"`{name}` flies apart at substeps of {amount(1e3 * step, 'ms')}: its links are too stiff and too light; "
            f"use {steps}{damped}, or a smaller youngs_modulus"
        )
        yield facts.problem("stiff-beam", ("bodies", name), text, key=True)


_RULER = """\
scene: {dt: 0.005, substeps: %s}
bodies:
  ruler:
    kind: beam
    size: [0.3, 0.03, 0.001]
    youngs_modulus: 2.0e11
    damping_ratio: 0.01
    material: {density: 7800}
    pose: {pos: [0, 0, 1]}
"""

RULES = (
    Rule(
        id="stiff-beam",
        title="A beam flies apart at this time step.",
        reason=f"""\
The engine integrates the springs between links explicitly, and their damping implicitly. With the substep h and the
angular frequency w of the fastest mode, the links to and fro, sqrt(48 E I / (rho A)) / l^2, of damping ratio z, this
is stable up to h w = 2 (z + sqrt(1 + z^2)). Damping in proportion to stiffness makes z large for the fastest mode: up
to h = 4 times `damping_ratio` over the first angular frequency a beam is stable however many links it has. The ruler
below diverged at 1.1 of the limit and held at 0.96; the rule allows {MAX_PHASE / 2:g}. Derived
substeps are short enough, but there are at most 50 in a step.""",
        remedy="""\
Leave `scene.substeps` out or use more; use a shorter `dt`, more damping, or a smaller Young's modulus.""",
        example=_RULER % 4,
        fix=_RULER % 16,
        run=_shaken,
    ),
)
