"""Events whose condition holds when the run begins; see `start_values` for the values at the start."""

from collections.abc import Callable, Iterator
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.lint.facts import Facts
from text2sim.lint.motion.initial_rest import all_still
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import bounds_of
from text2sim.lint.script.measure_bounds import values_of
from text2sim.lint.script.start_values import depth_inside
from text2sim.lint.script.targets import Targets
from text2sim.lint.soft.gaps import Gaps
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import quoted

MAX_TOUCHING_GAP = 1e-4
"""Largest gap [m] of bodies that touch from the first step."""


def _true_at_start(facts: Facts) -> Iterator[Problem]:
    actions = facts.case.actions
    used = {name for expect in actions.expect.values() for name in (expect.event, expect.before, expect.on)}
    used |= {getattr(control, "on", None) for control in actions.controls.values()}
    for name, event in actions.events.items():
        if (
            name not in used
            or event.after is not None
            or event.kind not in _TRUE_AT_START
            or bounds_of(facts, name).never
        ):
            continue
        why = _TRUE_AT_START[event.kind](facts, event)
        if why:
            yield facts.problem("true-at-start", ("actions", "events", name), f"`{name}`: {why}", key=True)


def _contact(facts: Facts, event: Any) -> str:
    pairs = facts.once(Targets).pairs(event.between) or []
    if any(target.link is not None or target.part is not None for pair in pairs for target in pair):
        return ""
    for a, b in pairs:
        if a.known and b.known and _gap(facts, a.copy, b.copy) <= MAX_TOUCHING_GAP:
            return (
                f"`{a.label}` and `{b.label}` touch from the start, so it happens at once; use `after` another event "
                "to find later contacts"
            )
    return ""


def _gap(facts: Facts, a: Copy, b: Copy) -> float:
    gaps = facts.once(Gaps)
    for one, other in ((a, b), (b, a)):
        if (ground := facts.ground(other)) is not None:
            return gaps.to_plane(one, ground, 1.0)
    return gaps.between(a, b, 1.0)


def _threshold(facts: Facts, event: Any) -> str:
    values = values_of(facts, event.measure)
    if values.start is None:
        return ""
    unit = f" {values.unit}".rstrip()
    above = event.above is not None and values.start - values.error > event.above
    below = event.below is not None and values.start + values.error < event.below
    if not above and not below or _leaves_first(facts, event):
        return ""
    side, bound = ("above", event.above) if above else ("below", event.below)
    return (
        f"`{event.measure}` is {values.start:.4g}{unit} at the start, already {side} {bound:g}{unit}; it happens only "
        f"when the measure comes back and crosses {bound:g} again"
    )


def _leaves_first(facts: Facts, event: Any) -> bool:
    """Return whether another event finds the measure beyond the bound: then it is the return that is meant."""
    others = [e for e in facts.case.actions.events.values() if e.kind == "threshold" and e.measure == event.measure]
    if event.below is not None:
        return any(other.above is not None and other.above >= event.below for other in others)
    return any(other.below is not None and other.below <= event.above for other in others)


def _region(facts: Facts, event: Any) -> str:
    targets = facts.once(Targets).select(event.of)
    if not targets or not all(target.known for target in targets):
        return ""
    depths = [depth_inside(event.region, target.origin) for target in targets]
    if event.kind == "enters" and min(depths) > 0.0:
        return f"{_named(event)} inside the region at the start, and enters it only after it has left it"
    if event.kind == "leaves" and max(depths) < 0.0:
        return f"{_named(event)} outside the region at the start, and leaves it only after it has entered it"
    return ""


def _rest_at_start(facts: Facts, event: Any) -> str:
    targets = facts.once(Targets).select(event.of)
    if not targets or any(target.driven for target in targets) or not all_still(facts):
        return ""
    if any(row.entity == target.copy.name for target in targets for row in facts.rows.velocities):
        return ""
    return f"{_named(event)} at rest from the start, so it happens at 0 s; use `after` to find a later rest"


def _named(event: Any) -> str:
    """Return the bodies of an event with a verb: `a` is, or `a`, `b` are."""
    return f"{quoted(event.subjects)} {'is' if len(event.subjects) == 1 else 'are'}"


_TRUE_AT_START: dict[str, Callable[[Facts, Any], str]] = {
    "contact": _contact,
    "threshold": _threshold,
    "enters": _region,
    "leaves": _region,
    "rest": _rest_at_start,
}

_BALL = """\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
  events:
    is_low: {kind: threshold, measure: height, below: %s}
  expect:
    comes_down: {event: is_low}
"""

RULES = (
    Rule(
        id="true-at-start",
        title="The condition of an event holds when the run begins.",
        reason="""\
Bodies that touch from the start have contact in the first step, and bodies at rest are at rest at once: such an event
says nothing about the run. A threshold that is already crossed, and a region that a body is already in, count only when
they are crossed again. It is silent about a threshold if another event finds its measure on the other side.""",
        remedy="""\
Choose a bound or a region beyond the start, or give another event as `after`. `check` also lists the expectations that
hold at the start.""",
        example=_BALL % "1.2",
        fix=_BALL % "0.5",
        run=_true_at_start,
    ),
)
