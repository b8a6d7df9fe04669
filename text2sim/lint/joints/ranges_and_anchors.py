"""Joints with targets beyond their range, and mounts with distant anchors.

A drive's target is in radians or metres from the start pose. A joint with limits stops there, and its servo pushes
against the limit with `stiffness x (target - limit)` as long as the target holds.
"""

from collections.abc import Iterator
from math import degrees, dist, pi, radians

from text2sim.compiler.shapes.boxes import sides
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount, as_radians
from text2sim.spec_schema.errors import Problem

MAX_BEYOND_RANGE = 0.02
"""Share of the range by which a target may exceed it, as for a clamp that presses."""
FAR_ANCHOR = 50.0
"""Largest distance of an anchor in lengths of the body: a bob of 4 cm may hang on 2 m."""


@one_per_place
def _range(facts: Facts) -> Iterator[Problem]:
    mechanics = facts.once(Mechanics)
    for (entity, name), spans in spans_of(facts).items():
        joint = mechanics.joint(facts.copies[entity], name)
        if joint is None or joint.spec.range is None:
            continue
        (low, high), unit = joint.spec.range, joint.units[0]
        slack = MAX_BEYOND_RANGE * (high - low)
        if (stuck := _against_end(spans, low - joint.start, high - joint.start)) is not None:
            end, toward = (high, "up") if stuck.extremes()[1] > 0.0 else (low, "down")
            text = (
                f"drives `{mechanics.label(joint)}` {toward}, but it starts at {end:.4g} {unit}, where its range ends: "
                "it pushes against that limit and does not move; change the sign, or widen the range"
            )
            yield facts.problem("target-out-of-range", stuck.where, text)
            continue
        for span in spans:
            if span.mode != "position":
                continue
            # A file's joint may start outside its range, and moves in from there.
            least, most = (min(max(x, low), high) if x == joint.start else x for x in span.extremes())
            if least >= low - slack and most <= high + slack:
                continue
            target, end = (most, high) if most - high > low - least else (least, low)
            limits = f"from {low:.4g} to {high:.4g} {unit}"
            hint = ""
            if joint.hinge:
                limits += f" ({degrees(low):.4g} to {degrees(high):.4g} deg)"
                if low - slack <= radians(target) <= high + slack and abs(target) > pi:
                    hint = f"; targets are in radians: {as_radians(target)}"
            text = (
                f"the target is {target:.4g} {unit}, and `{mechanics.label(joint)}` moves {limits}: it will stop at "
                f"{end:.4g} {unit} and push against its limit{hint}"
            )
            yield facts.problem("target-out-of-range", span.where, text)
            break


def _against_end(spans: list[Span], low: float, high: float) -> Span | None:
    """Return the only drive of a joint if it is a velocity towards the limit at which the joint starts.

    The limits are relative to the start.
    """
    if len(spans) != 1 or spans[0].mode != "velocity":
        return None
    least, most = spans[0].extremes()
    near = 1e-3 * (high - low)
    stuck = most <= 0.0 > least and low >= -near or least >= 0.0 < most and high <= near
    return spans[0] if stuck else None


def _far_anchor(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        anchor = getattr(getattr(body, "mount", None), "anchor", None)
        box = facts.box(facts.placed[name][0])
        if anchor is None or box is None:
            continue
        size = max(sides(box))
        if (away := dist(anchor, (0.0, 0.0, 0.0))) > FAR_ANCHOR * size:
            text = (
                f"`{name}` is {amount(size, 'm')} long and turns about a point {amount(away, 'm')} away from its "
                "origin; anchors are in metres, in the body's own frame"
            )
            where = facts.first_path(facts.where(name, "mount", "anchor"), facts.where(name))
            yield facts.problem("far-anchor", where, text)


_DOOR = """\
bodies:
  door:
    kind: rigid
    shape: {kind: box, size: [0.8, 0.04, 1.0]}
    pose: {pos: [0, 0, 0.6]}
    mount: {kind: hinge, axis: z, anchor: [-0.4, 0, 0], %s actuator: {stiffness: 800, damping: 160}}
actions:
  controls:
    open: {kind: drive, joint: door, position: {kind: ramp, to: %s, end: 0.9}}
"""
RULES = (
    Rule(
        id="target-out-of-range",
        title="The target of a drive is outside the range of its joint.",
        reason="""\
The joint stops at its limit, and its servo keeps pushing against it with the stiffness times the remaining distance. A
velocity towards the limit at which the joint starts moves nothing. Ranges of hinges are in degrees (`range_deg`),
targets in radians.""",
        remedy="Widen the range, or change the target; `${radians(45)}` turns degrees into radians.",
        example=_DOOR % ("range_deg: [0, 90],", "90"),
        fix=_DOOR % ("range_deg: [0, 90],", "1.57"),
        run=_range,
    ),
    Rule(
        id="far-anchor",
        title="A body turns about a point that is very far away.",
        reason=f"""\
The `anchor` of a mount is a point of the axis in the body's own frame, in metres, and holds the body like a rod without
mass. The rule reports anchors farther from the origin than {FAR_ANCHOR:g} times the length of the body.""",
        remedy="Give the anchor in metres: half of the width of a door, `[-0.4, 0, 0]`, not `[-400, 0, 0]`.",
        example="""\
bodies:
  door:
    kind: rigid
    shape: {kind: box, size: [0.8, 0.04, 2]}
    pose: {pos: [0, 0, 1.1]}
    mount: {kind: hinge, axis: z, anchor: [-400, 0, 0]}
""",
        fix="bodies: {door: {mount: {anchor: [-0.4, 0, 0]}}}",
        run=_far_anchor,
    ),
)
