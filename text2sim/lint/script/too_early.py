"""Expectations that come before any body can reach their target.

`causes` bounds how far bodies move by a time: from start velocities, earlier impulses and forces, and gravity; if
everything is at rest at the start, from the first cause on. Nothing is reported after the first drive, spring or
bounce.
"""

from collections.abc import Iterator
from math import inf
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.motion.causes import Causes
from text2sim.lint.rule import Rule
from text2sim.lint.script.gap_bounds import min_gap
from text2sim.lint.script.measure_bounds import Values, values_of
from text2sim.lint.script.outcomes import bound_of, count_bounds, field_of
from text2sim.lint.script.start_values import depth_inside
from text2sim.lint.script.targets import StartTarget, Targets
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.measures import Displacement, Position


def _too_soon(facts: Facts) -> Iterator[Problem]:
    causes = facts.once(Causes)
    actions = facts.case.actions
    for name, expect in actions.expect.items():
        where = ("actions", "expect", name)
        if expect.on is not None:
            continue
        if expect.event is not None:
            if expect.within is None or count_bounds(expect)[1] == 0:
                continue
            distance = _shortest_distance(facts, actions.events[expect.event])
            _, last = span_of(expect.within, facts.case.scene.duration)
            if not causes.reaches(distance, last):
                text = f"`{expect.event}` needs a motion of {distance:.3g} m" + _why_too_far(causes, distance, last)
                yield facts.problem("too-soon", (*where, "within"), text)
        elif expect.measure is not None:
            bound, values = bound_of(expect, facts.case.scene.duration), values_of(facts, expect.measure)
            if values.start is None or bound.stat not in ("all", "max", "min"):
                continue
            if not _changes_by_motion(actions.measures[expect.measure], values):
                continue
            # A minimum or maximum may occur at the end of the span; a bound on all values applies from its start.
            by = bound.first if bound.stat == "all" else bound.last
            change = max(bound.low - values.start, values.start - bound.high)
            if bound.stat in ("max", "min") and (bound.stat == "max") != (bound.low > values.start):
                continue
            if by > 0.0 and not causes.reaches(change, by):
                text = f"`{expect.measure}` has to change by {change:.3g} {values.unit} from its start"
                text += _why_too_far(causes, change, by)
                yield facts.problem("too-soon", (*where, field_of(expect)), text)


def _changes_by_motion(measure: Any, values: Values) -> bool:
    """Return whether a measure changes by at most the distance [m] that some body moves."""
    if not isinstance(measure, Position | Displacement) or getattr(measure, "frame", None) is not None:
        return False
    return not values.frozen and measure.stat not in ("count", "sum", "std", "range")


def _why_too_far(causes: Causes, distance: float, by: float) -> str:
    """Return why a distance is too long for a time."""
    needs = causes.soonest(distance)
    if by <= causes.quiet:
        if not causes.first:
            return ", but nothing here moves"
        return f", but by {by:g} s everything is at rest: `{causes.first}` acts first, at {causes.quiet:g} s"
    text = f", but nothing here is fast enough by {by:g} s"
    return text if needs == inf else f"{text}: it takes at least {needs:.2g} s"


def _shortest_distance(facts: Facts, event: Any) -> float:
    """Return the shortest distance [m] that some body has to move before an event; 0 if it is not known."""
    if event.kind == "contact":
        pairs = facts.once(Targets).pairs(event.between) or ()
        return min((_gap(facts, a, b) for a, b in pairs), default=0.0)
    if event.kind == "enters" and event.region.moves_with is None:
        targets = facts.once(Targets).select(event.of)
        if any(not target.known for target in targets):
            return 0.0
        return min((max(0.0, -depth_inside(event.region, target.origin)) for target in targets), default=0.0)
    if event.kind == "threshold":
        values = values_of(facts, event.measure)
        if values.start is not None and _changes_by_motion(facts.case.actions.measures[event.measure], values):
            return max(0.0, values.start - event.below if event.above is None else event.above - values.start)
    return 0.0


def _gap(facts: Facts, a: StartTarget, b: StartTarget) -> float:
    """Return the shortest distance [m] that one of two bodies has to move before they touch."""
    if a.copy.name == b.copy.name:
        return 0.0
    return min_gap(facts, a.copy, b.copy) / (2.0 if a.moves and b.moves else 1.0)


_BALL = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 3.1]}}
actions:
  events:
    lands: {kind: contact, between: [ball, floor]}
  expect:
    falls: {event: lands, within: %s}
"""

RULES = (
    Rule(
        id="too-soon",
        title="An expectation comes before any body can reach its target.",
        reason="""\
Start velocities, impulses and forces before the time t give a body at most a speed v, so nothing moves farther than
`2 v t + g t^2`, twice the distance of a thrown body; if everything is at rest at the start, t counts from the first
cause. No body reaches an event or a position, that of a `threshold` included, farther away in time. The rule is silent
after a drive or a driven body has started, or if springs or bounces act.""",
        remedy="Start earlier, nearer or faster, or let the span end later than the time in the message.",
        example=_BALL % "[0, 0.3]",
        fix=_BALL % "[0, 0.9]",
        run=_too_soon,
    ),
)
