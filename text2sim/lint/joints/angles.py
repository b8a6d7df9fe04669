"""Angles in radians that look like angles in degrees, and the other way round.

Only fields whose names end in `deg` are in degrees: targets, start positions and joint positions are in radians. A
round number of degrees (a multiple of 5 from 10 to 720) that makes more than a turn and a half is taken for one,
unless it is written with pi or has digits after the point. In a field in degrees, 1.571 is taken for a right angle.
"""

from collections.abc import Iterator
from math import degrees, pi
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.mechanics import mechanics_of
from text2sim.lint.joints.motors import one_each
from text2sim.lint.rule import Rule
from text2sim.lint.script.targets import targets_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.events import ThresholdEvent
from text2sim.spec_schema.models.measures import JointPosition
from text2sim.spec_schema.text.document import Path

TURNS = 10.0
"""Angle [rad] from which a target that is a round number of degrees is taken for degrees."""
HEAP, FLATTEST = "friction_angle_deg", 1.4
"""Field of an angle that is never as small [deg]: so flat a heap would be a liquid, and 1.4 rad are 80 deg."""
PARTS = (12, 8, 6, 5, 4, 3, 2.4, 2, 1.5, 4 / 3, 1.2, 1, 2 / 3, 0.5)
"""Half turns divided by these are angles that people mean: 15, 22.5, 30, 36 … 360 degrees."""


def in_degrees(value: float) -> bool:
    """Whether a number of radians looks like one of degrees: 45, 90, -120."""
    return abs(value) >= TURNS and abs(value) <= 720 and value == int(value) and int(value) % 5 == 0


def in_radians(value: float) -> bool:
    """Whether a number of degrees looks like one of radians: 1.571, 0.7854, 3.14."""
    digits = next((d for d in range(2, 8) if round(value, d) == value), 7)
    if digits == 2:
        return abs(value) in (1.57, 3.14, 4.71, 6.28)
    return any(round(pi / part, digits) == round(abs(value), digits) for part in PARTS)


def _radians(facts: Facts) -> Iterator[Problem]:
    """Fields in degrees; one finding for each field."""
    for section in ("bodies", "scene", "actions", "render"):
        for where, value in _in_degrees(facts.raw((section,)), (section,)):
            numbers = value if isinstance(value, list) else [value]
            found = [n for n in numbers if isinstance(n, int | float) and not isinstance(n, bool)]
            found = [n for n in found if in_radians(n) or (where[-1] == HEAP and n < FLATTEST)]
            if found:
                text = (
                    f"`{where[-1]}` is in degrees, and {found[0]:g} looks like radians: that would be "
                    f"{float(f'{degrees(found[0]):.3g}'):g} deg"
                )
                yield facts.problem("looks-like-radians", where, text)


def _in_degrees(value: Any, where: Path) -> Iterator[tuple[Path, Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        if isinstance(key, str) and key.endswith("_deg"):
            yield (*where, key), item
        elif isinstance(item, dict | list):
            yield from _in_degrees(item, (*where, key))


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
    yield from _swinging(facts)
    for name, body in facts.case.bodies.items():
        for joint, value in getattr(body, "initial", {}).items():
            swing = mechanics.swing(facts.placed[name][0], joint)
            if swing is not None and swing.hinge and in_degrees(value):
                text = f"start positions of hinges are in radians; {value:g} deg is ${{radians({value:g})}}"
                yield facts.problem("looks-like-degrees", ("bodies", name, "initial", joint), text)


def _swinging(facts: Facts) -> Iterator[Problem]:
    """Bounds on the angle of a pendulum, which does not go round several times: those of expectations and events."""
    actions = facts.case.actions
    rows = [
        (("actions", "expect", name), expect, ("above", "below", "equals")) for name, expect in actions.expect.items()
    ]
    rows += [
        (("actions", "events", name), event, ("above", "below"))
        for name, event in actions.events.items()
        if isinstance(event, ThresholdEvent)
    ]
    for where, said, keys in rows:
        bound = next(((key, b) for key in keys if (b := getattr(said, key)) is not None and in_degrees(b)), None)
        if bound is not None and said.measure is not None and _hangs(facts, said.measure):
            text = (
                f"`{said.measure}` is in radians, and {bound[1]:g} rad are {abs(bound[1]) / 6.2832:.2g} turns of what "
                f"only hangs and swings; {bound[1]:g} deg is ${{radians({bound[1]:g})}}"
            )
            yield facts.problem("looks-like-degrees", (*where, bound[0]), text)


def _hangs(facts: Facts, measure: str) -> bool:
    """Whether a measure is the angle of hinges that gravity alone turns."""
    found = facts.case.actions.measures.get(measure)
    if not isinstance(found, JointPosition) or found.stat in ("count", "sum", "std", "range"):
        return False
    targets = targets_of(facts).select(found.of)
    for target in targets:
        swing = mechanics_of(facts).swing(target.copy, target.link or target.copy.body)
        if swing is None or not swing.hinge or swing.floating or not any(abs(p) > 1e-6 for p in swing.pull):
            return False
        if spans_of(facts).get((target.copy.name, swing.name)):
            return False
    return bool(targets)


def _driven_to(facts: Facts, measure: str | None) -> float | None:
    """Farthest position [rad] to which the hinges of a measure are driven; None if that is not all that turns them."""
    found = facts.case.actions.measures.get(measure or "")
    if not isinstance(found, JointPosition) or found.stat in ("count", "sum", "std", "range"):
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

_PLANK = """\
bodies:
  plank: {kind: rigid, shape: {kind: box, size: [0.4, 0.1, 0.02]}, place: {on: floor, euler_deg: [0, 0, %s]}}
"""

RULES = (
    Rule(
        id="looks-like-degrees",
        severity="warning",
        title="An angle in radians looks like one in degrees.",
        reason="""\
Only fields whose names end in `deg` are in degrees. A target of 45 for a hinge without limits means seven turns.""",
        remedy="Write `${radians(45)}`. If many turns are meant, say them as such: `${14 * pi}`.",
        example=_DOOR % "90",
        fix=_DOOR % "1.57",
        run=lambda facts: one_each(_degrees(facts)),
    ),
    Rule(
        id="looks-like-radians",
        severity="warning",
        title="An angle in degrees looks like one in radians.",
        reason="""\
Fields whose names end in `deg` are in degrees. Where one is 1.571 or 0.7854, a quarter and an eighth of a turn in
radians, the body is turned by so little that nobody sees it.""",
        remedy="Write 90 for a right angle, or `${degrees(x)}` for an angle x in radians.",
        example=_PLANK % "1.5708",
        fix=_PLANK % "90",
        run=_radians,
    ),
)
