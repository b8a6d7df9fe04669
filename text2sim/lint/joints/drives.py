"""Drives of each joint in sequence, and the accelerations that they demand."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import pi, radians

from text2sim.compiler.drives import DriveTarget
from text2sim.compiler.schedules import value_at
from text2sim.lint.facts import Facts, once_per_case
from text2sim.spec_schema.models.motion import Constant, Piecewise, Ramp, Schedule, Sine, Steps
from text2sim.spec_schema.text.document import Path


@dataclass(frozen=True)
class Span:
    """A drive during the time that it alone controls its joint."""

    mode: str
    """`position`, `velocity` or `force`."""
    schedule: Schedule
    start: float
    end: float
    """Start and end [s], within the run."""
    before: float
    """Start value of a ramp without `from`."""
    control: str
    anytime: bool = False
    """Whether it begins at an event: its times assume that this happens at the start."""

    @property
    def where(self) -> Path:
        """Path of the target in the case."""
        return ("actions", "controls", self.control, self.mode)

    def value(self, t: float) -> float:
        """Return the target at time t [s]."""
        return value_at(self.schedule, t, self.before)

    def corners(self) -> list[tuple[float, float]]:
        """Return the times [s] and targets between which it is linear or smooth; for a sine, its extrema."""
        inner: list[float] = []
        if isinstance(self.schedule, Ramp):
            inner = [self.schedule.start, self.schedule.end]
        elif isinstance(self.schedule, Steps | Piecewise):
            inner = list(self.schedule.times)
        elif isinstance(self.schedule, Sine):
            inner = list(_peaks(self.schedule, self.start, self.end))
        times = [self.start, *(t for t in inner if self.start < t < self.end), self.end]
        return [(t, self.value(t)) for t in times]

    def extremes(self) -> tuple[float, float]:
        """Return the lowest and highest target."""
        values = [value for _, value in self.corners()]
        return min(values), max(values)

    @property
    def moves(self) -> bool:
        """Whether it asks for any motion or force."""
        if self.mode == "position":
            return len({self.before, *self.extremes()}) > 1
        return self.extremes() != (0.0, 0.0)


@dataclass(frozen=True)
class Demand:
    """A change of a target, and the motion that it demands."""

    start: float
    end: float
    """Start and end [s]."""
    first: float
    last: float
    """Position or speed at the start and at the end."""
    acceleration: float
    """Smallest acceleration [rad/s2 or m/s2] that follows it, from rest."""
    speed: float
    """Mean speed [rad/s or m/s]."""


@once_per_case
def spans_of(facts: Facts) -> dict[tuple[str, str], list[Span]]:
    """Return the drives of every driven joint, by copy and joint: in order of time, then those that begin at events."""
    duration = facts.case.scene.duration
    found = {}
    for (entity, joint), targets in facts.rows.joints.targets.items():
        first = facts.lowering.initial.get(entity, {}).get(joint, 0.0)
        found[entity, joint] = list(_chain(targets, first, duration))
        for _, mode, schedule, _, name in facts.rows.joints.later_targets.get((entity, joint), []):
            before = first if mode == "position" else 0.0
            found[entity, joint].append(Span(mode, schedule, 0.0, duration, before, name, anytime=True))
    return found


def _chain(targets: list[DriveTarget], first: float, duration: float) -> Iterator[Span]:
    """Yield the drives of one joint, each until the next takes over, as in `compiler.drives`."""
    ordered = sorted(targets, key=lambda target: target.start)
    before_it: Span | None = None
    for index, (start, mode, schedule, _, name) in enumerate(ordered):
        start = 0.0 if index == 0 else start
        later = ordered[index + 1].start if index + 1 < len(ordered) else duration
        before = 0.0
        if before_it is None:
            before = first if mode == "position" else 0.0
        elif mode == before_it.mode:
            before = before_it.value(start)
        before_it = Span(mode, schedule, start, min(max(start, later), duration), before, name)
        if start < duration:
            yield before_it


def demands(span: Span) -> Iterator[Demand]:
    """Yield the demands of a span on its joint, change by change.

    A joint follows a linear change of position if it reaches the speed by the middle of the change, a smooth one if it
    moves from rest to rest: 4 d / T2. A jump may take as long as the new value holds.
    """
    schedule = span.schedule
    if isinstance(schedule, Sine):
        rate, amplitude = 2 * pi * schedule.frequency, abs(schedule.amplitude)
        if span.end - span.start >= 0.25 / schedule.frequency:
            power = 2 if span.mode == "position" else 1
            low, high = schedule.offset - amplitude, schedule.offset + amplitude
            speed = amplitude * rate if span.mode == "position" else high
            yield Demand(span.start, span.end, low, high, amplitude * rate**power, speed)
        return
    if isinstance(schedule, Constant | float | int | Steps):
        first = span.before if span.mode == "position" and span.start == 0.0 else 0.0
        values = [(span.start, first), *span.corners()[:-1]]
        ends = [t for t, _ in values[2:]] + [span.end]
        for ((_, old), (t, new)), end in zip(pairwise(values), ends, strict=True):
            if end > t and new != old:
                yield _jump(span.mode, t, end, old, new)
        return
    slope = 0.0
    smooth = isinstance(schedule, Ramp) and schedule.ease == "smooth"
    for (t, old), (end, new) in pairwise(span.corners()):
        time, change = end - t, new - old
        if time <= 0.0:
            continue
        if span.mode == "velocity":
            asked, speed = abs(change) / time, max(abs(old), abs(new))
        elif smooth:
            asked, speed = 4 * abs(change) / time**2, abs(change) / time
        else:
            asked, speed = 2 * abs(change / time - slope) / time, abs(change) / time
            slope = change / time
        if change:
            yield Demand(t, end, old, new, asked, speed)


def _jump(mode: str, t: float, end: float, old: float, new: float) -> Demand:
    time, change = end - t, abs(new - old)
    if mode == "velocity":
        return Demand(t, end, old, new, change / time, abs(new))
    return Demand(t, end, old, new, 4 * change / time**2, change / time)


def _peaks(sine: Sine, start: float, end: float) -> Iterator[float]:
    """Yield the first two extrema [s] of a sine after `start`, once it has faded in: a maximum and a minimum."""
    half, start = 0.5 / sine.frequency, max(start, sine.start + sine.fade)
    first = sine.start + (pi / 2 - radians(sine.phase_deg)) / (2 * pi * sine.frequency)
    first += -(-(start - first) // half) * half
    for k in range(2):
        if first + k * half <= end:
            yield first + k * half
