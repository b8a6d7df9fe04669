"""Schedules of drives and forces, and the motion of driven bodies."""

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Axis, ByKind, Model, Positive, Real, Seconds, Vec3


class Constant(Model):
    """A constant value."""

    kind: Literal["constant"]
    value: Real
    """The value."""
    start: Seconds = 0.0
    """Time [s] from which it applies."""


class Ramp(Model):
    """A transition from one value to another."""

    kind: Literal["ramp"]
    from_: Real | None = Field(default=None, alias="from")
    """Value at `start`; by default the final value of the previous drive, or the joint's start position."""
    to: Real
    """Value from `end` on."""
    start: Seconds = 0.0
    """Start [s]."""
    end: Seconds
    """End [s]."""
    ease: Literal["linear", "smooth"] = "smooth"
    """`smooth` starts and ends at rest."""

    @model_validator(mode="after")
    def _order(self) -> "Ramp":
        if self.end <= self.start:
            raise ValueError(f"end must be later than start (got {self.start:g} and {self.end:g})")
        return self


def _check_times(times: list[float], key: str, items: list[Any]) -> None:
    if len(times) != len(items):
        raise ValueError(f"times and {key} must have the same length (got {len(times)} and {len(items)})")
    if any(b <= a for a, b in pairwise(times)):
        raise ValueError("times must be ascending")


class _Table(Model):
    times: list[Seconds] = Field(min_length=1, max_length=1000)
    """Times [s], ascending; the first value holds before them, the last one after them."""
    values: list[Real] = Field(min_length=1, max_length=1000)
    """One value for each time."""

    @model_validator(mode="after")
    def _growing(self) -> "_Table":
        _check_times(self.times, "values", self.values)
        return self


class Steps(_Table):
    """A step function: each value applies from its time to the next."""

    kind: Literal["steps"]


class Piecewise(_Table):
    """An interpolation of given values."""

    kind: Literal["piecewise"]
    ease: Literal["linear", "smooth", "spline"] = "linear"
    """`linear`: straight lines. `smooth`: at rest at every value. `spline`: at rest only at both ends and where the
    direction reverses, with continuous speed and without overshoot."""


class Sine(Model):
    """`offset + amplitude sin(2 pi frequency (t - start) + phase)`."""

    kind: Literal["sine"]
    amplitude: Real
    """Largest difference from `offset`."""
    frequency: Positive
    """Cycles per second [Hz]."""
    offset: Real = 0.0
    """Mean value."""
    phase_deg: Real = 0.0
    """Phase [deg] at `start`."""
    start: Seconds = 0.0
    """Time [s]."""
    end: Seconds | None = None
    """Time [s] from which it is `offset`; by default it goes on."""
    fade: Seconds = 0.0
    """Time [s] in which the amplitude grows from 0 at `start`, smoothly, and falls to 0 before `end`. With 0, a sine of
    a position sets off with a jump of velocity, which shakes off what stands loose."""

    @model_validator(mode="after")
    def _order(self) -> "Sine":
        if self.end is not None and self.end - self.start < max(2 * self.fade, 1e-9):
            raise ValueError(f"end must be later than start by two `fade` (got {self.start:g} and {self.end:g})")
        return self

    @property
    def fades(self) -> bool:
        """Whether its amplitude changes."""
        return self.end is not None or self.fade > 0


Schedule = Real | Annotated[Constant | Ramp | Steps | Piecewise | Sine, ByKind()]
"""A number, or a value that changes with time."""


def start_of(schedule: Schedule) -> float:
    """Return the time [s] at which a schedule begins and replaces an earlier one."""
    if isinstance(schedule, Constant | Ramp | Sine):
        return schedule.start
    if isinstance(schedule, Steps | Piecewise):
        return schedule.times[0]
    return 0.0


def end_of(schedule: Schedule) -> float:
    """Return the time [s] at which a schedule reaches its last value; 0 of one that has no last value."""
    if isinstance(schedule, Ramp):
        return schedule.end
    return schedule.times[-1] if isinstance(schedule, Steps | Piecewise) else 0.0


class Waypoints(Model):
    """A path through positions at given times."""

    kind: Literal["waypoints"]
    times: list[Seconds] = Field(min_length=2, max_length=1000)
    """Times [s], ascending."""
    positions: list[Vec3] = Field(min_length=2, max_length=1000)
    """Displacements [m] from the start pose, one for each time."""
    ease: Literal["linear", "smooth"] = "smooth"
    """`smooth` stops at every waypoint."""

    @model_validator(mode="after")
    def _growing(self) -> "Waypoints":
        _check_times(self.times, "positions", self.positions)
        return self


class Spin(Model):
    """Rotation about an axis through the body's origin."""

    kind: Literal["spin"]
    axis: Axis = "z"
    """Axis in the world."""
    speed: Schedule
    """Angular velocity [rad/s]."""


class Oscillate(Model):
    """Oscillation along an axis: `amplitude sin(2 pi frequency t)`."""

    kind: Literal["oscillate"]
    axis: Axis = "x"
    """Direction in the world."""
    amplitude: Positive
    """Largest displacement [m]."""
    frequency: Positive
    """Cycles per second [Hz]."""


Motion = Annotated[Waypoints | Spin | Oscillate, ByKind()]
