"""Sculpted shapes: parts that are joined smoothly into one solid."""

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
    """What every part of a sculpt has."""

    op: Literal["add", "cut", "paint"] = "add"
    """`add` joins it to the whole; `cut` takes it away from all that is joined; `paint` only gives its look to the
    surface that lies within it."""
    pose: Pose = Pose.model_construct()
    """Where the part sits in the shape's frame."""
    mirror: AxisName | None = None
    """The part stands a second time, mirrored: with `y`, at minus y."""
    blend: NonNegative | None = None
    """Radius [m] of the fillet to what came before it, or of the rounded rim of a cut; `blend` of the shape if left
    out."""
    look: Look | None = None
    """Look of the surface next to this part (of what it cuts, of what it paints), if it differs from the body's."""
    repeat: Multiple | None = None
    """So many of these parts, called `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""


class SculptEllipsoid(SculptPart):
    """An ellipsoid; a ball with three equal radii."""

    kind: Literal["ellipsoid"]
    radii: Size3
    """Half lengths [m] along x, y, z."""


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
    """A round bar along a curve: arms, tails, necks, handles, wires. With two points, a round cone."""

    kind: Literal["limb"]
    points: Points
    """Points [m] of its middle line, whose ends are round."""
    radii: Length | list[Length]
    """Radius [m]: one, or one at each point."""
    smooth: Bool = True
    """The line is a curve through the points (Catmull-Rom); if false, straight from each to the next."""

    @model_validator(mode="after")
    def _match(self) -> "SculptLimb":
        if isinstance(self.radii, list) and len(self.radii) != len(self.points):
            raise ValueError(f"give one radius, or one for each point (got {len(self.radii)} and {len(self.points)})")
        if any(a == b for a, b in zip(self.points, self.points[1:], strict=False)):
            raise ValueError("two points that follow each other must differ")
        return self


class SculptRevolve(SculptPart):
    """A profile that is turned about z: pots, bottles, wheels, knobs."""

    kind: Literal["revolve"]
    profile: list[Vec2] = Field(min_length=2, max_length=64)
    """Points (radius, height) [m]. The line is closed by the axis, or, with `closed`, by itself."""
    smooth: Bool = False
    """The line is a curve through the points (Catmull-Rom); if false, it has corners."""
    closed: Bool = False
    """The last point is joined to the first, which makes a ring; if false, both are joined to the axis."""

    @model_validator(mode="after")
    def _outside(self) -> "SculptRevolve":
        if any(radius < 0 for radius, _ in self.profile):
            raise ValueError("a radius of the profile must not be negative")
        if self.closed and len(self.profile) < 3:
            raise ValueError("a closed profile needs three points or more")
        if max(radius for radius, _ in self.profile) <= 0:
            raise ValueError("the profile lies on the axis: it encloses nothing")
        if any(a == b for a, b in zip(self.profile, self.profile[1:], strict=False)):
            raise ValueError("two points that follow each other must differ")
        return self


class Section(Model):
    """A cross-section of a loft."""

    at: Real
    """Where on the axis [m]."""
    size: Size2
    """Full lengths [m] along the two other axes, in the order x, y, z."""
    center: Vec2 = (0.0, 0.0)
    """Its middle [m] along the same two axes."""
    squareness: Fraction = 0.0
    """0: an ellipse; 1: a rectangle; between them, a rounded one."""


class SculptLoft(SculptPart):
    """A smooth body through cross-sections: hulls, fuselages, car bodies, blades, fins."""

    kind: Literal["loft"]
    axis: AxisName = "x"
    """Along which the sections follow each other."""
    sections: list[Section] = Field(min_length=2, max_length=48)
    """By growing `at`; the first and the last are its flat ends."""
    smooth: Bool = True
    """Sizes and middles follow curves through the sections (monotone cubic); if false, straight lines."""

    @model_validator(mode="after")
    def _ordered(self) -> "SculptLoft":
        if any(b.at <= a.at for a, b in zip(self.sections, self.sections[1:], strict=False)):
            raise ValueError("`at` must grow from section to section")
        return self


AnySculptPart = Annotated[SculptEllipsoid | SculptBox | SculptLimb | SculptRevolve | SculptLoft, ByKind()]


class Sculpt(Model):
    """A solid of parts that flow into each other: animals, tools, vessels, vehicles.

    Parts are joined in their order, then all cuts are made, then it is painted. It becomes a closed mesh, whose mass,
    centre of mass and inertia the body has. For contact, each part is one or several convex pieces; cuts are not hollow
    for contact, unless `collision` is `decompose`.
    """

    kind: Literal["sculpt"]
    parts: dict[Name, AnySculptPart] = Field(min_length=1, max_length=100)
    """The parts by name."""
    blend: NonNegative = 0.0
    """Radius [m] of the fillets where parts meet; parts whose surfaces nearly coincide swell there by up to 0.4 of
    it."""
    detail: Length | None = None
    """Cell [m] of the grid on which it is made; if left out, a fifth of the thinnest part, as far as the limit of cells
    allows."""
    collision: Literal["parts", "hull", "decompose"] = "parts"
    """Contact by convex pieces of the parts, by the convex hull of the whole, or by convex pieces that the engine finds
    in seconds."""

    @model_validator(mode="after")
    def _something(self) -> "Sculpt":
        if all(part.op != "add" for part in self.parts.values()):
            raise ValueError("one part at least must have op `add`")
        return self
