"""Section `actions`: what is driven, what is measured, and what must come true."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.base import (
    AxisName,
    Bool,
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
from text2sim.spec_schema.motion import Schedule
from text2sim.spec_schema.placement import Region

# --- controls
# -------------------------------------------------------------------------------------------------


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
    point: Vec3 | None = None
    """Where it strikes [m], in the body's frame; the centre of mass if left out."""


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
    """A target for a joint's actuator. Several drives of one joint take over from each other in time."""

    kind: Literal["drive"]
    joint: Selector
    """A mounted body (`drum`), its copies (`hook[*]`), or a joint of an articulated body (`arm.elbow`)."""
    position: Schedule | None = None
    """Target [rad or m], counted from the pose that the case describes; needs `stiffness`."""
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

# --- measures
# -------------------------------------------------------------------------------------------------

Stat = Literal["max", "min", "mean", "sum", "range", "count"]


class _Of(Model):
    of: Selector
    """A body, its copies, or a link of it."""
    stat: Stat | None = None
    """How several copies become one number; needed if there are several. `count` counts those that are
    `above` or `below`."""
    above: Real | None = None
    """With `stat: count`."""
    below: Real | None = None
    """With `stat: count`."""

    @model_validator(mode="after")
    def _count_needs_bound(self) -> "_Of":
        bounds = (self.above is not None) + (self.below is not None)
        if (self.stat == "count") != (bounds > 0):
            raise ValueError("above and below go with stat: count, which needs one of them")
        return self


class Position(_Of):
    """A coordinate of the body's origin [m]."""

    kind: Literal["position"]
    axis: AxisName
    """Which coordinate."""


class Velocity(_Of):
    """A component of the velocity of the centre of mass [m/s]."""

    kind: Literal["velocity"]
    axis: AxisName
    """Which component."""


class Speed(_Of):
    """Speed of the centre of mass [m/s]."""

    kind: Literal["speed"]


class AngularSpeed(_Of):
    """Angular speed [rad/s]."""

    kind: Literal["angular_speed"]


class Displacement(_Of):
    """Distance [m] of the body's origin from where it started."""

    kind: Literal["displacement"]
    axis: AxisName | None = None
    """Signed displacement along one axis instead."""


class Tilt(_Of):
    """Angle [deg] by which one of the body's own axes has turned away from its direction at the start."""

    kind: Literal["tilt"]
    axis: AxisName = "z"
    """Which of the body's own axes."""


class JointPosition(_Of):
    """Position of a hinge [rad] or slider [m], counted from the pose that the case describes."""

    kind: Literal["joint_position"]


class JointVelocity(_Of):
    """Velocity of a hinge [rad/s] or slider [m/s]."""

    kind: Literal["joint_velocity"]


class JointForce(_Of):
    """Torque [N m] or force [N] that the actuator gives."""

    kind: Literal["joint_force"]


class Extent(Model):
    """How far bodies reach along an axis [m], from the corners of their shapes."""

    kind: Literal["extent"]
    of: Selector
    """A body or its copies."""
    axis: AxisName
    """Which coordinate."""
    stat: Literal["max", "min", "range"]
    """The highest or lowest coordinate of all, or the difference."""


class Distance(Model):
    """Distance [m] between the origins of two bodies; of the nearest pair, if there are several."""

    kind: Literal["distance"]
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies."""


class ContactForce(Model):
    """Size [N] of the sum of contact forces on a body (from another, if `by` is given)."""

    kind: Literal["contact_force"]
    of: Selector
    """What is pushed on."""
    by: Selector | None = None
    """What pushes; anything if left out."""


class ContactCount(Model):
    """How many pairs of bodies touch: those of `of` with anything, or with `by`."""

    kind: Literal["contact_count"]
    of: Selector
    """A body or its copies."""
    by: Selector | None = None
    """What they touch; anything if left out."""


class Penetration(Model):
    """Deepest overlap [m] of touching bodies: of `of` with anything (or with `by`)."""

    kind: Literal["penetration"]
    of: Selector
    """A body or its copies."""
    by: Selector | None = None
    """What they overlap with; anything if left out."""


class Energy(Model):
    """Mechanical energy [J] of bodies; potential energy is zero at z = 0."""

    kind: Literal["energy"]
    of: Selector | None = None
    """All bodies if left out."""
    part: Literal["kinetic", "potential", "total"] = "total"
    """Which part of it."""


class Momentum(Model):
    """Linear momentum [kg m/s] of bodies along an axis."""

    kind: Literal["momentum"]
    of: Selector | None = None
    """All bodies if left out."""
    axis: AxisName
    """Which component."""


class CountIn(Model):
    """How many copies have their origin in a region."""

    kind: Literal["count_in"]
    of: Selector
    """A body and its copies."""
    region: Region
    """Where they are counted."""


Measure = Annotated[
    Position
    | Velocity
    | Speed
    | AngularSpeed
    | Displacement
    | Tilt
    | JointPosition
    | JointVelocity
    | JointForce
    | Extent
    | Distance
    | ContactForce
    | ContactCount
    | Penetration
    | Energy
    | Momentum
    | CountIn,
    Field(discriminator="kind"),
]

# --- events
# ---------------------------------------------------------------------------------------------------


class _Event(Model):
    after: Name | None = None
    """Look only after the first time of this other event."""


class ContactEvent(_Event):
    """Two bodies begin to touch."""

    kind: Literal["contact"]
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies; physics has to move one of them."""
    min_impulse: NonNegative = 0.0
    """Ignore touches that give less than this [N s]."""


