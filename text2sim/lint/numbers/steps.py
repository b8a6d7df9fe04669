"""The time step against what goes on within it: spinning, schedules.

Spinning. What turns by more than half a radian within a substep is tested for contact at every twelfth of a turn only.

Schedules. Targets and forces are set once in each time step (not substep). A sine with fewer than two steps in a cycle
shows another, slower one (Nyquist); with fewer than eight it is coarse.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import ceil
from typing import Any

from text2sim.compiler.schedules import extremes
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.mechanics import mechanics_of
from text2sim.lint.joints.motors import amount, one_each
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.controls import Drive, Force, InitialVelocity, Torque
from text2sim.spec_schema.models.motion import Oscillate, Piecewise, Ramp, Sine, Spin, Steps, Waypoints
from text2sim.spec_schema.text.document import Path

SPIN = 0.5
"""Turn [rad] within a substep that is worth a word."""
COARSE = 8
"""Time steps in a cycle below which a sine is coarse."""


# --- spinning ------------------------------------------------------------------------------------------------------


def _spin(facts: Facts) -> Iterator[Problem]:
    h, dt = facts.substep, facts.case.scene.dt
    for where, speed in _spins(facts):
        if speed * h > SPIN:
            text = (
                f"at {speed:.3g} rad/s it turns by {speed * h:.2g} rad within a substep, and misses what it passes "
                f"meanwhile; scene.substeps of {ceil(dt * speed / SPIN)} would be needed, or {SPIN / h:.3g} rad/s"
            )
            yield facts.problem("fast-spin", where, text)


def _spins(facts: Facts) -> Iterator[tuple[Path, float]]:
    """Places of the case that make something turn, and how fast [rad/s]."""
    for row in facts.rows.velocities:
        control = facts.case.actions.controls[row.control]
        if isinstance(control, InitialVelocity) and any(row.angular):
            speed = sum(w * w for w in row.angular) ** 0.5
            yield ("actions", "controls", row.control, "angular"), speed
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            if isinstance(copy.model, Driven) and isinstance(copy.model.motion, Spin):
                yield ("bodies", name, "motion", "speed"), max(map(abs, extremes(copy.model.motion.speed)))
    mechanics = mechanics_of(facts)
    for (entity, joint), spans in spans_of(facts).items():
        for span in spans:
            if span.mode == "velocity":
                swing = mechanics.swing(facts.copies[entity], joint)
                if swing is not None and swing.hinge:
                    yield span.where, max(map(abs, span.extremes()))


# --- schedules -----------------------------------------------------------------------------------------------------


def _schedules(facts: Facts) -> Iterator[tuple[Path, Any]]:
    """Everything that changes with time, and where it stands."""
    for name, control in facts.case.actions.controls.items():
        where = ("actions", "controls", name)
        if isinstance(control, Drive):
            for mode in ("position", "velocity", "force"):
                if getattr(control, mode) is not None:
                    yield (*where, mode), getattr(control, mode)
        elif isinstance(control, Force | Torque):
            yield (*where, "scale"), control.scale
    for name, body in facts.case.bodies.items():
        if isinstance(body, Driven):
            where = ("bodies", name, "motion")
            yield ((*where, "speed"), body.motion.speed) if isinstance(body.motion, Spin) else (where, body.motion)


def _fast(facts: Facts) -> Iterator[Problem]:
    dt = facts.case.scene.dt
    for where, schedule in _schedules(facts):
        if isinstance(schedule, Sine | Oscillate):
            steps = 1 / (schedule.frequency * dt)
            if steps >= COARSE:
                continue
            then = "is coarse" if steps >= 2 else "shows as another, slower one"
            text = (
                f"{schedule.frequency:g} Hz {then}: a cycle has {steps:.2g} time steps; it needs scene.dt of "
                f"{1 / (2.5 * COARSE * schedule.frequency):.1g} or less, or {1 / (COARSE * dt):.3g} Hz at most"
            )
            yield facts.problem("fast-schedule", (*where, "frequency"), text)
        elif isinstance(schedule, Ramp) and schedule.end - schedule.start < dt * (1 - 1e-6):
            text = (
                f"this ramp of {amount((schedule.end - schedule.start) * 1e3, 'ms')} is over within one time step "
                f"({amount(dt * 1e3, 'ms')}), and is a jump; make it longer, or say `steps`"
            )
            yield facts.problem("fast-schedule", where, text)
        elif isinstance(schedule, Steps | Piecewise | Waypoints):
            for index, (a, b) in enumerate(pairwise(schedule.times)):
                if b - a < dt * (1 - 1e-6):
                    text = (
                        f"{a:g} s and {b:g} s lie within one time step ({amount(dt * 1e3, 'ms')}), in which nothing "
                        f"can change; leave one out, or take scene.dt of {(b - a):.2g}"
                    )
                    yield facts.problem("fast-schedule", (*where, "times", index + 1), text)
                    break


_TURNED = """\
scene: {substeps: 1}
bodies:
  blade: {kind: rigid, shape: {kind: box, size: [0.5, 0.05, 0.02]}, pose: {pos: [0, 0, 0.5]}}
actions:
  controls:
    spin: {kind: initial_velocity, body: blade, angular: [0, 0, %s]}
"""
_SHAKEN = """\
bodies:
  sieve:
    kind: driven
    shape: {kind: box, size: [0.3, 0.3, 0.02]}
    motion: {kind: oscillate, axis: x, amplitude: 0.005, frequency: %s}
    pose: {pos: [0, 0, 0.3]}
"""

RULES = (
    Rule(
        id="fast-spin",
        severity="warning",
        title="Something turns too far within a substep.",
        reason="""\
Contacts are looked for once in each substep. What turns by more than half a radian meanwhile reaches into others, or
jumps past them, before it is seen.""",
        remedy="More substeps, or a slower turn.",
        example=_TURNED % "120",
        fix=_TURNED % "12",
        run=lambda facts: one_each(_spin(facts)),
    ),
    Rule(
        id="fast-schedule",
        severity="warning",
        title="A schedule changes faster than the time step.",
        reason="""\
Targets, forces and prescribed motions are set once in each time step. A sine with fewer than two steps in a cycle shows
as another, slower one, with fewer than eight it is coarse; a ramp that is over within a step is a jump, and of two
values within one step only one is seen.""",
        remedy="A shorter `scene.dt`, or a slower schedule.",
        example=_SHAKEN % "30",
        fix=_SHAKEN % "10",
        run=lambda facts: one_each(_fast(facts)),
    ),
)
