"""Lights of a film. Every `strength` is an irradiance, or goes with one: a white sheet under 3.14 is white."""

from typing import Annotated, Literal

from pydantic import Field

from text2sim.spec_schema.models.base import ByKind, Direction, Fraction, Model, Positive, Real, Vec3
from text2sim.spec_schema.models.cameras import Target
from text2sim.spec_schema.models.colors import Color

Strength = Annotated[Real, Field(ge=0.0, le=1e6)]


class Sun(Model):
    """Parallel light."""

    kind: Literal["sun"]
    direction: Direction = (-0.4, 0.5, -1.0)
    """The way the light goes."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 3.0
    """Irradiance on what faces it; 3.14 makes a white sheet white."""
    angle_deg: Real = Field(default=0.53, ge=0.0, le=90.0)
    """Apparent diameter [deg] of its disc: 0.53 is the sun in a clear sky, larger is hazier, with softer shadows."""


class Softbox(Model):
    """A large square lamp that stands away from the scene, against the direction of its light."""

    kind: Literal["softbox"]
    direction: Direction
    """The way the light goes."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 3.0
    """Irradiance at what it lights; 3.14 makes a white sheet that faces it white."""
    at: Target | None = None
    """What it lights: a point [m] or a body; the middle of the scene if left out."""
    distance: Positive | None = Field(default=None, le=1e4)
    """Distance [m] from there; goes with the size of the scene if left out."""
    size: Positive | None = Field(default=None, le=1e4)
    """Length [m] of its sides: larger is softer. 0.24 of the distance if left out."""


class Lamp(Model):
    """Light from a small ball."""

    kind: Literal["lamp"]
    pos: Vec3
    """Where it stands [m]."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 10.0
    """Radiant intensity: the irradiance in a distance of 1 m. It falls with the square of the distance."""
    radius: Positive | None = Field(default=None, le=1e3)
    """Radius [m] of the ball: larger is softer. It goes with the size of the scene if left out."""


class Spot(Model):
    """Light from a point within a cone."""

    kind: Literal["spot"]
    pos: Vec3
    """Where it stands [m]."""
    look_at: Target
    """What it points at (a body: where that is at the start)."""
    angle_deg: Real = Field(default=40.0, ge=1.0, le=170.0)
    """Full angle [deg] of the cone."""
    blur: Fraction = 0.3
    """Part of the cone in which its edge fades; 0 is sharp."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 10.0
    """Radiant intensity on its axis: the irradiance in a distance of 1 m."""


class Sky(Model):
    """A clear sky with its sun, as physics has it."""

    kind: Literal["sky"]
    direction: Direction = (-0.4, 0.5, -0.8)
    """The way the light of the sun goes: low is red."""
    turbidity: Real = Field(default=3.0, ge=1.0, le=10.0)
    """Haze: 2 is a very clear day, 6 a milky one."""
    strength: Strength = 3.0
    """Irradiance on the ground, sun and sky together."""


class Environment(Model):
    """Light from everywhere: a dome that changes evenly from the horizon to overhead."""

    kind: Literal["environment"]
    color: Color = "white"
    """Colour overhead."""
    horizon: Color | None = None
    """Colour at the horizon; that overhead if left out."""
    strength: Strength = 0.35
    """Radiance: 1 alone makes a white sheet white."""


Light = Annotated[Sun | Softbox | Lamp | Spot | Sky | Environment, ByKind()]
