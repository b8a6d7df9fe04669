"""Controls: what acts on bodies."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Model, Name, Seconds, Selector, Vec3, Window
from text2sim.spec_schema.models.motion import Schedule
from text2sim.spec_schema.models.regions import BodyRegion


class InitialVelocity(Model):
    """The velocity with which a free body starts."""

    kind: Literal["initial_velocity"]
    body: Selector
    """A free rigid body or a ragdoll, or its copies."""
    linear: Vec3 = (0.0, 0.0, 0.0)
    """Of the centre of mass [m/s], in the world."""
    angular: Vec3 = (0.0, 0.0, 0.0)
    """[rad/s], in the world."""


class Impulse(Model):
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


class Force(Model):
    """A force on a body over a span of time."""

    kind: Literal["force"]
    body: Selector
    """A body, or one link of it."""
    force: Vec3
    """Direction and size [N]; multiplied by `scale`."""
    scale: Schedule = 1.0
    """Factor that may change with time."""
    during: Window | None = None
    """From and to [s]; the whole run if left out."""
    frame: Literal["world", "body"] = "world"
    """The frame in which `force` is given."""
    point: Vec3 | BodyRegion | None = None
    """Where it acts: a point [m] or region in the body's frame, moving with it; the centre of mass if left out."""


class Torque(Model):
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


class Drive(Model):
    """A target for a joint's actuator. Several drives of one joint take over from each other in time.

    Until the first of them begins, the joint is held where it starts, or at rest, or pushed by nothing.
    """

    kind: Literal["drive"]
    joint: Selector
    """A mounted body (`drum`), its copies (`hook[*]`), or a joint of an articulated body (`arm.elbow`)."""
    position: Schedule | None = None
    """Target [rad or m], counted from the pose that the case describes, in a body from a file from the file's
    zero; needs `stiffness`."""
    velocity: Schedule | None = None
    """Target [rad/s or m/s]; needs `damping`."""
    force: Schedule | None = None
    """Force [N] or torque [N m]."""

    @model_validator(mode="after")
    def _one_target(self) -> "Drive":
        if sum(x is not None for x in (self.position, self.velocity, self.force)) != 1:
            raise ValueError("give exactly one of position, velocity, force")
        return self


class Attach(Model):
    """A weld between two bodies, from a time on; they keep the relative pose that they have then."""

    kind: Literal["attach"]
    body: Selector
    """What is attached: a body, or one link of it."""
    to: Selector
    """What it is attached to: a body or static, or one link. Copies pair one to one, or all with the one."""
    at: Seconds = 0.0
    """Time [s]."""


class Release(Model):
    """The end of an `attach`."""

    kind: Literal["release"]
    attach: Name
    """The name of the control that attached it."""
    at: Seconds
    """Time [s]."""


Control = Annotated[InitialVelocity | Impulse | Force | Torque | Drive | Attach | Release, Field(discriminator="kind")]
