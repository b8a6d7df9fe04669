"""Rules about motors that do not keep up with their targets: see `motors` for what the engine does.

A change of a position by d within T takes an acceleration of at least 4 d / T2 from rest to rest (half the time up,
half down), a change of a speed one of dv / T. So the force that it takes is at least `(I + h kv) a + load`, the load
being gravity on the mean along the way, dry friction and joint damping. A servo of stiffness kp and damping kv swings
with the damping ratio `(kv + d) / (2 sqrt(kp I))`. A velocity motor runs where `kv (wanted - v) = d v + load`.
"""

from collections.abc import Iterator
from math import inf, pi, sqrt

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Demand, demands
from text2sim.lint.joints.motors import Powered, amount, at_least, one_each, powered
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem

LATE = 1.5
"""A motor is slow if a change takes this many times longer than the target's."""
LIMP = 0.05
"""Damping ratio below which a servo swings more than three times before it has lost nine tenths of its swing."""
SHORT = 0.1
"""Missing part of the speed of a velocity motor that is worth a word."""


def _slow(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        if motor.limit == inf or motor.swing.closed:
            continue
        # Of a tree that moves freely, what hangs on the other side of the joint gives way, and what it carries turns
        # with it: only what the motor's own damping takes is known to be needed.
        own = 0.0 if motor.swing.floating else motor.swing.inertia
        inertia = own + facts.substep * motor.damping
        found = []
        for span in motor.spans:
            for demand in demands(span) if span.mode != "force" else ():
                load = 0.0 if motor.swing.floating else _load(motor, demand, span.mode)
                needed = inertia * demand.acceleration + load
                ratio = inertia * demand.acceleration / max(motor.limit - load, 1e-3 * needed, 1e-12)
                longer = sqrt(ratio) if span.mode == "position" else ratio
                if needed > motor.limit and longer >= LATE:
                    found.append((longer, needed, load, demand, span))
        if not found:
            continue
        longer, needed, load, demand, span = max(found, key=lambda entry: entry[0])
        unit, force = motor.swing.units
        speed = span.mode == "velocity"
        rotor = facts.substep * motor.damping * demand.acceleration
        parts = [f"{amount(own * demand.acceleration, force)} for its inertia"] * (own > 0.0)
        parts += [f"{amount(rotor, force)} for what the motor's damping adds to it (damping x substep)"] * (
            rotor > 0.05 * needed
        )
        parts += [f"{amount(load, force)} for its load"] * (load > 0.01 * needed)
        later = f"or {at_least(longer)} times as long" if load < motor.limit else "or less to carry"
        text = (
            f"`{motor.label}` cannot keep up: {demand.first:.3g} to {demand.last:.3g} {unit}{'/s' * speed} within "
            f"{demand.end - demand.start:.3g} s takes {amount(needed, force)} ({', '.join(parts)}), and its motor "
            f"gives {amount(motor.limit, force)}; give the motor a max_force of {at_least(1.2 * needed)}, {later}"
        )
        yield facts.problem("slow-motor", span.where, text)


def _load(motor: Powered, demand: Demand, mode: str) -> float:
    """Force against the motor on the mean along the way of a change; nothing if it is helped."""
    way = 1.0 if demand.last > demand.first else -1.0
    load = motor.swing.joint.friction + motor.swing.joint.damping * demand.speed
    if mode == "position":
        points = [demand.first + k / 4 * (demand.last - demand.first) for k in range(5)]
        load -= way * sum(motor.load(q) for q in points) / 5
    elif not motor.swing.hinge:
        load -= way * motor.swing.pull[0]
    return max(0.0, load)


def _short(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        joint = motor.swing.joint
        for span in motor.spans:
            wanted = max(span.extremes(), key=abs)
            if span.mode != "velocity" or wanted == 0.0 or not motor.alone or motor.damping <= 0.0 or joint.spring:
                continue
            way = 1.0 if wanted > 0.0 else -1.0
            load = max(0.0, joint.friction - (0.0 if motor.swing.hinge else way * motor.swing.pull[0]))
            reached = (motor.damping * abs(wanted) - load) / (motor.damping + joint.damping)
            key, better = "damping", (load + joint.damping * abs(wanted)) / (0.02 * abs(wanted))
            if joint.damping > 0.0 and (motor.limit - load) / joint.damping < reached:
                reached = (motor.limit - load) / joint.damping
                key, better = "max_force", 1.2 * (load + joint.damping * abs(wanted))
            missing = min([SHORT * abs(wanted), *motor.tolerances("joint_velocity")])
            if not 0.0 < reached < abs(wanted) - missing:
                continue
            unit, force = motor.swing.units
            against = [f"joint damping {joint.damping:g}"] * (joint.damping > 0) + [amount(load, force)] * (load > 0)
            text = (
                f"`{motor.label}` will run at {amount(way * reached, unit)}/s instead of {wanted:.3g}, for its motor "
                f"works against {' and '.join(against)} and pulls by damping {motor.damping:g} times the speed that is "
                f"missing; give it a {key} of {at_least(better)}"
            )
            yield facts.problem("short-speed", motor.where(key), text)
            break


def _swings(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        joint, inertia = motor.swing.joint, motor.swing.inertia
        if motor.stiffness <= 0.0 or not any(span.mode == "position" for span in motor.spans):
            continue
        ratio = (motor.damping + joint.damping) / (2 * sqrt((motor.stiffness + joint.spring) * inertia))
        if ratio >= LIMP or joint.friction > 0.0 or motor.swing.closed:
            continue
        period = 2 * pi * sqrt(inertia / (motor.stiffness + joint.spring))
        text = (
            f"`{motor.label}` will swing about its target every {amount(period, 's')} and hardly come to rest: the "
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
        severity="warning",
        title="A motor is too weak to follow its schedule.",
        reason="""\
A change of position by d within T takes an acceleration of at least `4 d / T^2`, a change of speed one of `dv / T`;
the force for it is that times the inertia of everything beyond the joint, plus gravity along the way, dry friction and
joint damping. The engine adds `damping x substep` of the motor to that inertia, so that a large damping makes a limited
motor slower still. Reported if the change would take at least 1.5 times as long as asked for.""",
        remedy="Raise `max_force`, allow more time, or lower a damping that counts as inertia.",
        example=_PUSHER % ("stiffness: 4000, damping: 200, max_force: 20", "position: {kind: ramp, to: 0.5, end: 0.4}"),
        fix=_PUSHER % ("stiffness: 4000, damping: 200, max_force: 120", "position: {kind: ramp, to: 0.5, end: 0.4}"),
        run=lambda facts: one_each(_slow(facts)),
    ),
    Rule(
        id="short-speed",
        severity="warning",
        title="A velocity motor will not reach its speed.",
        reason="""\
A velocity motor pulls with its damping times the speed that is missing. Against dry friction, joint damping or
gravity it runs where both are equal: `kv (wanted - v) = d v + load`. Reported if more than a tenth of the speed is
missing, or than the tolerance of an expectation of the joint's velocity.""",
        remedy="Raise the actuator's `damping` to fifty times what works against it at full speed.",
        example=_PUSHER.replace("axis: x", "axis: x, damping: 20") % ("damping: 30", "velocity: 0.2"),
        fix=_PUSHER.replace("axis: x", "axis: x, damping: 20") % ("damping: 1000", "velocity: 0.2"),
        run=lambda facts: one_each(_short(facts)),
    ),
    Rule(
        id="swinging-servo",
        severity="warning",
        title="A position servo has next to no damping.",
        reason="""\
A servo with stiffness kp, damping kv and a load of inertia I swings about its target with the damping ratio
`kv / (2 sqrt(kp I))`. Below 0.05 it swings on for many turns; without any damping, for ever.""",
        remedy="Give the actuator a `damping` of about `2 sqrt(stiffness x inertia)`.",
        example=_PUSHER % ("stiffness: 2000", "position: 0.2"),
        fix=_PUSHER % ("stiffness: 2000, damping: 200", "position: 0.2"),
        run=lambda facts: one_each(_swings(facts)),
    ),
)
