"""Section `render`: the cinematography, without influence on the physics."""

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
        raise ValueError(f"the span of the film must not be empty (got {span[0]:g} and {span[1]:g})")
    return span


Pixels = Annotated[Integer, Field(ge=64, le=4096)]


class Shot(Model):
    """A piece of the film between two cuts. Shots may overlap in time or go back, as for a replay in slow motion."""

    camera: Name
    """Name of its camera."""
    from_: Seconds | None = Field(default=None, alias="from")
    """Simulated time [s] of its first picture; by default the beginning of the film."""
    to: Seconds | None = None
    """Simulated time [s] of its end; by default the end of the film."""
    speed: Speed | None = None
    """Simulated seconds per second of film: 0.1 is slow motion. By default that of the film."""
    hold: Seconds = Field(default=0.0, le=60.0)
    """Duration [s of film] of a freeze at its last moment, during which a moving camera continues."""

    @model_validator(mode="after")
    def _forward(self) -> "Shot":
        if self.from_ is not None and self.to is not None and self.to <= self.from_:
            raise ValueError(f"to must come after from (got {self.from_:g} and {self.to:g})")
        return self


class Overlay(Model):
    """Text and insets in the pictures of the main film."""

    title: Annotated[str, StringConstraints(min_length=1, max_length=120)] | None = None
    """A line of text at the lower left, for the first seconds."""
    time: Bool = False
    """Show the simulated time, and the speed where it is not 1."""
    values: Annotated[list[Name], Field(max_length=4)] = Field(default_factory=list)
    """Measures whose current value is shown, four at most. Path traced only, because the preview is made before the
    run is judged."""
    inset: Bool = False
    """Keep the first picture in a corner for comparison."""


class Render(Model):
    """The cinematography; by default derived from the recording, with studio light."""

    resolution: Annotated[tuple[Pixels, Pixels], AfterValidator(_even)] = (1280, 720)
    """Width and height [pixels], both even."""
    fps: Positive = Field(default=25.0, ge=1.0, le=240.0)
    """Frames per second of film."""
    speed: Speed = 1.0
    """Simulated seconds per second of film; 0.25 is slow motion."""
    during: Annotated[Window, AfterValidator(_long)] | None = None
    """Start and end [s] of the part of the run that is shown; by default the whole run."""
    motion_blur: Fraction = 0.0
    """Fraction of the time between two pictures during which the shutter is open: 0.5 is usual in cinema, 0 is sharp.
    Path traced only."""
    quality: Literal["preview", "final"] = "preview"
    """The film that counts: the rasterised `preview`, which every run makes quickly, or the path-traced film that
    `text2sim render` makes of a run (`final`)."""
    setting: (
        Literal["studio", "workshop", "warehouse", "room", "kitchen", "tabletop", "street", "yard", "meadow"] | None
    ) = None
    """Location: floor, background and matching light, each of which can be overridden below. `studio`: a pale polished
    floor, a blue-grey wall. `workshop`: slabs, bricks. `warehouse`: slabs and concrete, cooler. `room`: boards,
    plaster. `kitchen`: tiles. `tabletop`: fine boards, for scenes that fit on a table. `street`: asphalt, a town far
    off, sun. `yard`: earth; `meadow`: grass; both with a wood far off, and sun. If neither light nor backdrop is given,
    it is by default derived from the case; then a ground with a given colour or finish keeps it."""
    supports: Literal["posts", "none"] = "posts"
    """`posts`: what floats gets thin posts where nothing moves past, or, if it is driven, a rod. Path traced only."""
    lighting: Literal["studio", "daylight", "sunlight", "overcast", "golden_hour", "dark_stage"] = "studio"
    """Preset of lights, backdrop and background, each of which can be overridden below. `studio`: a large soft lamp
    beside the camera, a cool rim light and little else, on a grey cyclorama. `daylight`: a window beside the camera, a
    room, a wall. `sunlight`: sky, and a sun of 2.9, 43 deg high, behind the camera on the left. `overcast`: shadowless,
    under a bright cloud. `golden_hour`: a warm sun of 3.4, 24 deg high, at the same place. `dark_stage`: soft light
    from above, on near-black."""
    lights: dict[Name, Light] = Field(default_factory=dict, max_length=20)
    """Lights by name, instead of those of `lighting`."""
    backdrop: Literal["wall", "cyclorama", "ground", "horizon", "none"] | None = None
    """Surroundings of the scene. `wall`: a floor, and a wall behind the scene. `cyclorama`: a floor that curves up into
    a seamless wall. `ground`: a floor that fades into the background. `horizon`: ground and sky. `none`: the ground of
    the scene and the background. The preview draws none of them."""
    background: Color | None = None
    """Colour of the backdrop and of the background."""
    ambient: NonNegative | None = Field(default=None, le=100.0)
    """Light from all directions: radiance of a dome; 1 alone makes a white sheet white."""
    exposure: Real = Field(default=0.0, ge=-10.0, le=10.0)
    """Exposure [stops] relative to the one derived from the lights; each stop doubles the brightness. It is the same in
    all pictures. Path traced only."""
    tone: Literal["agx", "aces", "standard"] = "agx"
    """Tone curve: `agx` is gentle to bright colours, `aces` has more contrast, `standard` has no curve and clips. Path
    traced only."""
    cameras: dict[Name, Camera] = Field(default_factory=dict, max_length=20)
    """Cameras by name; the first makes `video.mp4` unless there are `shots`. Without any, the camera is derived from
    the recording, and so is the pace unless there is `speed`, `during` or `shots`."""
    shots: dict[Name, Shot] = Field(default_factory=dict, max_length=100)
    """Shots by name, in their order in `video.mp4`. Cameras that no shot uses make separate films."""
    overlay: Overlay = Overlay.model_construct()
    """Title, time and values in the pictures."""
