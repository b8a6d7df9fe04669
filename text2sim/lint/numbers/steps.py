"""Rotations and schedules that are too fast for the time step.

A body that turns by more than half a radian per substep is tested for contact only at every twelfth of a turn. Targets
and forces are set once per time step (not substep). A sine with fewer than two steps per cycle aliases to a slower one
(Nyquist); with fewer than eight it is coarse.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import ceil, hypot
from typing import Any

from text2sim.compiler.schedules import extremes
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount, length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated, Driven
from text2sim.spec_schema.models.controls import Drive, InitialVelocity
from text2sim.spec_schema.models.motion import Oscillate, Piecewise, Ramp, Sine, Spin, Steps, Waypoints
from text2sim.spec_schema.rounding import at_most
from text2sim.spec_schema.text.document import Path

MAX_SPIN_PER_SUBSTEP = 0.5
"""Largest rotation [rad] per substep without a warning."""
MIN_STEPS_PER_CYCLE = 8
"""Fewest time steps per cycle of a sine without a warning."""


# --- spinning ------------------------------------------------------------------------------------------------------


@one_per_place
def _spin(facts: Facts) -> Iterator[Problem]:
    h, dt = facts.substep, facts.case.scene.dt
    for where, speed in _spins(facts):
        if speed * h > MAX_SPIN_PER_SUBSTEP:
            text = (
                f"at {speed:.3g} rad/s it turns by {speed * h:.2g} rad per substep and misses contacts in between; use "
                f"scene.substeps of {ceil(dt * speed / MAX_SPIN_PER_SUBSTEP)}, or at most "
                f"{at_most(MAX_SPIN_PER_SUBSTEP / h)} rad/s"
            )
            yield facts.problem("fast-spin", where, text)


def _spins(facts: Facts) -> Iterator[tuple[Path, float]]:
    """Yield the paths of values that make bodies turn, and the speed [rad/s]."""
    for row in facts.rows.velocities:
        control = facts.case.actions.controls[row.control]
        if isinstance(control, InitialVelocity) and any(row.angular):
            yield ("actions", "controls", row.control, "angular"), hypot(*row.angular)
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            if isinstance(copy.model, Driven) and isinstance(copy.model.motion, Spin):
                yield ("bodies", name, "motion", "speed"), max(map(abs, extremes(copy.model.motion.speed)))
    mechanics = facts.once(Mechanics)
    for entity, speeds in facts.lowering.joint_velocities.items():
        copy = facts.copies[entity]
        for name, speed in speeds.items():
            joint = mechanics.joint(copy, name)
            if joint is not None and joint.hinge:
                where = ("links", name, "joint") if isinstance(copy.model, Articulated) else ("mount",)
                yield ("bodies", copy.body, *where, "initial_velocity"), abs(speed)
    for (entity, name), spans in spans_of(facts).items():
        for span in spans:
            if span.mode == "velocity":
                joint = mechanics.joint(facts.copies[entity], name)
                if joint is not None and joint.hinge:
                    yield span.where, max(map(abs, span.extremes()))


# --- schedules -----------------------------------------------------------------------------------------------------


def _schedules(facts: Facts) -> Iterator[tuple[Path, Any]]:
    """Yield the schedules of controls and motions, with their paths."""
    for name, control in facts.case.actions.controls.items():
        where = ("actions", "controls", name)
        if isinstance(control, Drive):
            for mode in ("position", "velocity", "force"):
                if getattr(control, mode) is not None:
                    yield (*where, mode), getattr(control, mode)
        elif (scale := getattr(control, "scale", None)) is not None:
            yield (*where, "scale"), scale
    for name, body in facts.case.bodies.items():
        if isinstance(body, Driven):
            where = ("bodies", name, "motion")
            yield ((*where, "speed"), body.motion.speed) if isinstance(body.motion, Spin) else (where, body.motion)


@one_per_place
def _fast(facts: Facts) -> Iterator[Problem]:
    dt = facts.case.scene.dt
    for where, schedule in _schedules(facts):
        if isinstance(schedule, Sine | Oscillate):
            steps = 1 / (schedule.frequency * dt)
            if steps >= MIN_STEPS_PER_CYCLE:
                continue
            then = "is coarse" if steps >= 2 else "aliases to a slower frequency"
            text = (
                f"{schedule.frequency:g} Hz {then}: a cycle has {steps:.2g} time steps; use scene.dt of "
                f"{1 / (2.5 * MIN_STEPS_PER_CYCLE * schedule.frequency):.1g} or less, or at most "
                f"{1 / (MIN_STEPS_PER_CYCLE * dt):.3g} Hz"
            )
            yield facts.problem("fast-schedule", (*where, "frequency"), text)
        elif isinstance(schedule, Ramp) and schedule.end - schedule.start < dt * (1 - 1e-6):
            text = (
                f"this ramp of {amount((schedule.end - schedule.start) * 1e3, 'ms')} ends within one time step "
                f"({amount(dt * 1e3, 'ms')}) and is a jump; make it longer, or use `steps`"
            )
            yield facts.problem("fast-schedule", where, text)
        elif isinstance(schedule, Steps | Piecewise | Waypoints):
            if isinstance(schedule, Waypoints) and (jump := hypot(*schedule.positions[0])):
                text = (
                    "positions are displacements from `pose`, where the body is at the start: the first one is a jump "
                    f"of {length(jump)}; begin with [0, 0, 0]"
                )
                yield facts.problem("fast-schedule", (*where, "positions", 0), text)
            for index, (a, b) in enumerate(pairwise(schedule.times)):
                if b - a < dt * (1 - 1e-6):
                    text = (
                        f"{a:g} s and {b:g} s are within one time step ({amount(dt * 1e3, 'ms')}), in which nothing "
                        f"can change; leave one out, or use scene.dt of {at_most(b - a)}"
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
        title="A body turns too far within a substep.",
        reason="""\
The engine detects contacts once per substep. A body that turns by more than half a radian in that time enters others,
or jumps past them, before the contact is detected.""",
        remedy="Use more substeps, or a slower rotation.",
        example=_TURNED % "120",
        fix=_TURNED % "12",
        run=_spin,
    ),
    Rule(
        id="fast-schedule",
        title="A schedule changes faster than the time step.",
        reason="""\
Targets, forces and prescribed motions are set once per time step. A sine with fewer than two steps per cycle aliases to
a slower one, with fewer than eight it is coarse; a ramp that ends within a step is a jump, and so is a first waypoint
away from the start; of two values within one step only one has an effect.""",
        remedy="Use a shorter `scene.dt`, or a slower schedule.",
        example=_SHAKEN % "30",
        fix=_SHAKEN % "10",
        run=_fast,
    ),
)
