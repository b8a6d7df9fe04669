"""Expectations that cannot fail, or cannot hold: see `values` and `event_bounds` for what is known before the run.

An expectation of a measure holds if every value, or one statistic of them, lies between its bounds (the ends of `above`
and `below` not included). Where the values that the measure can ever have lie wholly inside, it cannot fail; where they
lie wholly outside, it cannot hold. A span that begins at 0 contains the value at the start: it alone decides a `min`
that has to be small, or an all-the-time that it breaks.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, inf, radians

from text2sim.lint.facts import Facts
from text2sim.lint.joints.angles import in_degrees
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import happening_of
from text2sim.lint.script.values import Values, values_of
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.text.document import Path

ROUNDING = 1e-9


@dataclass(frozen=True)
class Asked:
    """What an expectation asks of a measure."""

    low: float
    high: float
    """Between these, without the ends."""
    first: float
    last: float
    """From and to [s]."""
    stat: str
    """`all` values, or max, min, mean, std, range of them."""


def asked_of(expect: Expect, duration: float) -> Asked:
    """Return what an expectation of a measure asks for."""
    low = -inf if expect.above is None else expect.above
    high = inf if expect.below is None else expect.below
    if expect.equals is not None and expect.tolerance is not None:
        # The ends are allowed here: a hair more than the tolerance has no end.
        width = expect.tolerance * (1 + ROUNDING) + ROUNDING
        low, high = max(low, expect.equals - width), min(high, expect.equals + width)
    if expect.on is not None:  # some time after the start
        return Asked(low, high, ROUNDING, duration, expect.stat or "all")
    if expect.at is not None:
        at = {"start": 0.0, "end": duration}.get(str(expect.at), expect.at)
        return Asked(low, high, float(at), float(at), "all")
    first, last = span_of(expect.during if isinstance(expect.during, tuple) else None, duration)
    return Asked(low, high, first, last, expect.stat or "all")


def bound_of(expect: Expect) -> str:
    """Return the field of an expectation that says what its value is to be."""
    return next(name for name in ("above", "below", "equals") if getattr(expect, name) is not None)


def _measures(facts: Facts) -> Iterator[tuple[str, Expect, Asked, Values]]:
    for name, expect in facts.case.actions.expect.items():
        if expect.measure is None:
            continue
        values = values_of(facts, expect.measure)
        if not values.frozen:  # that a measure is dead is said of the measure
            yield name, expect, asked_of(expect, facts.case.scene.duration), values


def _verdict(asked: Asked, values: Values) -> tuple[str, str]:
    """What is certain (`holds`, `fails`, or nothing), and why."""
    low, high = values.low, values.high
    if asked.stat in ("range", "std"):
        low, high = 0.0, high - low if inf not in (high, -low) else inf
    unit = f" {values.unit}".rstrip()
    if high <= asked.low or low >= asked.high:
        edge = asked.low if high <= asked.low else asked.high
        way = "above" if high <= asked.low else "below"
        return "fails", f"it can never be {way} {edge:.6g}{unit}: {values.why}"
    if (low > asked.low or asked.low == -inf) and (high < asked.high or asked.high == inf):
        return "holds", f"it is always so: {values.why}"
    if values.start is None or asked.first > 0.0:
        return "", ""
    return _at_start(asked, values, unit)


def _at_start(asked: Asked, values: Values, unit: str) -> tuple[str, str]:
    start, error = values.start or 0.0, values.error
    over, under = start - error >= asked.high, start + error <= asked.low
    says = f"at the start it is {start:.4g}{unit}"
    if asked.stat == "all":
        if over or under:
            return "fails", says
        inside = asked.low < start - error and start + error < asked.high
        return ("holds", says) if inside and asked.last == 0.0 else ("", "")
    if asked.stat == "max":
        if over:
            return "fails", f"{says}, and the largest value is no less"
        return ("holds", f"{says}, which is enough") if start - error > asked.low and asked.high == inf else ("", "")
    if asked.stat == "min":
        if under:
            return "fails", f"{says}, and the smallest value is no more"
        return ("holds", f"{says}, which is enough") if start + error < asked.high and asked.low == -inf else ("", "")
    return "", ""


def _cannot_hold(facts: Facts) -> Iterator[Problem]:
    for name, expect, asked, values in _measures(facts):
        verdict, why = _verdict(asked, values)
        if verdict == "fails":
            bound = bound_of(expect)
            if not (values.high <= asked.low or values.low >= asked.high) and asked.first == 0.0 < asked.last:
                why += "; say `during` from when it has got there, or `at` a time"
            text = f"`{expect.measure}` cannot be so: {why}{_degrees(values, asked)}"
            yield facts.problem("cannot-hold", ("actions", "expect", name, bound), text)
    for name, expect in facts.case.actions.expect.items():
        if expect.event is not None:
            why, key = _too_early(facts, expect)
            if why:
                yield facts.problem("cannot-hold", ("actions", "expect", name, key), why)


def _degrees(values: Values, asked: Asked) -> str:
    for bound in (asked.low, asked.high):
        if values.unit == "rad" and in_degrees(bound) and values.low <= radians(bound) <= values.high:
            return f"; joint positions of hinges are in radians: {bound:g} deg is ${{radians({bound:g})}}"
    if values.unit == "rad" and max(abs(values.low), abs(values.high)) < inf:
        return f" ({degrees(values.low):.4g} to {degrees(values.high):.4g} deg, with some give)"
    return ""


def _too_early(facts: Facts, expect: Expect) -> tuple[str, str]:
    """Why an event cannot come in time, and the field that says so."""
    known = happening_of(facts, expect.event or "")
    if known.never or expect.on is not None:
        return "", ""  # that is said of the event; and when the other one happens is not known
    first, last = span_of(expect.within, facts.case.scene.duration)
    if expect.never:
        inside = [time for time in known.at or () if first <= time <= last]
        if inside:
            return f"`{expect.event}` happens at {inside[0]:g} s: the case itself says so", "never"
        return "", ""
    if expect.within is not None:
        if known.at is not None and known.at and not first - ROUNDING <= known.at[0] <= last + ROUNDING:
            return f"`{expect.event}` first happens at {known.at[0]:g} s: the case itself says so", "within"
        if last < known.earliest - ROUNDING:
            return f"`{expect.event}` cannot happen before {known.earliest:g} s, after which it is looked for", "within"
    if expect.count is not None and known.at is not None:
        low, high = (expect.count, expect.count) if isinstance(expect.count, int) else expect.count
        if not low <= len(known.at) <= high:
            return f"`{expect.event}` happens {len(known.at)} times: the case itself says so", "count"
    if expect.before is not None:
        other = happening_of(facts, expect.before)
        if other.at and known.earliest >= other.at[0]:
            return f"`{expect.before}` comes at {other.at[0]:g} s, `{expect.event}` no earlier than that", "before"
    return "", ""


def _cannot_fail(facts: Facts) -> Iterator[Problem]:
    for name, expect, asked, values in _measures(facts):
        verdict, why = _verdict(asked, values)
        if verdict == "holds":
            text = f"`{name}` cannot fail, and so says nothing: {why}"
            yield facts.problem("cannot-fail", ("actions", "expect", name, bound_of(expect)), text)
    for name, expect in facts.case.actions.expect.items():
        if expect.event is None or expect.before is not None or expect.on is not None:
            continue
        where: Path = ("actions", "expect", name)
        known = happening_of(facts, expect.event)
        happens = known.at is not None and not _too_early(facts, expect)[0]
        if happens and not expect.never:
            text = f"`{name}` cannot fail: the case itself says when `{expect.event}` happens"
            yield facts.problem("cannot-fail", (*where, "event"), text)
        elif expect.count is not None and not isinstance(expect.count, int) and expect.count[0] <= 0:
            if expect.count[1] >= 100_000 and expect.within is None:
                text = f"`{name}` cannot fail: any number of times is right"
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
        title="An expectation that nothing can satisfy.",
        reason="""\
By its definition, or by limits that the engine enforces, the measure is never what is asked for; or its value at the
start, which the case decides, breaks an expectation that includes the start; or the case itself says when an event
happens, and it is not then.""",
        remedy="Change the bound, begin `during` after the start, or measure what is meant.",
        example=_BALL % "during: all, above: 0.5",
        fix=_BALL % "during: [0.2, 1], above: 0.5",
        run=_cannot_hold,
    ),
    Rule(
        id="cannot-fail",
        severity="warning",
        title="An expectation that cannot fail.",
        reason="""\
By its definition the measure is always as is asked for, or its value at the start already decides. Such an expectation
passes whatever happens, and hides that nothing is tested.""",
        remedy="Ask for what would be wrong if the scene went wrong, or leave it out.",
        example=_BALL % "at: end, above: -1",
        fix=_BALL % "at: end, above: 1",
        run=_cannot_fail,
    ),
)
