"""Causes of motion in a scene, their times, and bounds on how far bodies move by a time.

An impulse J gives a free body of mass m the speed J / m, a force F in the time t at most F t / m; off centre, or if a
mount holds the body, up to four times as much at its far end (a rod that is hit at one end: four times; on a hinge:
three times). A body hit by it gets at most twice that speed (a heavy body against a light one), and all bodies may also
fall: so nothing moves farther in the time t than  2 v t + g t^2.

If everything is at rest at the start (`initial_rest`), the time counts from the first cause. Nothing is known after the
first cause of unknown strength (a drive, a driven body, a moving surface, a spring, a bounce).
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from math import dist, hypot, inf
from typing import NamedTuple

from text2sim.compiler.prescribed import sets_out
from text2sim.compiler.schedules import extremes
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.motion.initial_rest import all_still
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.controls import Force, Impulse
from text2sim.spec_schema.models.motion import Sine, Steps

LEVER_FACTOR = 4.0
"""Largest speed of the far end of a body over that of its centre after a push off centre."""


class Cause(NamedTuple):
    """A cause of motion: from `start` to `end` [s] it adds at most `speed` [m/s] to a body."""

    start: float
    name: str
    """Name in the case."""
    end: float = inf
    speed: float = inf
    """Infinite if its strength is not known."""


class Causes:
    """The causes of motion in a scene, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        found = [Cause(0.0, "")] if self._restless() else []
        found += [Cause(0.0, rows[0].control) for rows in facts.rows.joints.later.values()]  # at any time
        found += [*self._starts(), *self._wrenches(), *self._other_causes()]
        self.pushes = [cause for cause in found if cause.speed < inf]
        self.unknown = min((cause.start for cause in found if cause.speed == inf), default=inf)
        """Time [s] of the first cause of unknown strength."""
        self.onset, self.first = min(((cause.start, cause.name) for cause in found), default=(inf, ""))
        """Time [s] and name of the first cause."""
        if self._springy():
            self.unknown = min(self.unknown, self.onset if all_still(self.facts) else 0.0)

    @cached_property
    def quiet(self) -> float:
        """Time [s] until which everything is at rest."""
        return self.onset if self.onset > 0.0 and all_still(self.facts) else 0.0

    def reaches(self, distance: float, t: float) -> bool:
        """Return whether anything may have moved a distance [m] by a time [s]."""
        if distance <= 0.0 or t > self.unknown:
            return True
        # `quiet` is expensive, and only reduces the bound.
        return self._reach(t, 0.0) >= distance and self._reach(t, self.quiet) >= distance

    def _reach(self, t: float, quiet: float) -> float:
        """Return an upper bound on the distance [m] moved by a time [s], if nothing moves until `quiet`."""
        time = t - quiet
        if time <= 0.0:
            return 0.0
        if t > self.unknown:
            return inf
        speed = sum(
            push.speed * (min(1.0, (t - push.start) / (push.end - push.start)) if push.end > push.start else 1.0)
            for push in self.pushes
            if push.start < t
        )
        return 2 * speed * time + self.facts.pull * time**2

    def soonest(self, distance: float) -> float:
        """Return a lower bound on the time [s] to move a distance [m]; infinite if nothing moves so far in the run."""
        if distance <= 0.0:
            return 0.0
        low, high = 0.0, self.facts.case.scene.duration
        if not self.reaches(distance, high):
            return inf
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if not self.reaches(distance, middle) else (low, middle)
        return high

    def _restless(self) -> bool:
        """Return whether something of unknown strength acts from the start."""
        return bool(self.facts.plan.changes) or any(is_soft(body) for body in self.facts.case.bodies.values())

    def _springy(self) -> bool:
        """Return whether springs or bounces may return stored energy."""
        trees = self.facts.lowering.trees.values()
        springs = any(joint.spring > 0.0 for tree in trees for link in tree.links() for _, joint in link.all_joints())
        return springs or bool(self.facts.plan.contact)

    def _starts(self) -> Iterator[Cause]:
        for name in self.facts.lowering.joint_velocities:
            yield Cause(0.0, name)
        for row in self.facts.rows.velocities:
            box = self.facts.box(self.facts.copies[row.entity])
            far = dist(*box) if box is not None else 0.0
            speed = hypot(*row.linear) + hypot(*row.angular) * far
            if speed > 0.0:
                yield Cause(0.0, row.control, 0.0, speed)

    def _wrenches(self) -> Iterator[Cause]:
        facts = self.facts
        for row in facts.rows.wrenches:
            control = facts.case.actions.controls[row.control]
            if not any(row.force) and not any(row.torque):
                continue
            mass = facts.masses.get(row.entity, 0.0)
            known = isinstance(control, Impulse | Force) and mass > 0.0 and row.link is None
            if not known:
                yield Cause(row.start, row.control)
                continue
            lever = 1.0 if row.point is None and facts.free(facts.copies[row.entity]) else LEVER_FACTOR
            gain = lever * hypot(*row.force) / mass
            if isinstance(control, Force):
                end = min(row.end, facts.case.scene.duration)
                gain *= max(0.0, end - row.start) * max(map(abs, extremes(control.scale)))
                yield Cause(row.start, row.control, max(end, row.start), gain)
            else:
                yield Cause(row.start, row.control, row.start, gain)

    def _other_causes(self) -> Iterator[Cause]:
        """Yield the drives, driven bodies, moving surfaces, springs, releases and removals."""
        facts = self.facts
        for (entity, name), spans in spans_of(facts).items():
            joint = facts.once(Mechanics).joint(facts.copies[entity], name)
            rest = joint.start if joint is not None else facts.lowering.initial.get(entity, {}).get(name, 0.0)
            moved = [(time, span.control) for span in spans if (time := _moves(span, rest)) is not None]
            if moved:
                yield Cause(*min(moved))
        for body, model in facts.case.bodies.items():
            if isinstance(model, Driven):
                for copy in facts.placed[body]:
                    yield Cause(sets_out(copy.model.motion), body)
        for belt in facts.plan.belts:
            yield Cause(0.0, facts.copies[belt.entity].body)
        for weld in facts.rows.welds:
            if not weld.on:
                yield Cause(weld.at, weld.control, weld.at, 0.0)
        for spring in facts.rows.springs:
            yield Cause(spring.start, spring.control)
        for removal in facts.rows.removals:
            at = 0.0 if removal.at is None else removal.at  # an event may come at any time
            yield Cause(at, removal.control, at, 0.0)


def _moves(span: Span, rest: float) -> float | None:
    """Return when [s] a drive first moves its joint; None if it never does."""
    still = rest if span.mode == "position" else 0.0
    corners = span.corners()
    if isinstance(span.schedule, Sine) or corners[0][1] != still:
        return span.start
    if isinstance(span.schedule, Steps):
        return next((t for t, value in corners if value != still), None)
    return next((t for (t, _), (_, value) in pairwise(corners) if value != still), None)
