"""Shapes of cloth: sheets, discs, sleeves, surfaces of revolution and ribbons, which have no thickness."""

from itertools import pairwise
from math import dist, hypot, pi
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Bool, ByKind, Length, Model, NonNegative, Real, Size2, Vec2, Vec3
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Sphere
from text2sim.spec_schema.rounding import at_least

STEEPEST = 1.2
"""Largest angle [rad] between the vertical and the line from a side of a gathered sheet to the chord of its edges."""
LEAST_PART = 1e-3
"""Smallest distance of points of a profile, as a part of its largest radius."""
MIN_CLOSED = 4
"""Points of a ribbon without ends: a triangle, and its first corner again."""


class Sheet(Model):
    """A rectangle in the x-y plane, without thickness. For cloth only."""

    kind: Literal["sheet"]
    size: Size2
    """Lengths [m] along x and y."""
    sag: NonNegative = 0.0
    """Depth [m] of its middle at the start below its left and right edges, as in a hammock or awning; at most 0.45 of
    its length L. The sheet is then a parabola of length L with the origin between its ends, which are
    `L - 8/3 sag^2 / L` apart, within 1 % up to a fifth of L: a trough, open along x."""
    ends: Length | None = None
    """With `sag`: width [m] of its left and right edges, by default that of the sheet. Gathered to a small part of it,
    as by the cords of a hammock, they let the sides stand up. These then hang 30 % less deep, so that a load stays in
    the middle."""
    over: Length | None = None
    """Radius [m] of the fold of a sheet that hangs over a bar along y at its origin, down on both sides, as a scarf or
    a towel on a line: the radius of the bar plus the distance that cloth keeps from it (half a `cell`). `edge: left` is
    its hem on that side, `face: left` all of that side."""
    over_at: Annotated[Real, Field(gt=0, lt=1)] = 0.5
    """With `over`: fraction of its length to the left (-x) of the bar's top."""
    folds: int = Field(default=0, ge=0, le=200)
    """Number of waves along x at the start, as in a curtain. They rise and fall along z, begin at half their height at
    its left edge, and shorten the sheet accordingly."""
    fullness: Annotated[Real, Field(gt=1, le=4)] = 1.2
    """With `folds`: length of the sheet over the width that it occupies."""
    texture: str | None = Field(default=None, max_length=200)
    """A picture inside the case's folder, .png or .jpg, that covers it once."""

    @model_validator(mode="after")
    def _hangs(self) -> "Sheet":
        long = self.size[0]
        if self.sag > 0.45 * long:
            raise ValueError(f"sag may be at most 0.45 of the length, {0.45 * long:g} m (got {self.sag:g} m)")
        if bool(self.sag) + (self.over is not None) + bool(self.folds) > 1:
            raise ValueError("give at most one of sag, over, folds")
        if self.ends is not None:
            if not self.sag:
                raise ValueError("ends needs a sag")
            least, most = max(self.size[1] - 2 * STEEPEST * self.sag, 0.0), self.size[1]
            if not least <= self.ends <= most:
                raise ValueError(
                    f"ends must be from {at_least(least)} m to the width, {most:g} m (got {self.ends:g} m)"
                )
        if self.over is None:
            return self
        shorter, fold = long * min(self.over_at, 1 - self.over_at), pi / 2 * self.over
        if shorter < fold:
            raise ValueError(
                f"the shorter side must reach around the fold, {at_least(fold)} m or more (got {shorter:g} m)"
            )
        return self


class Disc(Model):
    """A round sheet or a ring: a tablecloth, a skirt. For cloth only. It lies in the x-y plane, without thickness."""

    kind: Literal["disc"]
    radius: Length
    """Radius [m]."""
    hole: NonNegative = 0.0
    """Radius [m] of a round hole in its middle. Its rim is `sphere: {center: [0, 0, 0], radius: …}`, with half a `cell`
    more than the hole."""

    @model_validator(mode="after")
    def _ring(self) -> "Disc":
        if self.hole > 0.95 * self.radius:
            raise ValueError(f"hole may be at most 0.95 of the radius, {0.95 * self.radius:g} m (got {self.hole:g} m)")
        return self

    @property
    def area(self) -> float:
        """Area [m2] of one side."""
        return pi * (self.radius**2 - self.hole**2)


