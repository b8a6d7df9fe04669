"""Measures: numbers over time."""

from typing import Annotated, ClassVar, Literal

from pydantic import model_validator

from text2sim.spec_schema.models.base import AxisName, ByKind, Real, Selector, Vec3
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.soft_measures import (
    FoldedArea,
    Gap,
    LargestPiece,
    Leaked,
    Measured,
    Pieces,
    SelfPenetration,
    ShareIn,
    Strain,
    Stretch,
    Volume,
    Wrinkling,
)
from text2sim.spec_schema.models.space import Region

Stat = Literal["max", "min", "mean", "std", "sum", "range", "count"]


class _Of(Measured):
    of: Selector
    """A body, its copies, or links of it (`net.x5_*`)."""
    stat: Stat | None = None
    """How several copies or links become one number; needed if there are several. `std` is their standard deviation,
    `count` counts those that are `above` or `below`."""
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


class _OfRegion(_Of):
    region: BodyRegion | None = None
    """Of a body that deforms: the mean over this part of it, chosen at the start, instead of its centre of mass."""


class Position(_OfRegion):
    """A coordinate of the body's origin [m]; of a body that deforms, of its centre of mass."""

    kind: Literal["position"]
    unit: ClassVar[str] = "m"
    axis: AxisName
    """Which coordinate."""


class Velocity(_OfRegion):
    """A component of the velocity of the centre of mass [m/s]."""

    kind: Literal["velocity"]
    unit: ClassVar[str] = "m/s"
    axis: AxisName
    """Which component."""


class Speed(_OfRegion):
    """Speed of the centre of mass [m/s]."""

    kind: Literal["speed"]
    unit: ClassVar[str] = "m/s"


class AngularSpeed(_Of):
    """Angular speed [rad/s]: how fast it turns, about whatever axis."""

    kind: Literal["angular_speed"]
    unit: ClassVar[str] = "rad/s"


class _Turning(_Of):
    axis: AxisName
    """About which axis; positive is counterclockwise, seen from where the axis points to."""
    frame: Literal["world", "body"] = "world"
    """Whose axis: that of the world, or the body's own, which turns with it."""


class AngularVelocity(_Turning):
    """A component of the angular velocity [rad/s], with its sign."""

    kind: Literal["angular_velocity"]
    unit: ClassVar[str] = "rad/s"


class Turns(_Turning):
    """How often a body has turned about an axis since the start, with its sign: 0.5 is half a turn.

    It is the integral of `angular_velocity`: whole turns add up, for a free body too.
    """

    kind: Literal["turns"]


class Bend(_Of):
    """Angle [deg] between a link and the one that carries it, less that at the start: how far a joint is bent.

    Of chains, nets, ropes, dolls and mechanisms, whose joints are hinges and balls. All joints of a body are meant
    unless links are named; the root of a free body has none.
    """

    kind: Literal["bend"]
    unit: ClassVar[str] = "deg"


class Displacement(_OfRegion):
    """Distance [m] of the body's origin from where it started; of a body that deforms, of its centre of mass."""

    kind: Literal["displacement"]
    unit: ClassVar[str] = "m"
    axis: AxisName | None = None
    """Signed displacement along one axis instead."""


class Tilt(_Of):
    """Angle [deg] by which one of the body's own axes has turned away from its direction at the start."""

    kind: Literal["tilt"]
    unit: ClassVar[str] = "deg"
    axis: AxisName = "z"
    """Which of the body's own axes."""


class JointPosition(_Of):
    """Position of a hinge [rad] or slider [m], counted from the pose that the case describes.

    In a body from a file it is counted from the file's zero.
    """

    kind: Literal["joint_position"]


class JointVelocity(_Of):
    """Velocity of a hinge [rad/s] or slider [m/s]."""

    kind: Literal["joint_velocity"]


class JointForce(_Of):
    """Torque [N m] or force [N] that the actuator gives."""

    kind: Literal["joint_force"]


class Extent(Measured):
    """How far bodies reach along an axis [m], by `stat`: max or min, a coordinate; range, their length along it."""

    kind: Literal["extent"]
    unit: ClassVar[str] = "m"
    of: Selector
    """A body or its copies."""
    region: BodyRegion | None = None
    """Of bodies that deform: of this part of them alone, chosen at the start."""
    frame: Selector | None = None
    """A rigid body or link, from whose origin and along whose axes is measured; the world if left out. So the height of
    a soft body on a car does not change as the car pitches."""
    axis: AxisName
    """Which coordinate."""
    stat: Literal["max", "min", "range"]
    """The highest or lowest coordinate of all, or the difference."""


class Distance(Measured):
    """Distance [m] between the origins of two bodies; of the nearest pair, if there are several."""

    kind: Literal["distance"]
    unit: ClassVar[str] = "m"
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies."""


class ContactForce(Measured):
    """Size [N] of the sum of contact forces on a body (from another, if `by` is given)."""

    kind: Literal["contact_force"]
    unit: ClassVar[str] = "N"
    of: Selector
    """What is pushed on."""
    by: Selector | None = None
    """What pushes; anything if left out."""


class ContactCount(Measured):
    """How many pairs of bodies touch: those of `of` with anything, or with `by`."""

    kind: Literal["contact_count"]
    of: Selector
    """A body or its copies."""
    by: Selector | None = None
    """What they touch; anything if left out."""


class Penetration(Measured):
    """Deepest overlap [m] of touching bodies: of `of` with anything (or with `by`)."""

    kind: Literal["penetration"]
    unit: ClassVar[str] = "m"
    of: Selector
    """A body or its copies."""
    by: Selector | None = None
    """What they overlap with; anything if left out."""


class Energy(Measured):
    """Mechanical energy [J] of bodies; potential energy is zero at z = 0."""

    kind: Literal["energy"]
    unit: ClassVar[str] = "J"
    of: Selector | None = None
    """All bodies if left out."""
    part: Literal["kinetic", "potential", "total"] = "total"
    """Which part of it."""


class Momentum(Measured):
    """Linear momentum [kg m/s] of bodies along an axis."""

    kind: Literal["momentum"]
    unit: ClassVar[str] = "kg m/s"
    of: Selector | None = None
    """All bodies if left out."""
    axis: AxisName
    """Which component."""


class AngularMomentum(Measured):
    """Angular momentum [kg m2/s] of bodies, about an axis of the world."""

    kind: Literal["angular_momentum"]
    unit: ClassVar[str] = "kg m2/s"
    of: Selector | None = None
    """All bodies if left out. Bodies that deform have none here."""
    axis: AxisName
    """Which component."""
    about: Vec3 | None = None
    """A point [m] of the axis; if left out, the common centre of mass of the bodies, which moves with them."""


class CountIn(Measured):
    """How many copies have their origin in a region (which a body carries with `moves_with: tray` in it)."""

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
    | AngularVelocity
    | Turns
    | Displacement
    | Tilt
    | JointPosition
    | JointVelocity
    | JointForce
    | Bend
    | Extent
    | Distance
    | ContactForce
    | ContactCount
    | Penetration
    | Energy
    | Momentum
    | AngularMomentum
    | CountIn
    | Volume
    | Stretch
    | Strain
    | Wrinkling
    | FoldedArea
    | Gap
    | SelfPenetration
    | ShareIn
    | Pieces
    | LargestPiece
    | Leaked,
    ByKind(),
]
