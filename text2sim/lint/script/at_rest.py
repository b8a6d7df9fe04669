"""Cases whose expectations all hold if nothing moves.

Every expectation is judged in a scene that stands still: measures keep the value of the start, speeds are zero, events
that need motion do not happen. What is not known then (forces of contact, energies, bodies that may touch from the
start) counts as a failure, so that a case is named only if every single expectation would certainly pass.

It is named only if something is meant to move: if it has controls other than welds, driven bodies, or a free body in
the air. A tower that is to stand still may say so.
"""

from collections.abc import Iterator
from itertools import product
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import happening_of
from text2sim.lint.script.gaps import gap, height
from text2sim.lint.script.outcomes import asked_of
from text2sim.lint.script.starts import resting
from text2sim.lint.script.targets import targets_of
from text2sim.lint.script.values import JOINTS, subjects, values_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.controls import Attach, Release
from text2sim.spec_schema.models.expectations import Expect

MAX_PAIRS = 2_000
"""Largest number of pairs of bodies that are tested."""
AIR = 0.02
"""Smallest gap [m] below a body that is in the air."""


def _at_rest(facts: Facts) -> Iterator[Problem]:
    expect = facts.case.actions.expect
    if not expect or not all(passes(facts, one) for one in expect.values()):
        return
    moved = _moved(facts)
    if not moved:
        return
    if len(expect) == 1:
        says = f"`{next(iter(expect))}`, the only expectation, holds"
    else:
        says = f"all {len(expect)} expectations hold"
    text = (
        f"{says} if nothing moves at all, and {moved}: add one that is true only after what is meant to happen has "
        "happened (an event that has to come, a measure that has to change)"
    )
    yield facts.problem("passes-at-rest", ("actions", "expect"), text, key=True)


def held_at_start(facts: Facts) -> list[str]:
    """Return the expectations that hold if nothing moves, by name: they say what must not go wrong."""
    return [name for name, one in facts.case.actions.expect.items() if passes(facts, one)]


def _moved(facts: Facts) -> str:
    """Describe what is meant to move; empty if nothing is."""
    for name, control in facts.case.actions.controls.items():
        if not isinstance(control, Attach | Release):
            return f"`{name}` is to move something"
    for name, body in facts.case.bodies.items():
        if body.kind == "driven":
            return f"`{name}` is driven"
    for copies in (facts.placed[name][:1] for name in facts.case.bodies):
        for copy in copies:
            if facts.free(copy) and _in_the_air(facts, copy):
                return f"`{copy.name}` starts in the air"
    return ""


def _in_the_air(facts: Facts, copy: Copy) -> bool:
    box = facts.box(copy)
    if box is None or not any(facts.plan.gravity) or any(height(ground, box) < AIR for ground in facts.planes):
        return False
    below = (tuple(low - AIR for low in box[0]), box[1])
    for other in facts.copies.values():
        under = facts.box(other)
        if other is not copy and under is not None and _overlap(under, below):
            return False
    return True


def _overlap(a: Any, b: Any) -> bool:
    return all(p < s and r < q for p, q, r, s in zip(*a, *b, strict=True))


def passes(facts: Facts, expect: Expect) -> bool:
    """Whether an expectation certainly holds in a scene that stands still."""
    if expect.on is not None:
        return False  # nothing that it could count from
    if expect.measure is not None:
        return _measure(facts, expect)
    event = facts.case.actions.events[expect.event or ""]
    known = happening_of(facts, expect.event or "")
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
    low, high = (1, 1e9) if expect.count is None else (expect.count, expect.count)
    if isinstance(expect.count, tuple):
        low, high = expect.count
    if not isinstance(low, int) or not low <= len(times) <= high:  # type: ignore[operator]
        return False
    first, last = span_of(expect.within, facts.case.scene.duration)
    return expect.within is None or not times or first <= times[0] <= last


def _measure(facts: Facts, expect: Expect) -> bool:
    measure = facts.case.actions.measures[expect.measure or ""]
    targets, values = subjects(facts, measure), values_of(facts, expect.measure or "")
    if measure.kind in JOINTS:
        value = values.start
    else:
        value = resting(facts, measure, targets)
    if value is None:
        return False
    asked = asked_of(expect, facts.case.scene.duration)
    if asked.stat in ("range", "std"):
        value = 0.0
    return asked.low < value < asked.high


def _may_touch(facts: Facts, between: tuple[str, str]) -> bool:
    first, second = (targets_of(facts).select(selector) for selector in between)
    if len(first) * len(second) > MAX_PAIRS:
        return True
    return any(gap(facts, a.copy, b.copy) < 1e-3 for a, b in product(first, second) if a.label != b.label)


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
        severity="warning",
        title="All expectations would hold if nothing moved.",
        reason="""\
Something is driven, pushed or dropped, and yet the case would pass if the engine did nothing. Such expectations only
say what must not go wrong; they do not test that anything happened.""",
        remedy="Add an expectation that fails at the start: an event that has to come, a place to be reached.",
        example=_BALL % "",
        fix=_BALL % "    lands: {measure: height, at: end, below: 0.2}\n",
        run=_at_rest,
    ),
)
