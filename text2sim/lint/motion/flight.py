"""Paths of free bodies under gravity up to the first body they meet.

The body does not rotate, and nothing else moves: that is enough to predict the first meeting and its speed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, apart, grown, moved, sides, union
from text2sim.compiler.shapes.rotation import Vec, vector_dot, vector_minus, vector_plus, vector_times
from text2sim.compiler.shapes.sweep import sweep
from text2sim.lint.facts import Facts
from text2sim.lint.parts import Ground, StandingPart
from text2sim.spec_schema.models.bodies import FreeMount, Rigid

MAX_RESTING_GAP = 0.002
"""Largest gap [m] below a body at rest."""
MAX_SWEEPS = 4000
"""Most sweeps in a case, which take half a second; the paths of further bodies are unknown."""
ARRAYS_FROM = 200
"""Number of copies from which arrays are used for the search."""
PATH_LEGS = (8, 40)
"""Fewest and most straight legs of a path."""


@dataclass(frozen=True)
class Meeting:
    """The first meeting of a body with another."""

    other: Copy
    part: StandingPart | None
    """The piece that is met; None for a plane."""
    time: float
    """Time [s]."""
    velocity: Vec
    """Velocity of the body then [m/s]."""


@dataclass(frozen=True)
class Flight:
    """The path of a free body until it meets another."""

    velocity: Vec
    """Velocity at the start [m/s]."""
    acceleration: Vec
    """Acceleration [m/s2]: gravity, or zero if the body rests on something."""
    end: float
    """Time [s] of the meeting, or of the end of the run."""
    meeting: Meeting | None = None

    def offset(self, t: float) -> Vec:
        """Return its displacement [m] at a time [s]."""
        return vector_plus(vector_times(self.velocity, t), vector_times(self.acceleration, t * t / 2))

    def velocity_at(self, t: float) -> Vec:
        """Return its velocity [m/s] at a time [s]."""
        return vector_plus(self.velocity, vector_times(self.acceleration, t))

    @property
    def moves(self) -> bool:
        """Whether it moves at all."""
        return any(self.velocity) or any(self.acceleration)


def flight_of(facts: Facts, copy: Copy) -> Flight | None:
    """Return the path of a copy; None if it is held, on a spring, damped, or has no size."""
    return facts.once(_Flights).of(copy)


class _Flights:
    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.of = cache(self._work_out)
        self.left = MAX_SWEEPS
        self.sides: Any = None
        """Sorted corners (n, 6) of many other copies, with the order, the axis and the longest side along it."""
        self.others = [(copy, box) for copy in facts.copies.values() if (box := facts.box(copy)) is not None]

    def _work_out(self, copy: Copy) -> Flight | None:
        facts = self.facts
        box = facts.box(copy)
        if box is None or not facts.loose(copy) or copy.name in facts.sprung:
            return None
        v, g = facts.velocities.get(copy.name, (0.0, 0.0, 0.0)), facts.case.scene.gravity
        path = Flight(v, g, facts.case.scene.duration)
        near = self._copies_along(copy, box, path)
        resting = any(g) and vector_dot(v, g) >= 0 and self._is_supported(copy, box, near)
        if resting or any(copy.name in (weld.a, weld.b) for weld in facts.rows.welds):
            path = replace(path, acceleration=(0.0, 0.0, 0.0))
            near = self._copies_along(copy, box, path)
        mount = copy.model.mount if isinstance(copy.model, Rigid) else None
        if path.moves and isinstance(mount, FreeMount) and mount.damping:
            return None  # its path is no parabola
        meeting = self._first(copy, box, near, path) if path.moves else None
        if self.left < 0:
            return None
        return path if meeting is None else replace(path, end=meeting.time, meeting=meeting)

    def _copies_along(self, copy: Copy, box: Bounds, path: Flight) -> list[tuple[Copy, Bounds]]:
        """Return the copies near the box around the whole path, with a margin for supports."""
        times = {0.0, path.end}
        turns = (-v / g for v, g in zip(path.velocity, path.acceleration, strict=True) if g)
        times.update(t for t in turns if 0 < t < path.end)
        room = grown(union(moved(box, path.offset(t)) for t in times), MAX_RESTING_GAP)
        return [
            (other, other_box)
            for other, other_box in self._copies_around(room)
            if other is not copy and not apart(other_box, room)
        ]

    def _copies_around(self, room: Bounds) -> list[tuple[Copy, Bounds]]:
        """Return the copies that a box may meet, and few others; for many copies, arrays are a hundred times faster."""
        if len(self.others) < ARRAYS_FROM:
            return self.others
        import numpy as np

        if self.sides is None:
            sides = np.array([(*low, *high) for _, (low, high) in self.others])
            axis = int(np.ptp(sides[:, :3], axis=0).argmax())
            order = np.argsort(sides[:, axis], kind="stable")
            self.sides = sides[order], order, axis, float((sides[:, 3 + axis] - sides[:, axis]).max())
        sides, order, axis, longest = self.sides
        # Sorted along the axis of their largest spread, the copies that can reach the box are contiguous.
        begins = sides[:, axis]
        first, last = np.searchsorted(begins, (room[0][axis] - longest, room[1][axis]))
        some = sides[first:last]
        met = ((some[:, 3:] > room[0]) & (some[:, :3] < room[1])).all(axis=1)
        return [self.others[k] for k in np.sort(order[first:last][met]).tolist()]

    def _is_supported(self, copy: Copy, box: Bounds, near: list[tuple[Copy, Bounds]]) -> bool:
        """Return whether a copy has something just below it at the start."""
        parts = self.facts.parts(copy)
        for ground in self.facts.planes:
            if any(ground.depth(part) > -MAX_RESTING_GAP and ground.beside(part.solid.center) < 0.0 for part in parts):
                return True
        reach = grown(box, MAX_RESTING_GAP)
        return any(not apart(reach, other_box) and is_just_above(self.facts, copy, other) for other, other_box in near)

    def _first(self, copy: Copy, box: Bounds, near: list[tuple[Copy, Bounds]], path: Flight) -> Meeting | None:
        parts = self.facts.parts(copy)
        landings = [_landing(ground, copy, parts, path) for ground in self.facts.planes]
        landing = min((m for m in landings if m is not None), key=lambda m: m.time, default=None)
        if not near:
            return landing
        end = landing.time if landing is not None else path.end
        touching = {other.name for other, other_box in near if not apart(box, other_box, -MAX_RESTING_GAP)}
        size = max(min(sides(box)), 1e-6)
        # Enough legs that the path is never farther from its chords than a tenth of the body.
        count = math.ceil(end * math.sqrt(math.hypot(*path.acceleration) / (0.8 * size)))
        count = min(max(count, PATH_LEGS[0]), PATH_LEGS[1])
        for k in range(count):
            meeting = self._leg(parts, box, near, touching, path, end * k / count, end * (k + 1) / count)
            if meeting is not None:
                return meeting
        return landing

    def _leg(
        self,
        parts: list[StandingPart],
        box: Bounds,
        near: list[tuple[Copy, Bounds]],
        touching: set[str],
        path: Flight,
        start: float,
        end: float,
    ) -> Meeting | None:
        a, b = path.offset(start), path.offset(end)
        step = vector_minus(b, a)
        length = math.hypot(*step)
        if length < 1e-12:
            return None
        direction: Vec = (step[0] / length, step[1] / length, step[2] / length)
        swept = union((moved(box, a), moved(box, b)))
        best: tuple[float, Copy, StandingPart] | None = None
        for other, other_box in near:
            if apart(swept, other_box):
                continue
            for part in self.facts.parts(other):
                if apart(swept, part.box) or self.left < 0:
                    continue
                self.left -= 1 + len(parts) // 4
                distance = sweep([p.solid for p in parts], [part.solid], direction, start=a)
                # It slides along, or leaves, a body that it touches at the start.
                if distance is None or distance > length or (best is not None and distance >= best[0]):
                    continue
                if other.name in touching and start == 0.0 and distance < MAX_RESTING_GAP:
                    continue
                best = distance, other, part
        if best is None:
            return None
        time = start + (end - start) * best[0] / length
        return Meeting(best[1], best[2], time, path.velocity_at(time))


def is_just_above(facts: Facts, copy: Copy, other: Copy) -> bool:
    """Return whether a copy touches another one if it moves down by the gap of bodies at rest.

    Args:
        facts: The case.
        copy: A copy.
        other: Another copy.
    """
    x, y, z = facts.up
    distance = sweep([p.solid for p in facts.parts(copy)], [p.solid for p in facts.parts(other)], (-x, -y, -z))
    return distance is not None and distance < MAX_RESTING_GAP


def _landing(ground: Ground, copy: Copy, parts: list[StandingPart], path: Flight) -> Meeting | None:
    """Return the meeting of a body with a plane from above."""
    height = -max((ground.depth(part) for part in parts), default=-math.inf)
    fall, rise = vector_dot(path.acceleration, ground.up) / 2, vector_dot(path.velocity, ground.up)
    if height < -MAX_RESTING_GAP:
        return None
    for t in _roots(fall, rise, max(height, 0.0)):
        pos = vector_plus(copy.pos, path.offset(t))
        if 0 <= t <= path.end and rise + 2 * fall * t < 0 and ground.beside(pos) < 0:
            return Meeting(ground.copy, None, t, path.velocity_at(t))
    return None


def _roots(a: float, b: float, c: float) -> Iterator[float]:
    """Yield the real solutions of a t^2 + b t + c = 0 in ascending order."""
    if abs(a) < 1e-12:
        yield from () if abs(b) < 1e-12 else (-c / b,)
        return
    inner = b * b - 4 * a * c
    if inner >= 0:
        root = math.sqrt(inner)
        yield from sorted(((-b - root) / (2 * a), (-b + root) / (2 * a)))
