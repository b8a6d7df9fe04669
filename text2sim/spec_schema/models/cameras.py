"""Cameras of a film: positions, targets, framing, lenses."""

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Bounds, ByKind, Direction, Model, Positive, Real, Seconds, Selector, Vec3
from text2sim.spec_schema.models.regions import BodyPoint

Target = Vec3 | Selector | BodyPoint
"""A point [m], or a body (the centre of its copies, if there are several), or a region of it."""
Margin = Annotated[Real, Field(ge=0.0, le=0.45)]
SENSOR = 24.0
"""Height [mm] of a picture on 35 mm film, 36 mm x 24 mm."""
FOV = 40.0
"""Default vertical field of view [deg]."""


def fov_of_lens(focal: float) -> float:
    """Return the vertical field of view [deg] of a lens, focal length in mm, on 35 mm film: 2 atan(12 / focal)."""
    return 2 * math.degrees(math.atan(SENSOR / 2 / focal))


class _Camera(Model):
    fov: Positive | None = Field(default=None, ge=2.0, le=140.0, alias="fov_deg")
    """Vertical field of view [deg]; 40 if no lens is given."""
    lens: Positive | None = Field(default=None, ge=5.0, le=600.0, alias="lens_mm")
    """Instead of `fov_deg`: focal length [mm] on 35 mm film, 36 mm x 24 mm. `fov_deg` = 2 atan(12 / `lens_mm`): 24
    is wide (53 deg), 50 is normal (27 deg), 85 is for portraits (16 deg)."""
    f_stop: Positive | None = Field(default=None, ge=0.5, le=64.0)
    """Aperture of the lens; bodies away from `focus` are blurred. Its diameter is `lens_mm` / `f_stop`, as in a real
    camera: 2.8 blurs from a metre away, 16 hardly at all. By default all is sharp. Path traced only."""
    focus: Target | None = None
    """With `f_stop`: the sharp point [m], or a body, which stays sharp while it moves. By default the target of the
    camera."""

    @model_validator(mode="after")
    def _one_lens(self) -> "_Camera":
        if self.fov is not None and self.lens is not None:
            raise ValueError("give either fov_deg or lens_mm")
        if self.focus is not None and self.f_stop is None:
            raise ValueError("focus needs an f_stop: without one all is sharp")
        return self

    @property
    def field(self) -> float:
        """Vertical field of view [deg]."""
        return fov_of_lens(self.lens) if self.lens is not None else self.fov if self.fov is not None else FOV


class _Upright(_Camera):
    up: Direction = (0.0, 0.0, 1.0)
    """Up direction of the picture; +y if the camera looks straight up or down."""


class _Framing(_Upright):
    frame: Annotated[list[Selector], Field(min_length=1, max_length=50)] | None = None
    """Bodies, statics, links (`net.x5_*`) or parts that touch, shown whole throughout the camera's shots. The position
    is derived from the recording."""
    margin: Margin | None = None
    """With `frame`: share of the picture that stays free at each edge; by default 0.08."""
    within: Bounds | None = None
    """With `frame`: the space that counts; what of the bodies is outside it, at any time, may leave the picture."""

    @model_validator(mode="after")
    def _margin_of_frame(self) -> "_Framing":
        if self.frame is None and (self.margin is not None or self.within is not None):
            raise ValueError("margin and within need frame")
        return self


class Still(_Framing):
    """A camera on a tripod.

    With `frame` it stands in the given `direction`, as near as possible with all bodies in the picture; or it stands at
    `from`, and derives its field of view.
    """

    kind: Literal["still"]
    from_: Vec3 | None = Field(default=None, alias="from")
    """Its position [m]."""
    look_at: Target | None = None
    """Its target (for a body: the position at the start)."""
    direction: Direction | None = None
    """With `frame`, instead of `from`: direction from the bodies to the camera. By default one with a free view."""

    @model_validator(mode="after")
    def _one_way(self) -> "Still":
        if self.frame is None:
            if self.from_ is None or self.look_at is None:
                raise ValueError("give from and look_at, or frame")
            if self.direction is not None:
                raise ValueError("direction needs frame")
            if self.from_ == self.look_at:
                raise ValueError("from and look_at are the same point")
        elif self.look_at is not None:
            raise ValueError("give either look_at or frame, which looks at the centre of its bodies")
        elif self.from_ is not None and self.direction is not None:
            raise ValueError("give either from or direction")
        elif self.from_ is not None and (self.fov is not None or self.lens is not None):
            raise ValueError("with from and frame the lens is derived; give a direction instead of from to choose it")
        return self


