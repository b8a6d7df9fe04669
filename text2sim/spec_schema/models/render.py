"""Section `render`: the cinematography. Nothing here can touch the physics."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from text2sim.spec_schema.models.base import (
    Direction,
    Integer,
    Model,
    Name,
    NonNegative,
    Positive,
    Real,
    Seconds,
    Selector,
    Vec3,
    Window,
)
from text2sim.spec_schema.models.colors import Color
from text2sim.spec_schema.models.regions import BodyPoint

Target = Vec3 | Selector | BodyPoint
"""A point [m], or a body that is looked at (the middle of its copies, if there are several), or a region of it."""


class _Camera(Model):
    fov: Positive = Field(default=40.0, ge=2.0, le=140.0, alias="fov_deg")
    """Vertical field of view [deg]."""
    up: Direction = (0.0, 0.0, 1.0)
    """Which way is up in the picture; +y where it looks straight up or down."""


class Still(_Camera):
    """A camera on a tripod."""

    kind: Literal["still"]
    from_: Vec3 = Field(alias="from")
    """Where it stands [m]."""
    look_at: Target
    """What it looks at (a body: where that is at the start)."""

    @model_validator(mode="after")
    def _apart(self) -> "Still":
        if self.from_ == self.look_at:
            raise ValueError("from and look_at are the same point")
        return self


class Follow(_Camera):
    """A camera that stands still or travels along, and keeps looking at a body."""

    kind: Literal["follow"]
    body: Selector
    """The body it looks at."""
    from_: Vec3 | None = Field(default=None, alias="from")
    """Where it stands [m]; give either this or `offset`."""
    offset: Direction | None = None
    """Its place relative to the body [m]: it travels along."""
    smooth: Seconds = 0.3
    """Time [s] over which its motion is averaged."""

    @model_validator(mode="after")
    def _one_place(self) -> "Follow":
        if (self.from_ is None) == (self.offset is None):
            raise ValueError("give either from or offset")
        return self


class Orbit(_Camera):
    """A camera on a circle about a point."""

    kind: Literal["orbit"]
    look_at: Target
    """Centre of the circle, and what it looks at."""
    radius: Positive
    """Radius [m]."""
    height: Real
    """Height [m] above the centre."""
    start_deg: Real = -90.0
    """Angle [deg] from +x at the start."""
    turn_deg: Real = 90.0
    """How far [deg] it goes round in the whole film."""


class Dolly(_Camera):
    """A camera that moves along a straight line over the whole film."""

    kind: Literal["dolly"]
    from_: Vec3 = Field(alias="from")
    """Where it starts [m]."""
    to: Vec3
    """Where it ends [m]."""
    look_at: Target
    """What it looks at (a body: where that is at the start)."""


Camera = Annotated[Still | Follow | Orbit | Dolly, Field(discriminator="kind")]


class Sun(Model):
    """Parallel light."""

    kind: Literal["sun"]
    direction: Direction = (-0.4, 0.5, -1.0)
    """The way the light goes."""
    color: Color = "white"
    """Colour of the light."""
    strength: NonNegative = 3.0
    """Brightness."""


class Softbox(Model):
    """A large lamp that stands away from the scene, against the direction of its light."""

    kind: Literal["softbox"]
    direction: Direction
    """The way the light goes."""
    color: Color = "white"
    """Colour of the light."""
    strength: NonNegative = 3.0
    """Brightness."""


class Lamp(Model):
    """Light from a point."""

    kind: Literal["lamp"]
    pos: Vec3
    """Where it stands [m]."""
    color: Color = "white"
    """Colour of the light."""
    strength: NonNegative = 10.0
    """Brightness."""


Light = Annotated[Sun | Softbox | Lamp, Field(discriminator="kind")]


def _even(size: tuple[int, int]) -> tuple[int, int]:
    if size[0] % 2 or size[1] % 2:
        raise ValueError(f"resolution must be even, for the video encoder (got {size[0]} x {size[1]})")
    return size


def _long(span: tuple[float, float]) -> tuple[float, float]:
    if span[0] == span[1]:
        raise ValueError(f"the film needs some length (got {span[0]:g} and {span[1]:g})")
    return span


Pixels = Annotated[Integer, Field(ge=64, le=4096)]


class Render(Model):
    """The cinematography."""

    resolution: Annotated[tuple[Pixels, Pixels], AfterValidator(_even)] = (1280, 720)
    """Width and height [pixels], both even."""
    fps: Positive = Field(default=25.0, ge=1.0, le=240.0)
    """Frames per second of film."""
    speed: Positive = Field(default=1.0, ge=0.01, le=100.0)
    """Simulated seconds per second of film; 0.25 is slow motion."""
    during: Annotated[Window, AfterValidator(_long)] | None = None
    """The part [s] of the run that is shown."""
    quality: Literal["preview", "final"] = "preview"
    """`preview` is rasterised."""
    background: Color = "#d9e2ec"
    """Colour behind everything."""
    ambient: NonNegative = 0.35
    """Light from everywhere."""
    cameras: dict[Name, Camera] = Field(default_factory=dict, max_length=20)
    """By name; the first makes `video.mp4`. One is derived if there is none."""
    lights: dict[Name, Light] = Field(default_factory=dict, max_length=20)
    """By name; one is derived if there are none."""
