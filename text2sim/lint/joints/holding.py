"""Motors that do not hold their load, or have no drive; see `motors` for the engine's model.

At rest, gravity's torque about a hinge is `axis . (r x m g)`, which depends on the angle as `a cos q + b sin q`; along
a slider the force is `axis . m g`. If the motor gives less, the joint sinks. A position servo has no integral term: it
stops `load / kp` away from its target (measured: 2 kg on kp 1000 N/m stays 19.62 mm low). A stalled velocity motor
gives `kv` times the target speed.
"""

from collections.abc import Iterator
from itertools import islice
from math import inf, pi

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.loads import Lift, lifts
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.joints.motors import Powered, powered
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_least

MIN_OVERLOAD = 1.05
"""Smallest load of a weak motor, over its limit; above 1, since masses of hollow shapes are slightly inaccurate."""
MIN_DROOP = 0.05
"""Smallest static error of a servo that is reported, as a fraction of its travel."""
DROOP_HELD = {"hinge": 0.1, "slider": 0.01}
"""Smallest reported static error [rad, m] of a joint that only holds its position."""

LINKAGE_SAMPLES = 8
"""Parts of the way of a linkage at whose ends its load is computed."""


def _largest_load(motor: Powered, span: Span) -> tuple[float, float]:
    """Return the position within the targets of a span at which the load is largest, and that load."""
    low, high = span.extremes()
    if span.mode == "velocity":
        low, high = _reached_positions(motor, low, high, span.end - span.start)
    if motor.linkage is not None:
        places = [low + k / LINKAGE_SAMPLES * (high - low) for k in range(LINKAGE_SAMPLES + 1)]
    else:
        places = [low, high, motor.joint.heaviest(low, high)[0]]
    return max(((q, motor.load(q)) for q in places), key=lambda pair: abs(pair[1]))


def _reached_positions(motor: Powered, slowest: float, fastest: float, time: float) -> tuple[float, float]:
    """Return the range of positions that a velocity motor reaches within a time, at most a turn."""
    joint = motor.joint
    if not joint.hinge:
        return joint.start, joint.start
    least, most = joint.spec.range or (-inf, inf)
    low = joint.start + max(-2 * pi, min(0.0, slowest) * time)
    return max(low, least), min(joint.start + min(2 * pi, max(0.0, fastest) * time), most)


