"""Patterns of copies.

Inside a repeated body these may stand in ``${…}``: ``i`` (0, 1, …), ``n`` (how many), ``u`` (``i/(n-1)``, 0
to 1), ``row``, ``column``, ``layer``.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from text2sim.spec_schema.models.base import Bool, ByKind, Count, Integer, Length, Model, NonNegative, Real, Vec3
from text2sim.spec_schema.models.space import Region


class Line(Model):
    """Copies in a row. For any other row, such as an arch or a fan, `step: [0, 0, 0]`, and `i` in the body's `pose`."""

    kind: Literal["line"]
    count: Count
    """How many copies."""
    step: Vec3
    """From one copy to the next [m]."""
    start: Vec3 | None = None
    """Position [m] of the first copy, instead of `pos` in the body's pose, whose orientation holds."""


class Grid(Model):
    """Copies on a regular grid, centred on the body's pose in x and y, rising from it in z."""

    kind: Literal["grid"]
    counts: tuple[Count, Count, Count] | tuple[Count, Count]
    """Copies along x, y (and z)."""
    spacing: tuple[Length, Length, Length] | tuple[Length, Length] | Length
    """Distance [m] between neighbours' centres."""


class Ring(Model):
    """Copies on a circle about the vertical through the body's pose."""

    kind: Literal["ring"]
    count: Count
    """How many copies."""
    radius: Length
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
    inner_radius: Length
    """Radius [m] at the first copy."""
    spacing: Length
    """Distance [m] between neighbours along the curve."""
    pitch: Length
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


def _in_the_world(region: Region) -> Region:
    if region.moves_with is not None:
        raise ValueError("copies are packed at the start: moves_with is for measures and events")
    return region


class Packing(Model):
    """Copies at random in a region, without overlap."""

    kind: Literal["packing"]
    count: Count
    """How many copies."""
    region: Annotated[Region, AfterValidator(_in_the_world)]
    """Where they lie; every copy is wholly inside."""
    seed: Integer = Field(default=0, ge=0)
    """Same seed, same packing."""
    gap: NonNegative = 0.001
    """Least gap [m] between neighbours."""
    turn: Literal["random", "yaw", "none"] = "random"
    """Orientation: anyhow, about the vertical only, or as the body's pose says."""


class Glyphs(Model):
    """One copy for each letter of a text or piece of a sketch, where it stands in the line or the picture."""

    kind: Literal["glyphs"]


Repeat = Annotated[Line | Grid | Ring | Spiral | Stack | RunningBond | Packing | Glyphs, ByKind()]
