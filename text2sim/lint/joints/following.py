"""Motors that do not follow their targets; see `motors` for the engine's model.

A change of position by d within T takes an acceleration of at least 4 d / T2 from rest to rest (half the time up, half
down), a change of speed one of dv / T. So it takes a force of at least `(I + h kv) a + load`, where the load is the
mean gravity along the change, dry friction and joint damping. A servo of stiffness kp and damping kv oscillates with
the damping ratio `(kv + d) / (2 sqrt(kp I))`. A velocity motor runs where `kv (wanted - v) = d v + load`.
"""

from collections.abc import Iterator
from math import inf, pi, sqrt

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Demand, demands
from text2sim.lint.joints.motors import Powered, powered
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_least

MAX_SLOWNESS = 1.5
"""A motor is slow if a change takes this many times as long as the target's."""
MIN_RATIO = 0.05
"""Damping ratio below which a servo oscillates more than three times before it loses nine tenths of its amplitude."""
MIN_MISSING_SPEED = 0.1
"""Missing share of the speed of a velocity motor that is reported."""


@one_per_place
def _slow_motors(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        if motor.limit == inf or (motor.joint.closed and motor.linkage is None):
            continue
        # In a floating tree, both sides of the joint move, and in a linkage, other links move otherwise than in an open
        # tree, so only the force for the motor's damping is certain.
        own = 0.0 if motor.joint.floating or motor.linkage is not None else motor.joint.inertia
        inertia = own + facts.substep * motor.damping
        found = []
        for span in motor.spans:
            for demand in demands(span) if span.mode != "force" else ():
                load = 0.0 if motor.joint.floating else _load(motor, demand, span.mode)
                needed = inertia * demand.acceleration + load
                ratio = inertia * demand.acceleration / max(motor.limit - load, 1e-3 * needed, 1e-12)
                longer = sqrt(ratio) if span.mode == "position" else ratio
                if needed > motor.limit and longer >= MAX_SLOWNESS:
                    found.append((longer, needed, load, demand, span))
        if not found:
            continue
        longer, needed, load, demand, span = max(found, key=lambda entry: entry[0])
        unit, force = motor.joint.units
        speed = span.mode == "velocity"
        rotor = facts.substep * motor.damping * demand.acceleration
        parts = [f"{amount(own * demand.acceleration, force)} for its inertia"] * (own > 0.0)
        parts += [f"{amount(rotor, force)} for the motor's damping (x substep)"] * (rotor > 0.05 * needed)
        parts += [f"{amount(load, force)} for its load"] * (load > 0.01 * needed)
        later = f"allow {at_least(longer)} times as long" if load < motor.limit else "reduce its load"
        text = (
            f"`{motor.label}` cannot keep up: {demand.first:.3g} to {demand.last:.3g} {unit}{'/s' * speed} within "
            f"{demand.end - demand.start:.3g} s takes {amount(needed, force)} ({', '.join(parts)}), and its motor "
            f"gives {amount(motor.limit, force)}; give the motor a max_force of {at_least(1.2 * needed)}, or {later}"
        )
        yield facts.problem("slow-motor", span.where, text)


def _load(motor: Powered, demand: Demand, mode: str) -> float:
    """Return the mean force against the motor during a change; 0 if gravity helps it."""
    sign = 1.0 if demand.last > demand.first else -1.0
    load = motor.joint.spec.friction + motor.joint.spec.damping * demand.speed
    if mode == "position":
        points = [demand.first + k / 4 * (demand.last - demand.first) for k in range(5)]
        load -= sign * sum(motor.load(q) for q in points) / 5
    elif not motor.joint.hinge and motor.linkage is None:
        load -= sign * motor.joint.pull[0]
    return max(0.0, load)


@one_per_place
def _short_of_speed(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        joint, spec = motor.joint, motor.joint.spec
        for span in motor.spans:
            wanted = max(span.extremes(), key=abs)
            if span.mode != "velocity" or wanted == 0.0 or not motor.alone or motor.damping <= 0.0 or spec.spring:
                continue
            sense = 1.0 if wanted > 0.0 else -1.0
            load = max(0.0, spec.friction - (0.0 if joint.hinge else sense * joint.pull[0]))
            reached = (motor.damping * abs(wanted) - load) / (motor.damping + spec.damping)
            key, better = "damping", (load + spec.damping * abs(wanted)) / (0.02 * abs(wanted))
            if spec.damping > 0.0 and (motor.limit - load) / spec.damping < reached:
                reached = (motor.limit - load) / spec.damping
                key, better = "max_force", 1.2 * (load + spec.damping * abs(wanted))
            missing = min([MIN_MISSING_SPEED * abs(wanted), *motor.tolerances("joint_velocity")])
            if not 0.0 < reached < abs(wanted) - missing:
                continue
            unit, force = joint.units
            against = [f"joint damping {spec.damping:g}"] * (spec.damping > 0) + [amount(load, force)] * (load > 0)
            text = (
                f"`{motor.label}` will run at {amount(sense * reached, unit)}/s instead of {wanted:.3g}: its motor "
                f"works against {' and '.join(against)} with a force of damping {motor.damping:g} times the missing "
                f"speed; give it a {key} of {at_least(better)}"
            )
            yield facts.problem("short-speed", motor.where(key), text)
            break


@one_per_place
def _oscillating(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        spec, inertia = motor.joint.spec, motor.joint.inertia
        if motor.stiffness <= 0.0 or not any(span.mode == "position" for span in motor.spans):
            continue
        ratio = (motor.damping + spec.damping) / (2 * sqrt((motor.stiffness + spec.spring) * inertia))
        if ratio >= MIN_RATIO or spec.friction > 0.0 or motor.joint.closed:
            continue
        period = 2 * pi * sqrt(inertia / (motor.stiffness + spec.spring))
        text = (
            f"`{motor.label}` will oscillate about its target every {amount(period, 's')} and hardly come to rest: the "
            f"damping ratio of its servo is {ratio:.2g}; damping {at_least(motor.critical(motor.stiffness))} makes it 1"
        )
        yield facts.problem("swinging-servo", motor.where("damping"), text)


_PUSHER = """\
bodies:
  pusher:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.3, 0.1]}
    material: {mass: 5.0}
    pose: {pos: [0, 0, 0.2]}
    mount: {kind: slider, axis: x, actuator: {%s}}
actions:
  controls:
    push: {kind: drive, joint: pusher, %s}
"""

RULES = (
    Rule(
        id="slow-motor",
        title="A motor is too weak to follow its schedule.",
        reason="""\
A change of position by d within T takes an acceleration of at least `4 d / T^2`, a change of speed one of `dv / T`. The
force is that times the inertia of everything beyond the joint, plus gravity along the change, dry friction and joint
damping. The engine adds `damping x substep` of the motor to that inertia, so a large damping makes a limited motor
slower still. The rule reports changes that would take at least 1.5 times as long as specified.""",
        remedy="Raise `max_force`, allow more time, or lower a damping that counts as inertia.",
        example=_PUSHER % ("stiffness: 4000, damping: 200, max_force: 20", "position: {kind: ramp, to: 0.5, end: 0.4}"),
        fix=_PUSHER % ("stiffness: 4000, damping: 200, max_force: 120", "position: {kind: ramp, to: 0.5, end: 0.4}"),
        run=_slow_motors,
    ),
    Rule(
        id="short-speed",
        title="A velocity motor will not reach its speed.",
        reason="""\
The force of a velocity motor is its damping times the missing speed. Against dry friction, joint damping or gravity it
runs where both are equal: `kv (wanted - v) = d v + load`. The rule reports a missing speed of more than a tenth, or
more than the tolerance of an expectation of the joint's velocity.""",
        remedy="Raise the actuator's `damping` to fifty times the resistance at full speed, over that speed.",
        example=_PUSHER.replace("axis: x", "axis: x, damping: 20") % ("damping: 30", "velocity: 0.2"),
        fix=_PUSHER.replace("axis: x", "axis: x, damping: 20") % ("damping: 1000", "velocity: 0.2"),
        run=_short_of_speed,
    ),
    Rule(
        id="swinging-servo",
        title="A position servo has almost no damping.",
        reason="""\
A servo with stiffness kp, damping kv and a load of inertia I oscillates about its target with the damping ratio
`kv / (2 sqrt(kp I))`. Below 0.05 it oscillates many times; without damping, forever.""",
        remedy="Give the actuator a `damping` of about `2 sqrt(stiffness x inertia)`.",
        example=_PUSHER % ("stiffness: 2000", "position: 0.2"),
        fix=_PUSHER % ("stiffness: 2000, damping: 200", "position: 0.2"),
        run=_oscillating,
    ),
)
