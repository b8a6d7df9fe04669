"""Schedules: values that change with time, evaluated here and printed as constructors for the program.

The program's own functions of the same names (`templates/actions/schedules.py.j2`) compute the same values.
"""

from bisect import bisect_right
from itertools import pairwise
from math import inf, pi, radians, sin

from text2sim.compiler.literal import Code, literal
from text2sim.spec_schema.models.motion import Constant, Oscillate, Piecewise, Ramp, Schedule, Sine, Steps, Waypoints


def value_at(schedule: Schedule, t: float, before: float = 0.0) -> float:
    """Return the value of a schedule at a time.

    Args:
        schedule: The schedule.
        t: Time of the simulation [s].
        before: Value before a ramp that has no `from`.
    """
    if isinstance(schedule, Ramp):
        first = before if schedule.from_ is None else schedule.from_
        u = min(max((t - schedule.start) / (schedule.end - schedule.start), 0.0), 1.0)
        return first + (schedule.to - first) * eased(u, schedule.ease)
    if isinstance(schedule, Sine):
        phase = 2 * pi * schedule.frequency * (t - schedule.start) + radians(schedule.phase_deg)
        return schedule.offset + schedule.amplitude * _strength(schedule, t) * sin(phase)
    if isinstance(schedule, Steps):
        return schedule.values[max(bisect_right(schedule.times, t) - 1, 0)]
    if isinstance(schedule, Piecewise):
        times, values = schedule.times, schedule.values
        k = bisect_right(times, t)
        if k == 0 or k == len(times):
            return values[0] if k == 0 else values[-1]
        step = times[k] - times[k - 1]
        u = (t - times[k - 1]) / step
        first, last = values[k - 1], values[k]
        if schedule.ease == "linear":
            return first + u * (last - first)
        a, b = (0.0, 0.0) if schedule.ease == "smooth" else slopes(times, values)[k - 1 : k + 1]
        rest = first + eased(u, "smooth") * (last - first)
        return rest + step * u * (1 - u) * (a * (1 - u) - b * u)
    return schedule.value if isinstance(schedule, Constant) else schedule


def _strength(sine: Sine, t: float) -> float:
    """Return the part of its amplitude that a sine has at a time."""
    left = inf if sine.end is None else sine.end - t
    inside = min(t - sine.start, left)
    if not sine.fade:
        return 1.0 if left > 0.0 else 0.0
    return eased(min(max(inside / sine.fade, 0.0), 1.0), "smooth")


def eased(u: float, ease: str) -> float:
    """Return the part of a change that is done after the part `u` of its time; `smooth` begins and ends at rest."""
    return u * u * (3 - 2 * u) if ease == "smooth" else u


def extremes(schedule: Schedule) -> tuple[float, float]:
    """Return the least and the largest value that a schedule can have."""
    if isinstance(schedule, Sine):
        return schedule.offset - abs(schedule.amplitude), schedule.offset + abs(schedule.amplitude)
    if isinstance(schedule, Ramp):
        ends = (schedule.from_ or 0.0, schedule.to)
        return min(ends), max(ends)
    if isinstance(schedule, Steps | Piecewise):
        return min(schedule.values), max(schedule.values)
    value = schedule.value if isinstance(schedule, Constant) else schedule
    return value, value


SCHEDULE_SAMPLES = 200
"""Times at which a schedule is sampled."""


def largest(schedule: Schedule, duration: float) -> float:
    """Return the largest absolute value of a schedule within a run of this duration [s]."""
    return max(abs(value_at(schedule, duration * k / SCHEDULE_SAMPLES)) for k in range(SCHEDULE_SAMPLES + 1))


def slopes(times: list[float], values: list[float]) -> list[float]:
    """Return the slopes of a cubic through values that does not overshoot (Fritsch and Butland 1984); 0 at both ends.

    Between two lines of slopes p and q and lengths g and h it is their harmonic mean, weighted by 2 h + g and h + 2 g;
    0 where p and q differ in sign.
    """
    steps = [b - a for a, b in pairwise(times)]
    lines = [(b - a) / step for (a, b), step in zip(pairwise(values), steps, strict=True)]
    found = [0.0]
    for (p, q), (g, h) in zip(pairwise(lines), pairwise(steps), strict=True):
        found.append(3 * (g + h) / ((2 * h + g) / p + (h + 2 * g) / q) if p * q > 0 else 0.0)
    return [*found, 0.0][: len(times)]


def scale_constructor(scale: Schedule) -> Code | None:
    """Return the source of the function of time of a control's `scale`; None if it is always 1."""
    return None if scale == 1.0 else constructor(scale)


def constructor(schedule: Schedule, before: float | Code = 0.0) -> Code:
    """Return the source of the function of time for a schedule; `before` stands in for a ramp's missing `from`."""
    if isinstance(schedule, Ramp):
        first = before if schedule.from_ is None else schedule.from_
        return call_of(
            "ramp", start=schedule.start, end=schedule.end, before=first, after=schedule.to, ease=schedule.ease
        )
    if isinstance(schedule, Sine):
        ends = {"end": schedule.end, "fade": schedule.fade} if schedule.fades else {}
        return call_of(
            "fading_sine" if ends else "sine",
            amplitude=schedule.amplitude,
            frequency=schedule.frequency,
            offset=schedule.offset,
            phase=radians(schedule.phase_deg),
            start=schedule.start,
            **ends,
        )
    if isinstance(schedule, Steps):
        return call_of("steps", times=schedule.times, values=schedule.values)
    if isinstance(schedule, Piecewise) and schedule.ease == "linear":
        return call_of("piecewise", times=schedule.times, values=schedule.values)
    if isinstance(schedule, Piecewise):
        speeds = slopes(schedule.times, schedule.values) if schedule.ease == "spline" else [0.0] * len(schedule.times)
        return call_of("spline", times=schedule.times, values=schedule.values, slopes=speeds)
    return call_of("constant", value=schedule.value if isinstance(schedule, Constant) else schedule)


def waypoint_functions(motion: Waypoints) -> tuple[Code, Code, Code]:
    """Return the functions of time for the displacement [m] along x, y and z."""
    return tuple(  # type: ignore[return-value]
        call_of("waypoints", times=motion.times, values=[p[k] for p in motion.positions], ease=motion.ease)
        for k in range(3)
    )


def oscillation(motion: Oscillate) -> Code:
    """Return the function of time for the displacement [m] along the axis."""
    return call_of("sine", amplitude=motion.amplitude, frequency=motion.frequency, offset=0.0, phase=0.0, start=0.0)


def call_of(function: str, **arguments: object) -> Code:
    """Return the call of a function with these arguments, as code."""
    return Code(f"{function}({', '.join(f'{key}={literal(value)}' for key, value in arguments.items())})")
