"""Fields: accelerations that fill space. They act on mpm and pbd bodies (cloth, soft bodies, grains, liquids, snow)."""

from typing import Literal

from pydantic import Field

from text2sim.spec_schema.models.base import Axis, Integer, Model, Multiple, NonNegative, Positive, Real, Vec3, Window
from text2sim.spec_schema.models.motion import Schedule


class Acting(Model):
    """What every control has."""

    repeat: Multiple | None = None
    """So many of these controls, called `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""


class _During(Acting):
    during: Window | None = None
    """From and to [s]; the whole run if left out."""
    scale: Schedule = 1.0
    """Factor that may change with time: a wind that rises, a gust."""


class Wind(_During):
    """A push along a direction, in a round stream or everywhere; on mpm and pbd bodies alone."""

    kind: Literal["wind"]
    direction: Axis
    """Where it blows to, in the world."""
    acceleration: Positive
    """What it gives to everything in it [m/s2]."""
    center: Vec3 = (0.0, 0.0, 0.0)
    """A point [m] on the axis of the stream."""
    radius: Positive | None = None
    """Radius [m] of the stream; everywhere if left out."""


class Drag(_During):
    """Resistance against motion of mpm and pbd bodies alone: an acceleration `-linear v - quadratic |v| v`."""

    kind: Literal["drag"]
    linear: NonNegative = 0.0
    """[1/s]"""
    quadratic: NonNegative = 0.0
    """[1/m]"""


class Attraction(_During):
    """A pull towards a point (or away from it, with a negative strength); on mpm and pbd bodies alone."""

    kind: Literal["attraction"]
    center: Vec3
    """The point [m]."""
    strength: Real
    """Acceleration [m/s2] at a distance of 1 m."""
    falloff: NonNegative = 0.0
    """The pull goes with the distance to the power of minus this; 0: the same everywhere."""


class Vortex(_During):
    """A whirl about a vertical axis; on mpm and pbd bodies alone."""

    kind: Literal["vortex"]
    center: Vec3 = (0.0, 0.0, 0.0)
    """A point [m] of its axis."""
    swirl: Real
    """Acceleration [m/s2] around the axis, counterclockwise seen from above, at a distance of 1 m."""
    inward: Real = 0.0
    """Acceleration [m/s2] towards the axis at a distance of 1 m."""
    falloff: NonNegative = 0.0
    """Both go with the distance to the power of minus this."""


class Turbulence(_During):
    """Gusts: smooth noise in space, which may travel; on mpm and pbd bodies alone."""

    kind: Literal["turbulence"]
    strength: Positive
    """Largest acceleration [m/s2]."""
    frequency: Positive = 3.0
    """Gusts per metre [1/m]."""
    drift: Vec3 = (0.0, 0.0, 0.0)
    """Velocity [m/s] with which the whole pattern travels, as a wind carries its gusts along: at one place it changes
    `frequency` times the speed as often in a second. Standing still if left out."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same gusts."""
