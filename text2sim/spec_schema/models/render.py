"""Section `render`: the cinematography. Nothing here can touch the physics."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from text2sim.spec_schema.models.base import (
    Bool,
    Fraction,
    Integer,
    Model,
    Name,
    NonNegative,
    Positive,
    Real,
    Seconds,
    Window,
)
from text2sim.spec_schema.models.cameras import Camera
from text2sim.spec_schema.models.colors import Color
from text2sim.spec_schema.models.lights import Light

Speed = Annotated[Positive, Field(ge=0.01, le=100.0)]


def _even(size: tuple[int, int]) -> tuple[int, int]:
    if size[0] % 2 or size[1] % 2:
        raise ValueError(f"resolution must be even, for the video encoder (got {size[0]} x {size[1]})")
    return size


def _long(span: tuple[float, float]) -> tuple[float, float]:
    if span[0] == span[1]:
        raise ValueError(f"the film needs some length (got {span[0]:g} and {span[1]:g})")
    return span


Pixels = Annotated[Integer, Field(ge=64, le=4096)]


class Shot(Model):
    """A piece of the film, from cut to cut. Shots may overlap in time and go back: a replay in slow motion."""

    camera: Name
    """Which camera takes it."""
    from_: Seconds | None = Field(default=None, alias="from")
    """Simulated time [s] of its first picture; the beginning of the film if left out."""
    to: Seconds | None = None
    """Simulated time [s] at which it ends; the end of the film if left out."""
    speed: Speed | None = None
    """Simulated seconds per second of film: 0.1 is slow motion. That of the film if left out."""
    hold: Seconds = Field(default=0.0, le=60.0)
    """How long [s of film] its last moment is held, while a moving camera goes on."""

    @model_validator(mode="after")
    def _forward(self) -> "Shot":
        if self.from_ is not None and self.to is not None and self.to <= self.from_:
            raise ValueError(f"to must come after from (got {self.from_:g} and {self.to:g})")
        return self


class Overlay(Model):
    """What is written into the pictures of the main film."""

    title: Annotated[str, StringConstraints(min_length=1, max_length=120)] | None = None
    """A line at the lower left, for the first seconds."""
    time: Bool = False
    """Whether the simulated time is shown, and the speed where it is not 1."""
    values: Annotated[list[Name], Field(max_length=4)] = Field(default_factory=list)
    """Measures whose value at each moment is shown. Only in films that are made after the run was judged: path
    traced ones."""
    inset: Bool = False
    """Whether the first picture stays in a corner, to compare with."""


class Render(Model):
    """The cinematography. A case that says nothing gets a film made of what was recorded, and studio light."""

    resolution: Annotated[tuple[Pixels, Pixels], AfterValidator(_even)] = (1280, 720)
    """Width and height [pixels], both even."""
    fps: Positive = Field(default=25.0, ge=1.0, le=240.0)
    """Frames per second of film."""
    speed: Speed = 1.0
    """Simulated seconds per second of film; 0.25 is slow motion."""
    during: Annotated[Window, AfterValidator(_long)] | None = None
    """The part [s] of the run that is shown."""
    motion_blur: Fraction = 0.0
    """Part of the time between two pictures in which the shutter is open: 0.5 is what cinema does, 0 is sharp. Path
    traced only."""
    quality: Literal["preview", "final"] = "preview"
    """A run makes the rasterised preview, in a moment; `text2sim render` makes path-traced films of a run. `final` says
    that this is what counts."""
    setting: Literal["studio", "workshop", "warehouse", "room", "kitchen", "tabletop", "street", "meadow"] | None = None
    """The place: floor, what is behind, and the light that belongs there; each can be said below instead. `studio`: a
    pale polished floor and wall. `workshop`: concrete slabs, a warm wall. `warehouse`: the same, cooler and darker.
    `room`: floor boards. `kitchen`: tiles. `tabletop`: fine boards, for what fits on a table. `street`: asphalt, sun
    and sky. `meadow`: grass, sun and sky. If nothing is said about light or backdrop either, it is chosen from the
    case, and then a ground that was given a colour or a finish keeps it."""
    supports: Literal["posts", "none"] = "posts"
    """Whether what stands in the air without anything below it, and never moves, gets thin posts down to the floor
    where nothing moves past. Path traced only."""
    lighting: Literal["studio", "daylight", "sunlight", "overcast", "golden_hour", "dark_stage"] = "studio"
    """Lights, backdrop and background in one word, each of which can be said below instead. `studio`: a large soft lamp
    beside the camera, a cool rim light, little else, on a seamless grey cyclorama. `daylight`: a large window beside
    the camera, a bright room, a wall. `sunlight`: sky and a sun of 2.9, 51 deg high at the left behind the camera.
    `overcast`: shadowless, under a bright cloud. `golden_hour`: a warm sun of 3.4, 19 deg high there. `dark_stage`: a
    spot from above, on black."""
    lights: dict[Name, Light] = Field(default_factory=dict, max_length=20)
    """By name, instead of those of `lighting`."""
    backdrop: Literal["wall", "cyclorama", "ground", "horizon", "none"] | None = None
    """What is under and behind everything. `wall`: a floor, and a wall behind the scene. `cyclorama`: a floor that
    curves up into a seamless wall. `ground`: a floor that fades into the background. `horizon`: ground and sky. `none`:
    the ground of the scene and the background. The preview draws none of them."""
    background: Color | None = None
    """Colour of the backdrop, and behind everything."""
    ambient: NonNegative | None = Field(default=None, le=100.0)
    """Light from everywhere: radiance of a dome, 1 alone makes a white sheet white."""
    exposure: Real = Field(default=0.0, ge=-10.0, le=10.0)
    """Stops brighter (each doubles) or darker than the lights call for. It is the same in all pictures. Path traced
    only."""
    tone: Literal["agx", "aces", "standard"] = "agx"
    """Curve from light to picture: `agx` is gentle to bright colours, `aces` has more contrast, `standard` has none
    and cuts off. Path traced only."""
    cameras: dict[Name, Camera] = Field(default_factory=dict, max_length=20)
    """By name; the first makes `video.mp4` unless there are `shots`. If there is none, place and pace follow from what
    was recorded; the pace not if there is a `speed`, `during` or `shots`."""
    shots: dict[Name, Shot] = Field(default_factory=dict, max_length=100)
    """By name, in the order in which they follow each other in `video.mp4`. Cameras that no shot uses make films of
    their own."""
    overlay: Overlay = Overlay.model_construct()
    """Title, time and values in the pictures."""
