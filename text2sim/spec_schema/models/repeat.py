"""Patterns of copies.

In a repeated body ``${…}`` can use ``i`` (0, 1, …), ``n`` (number of copies), ``u`` (``i/(n-1)``, 0 to 1), ``row``,
``column`` and ``layer``.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from text2sim.spec_schema.models.base import (
    Bool,
    ByKind,
    Count,
    Integer,
    Length,
    Model,
    NonNegative,
    Real,
    Vec3,
)
from text2sim.spec_schema.models.space import Region


class Line(Model):
    """Copies in a row. For other rows, such as an arch, use `step: [0, 0, 0]` and `i` in the body's `pose`."""

    kind: Literal["line"]
    count: Count
    """Number of copies."""
    step: Vec3
    """Displacement [m] in the world from one copy to the next."""
    start: Vec3 | None = None
    """Position [m] of the first copy in the world; then the body's pose may turn it, but has no `pos`."""


class Grid(Model):
    """Copies on a regular grid, centred on the body's pose in x and y, rising from it in z."""

    kind: Literal["grid"]
    counts: tuple[Count, Count, Count] | tuple[Count, Count]
    """Copies along x, y (and z)."""
    spacing: tuple[Length, Length, Length] | tuple[Length, Length] | Length
    """Distance [m] between neighbours' centres."""


class Ring(Model):
    """Copies on a circle. Its axis is the vertical one through the body's pose."""

    kind: Literal["ring"]
    count: Count
    """Number of copies."""
    radius: Length
    """Radius [m]."""
    start_deg: Real = 0.0
    """Angle [deg] of the first copy from +x."""
    arc_deg: Real = Field(default=360.0, gt=0, le=360.0)
    """Angle [deg] of the arc with copies; below 360 the last copy is at its end."""
    turn: Bool = True
    """Rotate each copy with the circle."""


class Spiral(Model):
    """Copies along a flat spiral. They are evenly spaced, and turned with it about the pose's vertical axis."""

    kind: Literal["spiral"]
    count: Count
    """Number of copies."""
    inner_radius: Length
    """Radius [m] at the first copy."""
    spacing: Length
    """Distance [m] between neighbours along the curve."""
    pitch: Length
    """Growth [m] of the radius per turn."""
    start_deg: Real = 0.0
    """Angle [deg] of its inner end from +x."""
    outward: Bool = True
    """False puts the first copy at the outer end."""


class Stack(Model):
    """Copies on top of each other."""

    kind: Literal["stack"]
    count: Count
    """Number of copies."""
    gap: NonNegative = 0.0
    """Gap [m] between neighbours."""


class RunningBond(Model):
    """A wall of boxes along the body's x axis. It is one box deep; joints lie above the middles of the row below."""

    kind: Literal["running_bond"]
    rows: Count
    """Number of rows on top of each other."""
    columns: Count
    """Number of boxes in a row."""
    gap: NonNegative = 0.0
    """Gap [m] between the boxes of a row; rows lie directly on each other."""
    ends: Literal["half", "open"] = "half"
    """`half` closes every second row with half boxes; `open` leaves the ends toothed, with overhanging boxes."""


def _in_the_world(region: Region) -> Region:
    if region.moves_with is not None:
        raise ValueError("moves_with is for measures and events; copies are packed at the start")
    return region


class Packing(Model):
    """Copies at random positions in a region, without overlap."""

    kind: Literal["packing"]
    count: Count
    """Number of copies."""
    region: Annotated[Region, AfterValidator(_in_the_world)]
    """The region, which contains every copy completely."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same packing."""
    gap: NonNegative = 0.001
    """Smallest gap [m] between neighbours."""
    turn: Literal["random", "yaw", "none"] = "random"
    """Orientation: random, random about the vertical only, or that of the body's pose."""


class Glyphs(Model):
    """One copy for each letter of a text or piece of a sketch, at its position there."""

    kind: Literal["glyphs"]


Stretch = Annotated[Real, Field(ge=0.02, le=50.0)]


class Fragments(Model):
    """One copy for each fragment into which a rigid body is cut, so that it can shatter.

    The fragments are the cells of a Voronoi diagram. They touch face to face and look like one body, but nothing holds
    them together. They are numbered from the focus outwards, or upwards without one; each has its origin at its centre
    of mass. The material's `mass` is that of all together.

    The shape is any with a closed surface, and drawn in the body's look; a pattern or label is on each fragment by
    itself. A cell in which the shape falls apart, such as one that reaches both walls of a tube, gives several
    fragments. Each has contact by its convex hull, or by those of up to four parts if it fills less than 70 % of its
    hull: with a larger `count`, the wall of a cup is followed more closely.
    """

    kind: Literal["fragments"]
    count: Annotated[Integer, Field(ge=2, le=200)] = 30
    """Number of cells."""
    seed: Annotated[Integer, Field(ge=0, le=1_000_000)] = 0
    """Same seed, same fragments."""
    focus: Vec3 | None = None
    """A point [m] in the body's frame, such as that of a blow, near which fragments are smaller. At a distance of a
    tenth of the body's longest side, an eighth as many cells lie in a volume as there; in general `1 / (1 + r / r0)^3`
    times as many."""
    stretch: tuple[Stretch, Stretch, Stretch] = (1.0, 1.0, 1.0)
    """How many times longer fragments are along x, y and z of the body's frame: `[1, 1, 6]` gives splinters along z."""


Divided = Glyphs | Fragments
"""Patterns whose copies are the parts of the shape."""
Repeat = Annotated[Line | Grid | Ring | Spiral | Stack | RunningBond | Packing | Glyphs | Fragments, ByKind()]
