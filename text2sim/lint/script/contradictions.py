"""Expectations that contradict each other.

For one measure: a bound at every time of a span (or at one time) has to agree with every other such bound at the same
time, and with the bounds of statistics over a span within it. For events: an event that must never happen cannot also
happen; its first time is in every `within`; and `before` has to agree with the spans, without cycles.
"""

from collections.abc import Iterator
from itertools import combinations, islice

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.outcomes import Bound, bound_of, count_bounds, field_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import CHANGE, SPREADS, Expect
from text2sim.spec_schema.names.reference_cycles import find_cycles

NamedBound = tuple[str, Expect, Bound]
MAX_PAIRS = 50_000
"""Most pairs of expectations of one measure or event that are compared: those of the first three hundred."""


def _contradictions(facts: Facts) -> Iterator[Problem]:
    duration = facts.case.scene.duration
    bounds: dict[str, list[NamedBound]] = {}
    events: dict[str, list[tuple[str, Expect]]] = {}
    for name, expect in facts.case.actions.expect.items():
        if expect.on is not None or expect.swing is not None:
            continue  # its time is not known, or other swings count
        if expect.measure is not None:
            bounds.setdefault(expect.measure, []).append((name, expect, bound_of(expect, duration)))
        elif expect.event is not None:
            events.setdefault(expect.event, []).append((name, expect))
    for measure, group in bounds.items():
        for a, b in islice(combinations(group, 2), MAX_PAIRS):
            if _clash(a[2], b[2]) or _clash(b[2], a[2]):
                text = f"`{a[0]}` and `{b[0]}` cannot both hold: they require different values of `{measure}`"
                at = max(a[2].first, b[2].first)
                text += f" at {at:g} s" if a[2].stat == b[2].stat == "all" else " over the same span"
                yield facts.problem("contradiction", ("actions", "expect", b[0], field_of(b[1])), text)
    for event, group in events.items():
        for a, b in islice(combinations(group, 2), MAX_PAIRS):
            if why := _at_odds(a[1], b[1], duration):
                text = f"`{a[0]}` and `{b[0]}` cannot both hold: `{event}` {why}"
                yield facts.problem("contradiction", ("actions", "expect", b[0]), text, key=True)
    yield from _order(facts, events)


def _clash(a: Bound, b: Bound) -> bool:
    """Return whether `a`, if it holds for all values, excludes `b`."""
    disjoint = max(a.low, b.low) >= min(a.high, b.high)
    touching = max(a.first, b.first) <= min(a.last, b.last)
    covered = b.first >= a.first and b.last <= a.last
    if a.stat != "all":
        return a.stat == b.stat and (a.first, a.last) == (b.first, b.last) and disjoint
    if b.stat == "all":
        return touching and disjoint
    if b.stat in SPREADS:  # a standard deviation is at most half of the range
        return covered and a.high - a.low <= (b.low if b.stat == "range" else 2 * b.low)
    if b.stat == CHANGE:
        return covered and (a.high - a.low <= b.low or a.low - a.high >= b.high)
    if covered and (a.high <= b.low or a.low >= b.high):
        return True
    # One value of the span is enough to violate a maximum or a minimum.
    return touching and (b.stat == "max" and a.low >= b.high or b.stat == "min" and a.high <= b.low)


def _at_odds(a: Expect, b: Expect, duration: float) -> str:
    """Return why two expectations of one event cannot both hold; empty if they can."""
    first, second = span_of(a.within, duration), span_of(b.within, duration)
    if a.never and b.never:
        return ""
    if a.never or b.never:
        span, other, least = (first, second, count_bounds(b)[0]) if a.never else (second, first, count_bounds(a)[0])
        inside = span[0] <= other[0] and other[1] <= span[1]
        return "must and must not happen" if inside and least > 0 else ""
    (least, most), (less, more) = count_bounds(a), count_bounds(b)
    if max(least, less) > min(most, more):
        return "has to happen different numbers of times"
    if least > 0 and less > 0 and max(first[0], second[0]) > min(first[1], second[1]):
        return "has to happen first in two separate spans"
    return ""


def _order(facts: Facts, events: dict[str, list[tuple[str, Expect]]]) -> Iterator[Problem]:
    """Check `before`."""
    follows: dict[str, str] = {}
    for event, group in events.items():
        for name, expect in group:
            other = expect.before
            if other is None or other not in facts.case.actions.events:
                continue
            where = ("actions", "expect", name, "before")
            follows[event] = other
            start = (expect.within or (0.0, 0.0))[0]
            rivals = [rival for _, rival in events.get(other, []) if rival.within and count_bounds(rival)[0] > 0]
            ends = [span_of(rival.within, facts.case.scene.duration)[1] for rival in rivals]
            if any(end <= start for end in ends):
                text = f"`{other}` has to happen by {min(ends):g} s, and `{event}` not before {start:g} s"
                yield facts.problem("contradiction", where, text)
            elif any(rival.never and rival.within is None for _, rival in events.get(other, [])):
                text = f"`{other}` must never happen, so nothing can happen before it"
                yield facts.problem("contradiction", where, text)
            elif facts.case.actions.events[event].after == other:
                text = f"`{event}` is only searched after `{other}`, so it never happens before it"
                yield facts.problem("contradiction", where, text)
    for cycle in find_cycles(follows):
        name = next(name for name, expect in events[cycle[0]] if expect.before is not None)
        text = f"events cannot happen before each other in a cycle: {' -> '.join([*cycle, cycle[0]])}"
        yield facts.problem("contradiction", ("actions", "expect", name, "before"), text)


_BALL = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
  expect:
    stays_up: {measure: height, during: [0, %s], above: 0.9}
    is_down: {measure: height, at: 0.5, below: 0.5}
"""

RULES = (
    Rule(
        id="contradiction",
        severity="error",
        title="Two expectations contradict each other.",
        reason="""\
Two bounds on one measure at the same time leave no value, or two expectations require an event at different times, or
an event that must not happen. The case fails whatever the run does.""",
        remedy="Change one of the two, or the times to which they apply.",
        example=_BALL % "0.8",
        fix=_BALL % "0.1",
        run=_contradictions,
    ),
)
