"""Measures: numbers over time."""

from typing import Annotated, ClassVar, Literal

from pydantic import model_validator

from text2sim.spec_schema.models.base import AxisName, ByKind, Name, Real, Selector, Selectors, Vec3
from text2sim.spec_schema.models.contact_measures import ContactCount, ContactForce, Penetration
from text2sim.spec_schema.models.derived_measures import Difference, Ratio
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.soft_measures import (
    FoldedArea,
    Folds,
    Gap,
    LargestPiece,
    Leaked,
    Measured,
    Pieces,
    SelfPenetration,
    ShareIn,
    Strain,
    Stretch,
    Submerged,
    SurfaceLevel,
    Traits,
    Volume,
    Wrinkling,
)
from text2sim.spec_schema.models.space import Region

Stat = Literal["max", "min", "mean", "std", "sum", "range", "count"]


class _Of(Measured):
    of: Selectors
    """A body, its copies, or links of it (`net.x5_*`)."""
    stat: Stat | None = None
    """Statistic over several copies or links; required if there are several. `std` is their standard deviation, `count`
    the number of those that are `above` or `below`."""
    above: Real | None = None
    """With `stat: count`: lower bound."""
    below: Real | None = None
    """With `stat: count`: upper bound."""

    @model_validator(mode="after")
    def _count_needs_bound(self) -> "_Of":
        bounds = (self.above is not None) + (self.below is not None)
        if (self.stat == "count") != (bounds > 0):
            raise ValueError("above and below need stat: count, which needs one of them")
        return self


class _OfRegion(_Of):
    region: BodyRegion | None = None
    """For deformable bodies: the mean over this part, chosen at the start, instead of the centre of mass."""


class Position(_OfRegion):
    """A coordinate of the body's origin [m].

    For a deformable body, of its centre of mass.
    """

    kind: Literal["position"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=True, from_poses=True, instead="")
    axis: AxisName
    """The coordinate."""


class Velocity(_OfRegion):
    """A component of the velocity of the centre of mass [m/s], along an axis of the world."""

    kind: Literal["velocity"]
    unit: ClassVar[str] = "m/s"
    traits: ClassVar = Traits(at_rest=0.0, never_negative=False, of_root=False, from_poses=True, instead="")
    axis: AxisName
    """The component."""


class Speed(_OfRegion):
    """Speed of the centre of mass [m/s]."""

    kind: Literal["speed"]
    unit: ClassVar[str] = "m/s"
    traits: ClassVar = Traits(at_rest=0.0, never_negative=True, of_root=False, from_poses=True, instead="")


class AngularSpeed(_Of):
    """Angular speed [rad/s] about any axis."""

    kind: Literal["angular_speed"]
    unit: ClassVar[str] = "rad/s"
    traits: ClassVar = Traits(
        at_rest=0.0,
        never_negative=True,
        of_root=True,
        from_poses=True,
        instead="measure the `velocity` of a `region` of it",
    )


class _Turning(_Of):
    axis: AxisName
    """The axis; positive is counterclockwise, seen against the axis."""
    frame: Literal["world", "body"] = "world"
    """Frame of the axis: the world, or the body, with which it turns."""


class AngularVelocity(_Turning):
    """A component of the angular velocity [rad/s], with its sign."""

    kind: Literal["angular_velocity"]
    unit: ClassVar[str] = "rad/s"
    traits: ClassVar = Traits(
        at_rest=0.0,
        never_negative=False,
        of_root=True,
        from_poses=True,
        instead="measure the `velocity` of a `region` of it",
    )


class Turns(_Turning):
    """Signed number of turns about an axis since the start.

    0.5 is half a turn. Rotations from picture to picture add up, for a free body too.
    """

    kind: Literal["turns"]
    traits: ClassVar = Traits(
        at_rest=0.0,
        never_negative=False,
        of_root=True,
        from_poses=True,
        instead="measure the `position` of two regions of it",
    )


class Bend(_Of):
    """Bend of a joint: angle [deg] between a link and its parent, minus that at the start.

    For chains, nets, ropes, ragdolls and mechanisms with hinges and ball joints. It includes all joints of a body
    unless links are named; the root of a free body has none.
    """

    kind: Literal["bend"]
    unit: ClassVar[str] = "deg"
    traits: ClassVar = Traits(
        at_rest=0.0,
        never_negative=True,
        of_root=False,
        from_poses=False,
        instead="measure the `position` of three regions of it, or the `wrinkling` of a cloth",
    )


class Displacement(_OfRegion):
    """Distance [m] of the body's origin from its start, in the world or in `frame`.

    Of a body that deforms, that of its centre of mass.
    """

    kind: Literal["displacement"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=0.0, never_negative=False, of_root=True, from_poses=True, instead="")
    axis: AxisName | None = None
    """Signed displacement along one axis instead."""
    frame: Selector | None = None
    """A rigid body or link whose origin and axes are the frame; by default the world. For example, in the frame of a
    drawer, its contents have no displacement while they move with it."""