class Sleeve(Model):
    """A round tube of cloth around z, open at both ends: a sleeve, a sock, a trouser leg, a lampshade.

    For cloth only. Its frame is on its axis at half its height. `edge: bottom` and `edge: top` are its rims. Pushed
    together along an arm that it lies within a `cell` of, it gathers into round folds; with a `bending_compliance` of
    1e4 it crumples.
    """

    kind: Literal["sleeve"]
    radius: Length
    """Radius [m] of its lower end."""
    height: Length
    """Height [m]."""
    top_radius: Length | None = None
    """Radius [m] of its upper end; by default that of the lower one."""

    @property
    def radii(self) -> tuple[float, float]:
        """Radii [m] of its lower and its upper end."""
        return self.radius, self.radius if self.top_radius is None else self.top_radius

    @property
    def slant(self) -> float:
        """Length [m] of the cloth from rim to rim."""
        low, high = self.radii
        return hypot(self.height, high - low)

    @property
    def area(self) -> float:
        """Area [m2] of one side."""
        return pi * sum(self.radii) * self.slant


class Revolve(Model):
    """A profile revolved about z: a dome, a bowl, a hat, a filter, the cover of an umbrella. For cloth only.

    Stretching is measured from this form, and with `rest_shape: start` so is bending: a dome that keeps its form.
    `edge: bottom` and `edge: top` are its rims, at its lowest and highest points.
    """

    kind: Literal["revolve"]
    profile: Annotated[list[Vec2], Field(min_length=2, max_length=64)]
    """Points (distance from the axis, z) [m] from one rim to the other; where the first or last has distance 0, the
    surface is closed."""
    smooth: Bool = False
    """Use a curve through the points (Catmull-Rom) instead of straight lines; it is round where it meets the axis."""

    @model_validator(mode="after")
    def _about_the_axis(self) -> "Revolve":
        radii = [radius for radius, _ in self.profile]
        if min(radii) < 0:
            raise ValueError(f"distances from the axis must not be negative (got {min(radii):g} m)")
        if max(radii) == 0:
            raise ValueError("the profile lies on the axis: it makes no surface")
        if any(radius == 0 for radius in radii[1:-1]):
            raise ValueError("only the first and the last point may lie on the axis")
        for k, (a, b) in enumerate(pairwise(self.profile)):
            if dist(a, b) < LEAST_PART * max(radii):
                raise ValueError(f"points {k} and {k + 1} of the profile coincide")
        return self


class Ribbon(Model):
    """A strip along a smooth curve: a bow, a loop, a loose knot. For cloth only.

    Its mesh is that of the curved strip: stretching is measured from it, and with `rest_shape: start` so is bending.
    If its last point is its first, it is a band without ends, such as a belt, with the edges `front` and `back` where
    it lies around y; for a tube use `sleeve`.
    """

    kind: Literal["ribbon"]
    points: Annotated[list[Vec3], Field(min_length=2, max_length=100)]
    """Points [m] that its middle passes through, from its left end to its right one: `edge: left` is its first end,
    `edge: right` its last. Strands that cross should be two cells apart."""
    width: Length
    """Its width [m]. At the left end it is level, or along y if it begins upright; then it turns no more than the
    curve does."""
    turns: Real = 0.0
    """Turns by which it is twisted on the way to its right end, by the right-hand rule."""

    @model_validator(mode="after")
    def _runs(self) -> "Ribbon":
        for k, (a, b) in enumerate(zip(self.points, self.points[1:], strict=False)):
            if dist(a, b) < 1e-3 * self.width:
                raise ValueError(f"points {k} and {k + 1} coincide")
        if self.closed and len(self.points) < MIN_CLOSED:
            raise ValueError(f"a ribbon that ends where it begins needs {MIN_CLOSED} points (got {len(self.points)})")
        if self.closed and self.turns != round(self.turns):
            raise ValueError(f"a ribbon that ends where it begins needs whole turns (got {self.turns:g})")
        return self

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
        return dist(self.points[0], self.points[-1]) < 1e-3 * self.width


ClothShape = Annotated[
    Sheet | Disc | Sleeve | Revolve | Ribbon | Mesh | Box | Sphere | Cylinder | Capsule | Ellipsoid | Sculpt, ByKind()
]
"""A sheet, a disc, a sleeve, a surface of revolution, a ribbon, a mesh, or the hull of a solid: a bag, a balloon, a
pillow."""