class SeparationEvent(_Event):
    """Two bodies that touched touch no more, for at least `for`."""

    kind: Literal["separation"]
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies; physics has to move one of them."""
    for_: Seconds = Field(default=0.05, alias="for")
    """Time [s] without touch."""


class ThresholdEvent(_Event):
    """A measure passes a value; each time it does so anew counts."""

    kind: Literal["threshold"]
    measure: Name
    """Name of a measure."""
    above: Real | None = None
    """It rises to this value."""
    below: Real | None = None
    """It falls to this value."""

    @model_validator(mode="after")
    def _one_bound(self) -> "ThresholdEvent":
        if (self.above is None) == (self.below is None):
            raise ValueError("give exactly one of above, below")
        return self


class RestEvent(_Event):
    """Bodies have come to rest."""

    kind: Literal["rest"]
    of: Selector
    """A body or its copies."""
    speed: Positive = 0.02
    """All are slower than this [m/s] …"""
    for_: Positive = Field(default=0.2, alias="for")
    """… for this long [s]."""


class LeftDomainEvent(_Event):
    """A body leaves `scene.domain`."""

    kind: Literal["left_domain"]
    of: Selector
    """A body or its copies."""


class RegionEvent(_Event):
    """A body's origin enters or leaves a region; each copy counts."""

    kind: Literal["enters", "leaves"]
    of: Selector
    """A body or its copies."""
    region: Region
    """Which region."""


class JointLimitEvent(_Event):
    """A joint comes to the end of its range."""

    kind: Literal["joint_limit"]
    of: Selector
    """A mounted body, its copies, or a joint."""


class ReleasedEvent(_Event):
    """An attachment is released."""

    kind: Literal["released"]
    attach: Name
    """Name of the control that attached it."""


Event = Annotated[
    ContactEvent
    | SeparationEvent
    | ThresholdEvent
    | RestEvent
    | LeftDomainEvent
    | RegionEvent
    | JointLimitEvent
    | ReleasedEvent,
    Field(discriminator="kind"),
]

# --- expectations
# ---------------------------------------------------------------------------------------------


class Expect(Model):
    """What must come true, of an event or of a measure.

    An event happens (`within` a span, `count` times, `before` another) or `never`; a measure is `above`,
    `below` or near a value (`equals`, `tolerance`), `at` a time or `during` a span.
    """

    event: Name | None = None
    """Name of the event that it is about."""
    within: Window | None = None
    """The first time of the event lies in this span [s]."""
    never: Bool = False
    """The event must not happen."""
    count: tuple[Integer, Integer] | Integer | None = None
    """How often the event happens: exactly, or from and to."""
    before: Name | None = None
    """The event's first time is earlier than that of this other event."""

    measure: Name | None = None
    """Name of the measure that it is about."""
    at: Seconds | Literal["start", "end"] | None = None
    """Time [s] at which the measure is read."""
    during: Window | Literal["all"] | None = None
    """Span [s] over which it is taken: every value must hold, or `stat` of them."""
    stat: Literal["max", "min", "mean", "range"] | None = None
    """With `during`: one number for the span."""
    above: Real | None = None
    """It is larger than this."""
    below: Real | None = None
    """It is smaller than this."""
    equals: Real | None = None
    """It is this, within `tolerance`."""
    tolerance: Positive | None = None
    """With `equals`: largest difference."""

    @model_validator(mode="after")
    def _complete(self) -> "Expect":
        if (self.event is None) == (self.measure is None):
            raise ValueError("give either event or measure")
        of_event = {"within", "never", "count", "before"} & self.model_fields_set
        of_measure = {"at", "during", "stat", "above", "below", "equals", "tolerance"} & self.model_fields_set
        if self.event is not None:
            if of_measure:
                raise ValueError(f"{', '.join(sorted(of_measure))} belong to a measure, not to an event")
            if self.never and (of_event - {"never", "within"}):
                raise ValueError("never goes with within alone")
            return self
        if of_event:
            raise ValueError(f"{', '.join(sorted(of_event))} belong to an event, not to a measure")
        if (self.at is None) == (self.during is None):
            raise ValueError("a measure needs either at or during")
        if self.stat is not None and self.during is None:
            raise ValueError("stat goes with during")
        if self.above is None and self.below is None and self.equals is None:
            raise ValueError("a measure needs above, below or equals")
        if (self.equals is None) != (self.tolerance is None):
            raise ValueError("equals and tolerance go together")
        return self


class Actions(Model):
    """The script: what is driven, what is measured, what must come true."""

    controls: dict[Name, Control] = Field(default_factory=dict)
    """What acts on the bodies, by name."""
    measures: dict[Name, Measure] = Field(default_factory=dict)
    """Numbers over time, by name."""
    events: dict[Name, Event] = Field(default_factory=dict)
    """Moments, by name."""
    expect: dict[Name, Expect] = Field(default_factory=dict)
    """What must come true, by name."""