class Follow(_Framing):
    """A camera that keeps looking at a body, from a fixed position or moving along.

    With `frame` it moves along in the given `direction` from the body, as near as possible with all of `frame` in the
    picture.
    """

    kind: Literal["follow"]
    body: Selector
    """Its target."""
    from_: Vec3 | None = Field(default=None, alias="from")
    """Its position [m]; give this, `offset`, or `frame` and `direction`."""
    offset: Direction | None = None
    """Its position relative to the body [m]: it moves along."""
    direction: Direction | None = None
    """With `frame`: direction from the bodies to the camera, which moves along."""
    smooth: Seconds = Field(default=0.3, le=60.0)
    """Time [s] over which its motion is averaged."""

    @model_validator(mode="after")
    def _one_place(self) -> "Follow":
        if sum(way is not None for way in (self.from_, self.offset, self.direction)) != 1:
            raise ValueError("give either from or offset, or frame and direction")
        if (self.frame is None) != (self.direction is None):
            raise ValueError("frame and direction go together")
        return self


class Mounted(_Camera):
    """A camera fixed to a body or link, which moves and turns with it: on a robot's hand, a dashboard or a drone.

    `pos`, `look_at`, `euler_deg` and `up` are in the frame of what carries it.
    """

    kind: Literal["mounted"]
    on: Selector
    """What carries it: one static or body that does not deform, or a link (`arm.hand`); of several links, the first."""
    pos: Vec3 = (0.0, 0.0, 0.0)
    """Its position [m]."""
    look_at: Vec3 | None = None
    """The point [m] in the middle of the picture; give either this or `euler_deg`."""
    euler_deg: Vec3 | None = None
    """Its orientation [deg]: rotations about the fixed x, then y, then z axis of a camera that looks along z, with x to
    the right and y down in the picture, as hand-eye calibration gives it. With `f_stop` it is sharp at 1 m."""
    up: Direction | None = None
    """With `look_at`: up direction of the picture; by default z, or y if the camera looks along z."""

    @model_validator(mode="after")
    def _one_direction(self) -> "Mounted":
        if (self.look_at is None) == (self.euler_deg is None):
            raise ValueError("give either look_at or euler_deg")
        if self.euler_deg is not None and self.up is not None:
            raise ValueError("up needs look_at: euler_deg says what is up")
        if self.look_at == self.pos:
            raise ValueError("pos and look_at are the same point")
        return self


class Orbit(_Framing):
    """A camera on a circle about a point, or about what it frames."""

    kind: Literal["orbit"]
    look_at: Target | None = None
    """Centre of the circle and target; with `frame` instead, the centre of its bodies."""
    radius: Positive | None = None
    """Radius [m]. With `frame` leave out both radius and height: then the circle is as small as possible."""
    height: Real | None = None
    """Height [m] above the centre."""
    start_deg: Real = -90.0
    """Angle [deg] from +x at the start."""
    turn_deg: Real = 90.0
    """Angle [deg] that it covers in its shots, or in the whole film."""

    @model_validator(mode="after")
    def _one_circle(self) -> "Orbit":
        if (self.look_at is None) == (self.frame is None):
            raise ValueError("give either look_at or frame")
        if (self.radius is None) != (self.height is None):
            raise ValueError("give both radius and height, or with frame neither")
        if self.frame is None and self.radius is None:
            raise ValueError("give radius and height, or frame instead of look_at")
        return self


class Dolly(_Upright):
    """A camera that moves along a straight line over its shots, or over the whole film."""

    kind: Literal["dolly"]
    from_: Vec3 = Field(alias="from")
    """Its start [m]."""
    to: Vec3
    """Its end [m]."""
    look_at: Target
    """Its target (for a body: the position at the start)."""


class Keyframed(_Upright):
    """A camera on a smooth path through given points, at rest at both ends."""

    kind: Literal["keyframed"]
    times: Annotated[list[Seconds], Field(min_length=2, max_length=200)]
    """Simulated times [s], ascending; it stands still before the first and after the last."""
    positions: Annotated[list[Vec3], Field(min_length=2, max_length=200)]
    """Its positions at these times [m]."""
    look_at: Target | Annotated[list[Vec3], Field(min_length=2, max_length=200)]
    """Its target (for a body: the position at the start), or a point [m] for each time."""

    @model_validator(mode="after")
    def _alike(self) -> "Keyframed":
        if len(self.times) != len(self.positions):
            counts = f"{len(self.times)} and {len(self.positions)}"
            raise ValueError(f"times and positions must have the same length (got {counts})")
        if isinstance(self.look_at, list) and len(self.look_at) != len(self.times):
            counts = f"{len(self.times)} and {len(self.look_at)}"
            raise ValueError(f"times and look_at must have the same length (got {counts})")
        if any(late - early < 1e-6 for early, late in pairwise(self.times)):
            raise ValueError("times must be ascending")
        return self


Camera = Annotated[Still | Follow | Mounted | Orbit | Dolly | Keyframed, ByKind()]
