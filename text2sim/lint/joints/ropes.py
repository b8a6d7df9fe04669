"""Light ropes and chains that carry heavy loads, at time steps that are too long for them."""

import math
from collections.abc import Iterator

from text2sim.compiler.rope_frequencies import TENSION_FACTOR, taut_frequencies
from text2sim.compiler.settings import TAUT_STEP
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem

MAX_PHASE = 1.4
"""Largest substep times angular frequency at which a taut rope holds (measured)."""
MAX_SUBSTEPS = 200
"""Largest number of substeps that is recommended."""


def _shaken(facts: Facts) -> Iterator[Problem]:
    scene, seen = facts.case.scene, set()
    taut = taut_frequencies(facts.lowering, facts.plan.bodies, facts.moving, facts.rows, scene.gravity)
    for name, frequency in sorted(taut.items(), key=lambda row: -row[1]):
        body = facts.copies[name].body
        if frequency * facts.substep <= MAX_PHASE or body in seen:
            continue
        seen.add(body)
        wanted = math.ceil(scene.dt * frequency / TAUT_STEP)
        steps = f"scene.substeps of {wanted}"
        if wanted > MAX_SUBSTEPS:
            steps = f"scene.dt of {MAX_SUBSTEPS * TAUT_STEP / frequency:.1g} s with scene.substeps of {MAX_SUBSTEPS}"
        text = (
            f"`{name}` is light for its load: taut, its links vibrate at {frequency:.3g} rad/s and fly apart at a "
            f"substep of {1e3 * facts.substep:.3g} ms; use {steps}, fewer and longer links, a heavier rope or a "
            "lighter load"
        )
        yield facts.problem("rope-load", ("bodies", body), text, key=True)


_ROPE = """\
scene: {dt: 0.005, substeps: %s}
bodies:
  rope: {kind: rope, length: 1.0, radius: 0.004, segments: 20, material: {mass: 0.05}, pose: {pos: [0, 0, 2]}}
  load: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 10}, pose: {pos: [0, 0, 0.94]}}
actions:
  controls: {tie: {kind: attach, body: rope.link_19, to: load}}
"""

RULES = (
    Rule(
        id="rope-load",
        title="A light rope or chain carries so much that its links fly apart at this time step.",
        reason=f"""\
Links of mass m and length l under the tension T vibrate transversely at up to 2 sqrt(T / (m l)), and the engine
integrates this explicitly: with 2 to 40 kg on links of 2.5 g a struck rope diverged at substeps of 1.5 over this
frequency and more, and held at {MAX_PHASE:g}. The rule takes T as {TENSION_FACTOR:g} times the weight of the rope, its
payload and attached bodies. Passive links in a row of an articulated body count as a chain, and armature as mass.
Derived substeps are short enough, but there are at most 50 in a step.""",
        remedy="""\
Leave `scene.substeps` out or use more; use a shorter `dt`, fewer links, a heavier rope or a lighter load.""",
        example=_ROPE % 1,
        fix=_ROPE % 14,
        run=_shaken,
    ),
)
