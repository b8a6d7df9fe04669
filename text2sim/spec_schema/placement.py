"""Where bodies start: relative placement, and patterns of copies.

Inside a repeated body these may stand in ``${…}``: ``i`` (0, 1, …), ``n`` (how many), ``u`` (``i/(n-1)``, 0
to 1), ``row``, ``column``, ``layer``.
"""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.base import (
    Axis,
    Bool,
    Bounds,
    Count,
    Integer,
    Model,
    NonNegative,
    Positive,
    Quat,
    Real,
    Selector,
    Vec2,
    Vec3,
)

RELATIONS = ("on", "above", "below", "inside", "left_of", "right_of", "in_front_of", "behind", "touching")


class Place(Model):
    """Position in relation to another body or static: exactly one relation. Left is -x, in front is -y."""

    on: Selector | None = None
    """Rest on top of it."""
    above: Selector | None = None
    """Over it, `clearance` higher than its top."""
    below: Selector | None = None
    """Under it, `clearance` lower than its bottom."""
    inside: Selector | None = None
    """Within its hollow, `clearance` above its inner floor."""
    left_of: Selector | None = None
    """Beside it, on the -x side."""
    right_of: Selector | None = None
    """Beside it, on the +x side."""
    in_front_of: Selector | None = None
    """Beside it, on the -y side."""
    behind: Selector | None = None
    """Beside it, on the +y side."""
    touching: Selector | None = None
    """Moved from the side `direction` towards its centre until the two surfaces meet."""
    at: Vec2 | None = None
    """World x and y [m] (on, above, below, inside); the other's centre if left out."""
    direction: Axis = Field(default=(0.0, 0.0, 1.0))
    """For `touching`: the side from which it comes."""
    clearance: NonNegative = 0.0
    """Gap [m] that is left between the two surfaces."""
    quat: Quat | None = None
    """Orientation (w, x, y, z)."""
    euler_deg: Vec3 | None = None
    """Orientation [deg]: turns about the fixed x, then y, then z axis."""

    @model_validator(mode="after")
    def _one_relation(self) -> "Place":
        given = [name for name in RELATIONS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"exactly one of {', '.join(RELATIONS)} is needed (got {', '.join(given) or 'none'})")
        return self

    @property
    def relation(self) -> str:
        """The one relation that is given."""
        return next(name for name in RELATIONS if getattr(self, name) is not None)

    @property
    def target(self) -> str:
        """The selector of the body that the relation is to."""
        return getattr(self, self.relation)


class Line(Model):
    """Copies in a row."""

    kind: Literal["line"]
    count: Count
    """How many copies."""
    step: Vec3
    """From one copy to the next [m]."""
    start: Vec3 | None = None
    """Position [m] of the first copy, instead of the body's pose."""


class Grid(Model):
    """Copies on a regular grid, centred on the body's pose in x and y, rising from it in z."""

    kind: Literal["grid"]
    counts: tuple[Count, Count, Count] | tuple[Count, Count]
    """Copies along x, y (and z)."""
    spacing: tuple[Positive, Positive, Positive] | tuple[Positive, Positive] | Positive
    """Distance [m] between neighbours' centres."""


class Ring(Model):
    """Copies on a circle about the vertical through the body's pose."""

    kind: Literal["ring"]
    count: Count
    """How many copies."""
    radius: Positive
    """Radius [m]."""
    start_deg: Real = 0.0
    """Angle [deg] of the first copy from +x."""
    arc_deg: Real = Field(default=360.0, gt=0, le=360.0)
    """Part of the circle that is filled; at less than 360 the last copy stands at its end."""
    turn: Bool = True
    """Turn each copy with the circle."""


class Spiral(Model):
    """Copies along a flat spiral about the body's vertical, evenly spaced and turned with it."""

    kind: Literal["spiral"]
    count: Count
    """How many copies."""
    inner_radius: Positive
    """Radius [m] at the first copy."""
    spacing: Positive
    """Distance [m] between neighbours along the curve."""
    pitch: Positive
    """Growth [m] of the radius in one turn."""
    outward: Bool = True
    """False puts the first copy at the outer end."""


class Stack(Model):
    """Copies on top of each other."""

    kind: Literal["stack"]
    count: Count
    """How many copies."""
    gap: NonNegative = 0.0
    """Gap [m] between neighbours."""


class RunningBond(Model):
    """A wall of boxes: the joints of a row stand over the middles of the row below; along x, one box deep."""

    kind: Literal["running_bond"]
    rows: Count
    """Rows of boxes on top of each other."""
    columns: Count
    """Boxes in a row."""
    gap: NonNegative = 0.0
    """Gap [m] between the boxes of a row; rows lie directly on each other."""
    ends: Literal["half", "open"] = "half"
    """`half` closes every second row with half boxes; `open` leaves the ends toothed (the end boxes hang
    over)."""


class BoxRegion(Bounds):
    """An upright box of space."""

    kind: Literal["box"]


class CylinderRegion(Model):
    """A cylinder of space."""

    kind: Literal["cylinder"]
    center: Vec3
    """Its middle [m]."""
    radius: Positive
    """Radius [m]."""
    height: Positive
    """Length [m] along its axis."""
    axis: Axis = "z"
    """Direction of its axis."""


class SphereRegion(Model):
    """A ball of space."""

    kind: Literal["sphere"]
    center: Vec3
    """Its middle [m]."""
    radius: Positive
    """Radius [m]."""


Region = Annotated[BoxRegion | CylinderRegion | SphereRegion, Field(discriminator="kind")]


class Packing(Model):
    """Copies at random in a region, without overlap."""

    kind: Literal["packing"]
    count: Count
    """How many copies."""
    region: Region
    """Where they lie; every copy is wholly inside."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same packing."""
    gap: NonNegative = 0.001
    """Least gap [m] between neighbours."""
    turn: Literal["random", "yaw", "none"] = "random"
    """Orientation: anyhow, about the vertical only, or as the body's pose says."""


Repeat = Annotated[Line | Grid | Ring | Spiral | Stack | RunningBond | Packing, Field(discriminator="kind")]