@one_per_place
def _weak(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        if not motor.loaded:
            continue
        for span in motor.spans:
            problem = _stuck_motor(facts, motor, span) if span.mode == "force" else _sinks(facts, motor, span)
            if problem is not None:
                yield problem
                break
        else:
            if not motor.alone:
                continue
            heavy = (_sinks(facts, lift.motor, lift.span, lift) for lift in lifts(motor))
            yield from islice(filter(None, heavy), 1)


def _sinks(facts: Facts, motor: Powered, span: Span, lift: Lift | None = None) -> Problem | None:
    joint = motor.joint
    fastest = max(map(abs, span.extremes()))
    most, key = motor.limit, "max_force"
    if span.mode == "velocity":
        if fastest == 0.0 or joint.spec.spring:
            return None
        if motor.damping * fastest < motor.limit:
            most, key = motor.damping * fastest, "damping"
    q, load = _largest_load(motor, span)
    needed = abs(load) - joint.spec.friction
    if needed <= most * MIN_OVERLOAD:
        return None
    unit, force = joint.units
    at = f" at {q:.3g} {unit}" if motor.linkage is not None or (joint.hinge and any(joint.pull)) else ""
    mass = "and all that its loops move" if motor.linkage is not None else f"({joint.mass:.3g} kg)"
    remedy = f"max_force of {at_least(1.2 * needed)}"
    limit = f"its motor gives at most {amount(most, force)}"
    if key == "damping":
        remedy = f"damping of {at_least(1.2 * needed / fastest)}"
        limit = f"with damping {motor.damping:g} its motor stalls at {amount(most, force)}"
    attached = "" if lift is None else f" with `{lift.load}`, which `{lift.control}` attaches at {lift.at:g} s,"
    text = (
        f"holding the load of `{motor.label}`{attached} {mass} takes {amount(needed, force)}{at}, and "
        f"{limit}: it will sink; give the motor a {remedy} or more, or reduce its load"
    )
    return facts.problem("weak-motor", motor.where(key), text)


def _stuck_motor(facts: Facts, motor: Powered, span: Span) -> Problem | None:
    joint, force = motor.joint, motor.joint.units[1]
    if not motor.alone:
        return None
    most = min(max(map(abs, span.extremes())), motor.limit)
    _, pull = joint.heaviest(joint.start, joint.start)
    if not 0.0 < most < joint.spec.friction - abs(pull):
        return None
    text = (
        f"the dry friction of `{motor.label}` ({amount(joint.spec.friction, force)}) is larger than this force (at "
        f"most {amount(most, force)}): it will not move; reduce the friction, or increase the force"
    )
    return facts.problem("weak-motor", span.where, text)


@one_per_place
def _droops(facts: Facts) -> Iterator[Problem]:
    for motor in powered(facts):
        joint = motor.joint
        positions = [span for span in motor.spans if span.mode == "position"]
        if not motor.loaded or motor.stiffness <= 0.0 or not positions:
            continue
        extremes = [span.extremes() for span in positions]
        travel = max(high for _, high in extremes) - min(low for low, _ in extremes)
        allowed = max(MIN_DROOP * travel, 0.1 * DROOP_HELD[joint.spec.kind])
        if travel == 0.0:
            allowed = DROOP_HELD[joint.spec.kind]
        allowed = min([allowed, *motor.tolerances("joint_position")])
        q, load = max((_largest_load(motor, span) for span in positions), key=lambda pair: abs(pair[1]))
        carried = max(0.0, abs(load) - joint.spec.friction)
        droop = carried / (motor.stiffness + joint.spec.spring)
        if droop <= allowed or carried > motor.limit * MIN_OVERLOAD:  # that is a weak motor
            continue
        unit, force = joint.units
        of = f", {droop / travel:.0%} of its travel," if travel > 0.0 else ""
        better = carried / (0.2 * allowed)
        text = (
            f"`{motor.label}` stays {amount(droop, unit)}{of} away from its target at {q:.3g} {unit}: a servo holds "
            f"its load ({amount(carried, force)}) only by stiffness times error; stiffness {at_least(better)} with "
            f"damping {at_least(motor.critical(better))} leaves {amount(0.2 * allowed, unit)}"
        )
        yield facts.problem("servo-droop", motor.where("stiffness"), text)


def _idle(facts: Facts) -> Iterator[Problem]:
    mechanics = facts.once(Mechanics)
    driven = {(facts.copies[entity].body, joint) for entity, joint in spans_of(facts)}
    bodies: dict[str, list[LoadedJoint]] = {}
    for joint in mechanics.joints():
        where = mechanics.where(joint, "actuator")
        if joint.motor is None or (joint.copy.body, joint.name) in driven or facts.value_at(where) is None:
            continue
        # The motor of a prefab may stay idle, as long as its joint does not sag.
        if facts.loaded.document.origin(where) is None or _sags(joint):
            bodies.setdefault(joint.copy.body, []).append(joint)
    for joints in bodies.values():
        names = list(dict.fromkeys(f"`{mechanics.label(joint)}`" for joint in joints))
        listed = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        then = "their joints move" if len(names) > 1 else "its joint moves"
        text = (
            f"no control drives {listed}: a motor without a drive gives no force, and {then} freely; add a control "
            "of kind `drive` (a constant `position` holds it), or leave the actuator out"
        )
        yield facts.problem("idle-motor", mechanics.where(joints[0], "actuator"), text, key=True)


def _sags(joint: LoadedJoint) -> bool:
    """Return whether gravity moves a joint that nothing holds."""
    scale = joint.mass * 9.81 * (joint.size if joint.hinge else 1.0)
    return max(map(abs, joint.pull)) > max(joint.spec.friction, 0.01 * scale) or joint.mass <= 0.0


RULES = (
    Rule(
        id="weak-motor",
        title="A motor is too weak to hold the load of its joint.",
        reason="""\
A motor gives at most `max_force`, and a stalled velocity motor at most its damping times the target speed. Gravity's
torque about a hinge is `axis . (r x m g)` of everything beyond the joint, including attached bodies, at its worst
within the driven range; along a slider the force is `axis . m g`. Where `loops` close the mechanism, the load is the
slope of its potential energy over the position of the joint, with the loops closed. A free body that `place` puts on a
link or inside it is part of the load; one attached later counts from then on, if a drive lifts it. Where the load, less
the dry friction of the joint, exceeds what the motor gives, the joint sinks. A force smaller than the dry friction
moves nothing.""",
        remedy="Raise `max_force` (or the `damping` of a velocity motor) to the value in the message, or carry less.",
        example="""\
bodies:
  arm:
    kind: rigid
    shape: {kind: box, size: [0.6, 0.05, 0.05]}
    material: {mass: 2.0}
    pose: {pos: [0, 0, 1]}
    mount: {kind: hinge, axis: y, anchor: [-0.3, 0, 0], actuator: {stiffness: 500, damping: 50, max_force: 4}}
actions:
  controls:
    hold: {kind: drive, joint: arm, position: 0}
""",
        fix="bodies: {arm: {mount: {actuator: {max_force: 8}}}}",
        run=_weak,
    ),
    Rule(
        id="servo-droop",
        title="A position servo stays visibly away from its target under its load.",
        reason="""\
A position motor is a spring and a damper to its target; the engine does not compensate gravity, and there is no
integral term. At rest the error is `load / stiffness`: 2 kg on 1000 N/m hang 2 cm low. The rule reports more than 5 %
of the travel (for a joint that only holds its position: 0.1 rad or 1 cm), or more than the tolerance of an expectation
of the joint's position.""",
        remedy="Raise the stiffness and the damping (critical: `2 sqrt(stiffness x inertia)`), or offset the target.",
        example="""\
bodies:
  lift:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.02]}
    material: {mass: 2.0}
    pose: {pos: [0, 0, 0.5]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 400, damping: 40}}
actions:
  controls:
    up: {kind: drive, joint: lift, position: {kind: ramp, to: 0.3, end: 1}}
""",
        fix="bodies: {lift: {mount: {actuator: {stiffness: 8000, damping: 250}}}}",
        run=_droops,
    ),
    Rule(
        id="idle-motor",
        title="A joint has a motor that no control drives.",
        reason="""\
An actuator does nothing until a control of kind `drive` gives it a target: it does not hold the start pose. The joint
moves as freely as without an actuator.""",
        remedy="Drive it (`position: 0` holds the pose of the case), or leave the actuator out.",
        example="""\
bodies:
  gate:
    kind: rigid
    shape: {kind: box, size: [0.5, 0.05, 0.3]}
    pose: {pos: [0, 0, 0.5]}
    mount: {kind: hinge, axis: y, anchor: [-0.25, 0, 0], actuator: {stiffness: 500, damping: 50}}
""",
        fix="""\
bodies: {gate: {mount: {actuator: {stiffness: 5000, damping: 500}}}}
actions: {controls: {hold: {kind: drive, joint: gate, position: 0}}}
""",
        run=_idle,
    ),
)
