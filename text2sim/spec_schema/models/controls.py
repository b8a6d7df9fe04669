"""Controls: what acts on bodies."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    ByKind,
    Integer,
    Name,
    NonNegative,
    Positive,
    Seconds,
    Selector,
    Vec3,
    Window,
)
from text2sim.spec_schema.models.fields import Acting, Attraction, Drag, Turbulence, Vortex, Wind
from text2sim.spec_schema.models.motion import Schedule
from text2sim.spec_schema.models.regions import BodyRegion


class InitialVelocity(Acting):
    """The velocity with which a free body starts."""

    kind: Literal["initial_velocity"]
    body: Selector
    """A free rigid body, a ragdoll, or a body that deforms; or its copies."""
    linear: Vec3 = (0.0, 0.0, 0.0)
    """Of the centre of mass [m/s], in the world."""
    angular: Vec3 = (0.0, 0.0, 0.0)
    """[rad/s], in the world."""


class Impulse(Acting):
    """A blow: momentum given within one time step."""

    kind: Literal["impulse"]
    body: Selector
    """A body, or one link of it (`arm.hand`)."""
    impulse: Vec3
    """[N s], in the world."""
    at: Seconds
    """Time [s]."""
    point: Vec3 | BodyRegion | None = None
    """Where it strikes: a point [m] or region in the body's frame; the centre of mass if left out."""


class Force(Acting):
    """A force on a body over a span of time."""

    kind: Literal["force"]
    body: Selector
    """A body, or one link of it; or a body that deforms."""
    force: Vec3
    """Direction and size [N]; multiplied by `scale`. On a body that deforms it is shared out by mass, so that all of
    what is pushed gets the same acceleration."""
    scale: Schedule = 1.0
    """Factor that may change with time."""
    during: Window | None = None
    """From and to [s]; the whole run if left out."""
    frame: Literal["world", "body"] = "world"
    """The frame in which `force` is given."""
    point: Vec3 | BodyRegion | None = None
    """Where it acts: a point [m] or region in the body's frame, moving with it; the centre of mass if left out. For
    rigid bodies."""
    region: BodyRegion | None = None
    """For bodies that deform: which part of it is pushed, chosen at the start and moving with it; the whole body if
    left out."""
    drag: NonNegative = 0.0
    """For bodies that deform: resistance [N s/m] to the velocity of that part while the force acts, so that it comes to
    `force / drag` and goes on with that. It acts on each point by its mass: one that runs ahead is held back."""


class Torque(Acting):
    """A torque on a body over a span of time."""

    kind: Literal["torque"]
    body: Selector
    """A body, or one link of it."""
    torque: Vec3
    """[N m]; multiplied by `scale`."""
    scale: Schedule = 1.0
    """Factor that may change with time."""
    during: Window | None = None
    """From and to [s]; the whole run if left out."""
    frame: Literal["world", "body"] = "world"
    """The frame in which `torque` is given."""


class Drive(Acting):
    """A target for a joint's actuator. Several drives of one joint take over from each other in time.

    Until the first of them begins (the `start` or first time of its target; at once if it has none), the joint is held
    where it starts, or at rest, or pushed by nothing.
    """

    kind: Literal["drive"]
    joint: Selector
    """A mounted body (`drum`), its copies (`hook[*]`), or a joint of an articulated body (`arm.elbow`), or several
    (`dog.*_hip`)."""
    position: Schedule | None = None
    """Target [rad or m], counted from the pose that the case describes, in a body from a file from the file's
    zero; needs `stiffness`."""
    velocity: Schedule | None = None
    """Target [rad/s or m/s]; needs `damping`."""
    force: Schedule | None = None
    """Force [N] or torque [N m]."""
    on: Name | None = None
    """Name of an event: it begins at its first time, and the times of the target count from there. A ramp without
    `from` starts where the target before it is then. The program itself has to see the event come, as for `release`."""

    @model_validator(mode="after")
    def _one_target(self) -> "Drive":
        if sum(x is not None for x in (self.position, self.velocity, self.force)) != 1:
            raise ValueError("give exactly one of position, velocity, force")
        return self


