"""Prescribed motion: where driven bodies are, how far and how fast they go, and when they set out."""

import math
from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from math import pi, sin

from text2sim.compiler.schedules import eased, value_at
from text2sim.compiler.shapes.boxes import NOWHERE, Bounds, around
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, Vec, quat_from_axis_angle, vector_times, vector_unit
from text2sim.spec_schema.models.motion import (
    Constant,
    Motion,
    Oscillate,
    Piecewise,
    Ramp,
    Sine,
    Spin,
    Steps,
    Waypoints,
    start_of,
)

PEAK_SPEED_RATIO = 1.5
"""Peak speed over mean speed of a body on a smooth stretch that begins and ends at rest."""
SPIN_SAMPLES = 200
"""Times at which the speed of a spin is sampled."""
MAX_POSES = 60
"""Most poses of a path or a turn."""

Moment = tuple[float, Vec, Quaternion]
"""A time [s], and how a body has moved [m] and turned about its origin by then."""


def displacement(motion: Motion, t: float) -> Vec:
    """Return how far [m] a driven body is from its start pose at time t [s], in the world; 0 if it only turns."""
    if isinstance(motion, Spin):
        return (0.0, 0.0, 0.0)
    if isinstance(motion, Oscillate):
        x, y, z = vector_unit(motion.axis)
        distance = motion.amplitude * sin(2 * pi * motion.frequency * t)
        return (distance * x, distance * y, distance * z)
    last = len(motion.times) - 1
    k = min(max(bisect_right(motion.times, t) - 1, 0), last - 1)
    (start, end), (a, b) = motion.times[k : k + 2], motion.positions[k : k + 2]
    u = eased(min(max((t - start) / (end - start), 0.0), 1.0), motion.ease)
    x, y, z = (p + u * (q - p) for p, q in zip(a, b, strict=True))
    return (x, y, z)


def displacements(motion: Motion) -> Bounds:
    """Return the box [m] of all displacements from the start pose."""
    if isinstance(motion, Oscillate):
        x, y, z = (abs(c) * motion.amplitude for c in vector_unit(motion.axis))
        return (-x, -y, -z), (x, y, z)
    return around([(0.0, 0.0, 0.0), *motion.positions]) if isinstance(motion, Waypoints) else NOWHERE


def strokes(motion: Oscillate | Waypoints) -> Iterator[tuple[Vec, Bounds]]:
    """Yield the highest velocity [m/s] on each straight part of a path, and the box [m] of its displacements.

    Parts on which a body stands still are left out.
    """
    if isinstance(motion, Oscillate):
        axis = vector_unit(motion.axis)
        yield vector_times(axis, 2 * pi * motion.frequency * motion.amplitude), displacements(motion)
        return
    peak = PEAK_SPEED_RATIO if motion.ease == "smooth" else 1.0
    for (t, a), (end, b) in pairwise(zip(motion.times, motion.positions, strict=True)):
        velocity = tuple((q - p) * peak / (end - t) for p, q in zip(a, b, strict=True))
        if any(velocity):
            yield velocity, around((a, b))  # type: ignore[misc]


def top_speed(motion: Oscillate | Waypoints) -> float:
    """Return a bound of the speed [m/s] along a path, as if the body came to rest at every waypoint."""
    if isinstance(motion, Oscillate):
        return 2 * pi * motion.frequency * motion.amplitude
    legs = pairwise(zip(motion.times, motion.positions, strict=True))
    return max(PEAK_SPEED_RATIO * math.dist(a, b) / (end - start) for (start, a), (end, b) in legs)


def moments(motion: Motion, duration: float, stride: float) -> Iterator[Moment]:
    """Yield moments of a motion within the run.

    Args:
        motion: The motion.
        duration: Of the run [s].
        stride: Greatest distance [m] between moments, unless that makes more than `MAX_POSES` of them.
    """
    if isinstance(motion, Spin):
        yield from _spin_moments(motion, duration)
        return
    corners = _corners(motion, duration)
    total = sum(math.dist(a, b) for (_, a), (_, b) in pairwise(corners)) or 1.0
    for (start, a), (end, b) in pairwise(corners):
        far = math.dist(a, b)
        count = max(1, math.ceil(min(far / stride, MAX_POSES * far / total)))
        for k in range(1, count + 1):
            u = k / count
            x, y, z = (p + u * (q - p) for p, q in zip(a, b, strict=True))
            yield start + u * (end - start), (x, y, z), IDENTITY


def _corners(motion: Waypoints | Oscillate, duration: float) -> list[tuple[float, Vec]]:
    """Return times [s] and displacements [m] of the corners of a path, or of the first cycle of an oscillation."""
    if isinstance(motion, Oscillate):
        turns = [0.25 / motion.frequency, 0.75 / motion.frequency]
    else:
        turns = list(motion.times)
    times = [0.0, *(t for t in turns if 0.0 < t < duration), duration]
    return [(t, displacement(motion, t)) for t in times]


def _spin_moments(motion: Spin, duration: float) -> Iterator[Moment]:
    """Yield moments of a spin up to its largest angle either way, at most one turn each."""
    axis = vector_unit(motion.axis)
    low = high = angle = 0.0
    ends = [(0.0, 0.0), (0.0, 0.0)]
    for k in range(SPIN_SAMPLES):
        t = duration * (k + 1) / SPIN_SAMPLES
        angle += value_at(motion.speed, t - duration / (2 * SPIN_SAMPLES)) * duration / SPIN_SAMPLES
        if angle < low or angle > high:
            low, high = min(low, angle), max(high, angle)
            ends[angle > 0] = (angle, t)
    for last, t in ends:
        last = max(-2 * pi, min(last, 2 * pi))
        for k in range(1, MAX_POSES + 1) if last else ():
            yield t * k / MAX_POSES, (0.0, 0.0, 0.0), quat_from_axis_angle(axis, last * k / MAX_POSES)


def sets_out(motion: Motion) -> float:
    """Return the time [s] at which a driven body leaves its start pose; infinite if it never does."""
    if isinstance(motion, Waypoints):
        return _leaves(motion.times, [0.0 if p == (0.0, 0.0, 0.0) else 1.0 for p in motion.positions])
    if not isinstance(motion, Spin) or isinstance(motion.speed, Sine):
        return 0.0
    speed = motion.speed
    if isinstance(speed, Steps):
        changes = (t for t, value in zip(speed.times, speed.values, strict=True) if value)
        return 0.0 if speed.values[0] else next(changes, math.inf)
    if isinstance(speed, Piecewise):
        return _leaves(speed.times, speed.values)
    if isinstance(speed, Ramp):
        return 0.0 if speed.from_ else start_of(speed)
    return 0.0 if (speed.value if isinstance(speed, Constant) else speed) else math.inf


def _leaves(times: list[float], values: list[float]) -> float:
    """Return the time [s] at which straight lines between values leave 0."""
    if values[0]:
        return 0.0
    return next((t for t, value in zip(times, values[1:], strict=False) if value), math.inf)
