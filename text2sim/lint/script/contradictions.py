"""Expectations of which only one can hold.

Of one measure: what must be so at every time of a span (or at one time) has to fit with every other such wish at the
same time, and with what a statistic over a span within it has to reach. Of events: an event that must never happen
cannot also happen; first times lie in every `within`; and `before` has to fit with the spans, without cycles.
"""

from collections.abc import Iterator
from itertools import combinations, islice

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.outcomes import Asked, asked_of, bound_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.names.reference_cycles import find_cycles

Wish = tuple[str, Expect, Asked]
PAIRS = 50_000
"""Of the expectations of one measure or event that are held against each other: those of the first three hundred."""


def _contradictions(facts: Facts) -> Iterator[Problem]:
    duration = facts.case.scene.duration
    wishes: dict[str, list[Wish]] = {}
    events: dict[str, list[tuple[str, Expect]]] = {}
    for name, expect in facts.case.actions.expect.items():
        if expect.on is not None:
            continue  # when is not known
        if expect.measure is not None:
            wishes.setdefault(expect.measure, []).append((name, expect, asked_of(expect, duration)))
        elif expect.event is not None:
            events.setdefault(expect.event, []).append((name, expect))
    for measure, group in wishes.items():
        for a, b in islice(combinations(group, 2), PAIRS):
            if _clash(a[2], b[2]) or _clash(b[2], a[2]):
                text = f"`{a[0]}` and `{b[0]}` cannot both hold: they ask for different values of `{measure}`"
                at = max(a[2].first, b[2].first)
                text += f" at {at:g} s" if a[2].stat == b[2].stat == "all" else " over the same span"
                yield facts.problem("contradiction", ("actions", "expect", b[0], bound_of(b[1])), text)
    for event, group in events.items():
        for a, b in islice(combinations(group, 2), PAIRS):
            if why := _at_odds(a[1], b[1], duration):
                text = f"`{a[0]}` and `{b[0]}` cannot both hold: `{event}` {why}"
                yield facts.problem("contradiction", ("actions", "expect", b[0]), text, key=True)
    yield from _order(facts, events)


def _clash(a: Asked, b: Asked) -> bool:
    """Whether `a`, which holds for all values, leaves `b` nothing."""
    if a.stat == b.stat and a.stat != "all":
        return (a.first, a.last) == (b.first, b.last) and max(a.low, b.low) >= min(a.high, b.high)
    if a.stat != "all":
        return False
    if b.stat == "all":
        return max(a.first, b.first) <= min(a.last, b.last) and max(a.low, b.low) >= min(a.high, b.high)
    if b.stat == "range":
        return b.first >= a.first and b.last <= a.last and a.high - a.low <= b.low
    if b.stat == "std":  # at most half of the range
        return b.first >= a.first and b.last <= a.last and a.high - a.low <= 2 * b.low
    covered = b.first >= a.first and b.last <= a.last
    if covered and (a.high <= b.low or a.low >= b.high):
        return True
    # One value of the span is enough to break a largest or a smallest one.
    touching = max(a.first, b.first) <= min(a.last, b.last)
    return touching and (b.stat == "max" and a.low >= b.high or b.stat == "min" and a.high <= b.low)


def _times(expect: Expect) -> tuple[int, float]:
    if expect.never:
        return 0, 0
    if expect.count is None:
        return 1, float("inf")
    return (expect.count, expect.count) if isinstance(expect.count, int) else expect.count


def _at_odds(a: Expect, b: Expect, duration: float) -> str:
    """Why two expectations of one event cannot both hold."""
    first, second = span_of(a.within, duration), span_of(b.within, duration)
    if a.never and b.never:
        return ""
    if a.never or b.never:
        span, other, least = (first, second, _times(b)[0]) if a.never else (second, first, _times(a)[0])
        inside = span[0] <= other[0] and other[1] <= span[1]
        return "must not happen, and must" if inside and least > 0 else ""
    (least, most), (less, more) = _times(a), _times(b)
    if max(least, less) > min(most, more):
        return "is to happen a different number of times"
    if least > 0 and less > 0 and max(first[0], second[0]) > min(first[1], second[1]):
        return "has one first time, and is to have it in two spans"
    return ""


def _order(facts: Facts, events: dict[str, list[tuple[str, Expect]]]) -> Iterator[Problem]:
    """Yield what is wrong with `before`."""
    follows: dict[str, str] = {}
    for event, group in events.items():
        for name, expect in group:
            other = expect.before
            if other is None or other not in facts.case.actions.events:
                continue
            where = ("actions", "expect", name, "before")
            follows[event] = other
            start = (expect.within or (0.0, 0.0))[0]
            rivals = [rival for _, rival in events.get(other, []) if rival.within and _times(rival)[0] > 0]
            ends = [span_of(rival.within, facts.case.scene.duration)[1] for rival in rivals]
            if any(end <= start for end in ends):
                text = f"`{other}` is to happen by {min(ends):g} s, and `{event}` not before {start:g} s"
                yield facts.problem("contradiction", where, text)
            elif any(rival.never and rival.within is None for _, rival in events.get(other, [])):
                text = f"`{other}` must never happen, and so nothing can come before it"
                yield facts.problem("contradiction", where, text)
            elif facts.case.actions.events[event].after == other:
                text = f"`{event}` is looked for after `{other}` only, and so never comes before it"
                yield facts.problem("contradiction", where, text)
    for cycle in find_cycles(follows):
        name = next(name for name, expect in events[cycle[0]] if expect.before is not None)
        text = f"events cannot come before each other in a circle: {' -> '.join([*cycle, cycle[0]])}"
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
        title="Two expectations of which only one can hold.",
        reason="""\
Two bounds on one measure at the same time leave no value, or two expectations want an event at different times, or an
event that must not happen. Whatever the run does, the case fails.""",
        remedy="Change one of the two, or the times to which they apply.",
        example=_BALL % "0.8",
        fix=_BALL % "0.1",
        run=_contradictions,
    ),
)
