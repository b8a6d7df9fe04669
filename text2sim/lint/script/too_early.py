"""Expectations that come before anything can have got there.

How far anything can have gone by a time, at the very most, is worked out in `causes`: from the start velocities, the
blows and forces before that time, and gravity; where everything stands still at first, from the first of them on. After
the first drive, spring or bounce, nothing is said.
"""

from collections.abc import Iterator
from itertools import product
from math import inf
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.motion.causes import Causes, causes_of
from text2sim.lint.rule import Rule
from text2sim.lint.script.gaps import gap
from text2sim.lint.script.outcomes import asked_of, bound_of
from text2sim.lint.script.starts import depth_inside
from text2sim.lint.script.targets import Target, targets_of
from text2sim.lint.script.values import values_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of

MAX_PAIRS = 2_000
"""Pairs of bodies that are looked at, at most."""


def _soon(facts: Facts) -> Iterator[Problem]:
    causes = causes_of(facts)
    actions = facts.case.actions
    for name, expect in actions.expect.items():
        where = ("actions", "expect", name)
        if expect.on is not None:
            continue
        if expect.event is not None:
            if expect.never or expect.within is None or expect.count in (0, (0, 0)):
                continue
            way = _way(facts, actions.events[expect.event])
            _, last = span_of(expect.within, facts.case.scene.duration)
            if not causes.reaches(way, last):
                text = f"`{expect.event}` needs a way of {way:.3g} m" + _late(causes, way, last)
                yield facts.problem("too-soon", (*where, "within"), text)
        elif expect.measure is not None:
            asked, values = asked_of(expect, facts.case.scene.duration), values_of(facts, expect.measure)
            measure = actions.measures[expect.measure]
            if measure.kind not in ("position", "displacement") or asked.stat in ("mean", "std", "range"):
                continue
            if (
                values.start is None
                or values.frozen
                or getattr(measure, "stat", None) in ("count", "sum", "std", "range")
            ):
                continue
            # A smallest value that has to be low may come at the end of the span; an all-the-time begins at once.
            by = asked.first if asked.stat == "all" else asked.last
            way = max(asked.low - values.start, values.start - asked.high)
            if asked.stat in ("max", "min") and (asked.stat == "max") != (asked.low > values.start):
                continue
            if by > 0.0 and not causes.reaches(way, by):
                text = f"`{expect.measure}` has {way:.3g} {values.unit} to go from where it starts"
                text += _late(causes, way, by)
                yield facts.problem("too-soon", (*where, bound_of(expect)), text)


def _late(causes: Causes, way: float, by: float) -> str:
    """Why a way is too long for a time, in words."""
    needs = causes.soonest(way)
    if by <= causes.quiet:
        if not causes.first:
            return ", and nothing here moves"
        return f", and by {by:g} s everything still stands: `{causes.first}` is the first to act, at {causes.quiet:g} s"
    text = f", for which nothing here is fast enough by {by:g} s"
    return text if needs == inf else f"{text}: it takes {needs:.2g} s at the very least"


def _way(facts: Facts, event: Any) -> float:
    """Shortest way [m] that some body has to go before an event happens; 0 if that is not known."""
    if event.kind == "contact":
        first, second = (targets_of(facts).select(selector) for selector in event.between)
        if len(first) * len(second) > MAX_PAIRS:
            return 0.0
        return min((_gap(facts, a, b) for a, b in product(first, second) if a.label != b.label), default=0.0)
    if event.kind == "enters" and event.region.moves_with is None:
        targets = targets_of(facts).select(event.of)
        if any(not target.known for target in targets):
            return 0.0
        return min((max(0.0, -depth_inside(event.region, target.origin)) for target in targets), default=0.0)
    return 0.0


def _gap(facts: Facts, a: Target, b: Target) -> float:
    """Way [m] that one of two bodies has to go at least before they touch."""
    if a.copy.name == b.copy.name:
        return 0.0
    return gap(facts, a.copy, b.copy) / (2.0 if a.moves and b.moves else 1.0)


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
        severity="warning",
        title="An expectation that comes before anything can have got there.",
        reason="""\
Start velocities, blows and forces before the time t give no body more than some speed v, and so nothing gets farther
than `2 v t + g t^2`, which is twice what a thrown body can do; where everything stands still at first, t counts from
the first cause. An event or a place that is farther away cannot be reached in time. Nothing is said of what comes after
a drive has begun, a driven body has set out, or a spring or a bounce is at work.""",
        remedy="Begin sooner, nearer or faster, or let the span end later than the time in the message.",
        example=_BALL % "[0, 0.3]",
        fix=_BALL % "[0, 0.9]",
        run=_soon,
    ),
)
