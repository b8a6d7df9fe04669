"""Loads that are attached to joints during the run, such as those of a crane.

A load counts from its `attach` to its release, once a drive moves the joint against its weight: before, its support may
still carry it. It is picked up where it starts, or where its fall has taken it; the joints of a tree are assumed to be
at the targets of their position drives. For a joint driven by velocity or force, the load is only known for a slider,
where it does not depend on the position.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, inf, sin

from text2sim.compiler.action_rows import Weld
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.inertials import Inertial, combined_inertial
from text2sim.compiler.shapes.rotation import frame_apply, quat_rotate
from text2sim.compiler.trees.tree import StandingLink, tree_links
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint, pull_of
from text2sim.lint.joints.motors import Powered
from text2sim.lint.motion.whereabouts import Whereabouts

MIN_TARGET_CHANGE = 1e-6
"""Smallest change of a target [rad or m] that counts as motion."""


@dataclass(frozen=True)
class Lift:
    """A motor that lifts a body attached to its joint during the run."""

    motor: Powered
    """The motor, with the weight of the load in its pull."""
    span: Span
    """The drive, while the load is attached."""
    load: str
    """Name of the attached body."""
    control: str
    at: float
    """Time of the attachment [s]."""


def lifts(motor: Powered) -> Iterator[Lift]:
    """Yield the drives by which a motor lifts bodies attached to its joint after the start."""
    facts, joint = motor.mechanics.facts, motor.joint
    tree = facts.tree(joint.copy)
    for weld, until in _later(facts):
        for holder, link, other in ((weld.a, weld.a_link, weld.b), (weld.b, weld.b_link, weld.a)):
            if holder != joint.copy.name or tree is None or not facts.free(facts.copies[other]):
                continue
            carried = motor.mechanics.beyond(joint)
            if (link or tree.roots[0].name) not in carried:
                continue
            standing = [row for row in _standing(facts, joint.copy, weld.at) if row.link.name in carried]
            inertial = combined_inertial(_inertial(motor, name, weld.at) for name in _group(facts, other, weld.at))
            own = next(row for row in standing if any(name == joint.name for name, _ in row.link.all_joints()))
            yield from _lifts(motor, own, inertial, weld, min(until, facts.case.scene.duration), other)


def _lifts(
    motor: Powered, standing: StandingLink, inertial: Inertial, weld: Weld, until: float, other: str
) -> Iterator[Lift]:
    joint, gravity = motor.joint, motor.mechanics.facts.plan.gravity
    axis = quat_rotate(standing.quat, joint.spec.axis)
    anchor = frame_apply(standing.pos, standing.quat, joint.spec.anchor)
    pull = pull_of(joint.spec.kind, axis, anchor, inertial, gravity)
    if joint.hinge:
        pull = _turned_pull(pull, _position(motor, weld.at) - joint.start)
    for span in motor.spans:
        start, end = max(span.start, weld.at), min(span.end, until)
        if span.mode == "force" or span.anytime or end <= start or (joint.hinge and span.mode != "position"):
            continue
        part = replace(span, start=start, end=end)
        if not _opposes(replace(joint, pull=pull), part):
            continue
        both = (joint.pull[0] + pull[0], joint.pull[1] + pull[1])
        lifting = replace(joint, pull=both, mass=joint.mass + inertial.mass)
        yield Lift(replace(motor, joint=lifting), part, other, weld.control, weld.at)


def _later(facts: Facts) -> Iterator[tuple[Weld, float]]:
    """Yield the welds that are made after the start, and when [s] each is released."""
    for weld in facts.rows.welds:
        if not weld.on or weld.at <= 0.0 or weld.a not in facts.copies or weld.b not in facts.copies:
            continue
        ends = (weld.a, weld.a_link, weld.b, weld.b_link)
        undone = (
            row.at
            for row in facts.rows.welds
            if not row.on and row.at > weld.at and (row.a, row.a_link, row.b, row.b_link) == ends
        )
        yield weld, min(undone, default=inf)


def _group(facts: Facts, name: str, t: float) -> set[str]:
    """Return the name of a free body and of all free ones welded to it at a time [s]."""
    found, waiting = {name}, [name]
    while waiting:
        current = waiting.pop()
        for weld in facts.rows.welds:
            if weld.on and weld.at <= t and current in (weld.a, weld.b):
                other = weld.b if current == weld.a else weld.a
                if other not in found and other in facts.copies and facts.free(facts.copies[other]):
                    found.add(other)
                    waiting.append(other)
    return found


def _inertial(motor: Powered, name: str, t: float) -> Inertial:
    """Return the inertial of a load in the place to which it has fallen by a time [s]."""
    facts = motor.mechanics.facts
    copy = facts.copies[name]
    inertial = motor.mechanics.inertial(copy)
    x, y, z = (c + d for c, d in zip(inertial.center, facts.once(Whereabouts).offset(copy, t), strict=True))
    return replace(inertial, center=(x, y, z))


def _standing(facts: Facts, copy: Copy, t: float) -> list[StandingLink]:
    """Return the links of a copy whose joints are at the targets that their position drives have at a time [s]."""
    tree = facts.tree(copy)
    assert tree is not None
    initial = dict(tree.initial)
    for (entity, joint), spans in spans_of(facts).items():
        if entity == copy.name:
            for span in spans:
                if span.mode == "position" and span.start <= t and not span.anytime:
                    initial[joint] = span.value(t)
    return tree_links(replace(tree, initial=initial), copy.pos, copy.quat)


def _position(motor: Powered, t: float) -> float:
    """Return the target [rad or m] of a joint at a time [s]; its start if it has none."""
    timed = [span for span in motor.spans if span.mode == "position" and not span.anytime]
    values = [span.value(t) for span in timed if span.start <= t]
    return values[-1] if values else motor.joint.start


def _turned_pull(pull: tuple[float, float], turn: float) -> tuple[float, float]:
    """Return a pull, as in `LoadedJoint.pull`, with angles from the start, given one with angles from `turn` [rad]."""
    return (pull[0] * cos(turn) - pull[1] * sin(turn), pull[0] * sin(turn) + pull[1] * cos(turn))


def _opposes(joint: LoadedJoint, span: Span) -> bool:
    """Return whether a drive moves a joint against its pull."""
    corners = span.corners()
    if span.mode == "velocity":
        return any(value * joint.pull[0] < 0.0 for _, value in corners)
    steps = pairwise(corners)
    return any(
        abs(q - p) > MIN_TARGET_CHANGE and (q - p) * joint.gravity((p + q) / 2) < 0.0 for (_, p), (_, q) in steps
    )
