"""Lights of a film. Their units are such that an irradiance of 3.14 makes a white sheet white."""

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
    """Direction in which the light travels."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 3.0
    """Irradiance on a surface that faces the light; 3.14 makes a white sheet white."""
    angle_deg: Real = Field(default=0.53, ge=0.0, le=90.0)
    """Apparent diameter [deg] of its disc: 0.53 is the sun in a clear sky, larger is hazier, with softer shadows."""


class Softbox(Model):
    """A large square area light that illuminates the scene from a distance."""

    kind: Literal["softbox"]
    direction: Direction
    """Direction in which the light travels."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 3.0
    """Irradiance on a surface at its target that faces the light; 3.14 makes a white sheet white."""
    at: Target | None = None
    """Its target: a point [m] or a body; by default the middle of the scene."""
    distance: Positive | None = Field(default=None, le=1e4)
    """Distance [m] from the target; by default derived from the size of the scene."""
    size: Positive | None = Field(default=None, le=1e4)
    """Length [m] of its sides; larger gives softer shadows. By default 0.24 of the distance."""


class Lamp(Model):
    """Light from a small sphere."""

    kind: Literal["lamp"]
    pos: Vec3
    """Its position [m]."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 10.0
    """Radiant intensity: the irradiance at a distance of 1 m, which falls with the square of the distance."""
    radius: Positive | None = Field(default=None, le=1e3)
    """Radius [m] of the sphere; larger gives softer shadows. By default derived from the size of the scene."""


class Spot(Model):
    """A cone of light from a point."""

    kind: Literal["spot"]
    pos: Vec3
    """Its position [m]."""
    look_at: Target
    """Its target (for a body: the position at the start)."""
    angle_deg: Real = Field(default=40.0, ge=1.0, le=170.0)
    """Full angle [deg] of the cone."""
    blur: Fraction = 0.3
    """Fraction of the cone over which its edge fades; 0 is sharp."""
    color: Color = "white"
    """Colour of the light."""
    strength: Strength = 10.0
    """Radiant intensity on the axis: the irradiance at a distance of 1 m."""


class Sky(Model):
    """A physically based clear sky with its sun."""

    kind: Literal["sky"]
    direction: Direction = (-0.4, 0.5, -0.8)
    """Direction in which sunlight travels; a low sun is red."""
    turbidity: Real = Field(default=3.0, ge=1.0, le=10.0)
    """Haze: 2 is a very clear day, 6 a milky one."""
    strength: Strength = 3.0
    """Irradiance on the ground from sun and sky together."""


class Environment(Model):
    """Light from all directions: a dome whose colour changes evenly from the horizon to the zenith."""

    kind: Literal["environment"]
    color: Color = "white"
    """Colour at the zenith."""
    horizon: Color | None = None
    """Colour at the horizon; by default that of the zenith."""
    strength: Strength = 0.35
    """Radiance: 1 alone makes a white sheet white."""


Light = Annotated[Sun | Softbox | Lamp | Spot | Sky | Environment, ByKind()]
