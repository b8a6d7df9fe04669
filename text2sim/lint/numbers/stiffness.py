"""Springs and servos that are too stiff for the time step, and joints without damping.

The engine (integrator `approximate_implicitfast`) integrates damping implicitly and stiffness explicitly. With the
substep h, the spring or servo stiffness k, the total damping d and the inertia I of a joint it steps

    (I + h d) v' = I v - h k x,    x' = x + h v'

which is stable only for  h^2 k < 4 I + 2 h d; measured at h = 10 ms with 1 kg: 3e4 N/m oscillates, 4.5e4 N/m diverges,
1e6 N/m with a damping of 6e4 is at rest. In a tree, I is the joint's entry of the mass matrix: if it violates the
bound, so does the tree, whatever the other joints do. The relative error of the frequency is (h w)^2 / 24.

Trees of ball joints without damping and armature diverge on their own: measured with a chain of 10 links at 10 ms, and
with a net (closed loops) at 5 ms.
"""

from collections.abc import Iterator
from math import ceil, inf, sqrt

from text2sim.lint.facts import Facts
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.joints.motors import powered
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_least
from text2sim.spec_schema.text.document import Path

MAX_PHASE = 1.0
"""Largest substep times angular frequency without a warning: the frequency is 4 % wrong."""
MIN_DAMPING_RATIO = 0.3
"""Damping ratio below which an oscillation is visible."""
MIN_CHAIN_JOINTS = 3
"""Fewest ball joints in a row that make a chain."""
CHAIN_STEP, LOOP_STEP = 0.005, 0.0025
"""Longest substeps [s] at which an undamped chain, and an undamped net, remained stable (measured)."""


@one_per_place
def _stiff(facts: Facts) -> Iterator[Problem]:
    mechanics = facts.once(Mechanics)
    for motor in powered(facts):
        joint = motor.joint
        if motor.stiffness > 0.0 and not joint.closed and any(span.mode == "position" for span in motor.spans):
            stiffness, damping = motor.stiffness + joint.spec.spring, motor.damping + joint.spec.damping
            where, name = motor.where("stiffness"), f"stiffness {motor.stiffness:g}"
            yield from _judge(facts, motor.label, joint, stiffness, damping, where, name, motor.limit)
    for joint in mechanics.joints():
        if joint.spec.spring > 0.0 and joint.inertia > 0.0 and not joint.closed:
            where = mechanics.where(joint, "spring")
            if facts.value_at(where) is not None:
                name, label = f"spring {joint.spec.spring:g}", mechanics.label(joint)
                yield from _judge(facts, label, joint, joint.spec.spring, joint.spec.damping, where, name, inf)


def _judge(
    facts: Facts, label: str, joint: LoadedJoint, stiffness: float, damping: float, where: Path, name: str, limit: float
) -> Iterator[Problem]:
    h, dt, inertia = facts.substep, facts.case.scene.dt, joint.inertia
    unit = "kg m2" if joint.hinge else "kg"
    rate = sqrt(stiffness / inertia)
    if h * h * stiffness >= 4 * inertia + 2 * h * damping:
        longest = (damping + sqrt(damping**2 + 4 * stiffness * inertia)) / stiffness
        most = 0.8 * (4 * inertia + 2 * h * damping) / (h * h)
        wanted = 1.2 * (h * stiffness / 2 - 2 * inertia / h)
        then = "diverges" if limit == inf else "chatters at its limit"
        key = "joint damping" if name.startswith("spring") else "damping"
        text = (
            f"`{label}` {then}: {name} on an inertia of {amount(inertia, unit)} is too stiff for substeps of "
            f"{amount(h * 1e3, 'ms')}; use scene.substeps of {ceil(dt / (0.8 * longest))} or more, a value below "
            f"{most:.2g}, or a {key} of {at_least(wanted)}"
        )
        yield facts.problem("stiff-joint", where, text, severity="error" if limit == inf else "warning")
    elif h * rate > MAX_PHASE and damping / (2 * sqrt(stiffness * inertia)) < MIN_DAMPING_RATIO:
        text = (
            f"`{label}` oscillates at {amount(rate / 6.2832, 'Hz')} with {name} on {amount(inertia, unit)}, and "
            f"substeps of {amount(h * 1e3, 'ms')} make that frequency wrong by {(h * rate) ** 2 / 24:.0%}; use "
            f"scene.substeps of {ceil(dt * rate / 0.5)} for 1 %, or a value below {inertia * (0.5 / h) ** 2:.2g}"
        )
        yield facts.problem("stiff-joint", where, text, severity="warning")


