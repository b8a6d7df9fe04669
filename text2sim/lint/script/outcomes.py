"""Expectations that cannot fail or cannot hold, from `measure_bounds` and `event_bounds`.

An expectation of a measure holds if every value, or a statistic of them, is between its bounds (`above` and `below` are
exclusive). If all possible values of the measure are inside, it cannot fail; if they are all outside, it cannot hold. A
span that begins at 0 contains the value at the start, which alone may decide a `min`, a `max`, or a bound at all times.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, inf, radians

from text2sim.lint.facts import Facts
from text2sim.lint.joints.angles import in_degrees
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import bounds_of
from text2sim.lint.script.measure_bounds import Values, values_of
from text2sim.lint.words import as_radians
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import CHANGE, SPREADS, SWINGS, Expect
from text2sim.spec_schema.text.document import Path

ROUNDING = 1e-9


@dataclass(frozen=True)
class Bound:
    """The bound that an expectation puts on a measure."""

    low: float
    high: float
    """Bounds, both exclusive."""
    first: float
    last: float
    """Start and end [s]."""
    stat: str
    """`all` values, or a `stat` of an expectation."""

    def of_constant(self, value: float) -> float | None:
        """Return what is bounded, of a measure that stays at `value`; None if it has none such."""
        return value if self.stat not in (*SPREADS, CHANGE, *SWINGS) else None if self.stat in SWINGS[1:] else 0.0


def bound_of(expect: Expect, duration: float) -> Bound:
    """Return the bound of an expectation on a measure."""
    low = -inf if expect.above is None else expect.above
    high = inf if expect.below is None else expect.below
    if expect.equals is not None and expect.tolerance is not None:
        # The tolerance is inclusive, so the exclusive bounds are slightly wider.
        width = expect.tolerance * (1 + ROUNDING) + ROUNDING
        low, high = max(low, expect.equals - width), min(high, expect.equals + width)
    if expect.on is not None:  # at an unknown time after the start
        return Bound(low, high, ROUNDING, duration, expect.stat or "all")
    if expect.at is not None:
        at = {"start": 0.0, "end": duration}.get(str(expect.at), expect.at)
        return Bound(low, high, float(at), float(at), "all")
    first, last = span_of(expect.during if isinstance(expect.during, tuple) else None, duration)
    return Bound(low, high, first, last, expect.stat or "all")


def count_bounds(expect: Expect) -> tuple[int, float]:
    """Return the smallest and the largest number of times that an event may happen to satisfy an expectation."""
    if expect.never:
        return 0, 0
    if expect.count is None:
        return 1, inf
    return (expect.count, expect.count) if isinstance(expect.count, int) else expect.count


def field_of(expect: Expect) -> str:
    """Return the first field of an expectation that gives a bound."""
    return next(name for name in ("above", "below", "equals") if getattr(expect, name) is not None)


def _measures(facts: Facts) -> Iterator[tuple[str, Expect, Bound, Values]]:
    for name, expect in facts.case.actions.expect.items():
        if expect.measure is None:
            continue
        values = values_of(facts, expect.measure)
        if not values.frozen:  # `dead-measure` reports the measure
            if expect.stat in SWINGS:
                values = Values(low=-inf if expect.stat == "decrement" else 0.0, why="it is never negative")
            yield name, expect, bound_of(expect, facts.case.scene.duration), values


def _verdict(bound: Bound, values: Values) -> tuple[str, str]:
    """Return `holds`, `fails`, or nothing if it is not certain, and why."""
    low, high = values.low, values.high
    if bound.stat in SPREADS:
        low, high = 0.0, high - low if inf not in (high, -low) else inf
    elif bound.stat == CHANGE:
        low, high = (low - high, high - low) if inf not in (high, -low) else (-inf, inf)
    unit = f" {values.unit}".rstrip()
    if high <= bound.low or low >= bound.high:
        edge = bound.low if high <= bound.low else bound.high
        side = "above" if high <= bound.low else "below"
        return "fails", f"it can never be {side} {edge:.6g}{unit}: {values.why}"
    if (low > bound.low or bound.low == -inf) and (high < bound.high or bound.high == inf):
        return "holds", values.why
    if values.start is None or bound.first > 0.0:
        return "", ""
    return _at_start(bound, values, unit)


def _at_start(bound: Bound, values: Values, unit: str) -> tuple[str, str]:
    start, error = values.start or 0.0, values.error
    over, under = start - error >= bound.high, start + error <= bound.low
    why = f"at the start it is {start:.4g}{unit}"
    if bound.stat == "all":
        if over or under:
            return "fails", why
        inside = bound.low < start - error and start + error < bound.high
        return ("holds", why) if inside and bound.last == 0.0 else ("", "")
    if bound.stat == "max":
        if over:
            return "fails", f"{why}, and the largest value is at least that"
        return ("holds", f"{why}, which is enough") if start - error > bound.low and bound.high == inf else ("", "")
    if bound.stat == "min":
        if under:
            return "fails", f"{why}, and the smallest value is at most that"
        return ("holds", f"{why}, which is enough") if start + error < bound.high and bound.low == -inf else ("", "")
    return "", ""


def _cannot_hold(facts: Facts) -> Iterator[Problem]:
    for name, expect, bound, values in _measures(facts):
        verdict, why = _verdict(bound, values)
        if verdict == "fails":
            if not (values.high <= bound.low or values.low >= bound.high) and bound.first == 0.0 < bound.last:
                why += "; begin `during` later, or give `at`"
            text = f"`{expect.measure}` cannot satisfy this: {why}{_degrees(values, bound)}"
            yield facts.problem("cannot-hold", ("actions", "expect", name, field_of(expect)), text)
    for name, expect in facts.case.actions.expect.items():
        if expect.event is not None:
            why, key = _too_early(facts, expect)
            if why:
                yield facts.problem("cannot-hold", ("actions", "expect", name, key), why)


def _degrees(values: Values, bound: Bound) -> str:
    for edge in (bound.low, bound.high):
        if values.unit == "rad" and in_degrees(edge) and values.low <= radians(edge) <= values.high:
            return f"; joint positions of hinges are in radians: {as_radians(edge)}"
    if values.unit == "rad" and max(abs(values.low), abs(values.high)) < inf:
        return f" ({degrees(values.low):.4g} to {degrees(values.high):.4g} deg, with a margin)"
    return ""


def _too_early(facts: Facts, expect: Expect) -> tuple[str, str]:
    """Return why an event cannot satisfy its expectation, and which field it violates."""
    known = bounds_of(facts, expect.event or "")
    if known.never or expect.on is not None:
        return "", ""  # `dead-event` reports the event; the time of `on` is not known
    first, last = span_of(expect.within, facts.case.scene.duration)
    if expect.never:
        inside = [time for time in known.at or () if first <= time <= last]
        if inside:
            return f"`{expect.event}` happens at {inside[0]:g} s, as the case specifies", "never"
        return "", ""
    if expect.within is not None:
        if known.at is not None and known.at and not first - ROUNDING <= known.at[0] <= last + ROUNDING:
            return f"`{expect.event}` first happens at {known.at[0]:g} s, as the case specifies", "within"
        if last < known.earliest - ROUNDING:
            return f"`{expect.event}` cannot happen before {known.earliest:g} s, when its `after` happens", "within"
    if expect.count is not None and known.at is not None:
        least, most = count_bounds(expect)
        if not least <= len(known.at) <= most:
            return f"`{expect.event}` happens {len(known.at)} times, as the case specifies", "count"
    if expect.before is not None:
        other = bounds_of(facts, expect.before)
        if other.at and known.earliest >= other.at[0]:
            return f"`{expect.before}` happens at {other.at[0]:g} s, `{expect.event}` not earlier", "before"
    return "", ""


def _cannot_fail(facts: Facts) -> Iterator[Problem]:
    for name, expect, bound, values in _measures(facts):
        verdict, why = _verdict(bound, values)
        if verdict == "holds":
            text = f"`{expect.measure}` always satisfies `{name}`, which therefore tests nothing: {why}"
            yield facts.problem("cannot-fail", ("actions", "expect", name, field_of(expect)), text)
    for name, expect in facts.case.actions.expect.items():
        if expect.event is None or expect.before is not None or expect.on is not None:
            continue
        where: Path = ("actions", "expect", name)
        known = bounds_of(facts, expect.event)
        least, most = count_bounds(expect)
        happens = known.at is not None and not _too_early(facts, expect)[0]
        if happens and not expect.never:
            text = f"`{name}` cannot fail: the case specifies when `{expect.event}` happens"
            yield facts.problem("cannot-fail", (*where, "event"), text)
        elif least <= 0 and most >= 100_000 and expect.within is None:
            text = f"`{name}` cannot fail: it accepts any number of times"
            yield facts.problem("cannot-fail", (*where, "count"), text)


_BALL = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
actions:
  measures:
    speed: {kind: speed, of: ball}
  expect:
    goes: {measure: speed, %s}
"""

RULES = (
    Rule(
        id="cannot-hold",
        severity="error",
        title="An expectation cannot hold.",
        reason="""\
By its definition, or by limits that the engine enforces, the measure is never within the bounds; or its value at the
start, which the case determines, violates an expectation that includes the start; or the case specifies another time
for an event.""",
        remedy="Change the bound, begin `during` after the start, or use the intended measure.",
        example=_BALL % "during: all, above: 0.5",
        fix=_BALL % "during: [0.2, 1], above: 0.5",
        run=_cannot_hold,
    ),
    Rule(
        id="cannot-fail",
        title="An expectation cannot fail.",
        reason="""\
By its definition the measure is always within the bounds, or its value at the start decides. Such an expectation passes
whatever happens and tests nothing.""",
        remedy="Change the bound so that it fails if the scene goes wrong, or leave the expectation out.",
        example=_BALL % "at: end, above: -1",
        fix=_BALL % "at: end, above: 1",
        run=_cannot_fail,
    ),
)
