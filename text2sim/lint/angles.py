"""Angles in radians that look like angles in degrees.

Only fields whose names end in `deg` are in degrees: targets, start positions and joint positions are in radians. A
round number of degrees (a multiple of 5 from 10 to 720) that makes more than a turn and a half is taken for one,
unless it is written with pi or has digits after the point.
"""

from collections.abc import Iterator

from text2sim.lint.drives import spans_of
from text2sim.lint.facts import Facts
from text2sim.lint.mechanics import mechanics_of
from text2sim.lint.motors import one_each
from text2sim.lint.rule import Rule
from text2sim.lint.targets import targets_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.measures import JointPosition

TURNS = 10.0
"""Angle [rad] from which a target that is a round number of degrees is taken for degrees."""


def in_degrees(value: float) -> bool:
    """Whether a number of radians looks like one of degrees: 45, 90, -120."""
    return abs(value) >= TURNS and abs(value) <= 720 and value == int(value) and int(value) % 5 == 0


def _degrees(facts: Facts) -> Iterator[Problem]:
    mechanics = mechanics_of(facts)
    for (entity, name), spans in spans_of(facts).items():
        swing = mechanics.swing(facts.copies[entity], name)
        if swing is None or not swing.hinge or swing.joint.range is not None:
            continue
        for span in spans:
            worst = max(span.extremes(), key=abs)
            if span.mode == "position" and in_degrees(worst):
                text = (
                    f"{worst:g} rad are {abs(worst) / 6.2832:.2g} turns; targets are in radians, and {worst:g} deg is "
                    f"${{radians({worst:g})}}"
                )
                yield facts.problem("looks-like-degrees", span.where, text)
                break
    for name, expect in facts.case.actions.expect.items():
        bound = next((b for b in (expect.above, expect.below, expect.equals) if b is not None and in_degrees(b)), None)
        if bound is not None and (most := _driven_to(facts, expect.measure)) is not None and abs(bound) > 2 * most:
            field = next(key for key in ("above", "below", "equals") if getattr(expect, key) == bound)
            text = (
                f"`{expect.measure}` is in radians, and its joint is driven to {most:.3g} rad at most; {bound:g} deg "
                f"is ${{radians({bound:g})}}"
            )
            yield facts.problem("looks-like-degrees", ("actions", "expect", name, field), text)
    for name, body in facts.case.bodies.items():
        for joint, value in getattr(body, "initial", {}).items():
            swing = mechanics.swing(facts.placed[name][0], joint)
            if swing is not None and swing.hinge and in_degrees(value):
                text = f"start positions of hinges are in radians; {value:g} deg is ${{radians({value:g})}}"
                yield facts.problem("looks-like-degrees", ("bodies", name, "initial", joint), text)


def _driven_to(facts: Facts, measure: str | None) -> float | None:
    """Farthest position [rad] to which the hinges of a measure are driven; None if that is not all that turns them."""
    found = facts.case.actions.measures.get(measure or "")
    if not isinstance(found, JointPosition) or found.stat in ("count", "sum", "range"):
        return None
    most = 0.0
    for target in targets_of(facts).select(found.of):
        swing = mechanics_of(facts).swing(target.copy, target.link or target.copy.body)
        spans = spans_of(facts).get((target.copy.name, swing.name if swing is not None else ""), [])
        if swing is None or not swing.hinge or not spans or any(span.mode != "position" for span in spans):
            return None
        most = max([most, *(abs(value) for span in spans for value in span.extremes())])
    return most or None


_DOOR = """\
bodies:
  door:
    kind: rigid
    shape: {kind: box, size: [0.8, 0.04, 1.0]}
    pose: {pos: [0, 0, 0.6]}
    mount: {kind: hinge, axis: z, anchor: [-0.4, 0, 0], actuator: {stiffness: 800, damping: 160}}
actions:
  controls:
    open: {kind: drive, joint: door, position: {kind: ramp, to: %s, end: 0.9}}
"""

RULES = (
    Rule(
        id="looks-like-degrees",
        severity="warning",
        title="An angle in radians looks like one in degrees.",
        reason="""\
Only fields whose names end in `deg` are in degrees. A target of 45 for a hinge without limits means seven turns.""",
        way_out="Write `${radians(45)}`. If many turns are meant, say them as such: `${14 * pi}`.",
        example=_DOOR % "90",
        mended=_DOOR % "1.57",
        run=lambda facts: one_each(_degrees(facts)),
    ),
)