def _undamped(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        tree = facts.tree(facts.placed[name][0]) if facts.placed[name] else None
        if tree is None or body.kind in ("rigid", "driven") or getattr(body, "file", None) is not None:
            continue
        longest = LOOP_STEP if tree.loops else CHAIN_STEP
        if facts.substep <= longest * (1 + 1e-9):
            continue
        queue = [(link, 0) for link in tree.roots]
        while queue:
            link, depth = queue.pop()
            joint = link.joint
            if joint is not None:
                loose = joint.kind == "ball" and joint.damping == joint.armature == 0.0
                depth = depth + 1 if loose else 0
            if depth >= MIN_CHAIN_JOINTS:
                where = facts.first_path(
                    facts.where(name, "links", link.name, "joint"), facts.where(name, "joint"), facts.where(name)
                )
                needed = ceil(facts.case.scene.dt / longest - 1e-9)
                text = (
                    f"`{name}` has {depth} ball joints in a row without damping and armature, and will fly apart at "
                    f"substeps of {amount(facts.substep * 1e3, 'ms')}; give its joints a damping (0.02 is enough for "
                    f"links of about 0.1 kg) or an armature, or set scene.substeps to {needed} or more"
                )
                yield facts.problem("undamped-joints", where, text, key=True)
                break
            queue += [(child, depth) for child in link.children]


_CART = """\
scene: {substeps: 1}
bodies:
  cart:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {mass: 0.5}
    pose: {pos: [0, 0, 0.5]}
    mount: {kind: slider, axis: x, actuator: {stiffness: %s, damping: 20}}
actions:
  controls:
    push: {kind: drive, joint: cart, position: {kind: ramp, to: 0.2, end: 0.5}}
"""

_LINK = """\
      %s:
        parent: %s
        shape: {kind: capsule, radius: 0.02, length: 0.1}
        pose: {pos: [0, 0, -0.2]}
        joint: {kind: ball, anchor: [0, 0, 0.1], damping: %s}
"""


def _chain(damping: str) -> str:
    links = "".join(_LINK % (name, parent, damping) for parent, name in zip("abcd", "bcde", strict=True))
    return f"""\
scene: {{substeps: 1}}
bodies:
  rope:
    kind: articulated
    pose: {{pos: [0, 0, 2]}}
    links:
      a: {{shape: {{kind: sphere, radius: 0.03}}}}
{links}"""


RULES = (
    Rule(
        id="stiff-joint",
        severity="error",
        title="A spring or a servo is too stiff for the time step.",
        reason="""\
The engine integrates stiffness explicitly: a joint of inertia I with a spring or servo of stiffness k and damping d is
stable only for `h^2 k < 4 I + 2 h d`, where h is the substep. Otherwise the amplitude grows with every step until the
run diverges; a limited motor chatters between its limits (a warning). An oscillation that is fast for the substep
(`h w > 1`) and hardly damped has a wrong frequency (a warning). Damping is integrated implicitly and is never too
large.""",
        remedy="Use more substeps, a lower stiffness, more damping, or a heavier load: the message has the numbers.",
        example=_CART % "1.0e+5",
        fix=_CART % "4000",
        run=_stiff,
    ),
    Rule(
        id="undamped-joints",
        title="A chain of ball joints has no damping and no armature.",
        reason="""\
An undamped tree of ball joints gains energy from the integrator: a chain of ten links flew apart at substeps of 10 ms
after 1.3 s, a net (with closed loops) at 5 ms after 0.3 s, both without any contact. A little damping or armature
prevents it at no visible cost; chains, nets and ragdolls have both by default.""",
        remedy="Give the joints a `damping` or an `armature`, or use more substeps.",
        example=_chain("0"),
        fix=_chain("0.01"),
        run=_undamped,
    ),
)
