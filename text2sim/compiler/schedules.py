"""Schedules: values that change with time, evaluated here and printed as constructors for the program.

The program's own functions of the same names (`templates/actions/schedules.py.j2`) compute the same values.
"""

from bisect import bisect_right
from math import pi, radians, sin

from text2sim.compiler.literal import Code, literal
from text2sim.compiler.shapes.rotation import Vec, vector_unit
from text2sim.spec_schema.models.motion import (
    Constant,
    Oscillate,
    Piecewise,
    Ramp,
    Schedule,
    Sine,
    Spin,
    Steps,
    Waypoints,
)


def start_of(schedule: Schedule) -> float:
    """Time [s] at which a schedule takes over from an earlier one."""
    if isinstance(schedule, Constant | Ramp | Sine):
        return schedule.start
    if isinstance(schedule, Steps | Piecewise):
        return schedule.times[0]
    return 0.0


def value_at(schedule: Schedule, t: float, before: float = 0.0) -> float:
    """Value of a schedule at time t [s]; `before` stands in for a ramp's missing `from`."""
    if isinstance(schedule, Ramp):
        first = before if schedule.from_ is None else schedule.from_
        u = min(max((t - schedule.start) / (schedule.end - schedule.start), 0.0), 1.0)
        if schedule.ease == "smooth":
            u = u * u * (3 - 2 * u)
        return first + (schedule.to - first) * u
    if isinstance(schedule, Sine):
        phase = 2 * pi * schedule.frequency * (t - schedule.start) + radians(schedule.phase_deg)
        return schedule.offset + schedule.amplitude * sin(phase)
    if isinstance(schedule, Steps):
        return schedule.values[max(bisect_right(schedule.times, t) - 1, 0)]
    if isinstance(schedule, Piecewise):
        times, values = schedule.times, schedule.values
        k = bisect_right(times, t)
        if k == 0 or k == len(times):
            return values[0] if k == 0 else values[-1]
        u = (t - times[k - 1]) / (times[k] - times[k - 1])
        return values[k - 1] + u * (values[k] - values[k - 1])
    return schedule.value if isinstance(schedule, Constant) else schedule


def displacement(motion: Waypoints | Oscillate | Spin, t: float) -> Vec:
    """How far [m] a driven body is from its start pose at time t [s], in the world; nothing for one that only turns."""
    if isinstance(motion, Spin):
        return (0.0, 0.0, 0.0)
    if isinstance(motion, Oscillate):
        x, y, z = vector_unit(motion.axis)
        way = motion.amplitude * sin(2 * pi * motion.frequency * t)
        return (way * x, way * y, way * z)
    last = len(motion.times) - 1
    k = min(max(bisect_right(motion.times, t) - 1, 0), last - 1)
    (start, end), (a, b) = motion.times[k : k + 2], motion.positions[k : k + 2]
    u = min(max((t - start) / (end - start), 0.0), 1.0)
    u = u * u * (3 - 2 * u) if motion.ease == "smooth" else u
    x, y, z = (p + u * (q - p) for p, q in zip(a, b, strict=True))
    return (x, y, z)


def constructor(schedule: Schedule, before: float = 0.0) -> Code:
    """Source of the function of time for a schedule."""
    if isinstance(schedule, Ramp):
        first = before if schedule.from_ is None else schedule.from_
        return _call(
            "ramp", start=schedule.start, end=schedule.end, before=first, after=schedule.to, ease=schedule.ease
        )
    if isinstance(schedule, Sine):
        return _call(
            "sine",
            amplitude=schedule.amplitude,
            frequency=schedule.frequency,
            offset=schedule.offset,
            phase=radians(schedule.phase_deg),
            start=schedule.start,
        )
    if isinstance(schedule, Steps):
        return _call("steps", times=schedule.times, values=schedule.values)
    if isinstance(schedule, Piecewise):
        return _call("piecewise", times=schedule.times, values=schedule.values)
    return _call("constant", value=schedule.value if isinstance(schedule, Constant) else schedule)


def waypoint_functions(motion: Waypoints) -> tuple[Code, Code, Code]:
    """Functions of time for the displacement [m] along x, y and z."""
    return tuple(  # type: ignore[return-value]
        _call("waypoints", times=motion.times, values=[p[k] for p in motion.positions], ease=motion.ease)
        for k in range(3)
    )


def oscillation(motion: Oscillate) -> Code:
    """Function of time for the displacement [m] along the axis."""
    return _call("sine", amplitude=motion.amplitude, frequency=motion.frequency, offset=0.0, phase=0.0, start=0.0)


def _call(function: str, **arguments: object) -> Code:
    return Code(f"{function}({', '.join(f'{key}={literal(value)}' for key, value in arguments.items())})")
