"""Expectations that come before anything can have got there.

In a scene whose only energy is that of `initial_velocity` and of gravity, nothing that starts at rest moves faster than
what it is hit by, but for a light body that a heavy one hits: at most twice as fast. So after the time t no body has
gone farther than  s(t) = 2 v t + g t^2  (twice  v t + g t^2 / 2), v being the largest speed at the start, spin
included. Where motors, forces, springs, driven bodies or bounces add something, nothing is said.
"""

from collections.abc import Iterator
from itertools import product
from math import dist, inf, sqrt
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.gaps import gap
from text2sim.lint.script.outcomes import asked_of, bound_of
from text2sim.lint.script.starts import depth_inside, norm
from text2sim.lint.script.targets import Target, targets_of
from text2sim.lint.script.values import values_of
from text2sim.spec_schema.errors import Problem

MANY = 2_000
"""Pairs of bodies that are looked at, at most."""


def _soon(facts: Facts) -> Iterator[Problem]:
    speed = _fastest(facts)
    if speed is None:
        return
    actions = facts.case.actions
    for name, expect in actions.expect.items():
        where = ("actions", "expect", name)
        if expect.event is not None:
            if expect.never or expect.within is None or expect.count in (0, (0, 0)):
                continue
            way = _way(facts, actions.events[expect.event])
            needs = _time(facts, speed, way)
            if needs > expect.within[1]:
                text = (
                    f"`{expect.event}` needs a way of {way:.3g} m, for which nothing here is fast enough by "
                    f"{expect.within[1]:g} s: it takes {needs:.2g} s at the very least"
                )
                yield facts.problem("too-soon", (*where, "within"), text)
        elif expect.measure is not None:
            asked, values = asked_of(expect, facts.case.scene.duration), values_of(facts, expect.measure)
            measure = actions.measures[expect.measure]
            if measure.kind not in ("position", "displacement") or asked.stat in ("mean", "range"):
                continue
            if values.start is None or values.frozen or getattr(measure, "stat", None) in ("count", "sum", "range"):
                continue
            # A smallest value that has to be low may come at the end of the span; an all-the-time begins at once.
            by = asked.first if asked.stat == "all" else asked.last
            way = max(asked.low - values.start, values.start - asked.high)
            needs = _time(facts, speed, way)
            if asked.stat in ("max", "min") and (asked.stat == "max") != (asked.low > values.start):
                continue
            if 0.0 < by < needs:
                text = (
                    f"`{expect.measure}` has {way:.3g} {values.unit} to go from where it starts, for which nothing "
                    f"here is fast enough by {by:g} s: it takes {needs:.2g} s at the very least"
                )
                yield facts.problem("too-soon", (*where, bound_of(expect)), text)


def adds_energy(facts: Facts) -> bool:
    """Whether anything but start velocities and gravity moves bodies."""
    plan = facts.plan
    if plan.drives or plan.wrenches or plan.prescribed or plan.contact or plan.motors or plan.changes:
        return True
    trees = facts.lowering.trees.values()
    return any(joint.spring > 0.0 for tree in trees for link in tree.links() for _, joint in link.all_joints())


def _fastest(facts: Facts) -> float | None:
    """Largest speed [m/s] of anything at the start; None if something adds energy to the scene."""
    if adds_energy(facts):
        return None
    fastest = 0.0
    for row in facts.rows.velocities:
        copy = facts.copies[row.entity]
        box = facts.box(copy)
        far = dist(*box) if box is not None else 0.0
        fastest = max(fastest, norm(row.linear) + norm(row.angular) * far)
    return fastest


def _time(facts: Facts, speed: float, way: float) -> float:
    """Time [s] that a way [m] takes at the very least: s(t) = 2 v t + g t^2, solved for t."""
    gravity = norm(facts.plan.gravity)
    if way <= 0.0:
        return 0.0
    if gravity == 0.0:
        return way / (2 * speed) if speed > 0.0 else inf
    return (sqrt(speed**2 + gravity * way) - speed) / gravity


def _way(facts: Facts, event: Any) -> float:
    """Shortest way [m] that some body has to go before an event happens; 0 if that is not known."""
    if event.kind == "contact":
        first, second = (targets_of(facts).select(selector) for selector in event.between)
        if len(first) * len(second) > MANY:
            return 0.0
        return min((_gap(facts, a, b) for a, b in product(first, second) if a.label != b.label), default=0.0)
    if event.kind == "enters":
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
Where nothing but start velocities and gravity moves the bodies, none gets farther than `2 v t + g t^2`, which is twice
what a thrown body can do. An event or a place that is farther away cannot be reached in time.""",
        way_out="Begin nearer or faster, or let the span end later than the time in the message.",
        example=_BALL % "[0, 0.3]",
        mended=_BALL % "[0, 0.9]",
        run=_soon,
    ),
)
