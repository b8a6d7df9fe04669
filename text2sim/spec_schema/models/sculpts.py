"""Sculpted shapes: parts that are blended into one solid."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    AxisName,
    Bool,
    ByKind,
    Fraction,
    Length,
    Model,
    Multiple,
    Name,
    NonNegative,
    Pose,
    Real,
    Size2,
    Size3,
    Vec2,
    Vec3,
)
from text2sim.spec_schema.models.materials import Look

Points = Annotated[list[Vec3], Field(min_length=2, max_length=48)]


class SculptPart(Model):
    """Fields of every part of a sculpt."""

    op: Literal["add", "cut", "paint"] = "add"
    """`add` joins it to the whole; `cut` subtracts it from all joined parts; `paint` only applies its look to the
    surface inside it."""
    pose: Pose = Pose.model_construct()
    """Pose of the part in the shape's frame."""
    mirror: AxisName | None = None
    """Add a mirrored copy of the part: with `y`, at minus y."""
    blend: NonNegative | None = None
    """Radius [m] of the fillet to the preceding parts, or of the rounded rim of a cut; by default `blend` of the
    shape."""
    look: Look | None = None
    """Look of the surface next to this part (for `cut` and `paint`, of that surface), if it differs from the body's."""
    repeat: Multiple | None = None
    """Number of such parts, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""


class SculptEllipsoid(SculptPart):
    """An ellipsoid; a sphere if all radii are equal."""

    kind: Literal["ellipsoid"]
    radii: Size3
    """Semi-axes [m] along x, y, z."""


class SculptBox(SculptPart):
    """A box with rounded edges."""

    kind: Literal["box"]
    size: Size3
    """Full lengths [m] along x, y, z, the rounding included."""
    rounding: NonNegative = 0.0
    """Radius [m] of its edges and corners."""

    @model_validator(mode="after")
    def _round(self) -> "SculptBox":
        if self.rounding > min(self.size) / 2:
            raise ValueError(
                f"rounding may be at most half the shortest side, {min(self.size) / 2:g} (got {self.rounding:g})"
            )
        return self


class SculptLimb(SculptPart):
    """A round bar along a curve, for arms, tails, necks, handles, wires. With two points, a round cone."""

    kind: Literal["limb"]
    points: Points
    """Points [m] of its centre line; the ends are round."""
    radii: Length | list[Length]
    """Radius [m]: one for all points, or one for each."""
    smooth: Bool = True
    """Use a curve through the points (Catmull-Rom) instead of straight lines."""

    @model_validator(mode="after")
    def _match(self) -> "SculptLimb":
        if isinstance(self.radii, list) and len(self.radii) != len(self.points):
            raise ValueError(f"give one radius, or one for each point (got {len(self.radii)} and {len(self.points)})")
        if any(a == b for a, b in pairwise(self.points)):
            raise ValueError("consecutive points must differ")
        return self


class SculptRevolve(SculptPart):
    """A profile revolved about the z axis of its `pose`: pots, bottles, wheels, knobs."""

    kind: Literal["revolve"]
    profile: list[Vec2] = Field(min_length=2, max_length=64)
    """Points (distance from the axis, z) [m] of a line that is closed by the axis or, with `closed`, by itself."""
    smooth: Bool = False
    """Use a curve through the points (Catmull-Rom) instead of straight lines."""
    closed: Bool = False
    """Join the last point to the first, which makes a ring, instead of both to the axis."""

    @model_validator(mode="after")
    def _outside(self) -> "SculptRevolve":
        if any(radius < 0 for radius, _ in self.profile):
            raise ValueError("radii of the profile must not be negative")
        if self.closed and len(self.profile) < 3:
            raise ValueError("a closed profile needs at least three points")
        if max(radius for radius, _ in self.profile) <= 0:
            raise ValueError("the profile lies on the axis: it encloses nothing")
        if any(a == b for a, b in pairwise(self.profile)):
            raise ValueError("consecutive points must differ")
        return self


class Section(Model):
    """A cross-section of a loft."""

    at: Real
    """Position [m] along the axis."""
    size: Size2
    """Full lengths [m] along the two other axes, in the order x, y, z."""
    center: Vec2 = (0.0, 0.0)
    """Its centre [m] along the same two axes."""
    squareness: Fraction = 0.0
    """0 is an ellipse, 1 a rectangle; values between are rounded rectangles."""


class SculptLoft(SculptPart):
    """A smooth solid through cross-sections: hulls, fuselages, car bodies, blades, fins."""

    kind: Literal["loft"]
    axis: AxisName = "x"
    """Axis along which the sections are placed."""
    sections: list[Section] = Field(min_length=2, max_length=48)
    """Cross-sections by ascending `at`; the first and the last are its flat ends."""
    smooth: Bool = True
    """Interpolate sizes and centres with curves through the sections (monotone cubic) instead of straight lines."""

    @model_validator(mode="after")
    def _ordered(self) -> "SculptLoft":
        if any(b.at <= a.at for a, b in pairwise(self.sections)):
            raise ValueError("`at` must be ascending")
        return self


AnySculptPart = Annotated[SculptEllipsoid | SculptBox | SculptLimb | SculptRevolve | SculptLoft, ByKind()]


class Sculpt(Model):
    """A solid of parts that blend into each other: animals, tools, vessels, vehicles.

    Parts are joined in their order, then all cuts are made, then paint is applied. The result is a closed mesh, which
    determines mass, centre of mass and inertia. For contact, each part is one or several convex pieces, without its
    hollows; only `decompose` and `exact` know those, and cuts: a bowl is an `exact` `revolve`.
    """

    kind: Literal["sculpt"]
    parts: dict[Name, AnySculptPart] = Field(min_length=1, max_length=100)
    """Parts by name, with their copies 100 at most."""
    blend: NonNegative = 0.0
    """Radius [m] of the fillets where parts meet; where surfaces nearly coincide, parts swell by up to 0.4 of it."""
    detail: Length | None = None
    """Cell [m] of the grid on which the mesh is made; by default a fifth of the thinnest part, within the limit of
    cells."""
    collision: Literal["parts", "hull", "decompose", "exact"] = "parts"
    """Contact by convex pieces of the parts, by the convex hull of the whole, by convex pieces of the whole, which the
    engine takes seconds to find, or by the surface itself, on which a ball rolls smoothly (see contact.md)."""

    @model_validator(mode="after")
    def _something(self) -> "Sculpt":
        if all(part.op != "add" for part in self.parts.values()):
            raise ValueError("at least one part must have op `add`")
        return self
