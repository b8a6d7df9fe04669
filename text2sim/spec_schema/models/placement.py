"""Placement of bodies in relation to others."""

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
)

End = Literal["min", "center", "max"]


class Align(Model):
    """Which parts of the two line up along each axis of the world; what is left out is as without `align`."""

    x: End | None = None
    """`min`: their left ends, `center`: their middles, `max`: their right ends."""
    y: End | None = None
    """`min`: their front ends, `max`: their back ends."""
    z: End | None = None
    """`min`: their lowest points, `max`: their highest."""


class Place(Model):
    """Position in relation to another body or static: exactly one relation. Left is -x, in front is -y."""

    on: Selector | None = None
    """Rest on top of it: lowered until it touches."""
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
    beside: Selector | None = None
    """Beside it, on the side `direction`."""
    around: Selector | None = None
    """All around it: a ring on its pole, turned with its axis; copies in a ring or spiral stand around it."""
    touching: Selector | None = None
    """Moved from the side `direction` towards its centre, or towards the region `at`, until the two surfaces meet."""
    at: Vec2 | BodyRegion | None = None
    """World x and y [m], or a region of the other in the other's own frame; the other's centre if left out."""
    inset: NonNegative = 0.0
    """With a side, an edge or a corner in `at`: how far [m] from it."""
    direction: Axis | None = None
    """The side: of `beside`, level, x if left out; of `touching`, z if left out."""
    align: Literal["top", "center", "bottom"] | Align | None = None
    """What lines up where the relation leaves it open: heights (`top`, `center`, `bottom`), or each axis."""
    clearance: NonNegative = 0.0
    """Gap [m] that is left between the two surfaces."""
    offset: Vec3 = (0.0, 0.0, 0.0)
    """Moved by this [m] in the end; `on` and `inside` let it down there."""
    facing: Selector | Vec3 | None = None
    """Turned about the vertical until its +x axis points towards this body or point [m]."""
    flush_deg: Real | None = None
    """With `on` and `above`: laid flat on the face of the other that is on top at that place, however it leans, and
    turned about its normal by this [deg]. At 0 it is tipped with the face, and not turned. A pattern of copies leans
    with them."""
    quat: Quat | None = None
    """Orientation (w, x, y, z)."""
    euler_deg: Vec3 | None = None
    """Orientation [deg]: turns about the fixed x, then y, then z axis."""

    @model_validator(mode="after")
    def _one_relation(self) -> "Place":
        given = [name for name in RELATIONS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"exactly one of {', '.join(RELATIONS)} is needed (got {', '.join(given) or 'none'}); "
                "what it leaves open is said by align, at and offset"
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
        """The selector of the body that the relation is to."""
        return getattr(self, self.relation)

    def alignment(self, axis: int) -> End | None:
        """Return which parts line up along an axis (0, 1, 2); None if the author says nothing of it."""
        if isinstance(self.align, Align):
            return (self.align.x, self.align.y, self.align.z)[axis]
        if self.align is None or axis != 2:
            return None
        return {"top": "max", "center": "center", "bottom": "min"}[self.align]  # type: ignore[return-value]
