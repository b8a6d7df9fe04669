"""Placement of bodies relative to others."""

from typing import Literal

from pydantic import model_validator

from text2sim.spec_schema.models.base import Axis, Model, NonNegative, Quat, Real, Selector, Vec2, Vec3
from text2sim.spec_schema.models.regions import BodyRegion

RELATIONS = (
    "on",
    "above",
    "below",
    "inside",
    "left_of",
    "right_of",
    "in_front_of",
    "behind",
    "beside",
    "around",
    "touching",
    "relative_to",
)

End = Literal["min", "center", "max"]


class Align(Model):
    """Alignment with the other body along each axis of the world; axes that are left out are as without `align`."""

    x: End | None = None
    """`min`: the left ends of both, `center`: the centres, `max`: the right ends."""
    y: End | None = None
    """`min`: the front ends of both, `center`: the centres, `max`: the back ends."""
    z: End | None = None
    """`min`: the lowest points of both, `center`: the centres, `max`: the highest points."""


class Place(Model):
    """Position relative to another body or static by exactly one relation. Left is -x, in front is -y.

    `on: table.tray` and the like mean a link of an `articulated` body, where it starts.
    """

    on: Selector | None = None
    """On top of it: lowered until it touches."""
    above: Selector | None = None
    """Above it, `clearance` higher than its top."""
    below: Selector | None = None
    """Below it, `clearance` lower than its bottom."""
    inside: Selector | None = None
    """Inside its cavity, `clearance` above its inner floor."""
    left_of: Selector | None = None
    """Beside it, on the -x side."""
    right_of: Selector | None = None
    """Beside it, on the +x side."""
    in_front_of: Selector | None = None
    """Beside it, on the -y side."""
    behind: Selector | None = None
    """Beside it, on the +y side."""
    beside: Selector | None = None
    """Beside it, on the side given by `direction`."""
    around: Selector | None = None
    """Around it: a ring on a pole, aligned with its axis, or copies in a ring or spiral."""
    touching: Selector | None = None
    """Moved from the side given by `direction` towards its centre, or towards the region `at`, until they touch."""
    relative_to: Selector | None = None
    """At `pos` in its frame, where it starts. The orientation and the pattern of copies are in that frame, too."""
    pos: Vec3 | None = None
    """With `relative_to`: position [m] of the origin in that frame, by default its origin."""
    at: Vec2 | BodyRegion | None = None
    """World x and y [m], or a region of the other body in that body's frame; by default its centre."""
    inset: NonNegative = 0.0
    """With a side, an edge or a corner in `at`: distance [m] from it."""
    direction: Axis | None = None
    """With `beside`, the side, which is horizontal, by default x; with `touching`, the side that it moves in from, by
    default z."""
    align: Literal["top", "center", "bottom"] | Align | None = None
    """Alignment that the relation leaves open: of the heights (`top`, `center`, `bottom`), or of each axis."""
    clearance: NonNegative = 0.0
    """Gap [m] between the two surfaces."""
    offset: Vec3 = (0.0, 0.0, 0.0)
    """Final displacement [m]; `on` and `inside` lower the body at the displaced position."""
    facing: Selector | Vec3 | None = None
    """Body or point [m] that its +x axis points to, by a rotation about the vertical."""
    flush_deg: Real | None = None
    """With `on` and `above`: the body lies flat on the top face of the other at that position, whatever its slope,
    rotated about the face's normal by this angle [deg]. At 0 it is tilted with the face, but not rotated. A pattern of
    copies is tilted as well."""
    quat: Quat | None = None
    """Orientation (w, x, y, z)."""
    euler_deg: Vec3 | None = None
    """Orientation [deg]: rotations about the fixed x, then y, then z axis."""

    @model_validator(mode="after")
    def _one_relation(self) -> "Place":
        given = [name for name in RELATIONS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"exactly one of {', '.join(RELATIONS)} is needed (got {', '.join(given) or 'none'}); "
                "align, at and offset refine it"
            )
        if self.quat is not None and self.euler_deg is not None:
            raise ValueError("give either quat or euler_deg, not both")
        return self

    @property
    def relation(self) -> str:
        """The one relation that is given."""
        return next(name for name in RELATIONS if getattr(self, name) is not None)

    @property
    def target(self) -> str:
        """The selector of the body that the relation refers to."""
        return getattr(self, self.relation)

    def alignment(self, axis: int) -> End | None:
        """Return the alignment along an axis (0, 1, 2); None if none is given."""
        if isinstance(self.align, Align):
            return (self.align.x, self.align.y, self.align.z)[axis]
        if self.align is None or axis != 2:
            return None
        return {"top": "max", "center": "center", "bottom": "min"}[self.align]  # type: ignore[return-value]
