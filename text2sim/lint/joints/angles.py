"""Angles in radians that look like degrees, and vice versa.

Only fields whose names end in `deg` are in degrees: targets, start positions and joint positions are in radians. A
value in radians looks like degrees if it is a multiple of 5 from 10 to 720, which is more than a turn and a half. A
value in degrees looks like radians if it is a rounded simple fraction of pi: 1.571 looks like a right angle.
"""

from collections.abc import Iterator
from math import degrees, pi, tau
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.script.targets import Targets
from text2sim.lint.words import as_radians
from text2sim.spec_schema.arithmetic.values import is_number
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.events import ThresholdEvent
from text2sim.spec_schema.models.measures import JointPosition
from text2sim.spec_schema.text.document import Path

MIN_DEGREES = 10.0
"""Smallest value [rad] that may look like degrees."""
HEAP_ANGLE_FIELD, MIN_HEAP_ANGLE = "friction_angle_deg", 1.4
"""Field of a friction angle, and its smallest plausible value [deg]: a flatter heap is a liquid; 1.4 rad are 80 deg."""
COMMON_DIVISORS = (12, 8, 6, 5, 4, 3, 2.4, 2, 1.5, 4 / 3, 1.2, 1, 2 / 3, 0.5)
"""Divisors of pi that give common angles: 15, 22.5, 30, 36 … 360 degrees."""


def in_degrees(value: float) -> bool:
    """Return whether a value in radians looks like degrees: 45, 90, -120."""
    return MIN_DEGREES <= abs(value) <= 720 and value == int(value) and int(value) % 5 == 0


def in_radians(value: float) -> bool:
    """Return whether a value in degrees looks like radians: 1.571, 0.7854, 3.14."""
    digits = next((d for d in range(2, 8) if round(value, d) == value), 7)
    if digits == 2:
        return abs(value) in (1.57, 3.14, 4.71, 6.28)
    return any(round(pi / divisor, digits) == round(abs(value), digits) for divisor in COMMON_DIVISORS)


def _radians(facts: Facts) -> Iterator[Problem]:
    """Report each field in degrees once."""
    for section in ("bodies", "scene", "actions", "render"):
        for where, value in _in_degrees(facts.value_at((section,)), (section,)):
            numbers = value if isinstance(value, list) else [value]
            found = [n for n in numbers if is_number(n)]
            found = [n for n in found if in_radians(n) or (where[-1] == HEAP_ANGLE_FIELD and n < MIN_HEAP_ANGLE)]
            if found:
                text = (
                    f"`{where[-1]}` is in degrees, and {found[0]:g} looks like radians; write "
                    f"{float(f'{degrees(found[0]):.3g}'):g}"
                )
                yield facts.problem("looks-like-radians", where, text)


def _in_degrees(value: Any, where: Path) -> Iterator[tuple[Path, Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        if isinstance(key, str) and key.endswith("_deg"):
            yield (*where, key), item
        elif isinstance(item, dict | list):
            yield from _in_degrees(item, (*where, key))


@one_per_place
def _degrees(facts: Facts) -> Iterator[Problem]:
    mechanics = facts.once(Mechanics)
    for (entity, name), spans in spans_of(facts).items():
        joint = mechanics.joint(facts.copies[entity], name)
        if joint is None or not joint.hinge or joint.spec.range is not None:
            continue
        for span in spans:
            worst = max(span.extremes(), key=abs)
            if span.mode == "position" and in_degrees(worst):
                text = f"{worst:g} rad are {abs(worst) / tau:.2g} turns; targets are in radians: {as_radians(worst)}"
                yield facts.problem("looks-like-degrees", span.where, text)
                break
    yield from _bounds(facts)
    for name, body in facts.case.bodies.items():
        for key, value in getattr(body, "initial", {}).items():
            joint = mechanics.joint(facts.placed[name][0], key)
            if joint is not None and joint.hinge and in_degrees(value):
                text = f"start positions of hinges are in radians: {as_radians(value)}"
                yield facts.problem("looks-like-degrees", ("bodies", name, "initial", key), text)


def _bounds(facts: Facts) -> Iterator[Problem]:
    """Report bounds of expectations and events on the angles of hinges that do not turn that far."""
    actions = facts.case.actions
    rows: list[tuple[Path, Any]] = [(("actions", "expect", name), one) for name, one in actions.expect.items()]
    events = actions.events.items()
    rows += [(("actions", "events", name), one) for name, one in events if isinstance(one, ThresholdEvent)]
    for where, entry in rows:
        values = ((key, getattr(entry, key, None)) for key in ("above", "below", "equals"))
        found = next(((key, bound) for key, bound in values if bound is not None and in_degrees(bound)), None)
        if found is None or entry.measure is None:
            continue
        key, bound = found
        why = ""
        if _is_free_hinge_angle(facts, entry.measure):
            why = f"{bound:g} rad are {abs(bound) / tau:.2g} turns of a joint that only hangs and swings"
        elif where[1] == "expect" and (most := _driven_to(facts, entry.measure)) and abs(bound) > 2 * most:
            why = f"its joint is driven to at most {most:.3g} rad"
        if why:
            text = f"`{entry.measure}` is in radians, and {why}; {as_radians(bound)}"
            yield facts.problem("looks-like-degrees", (*where, key), text)


def _hinges(facts: Facts, measure: str) -> list[tuple[LoadedJoint, list[Span]]]:
    """Return the hinges whose angle a measure is, with their drives; none if it is not an angle of hinges."""
    found = facts.case.actions.measures.get(measure)
    if not isinstance(found, JointPosition) or found.stat in ("count", "sum", "std", "range"):
        return []
    rows = []
    for target in facts.once(Targets).select(found.of):
        joint = facts.once(Mechanics).joint(target.copy, target.link or target.copy.body)
        if joint is None or not joint.hinge:
            return []
        rows.append((joint, spans_of(facts).get((target.copy.name, joint.name), [])))
    return rows


def _is_free_hinge_angle(facts: Facts, measure: str) -> bool:
    """Return whether a measure is the angle of hinges that only gravity turns."""
    hinges = _hinges(facts, measure)
    return bool(hinges) and all(
        not spans and not joint.floating and any(abs(p) > 1e-6 for p in joint.pull) for joint, spans in hinges
    )


def _driven_to(facts: Facts, measure: str) -> float:
    """Return the largest angle [rad] to which the hinges of a measure are driven; 0 if something else turns them."""
    spans = [spans for _, spans in _hinges(facts, measure)]
    if not all(spans) or any(span.mode != "position" for row in spans for span in row):
        return 0.0
    return max((abs(value) for row in spans for span in row for value in span.extremes()), default=0.0)


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
        title="An angle in radians looks like one in degrees.",
        reason="""\
Only fields whose names end in `deg` are in degrees. A target of 45 for a hinge without limits means seven turns.""",
        remedy="Write `${radians(45)}`. For many turns, write a multiple of pi: `${14 * pi}`.",
        example=_DOOR % "90",
        fix=_DOOR % "1.57",
        run=_degrees,
    ),
    Rule(
        id="looks-like-radians",
        title="An angle in degrees looks like one in radians.",
        reason="""\
Fields whose names end in `deg` are in degrees. A value of 1.571 or 0.7854, a quarter or an eighth of a turn in radians,
turns the body so little that nobody sees it.""",
        remedy="Write 90 for a right angle, or `${degrees(x)}` for an angle x in radians.",
        example=_PLANK % "1.5708",
        fix=_PLANK % "90",
        run=_radians,
    ),
)
