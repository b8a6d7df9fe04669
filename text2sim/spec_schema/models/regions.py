"""Regions on bodies: sides, edges, corners and other parts, in the body's own frame."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Bounds, Model, Positive, Selector, Vec3

Side = Literal["left", "right", "front", "back", "bottom", "top"]

SIDES: dict[str, tuple[int, int]] = {
    "left": (0, -1),
    "right": (0, 1),
    "front": (1, -1),
    "back": (1, 1),
    "bottom": (2, -1),
    "top": (2, 1),
}
"""Axis and sign of every side, in the body's own frame."""
FORMS = ("face", "edge", "corner", "box", "sphere", "nearest")


class Block(Bounds):
    """A box aligned with the axes of the body's frame."""


class Ball(Model):
    """A sphere around a point of the body's frame."""

    center: Vec3
    """Its centre [m]."""
    radius: Positive
    """Radius [m]."""


class BodyRegion(Model):
    """A part of a body's surface, in the body's own frame: exactly one of these.

    The sides are those of the body's bounds in its own frame, before any rotation: left is -x, front -y, bottom -z.
    """

    face: Side | None = None
    """The outermost points on this side."""
    edge: Side | Annotated[list[Side], Field(min_length=2, max_length=2)] | None = None
    """The line where two sides meet. For flat bodies one side is enough: `left` is the left edge of a sheet, or in
    `place.at` that of a table top. `top` and `bottom` are the rims of a `sleeve`."""
    corner: Annotated[list[Side], Field(min_length=2, max_length=3)] | None = None
    """The point where three sides meet, or two of a flat body."""
    box: Block | None = None
    """The part inside a box."""
    sphere: Ball | None = None
    """The part inside a sphere."""
    nearest: Vec3 | None = None
    """The one point of the surface that is nearest to this point [m]."""

    @model_validator(mode="after")
    def _one_form(self) -> "BodyRegion":
        given = [name for name in FORMS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"exactly one of {', '.join(FORMS)} is needed (got {', '.join(given) or 'none'})")
        sides = self.sides
        for index, side in enumerate(sides):
            for other in sides[:index]:
                if SIDES[side][0] == SIDES[other][0]:
                    how = "is named twice" if side == other else "do not meet: they are opposite"
                    raise ValueError(f"{side} {how}" if side == other else f"{other} and {side} {how}")
        return self

    @property
    def form(self) -> str:
        """The name of the one form that is given."""
        return next(name for name in FORMS if getattr(self, name) is not None)

    @property
    def sides(self) -> tuple[Side, ...]:
        """The named sides; none for a box, a sphere or a nearest point."""
        if self.corner is not None:
            return tuple(self.corner)
        if self.face is not None:
            return (self.face,)
        if self.edge is None:
            return ()
        return (self.edge,) if isinstance(self.edge, str) else tuple(self.edge)

    def __str__(self) -> str:
        if self.sides:
            return f"{self.form} {', '.join(self.sides)}"
        return f"{self.form} region" if self.form != "nearest" else "nearest point"


class BodyPoint(Model):
    """A point on a body: the centre of one of its regions."""

    body: Selector
    """A body or static, or one copy or link of it."""
    region: BodyRegion
    """The region."""