class Tilt(_Of):
    """Angle [deg] between one of the body's own axes and its direction at the start."""

    kind: Literal["tilt"]
    unit: ClassVar[str] = "deg"
    traits: ClassVar = Traits(
        at_rest=0.0,
        never_negative=True,
        of_root=True,
        from_poses=True,
        instead="measure the `position` of two regions of it",
    )
    axis: AxisName = "z"
    """The body's own axis."""


class JointPosition(_Of):
    """Position of a hinge [rad] or slider [m], relative to the pose in the case.

    For a body from a file it is relative to the file's zero.
    """

    kind: Literal["joint_position"]
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=True, instead="")


class JointVelocity(_Of):
    """Velocity of a hinge [rad/s] or slider [m/s]."""

    kind: Literal["joint_velocity"]
    traits: ClassVar = Traits(at_rest=0.0, never_negative=False, of_root=False, from_poses=True, instead="")


class JointForce(_Of):
    """Torque [N m] or force [N] of the actuator, mean over a time step."""

    kind: Literal["joint_force"]
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")


class SpringForce(Measured):
    """Force [N] with which a `spring` pulls its ends together, negative while it pushes."""

    kind: Literal["spring_force"]
    unit: ClassVar[str] = "N"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    spring: Name
    """Name of the control of kind `spring`; of copies, the sum."""


class Extent(Measured):
    """Extent of bodies along an axis [m]: their highest (`max`) or lowest (`min`) coordinate, or length (`range`)."""

    kind: Literal["extent"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A body or its copies."""
    region: BodyRegion | None = None
    """For deformable bodies: only this part, chosen at the start."""
    frame: Selector | None = None
    """A rigid body or link whose origin and axes are the frame; by default the world. So the height of a soft body on a
    car does not change as the car pitches."""
    axis: AxisName
    """The coordinate."""
    stat: Literal["max", "min", "range"]
    """The highest or lowest coordinate of all, or the difference."""


class Distance(Measured):
    """Distance [m] between the origins of two bodies; the `gap` is to the surface of what deforms.

    For several, of the nearest pair.
    """

    kind: Literal["distance"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=True, from_poses=True, instead="")
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies."""


class Energy(Measured):
    """Mechanical energy [J] of bodies; potential energy is zero at z = 0."""

    kind: Literal["energy"]
    unit: ClassVar[str] = "J"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=True, instead="")
    of: Selectors | None = None
    """A body or its copies; by default all bodies."""
    part: Literal["kinetic", "potential", "total"] = "total"
    """The part of the energy."""

    @property
    def at_rest(self) -> float | None:
        """Its value while nothing moves."""
        return 0.0 if self.part == "kinetic" else super().at_rest


class Momentum(Measured):
    """Linear momentum [kg m/s] of bodies along an axis."""

    kind: Literal["momentum"]
    unit: ClassVar[str] = "kg m/s"
    traits: ClassVar = Traits(at_rest=0.0, never_negative=False, of_root=False, from_poses=True, instead="")
    of: Selectors | None = None
    """A body or its copies; by default all bodies."""
    axis: AxisName
    """The component."""


class AngularMomentum(Measured):
    """Angular momentum [kg m2/s] of bodies, water too, about an axis."""

    kind: Literal["angular_momentum"]
    unit: ClassVar[str] = "kg m2/s"
    traits: ClassVar = Traits(at_rest=0.0, never_negative=False, of_root=False, from_poses=True, instead="")
    of: Selectors | None = None
    """A body or its copies; by default all bodies."""
    axis: AxisName
    """The component."""
    about: Vec3 | None = None
    """A point [m] of the axis; by default the common centre of mass of the bodies, which moves with them."""


class CountIn(Measured):
    """Number of copies with their origin in a region.

    A body carries the region if it has `moves_with: tray`.
    """

    kind: Literal["count_in"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=True, from_poses=True, instead="")
    of: Selectors
    """A body and its copies."""
    region: Region
    """The region."""


class Threaded(Measured):
    """Number of rings that a rod passes through.

    The rod's axis pierces the disc that the ring's centre line bounds. Rings are tori and tubes; rods are cylinders,
    capsules and boxes (along their longest side).
    """

    kind: Literal["threaded"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A ring or its copies, links or parts of a compound that are rings."""
    by: Selectors
    """A rod, likewise; of several, any counts."""


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
    | SpringForce
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
    | Threaded
    | Difference
    | Ratio
    | Volume
    | Stretch
    | Strain
    | Wrinkling
    | FoldedArea
    | Folds
    | Gap
    | SelfPenetration
    | ShareIn
    | Pieces
    | LargestPiece
    | Leaked
    | SurfaceLevel
    | Submerged,
    ByKind(),
]
