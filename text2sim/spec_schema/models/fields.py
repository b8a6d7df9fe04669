"""Fields: accelerations that fill space. They act on mpm and pbd bodies (cloth, soft bodies, grains, liquids, snow)."""

from math import hypot
from typing import Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    Axis,
    Integer,
    Model,
    Multiple,
    NonNegative,
    Positive,
    Real,
    Selectors,
    Vec3,
    Window,
)
from text2sim.spec_schema.models.motion import Schedule

FASTEST_AIR = 100.0
"""Largest speed [m/s] of moving air: beyond, its density would change, too."""


class Acting(Model):
    """Fields of every control."""

    repeat: Multiple | None = None
    """Number of such controls, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each,
    in selectors, too (`"rod[${k}]"`)."""


class _During(Acting):
    during: Window | None = None
    """Start and end [s]; by default the whole run."""
    scale: Schedule = 1.0
    """Factor that may change with time, such as for a gust."""


class Wind(_During):
    """A wind in a cylindrical stream or everywhere; acts only on mpm and pbd bodies.

    It is an acceleration, like another gravity; cloth that streams and waves in a wind needs an `airflow`.
    """

    kind: Literal["wind"]
    direction: Axis
    """Its direction in the world."""
    acceleration: Positive
    """Acceleration of everything in it [m/s2]."""
    center: Vec3 = (0.0, 0.0, 0.0)
    """A point [m] on the axis of the stream."""
    radius: Positive | None = None
    """Radius [m] of the stream; everywhere by default."""


class Airflow(_During):
    """Air that flows past a cloth, which streams, waves and fills.

    Only for solver pbd. The force on a triangle of the cloth is
    `rho A |u| (1.5 u_across + 0.05 u_along) / 2` with the air's velocity u relative to it and `rho` = 1.225 kg/m3. It
    replaces the cloth's `air_resistance`; outside `during`, and with a velocity of 0, the air is still.
    Other bodies give no shelter.
    """

    kind: Literal["airflow"]
    body: Selectors
    """The cloth, copies of one, or a list. One airflow for each."""
    velocity: Vec3
    """Velocity [m/s] of the air, multiplied by `scale`. It carries a sheet that lies
    across it from `sqrt(2 area_density g / (1.5 rho))` on: 1.3 m/s for 0.15 kg/m2."""
    gusts: NonNegative = Field(default=0.15, le=1.0)
    """Root mean square of gusts in each direction, as a fraction of the velocity. They travel with the air: their waves
    run along a flag."""
    gust_size: Positive = 1.0
    """Length [m] of the largest gusts, about the length of the cloth; the smallest are a quarter of it."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same gusts."""

    @model_validator(mode="after")
    def _no_storm(self) -> "Airflow":
        if (speed := hypot(*self.velocity)) > FASTEST_AIR:
            raise ValueError(f"velocity must be at most {FASTEST_AIR:g} m/s, that of a tornado (got {speed:.3g} m/s)")
        return self


class Drag(_During):
    """Resistance to motion, everywhere: all mpm and pbd bodies get an acceleration `-linear v - quadratic |v| v`."""

    kind: Literal["drag"]
    linear: NonNegative = 0.0
    """[1/s]"""
    quadratic: NonNegative = 0.0
    """[1/m]"""


class Attraction(_During):
    """Attraction to a point (or repulsion, with a negative strength); acts only on mpm and pbd bodies."""

    kind: Literal["attraction"]
    center: Vec3
    """The point [m]."""
    strength: Real
    """Acceleration [m/s2] at a distance of 1 m."""
    falloff: NonNegative = 0.0
    """Exponent: the acceleration is proportional to the distance to the power of minus this; 0 is constant."""


class Vortex(_During):
    """A vortex about a vertical axis; acts only on mpm and pbd bodies."""

    kind: Literal["vortex"]
    center: Vec3 = (0.0, 0.0, 0.0)
    """A point [m] of its axis."""
    swirl: Real
    """Acceleration [m/s2] around the axis, counterclockwise seen from above, at a distance of 1 m."""
    inward: Real = 0.0
    """Acceleration [m/s2] towards the axis at a distance of 1 m."""
    falloff: NonNegative = 0.0
    """Exponent: both are proportional to the distance to the power of minus this."""


class Turbulence(_During):
    """Gusts: smooth noise in space, which may travel; acts only on mpm and pbd bodies."""

    kind: Literal["turbulence"]
    strength: Positive
    """Largest acceleration [m/s2]."""
    frequency: Positive = 3.0
    """Gusts per metre [1/m]."""
    drift: Vec3 = (0.0, 0.0, 0.0)
    """Velocity [m/s] of the whole pattern, as in a wind: at a fixed point it changes `frequency` times the speed
    per second. By default it does not move."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same gusts."""
