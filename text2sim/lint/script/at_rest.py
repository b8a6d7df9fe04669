"""Cases whose expectations all hold if nothing moves.

The rule evaluates every expectation in a scene at rest: measures keep their start values, speeds are zero, events that
need motion do not happen. Unknown values (contact forces, energies, bodies that may touch from the start) count as
failures, so the rule reports a case only if every expectation would certainly pass.

It reports only cases in which something should move: with controls other than welds, driven bodies, or a free body in
the air.
"""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.lint.facts import Facts, once_per_case
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import bounds_of
from text2sim.lint.script.gap_bounds import height, min_gap
from text2sim.lint.script.measure_bounds import JOINT_MEASURES, subjects, values_of
from text2sim.lint.script.outcomes import bound_of, count_bounds
from text2sim.lint.script.start_values import value_at_rest
from text2sim.lint.script.targets import Targets
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.controls import Attach, Bond, Control, Drive, Release
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.models.motion import start_of

MIN_AIR_GAP = 0.02
"""Smallest gap [m] below a body in the air."""


def _at_rest(facts: Facts) -> Iterator[Problem]:
    expect = facts.case.actions.expect
    if not expect or len(held_at_start(facts)) < len(expect):
        return
    moved = _what_should_move(facts)
    if not moved:
        return
    if len(expect) == 1:
        holds = f"`{next(iter(expect))}`, the only expectation, holds"
    else:
        holds = f"all {len(expect)} expectations hold"
    text = (
        f"{holds} if nothing moves, but {moved}: add an expectation that fails at the start (an event that has to "
        "happen, a measure that has to change)"
    )
    yield facts.problem("passes-at-rest", ("actions", "expect"), text, key=True)


@once_per_case
def held_at_start(facts: Facts) -> list[str]:
    """Return the names of the expectations that hold if nothing moves."""
    return [name for name, expect in facts.case.actions.expect.items() if passes(facts, expect)]


def beginning(facts: Facts) -> float:
    """Return the time [s] at which the first control begins; 0 if something falls or is moved before it.

    What swings or rolls off by itself is not seen.
    """
    if _what_moves_by_itself(facts):
        return 0.0
    starts = [_start_of(control) for control in facts.case.actions.controls.values()]
    return min((start for start in starts if start is not None), default=0.0)


def _start_of(control: Control) -> float | None:
    """Return when [s] a control begins to move something; None if it moves nothing, or only after an event."""
    if isinstance(control, Attach | Bond) or getattr(control, "on", None) is not None:
        return None
    if isinstance(control, Drive):
        schedules = (control.position, control.velocity, control.force)
        return min(start_of(schedule) for schedule in schedules if schedule is not None)
    during = getattr(control, "during", None)
    return during[0] if during is not None else getattr(control, "at", None) or getattr(control, "start", 0.0)


def _what_should_move(facts: Facts) -> str:
    """Return what should move; empty if nothing should."""
    for name, control in facts.case.actions.controls.items():
        if not isinstance(control, Attach | Release):
            return f"`{name}` should move something"
    return _what_moves_by_itself(facts)


def _what_moves_by_itself(facts: Facts) -> str:
    """Return what moves from the start without a control; empty if nothing does."""
    for name in facts.lowering.joint_velocities:
        return f"`{name}` starts to move"
    for name, body in facts.case.bodies.items():
        if body.kind == "driven":
            return f"`{name}` is driven"
    for name in facts.case.bodies:
        for copy in facts.placed[name][:1]:
            if facts.free(copy) and _in_the_air(facts, copy):
                return f"`{copy.name}` starts in the air"
    return ""


def _in_the_air(facts: Facts, copy: Copy) -> bool:
    box = facts.box(copy)
    if box is None or not any(facts.plan.gravity) or any(height(ground, box) < MIN_AIR_GAP for ground in facts.planes):
        return False
    (x, y, z), high = box
    below = ((x - MIN_AIR_GAP, y - MIN_AIR_GAP, z - MIN_AIR_GAP), high)
    boxes = (facts.box(other) for other in facts.copies.values() if other is not copy)
    return all(other is None or apart(other, below) for other in boxes)


def passes(facts: Facts, expect: Expect) -> bool:
    """Return whether an expectation certainly holds in a scene at rest."""
    if expect.on is not None:
        return False
    if expect.measure is not None:
        return _measure(facts, expect)
    event = facts.case.actions.events[expect.event or ""]
    known = bounds_of(facts, expect.event or "")
    times = known.at
    if times is None:
        happens = event.kind == "rest" and event.after is None and event.for_ < facts.case.scene.duration
        times = (0.0,) if happens else ()
        between = getattr(event, "between", None)
        if between is not None and not known.never and _may_touch(facts, between):
            return False
    if expect.never:
        first, last = span_of(expect.within, facts.case.scene.duration)
        return not any(first <= time <= last for time in times)
    if expect.before is not None:
        return False
    least, most = count_bounds(expect)
    if not least <= len(times) <= most:
        return False
    first, last = span_of(expect.within, facts.case.scene.duration)
    return expect.within is None or not times or first <= times[0] <= last


def _measure(facts: Facts, expect: Expect) -> bool:
    measure = facts.case.actions.measures[expect.measure or ""]
    targets, values = subjects(facts, measure), values_of(facts, expect.measure or "")
    if measure.kind in JOINT_MEASURES:
        value = 0.0 if measure.kind == "joint_velocity" else values.start
    else:
        value = value_at_rest(facts, measure, targets)
    if value is None:
        return False
    bound = bound_of(expect, facts.case.scene.duration)
    value = bound.of_constant(value)
    return value is not None and bound.low < value < bound.high


def _may_touch(facts: Facts, between: tuple[str, str]) -> bool:
    pairs = facts.once(Targets).pairs(between)
    return pairs is None or any(min_gap(facts, a.copy, b.copy) < 1e-3 for a, b in pairs)


_BALL = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
    tilt: {kind: tilt, of: ball}
  expect:
    stays_here: {measure: height, during: all, above: -1}
    keeps_upright: {measure: tilt, at: end, below: 20}
%s"""

RULES = (
    Rule(
        id="passes-at-rest",
        title="All expectations would hold if nothing moved.",
        reason="""\
A body is driven, pushed or dropped, but the case would pass if the engine did nothing. Such expectations do not test
that anything happened.""",
        remedy="Add an expectation that fails at the start: an event that has to happen, a position to reach.",
        example=_BALL % "",
        fix=_BALL % "    lands: {measure: height, at: end, below: 0.2}\n",
        run=_at_rest,
    ),
)