class Reach(Acting):
    """Where a link of a mechanism is to be, made into targets of its joints by inverse kinematics.

    All hinges and sliders from the world to that link move, and their actuators need a stiffness. They go from target
    to target, at rest at each; as drives, they take over from others in time. What carries a load sags by load over
    stiffness, as with every drive. What is out of reach is an error of `check`.
    """

    kind: Literal["reach"]
    body: Selector
    """The link (`arm.hand`)."""
    times: list[Seconds] = Field(min_length=1, max_length=100)
    """When it is to be at each target [s], growing."""
    positions: list[Vec3] = Field(min_length=1, max_length=100)
    """Where [m], in the world; one for each time."""
    euler_deg: Vec3 | list[Vec3] | None = None
    """How the link's frame is turned there [deg], one for all or one for each: turns about the world's x, then y, then
    z. Left out: anyhow."""
    point: Vec3 = (0.0, 0.0, 0.0)
    """Which point of the link, in its frame [m]: the tip of a tool."""
    start: Seconds = 0.0
    """When it sets out for the first target [s]."""
    ease: Literal["linear", "smooth"] = "smooth"
    """Of the joints, from target to target; `smooth` starts and ends at rest."""

    @model_validator(mode="after")
    def _one_for_each(self) -> "Reach":
        counts = {"positions": len(self.positions)}
        if isinstance(self.euler_deg, list):
            counts["euler_deg"] = len(self.euler_deg)
        for key, count in counts.items():
            if count != len(self.times):
                raise ValueError(f"times and {key} must have the same length (got {len(self.times)} and {count})")
        if any(b <= a for a, b in zip([self.start, *self.times], self.times, strict=False)):
            raise ValueError("times must grow, and the first must be later than start")
        return self

    @property
    def turns(self) -> list[Vec3] | None:
        """How it is turned at each target [deg]; None for anyhow."""
        return [self.euler_deg] * len(self.times) if isinstance(self.euler_deg, tuple) else self.euler_deg


class Attach(Acting):
    """A hold between two bodies, from a time on; they keep the relative pose that they have then.

    Between rigid bodies it is a weld, and the two links that it holds do not touch each other meanwhile; other links of
    the two bodies do. Of a body that deforms it holds points: pins, hooks, clamps. Cloth (pbd) pulls at what holds it,
    unless that is driven or has a motor: a parachute, a sling, a sail. A soft body does not: what holds its points
    carries them along, and does not feel them.
    """

    kind: Literal["attach"]
    body: Selector
    """What is attached: a body, or one link of it."""
    region: BodyRegion | None = None
    """For bodies that deform: which part of it is held; the whole body if left out."""
    points: Annotated[Integer, Field(ge=1, le=10_000)] | None = None
    """Of bodies that deform: how many points of the region, evenly spread; all if left out. With several copies in `to`
    each of them holds those that are nearest to it."""
    to: Selector
    """What it is attached to: a body or static, or one link, or `world`, which holds it where it is then. Copies pair
    one to one, or all with the one; several copies hold one body that deforms together."""
    stiffness: Positive | None = None
    """For mpm and fem bodies: hold by springs of this stiffness [N/m] in all, instead of firmly. Firmly means exactly
    for fem and pbd; mpm particles trail what carries them by four substeps of its way."""
    at: Seconds = 0.0
    """Time [s]."""


class Release(Acting):
    """The end of an `attach`, at a time or when something happens."""

    kind: Literal["release"]
    attach: Name
    """The name of the control that attached it."""
    at: Seconds | None = None
    """Time [s]."""
    on: Name | None = None
    """Name of an event: at its first time after it was attached. The program itself has to see it come: contact of
    bodies of links, a region entered or left, a threshold of a position, displacement, velocity, speed, distance or
    joint_position."""

    @model_validator(mode="after")
    def _one_moment(self) -> "Release":
        if (self.at is None) == (self.on is None):
            raise ValueError("give exactly one of at, on")
        return self


class Remove(Acting):
    """A body that leaves the scene, at a time or when something happens, and does not come back.

    It is switched off where it is: nothing touches it any more, nothing moves it, and no picture shows it. What was
    attached to it is free, its measures have no values from then on, and it is in no region. Evidence lists when it
    went, under `removed`.
    """

    kind: Literal["remove"]
    body: Selector
    """A body of links, a driven body or a static, or copies of one."""
    at: Seconds | None = None
    """Time [s]."""
    on: Name | None = None
    """Name of an event: at its first time. The program itself has to see it come, as for `release`."""

    @model_validator(mode="after")
    def _one_moment(self) -> "Remove":
        if (self.at is None) == (self.on is None):
            raise ValueError("give exactly one of at, on")
        return self


Control = Annotated[
    InitialVelocity
    | Impulse
    | Force
    | Torque
    | Drive
    | Reach
    | Attach
    | Release
    | Remove
    | Wind
    | Drag
    | Attraction
    | Vortex
    | Turbulence,
    ByKind(),
]
