"""Shapes, centred on the origin of their frame and with the axis along z unless stated otherwise."""

from math import pi
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    Axis,
    Bool,
    ByKind,
    Density,
    Integer,
    Length,
    Model,
    Multiple,
    Name,
    NonNegative,
    Pose,
    Positive,
    Size3,
    Vec2,
)
from text2sim.spec_schema.models.faceted import Polyhedron, Rock
from text2sim.spec_schema.models.materials import Look
from text2sim.spec_schema.models.sculpts import Sculpt

Segments = Annotated[Integer, Field(ge=6, le=64)]


class Plane(Model):
    """The horizontal ground z = 0 of its frame. For statics only."""

    kind: Literal["plane"]
    size: Length = 40.0
    """Side [m] of the square around its origin that is drawn and that supports bodies; outside it they fall."""


class Box(Model):
    """A box."""

    kind: Literal["box"]
    size: Size3
    """Full lengths [m] along x, y, z."""


class Sphere(Model):
    """A sphere."""

    kind: Literal["sphere"]
    radius: Length
    """Radius [m]."""


class Cylinder(Model):
    """A cylinder along z."""

    kind: Literal["cylinder"]
    radius: Length
    """Radius [m]."""
    height: Length
    """Height [m]."""


class Capsule(Model):
    """A cylinder along z with a hemisphere at each end."""

    kind: Literal["capsule"]
    radius: Length
    """Radius [m]."""
    length: Length
    """Length [m] of the straight part; the total length is `length + 2 radius`."""


class Cone(Model):
    """A cone along z with its tip up; its frame is at half its height."""

    kind: Literal["cone"]
    radius: Length
    """Radius [m] of the base."""
    height: Length
    """Height [m]."""
    top_radius: NonNegative = 0.0
    """Radius [m] of the upper end of a frustum; 0 is a tip. It is solid: `cup` and `funnel` are hollow."""


class Ellipsoid(Model):
    """An ellipsoid."""

    kind: Literal["ellipsoid"]
    radii: Size3
    """Semi-axes [m] along x, y, z."""


class Torus(Model):
    """A ring around z, made of capsules.

    Its hole is a polygon with an inscribed circle of radius `radius cos(180 deg / segments) - bar_radius`. The centres
    of linked rings are at most `2 (radius - bar_radius)` apart.
    """

    kind: Literal["torus"]
    radius: Length
    """Radius [m] of the centre line of the bar."""
    bar_radius: Length
    """Radius [m] of the bar."""
    segments: Segments = 16
    """Capsules around the ring."""

    @model_validator(mode="after")
    def _hollow(self) -> "Torus":
        if self.bar_radius >= self.radius:
            radii = f"{self.bar_radius:g} and {self.radius:g}"
            raise ValueError(f"bar_radius must be smaller than radius (got {radii})")
        return self


class Tube(Model):
    """A hollow cylinder along z, open at both ends, made of convex staves; its frame is at half its height."""

    kind: Literal["tube"]
    outer_radius: Length
    """Outer radius [m]."""
    inner_radius: Length
    """Inner radius [m]."""
    height: Length
    """Height [m]."""
    segments: Segments = 24
    """Staves around the wall."""

    @model_validator(mode="after")
    def _hollow(self) -> "Tube":
        if self.inner_radius >= self.outer_radius:
            radii = f"{self.inner_radius:g} and {self.outer_radius:g}"
            raise ValueError(f"inner_radius must be smaller than outer_radius (got {radii})")
        return self


class Cup(Model):
    """A tube with a floor, open at the top, made of convex pieces.

    Its frame is at half its height. A round bowl is a `sculpt`.
    """

    kind: Literal["cup"]
    radius: Length
    """Outer radius [m]."""
    height: Length
    """Overall height [m]."""
    thickness: Length
    """Thickness [m] of wall and floor."""
    segments: Segments = 24
    """Staves around the wall."""

    @model_validator(mode="after")
    def _hollow(self) -> "Cup":
        if self.thickness >= min(self.radius, self.height):
            raise ValueError(f"thickness must be smaller than radius and height (got {self.thickness:g})")
        return self


class Funnel(Model):
    """A conical wall along z, open at both ends, made of convex staves.

    Its frame is at half its height, and its top at +z, whichever end is wider. `euler_deg: [0, -90, 0]` lays it along
    x, with the top at -x.
    """

    kind: Literal["funnel"]
    top_radius: Length
    """Inner radius [m] at the top."""
    bottom_radius: Length
    """Inner radius [m] at the bottom."""
    height: Length
    """Height [m]."""
    thickness: Length
    """Thickness [m] of the wall in the radial direction."""
    segments: Segments = 24
    """Staves around the wall."""


class Mesh(Model):
    """A triangle mesh from the case's folder. It has its own colours and texture unless the look has a `color`.

    Mass and centre of mass are those of the enclosed solid or, for an open surface, of its convex hull. The y axis of
    .glb and .gltf files, which points up, becomes z.
    """

    kind: Literal["mesh"]
    file: str = Field(max_length=200)
    """Path inside the case's folder: .obj, .stl, .ply, .glb or .gltf; the prefix `genesis:` denotes the engine's own
    assets."""
    scale: Positive = 1.0
    """Factor from the file's unit to metres."""
    collision: Literal["hull", "decompose", "exact"] = "hull"
    """Contact by its convex hull, by several convex pieces, which take seconds to find, or by the surface itself, with
    its holes and threads (if closed, as a signed distance field; see contact.md). It is the same for all meshes of a
    body."""
    cell: Length | None = None
    """With `exact`: distance [m] of the nodes of the field, within which edges are rounded. By default 1/95 of the
    grid, which is a fifth longer than the mesh, or half of the thickness of thinner walls, but at least 1/127."""

    @model_validator(mode="after")
    def _gridded(self) -> "Mesh":
        if self.cell is not None and self.collision != "exact":
            raise ValueError(f"cell needs collision: exact (got {self.collision})")
        return self


class Text(Model):
    """Upright letters as a centred solid.

    Their width is along x, their height along z, their depth along y. The font is DejaVu Sans Bold.
    """

    kind: Literal["text"]
    text: str = Field(min_length=1, max_length=200)
    """The text; a line break begins a new line 1.5 heights below, at the left."""
    height: Length
    """Height [m] of a capital letter."""
    depth: Length
    """Thickness [m] along y."""
    font: str | None = Field(default=None, max_length=200)
    """A .ttf or .otf file inside the case's folder instead of the built-in font."""
    part: Annotated[Integer, Field(ge=0, le=1000)] | None = None
    """Index of the only letter, from 0 and without blanks; by default all letters."""


class Sketch(Model):
    """An upright drawing from a picture as a centred solid.

    Its width is along x, its height along z, its depth along y. Strokes and filled forms become solid where they are
    darker than the paper. Specks are ignored.
    """

    kind: Literal["sketch"]
    file: str = Field(max_length=200)
    """Path inside the case's folder: .png or .jpg."""
    height: Length
    """Height [m] of the whole drawing."""
    depth: Length
    """Thickness [m] along y."""
    part: Annotated[Integer, Field(ge=0, le=1000)] | None = None
    """Index of the only connected piece, from 0 by rows from left to right; by default all pieces."""


class Extrusion(Model):
    """A flat outline that is thick along y: a cam, a ratchet, a curved ramp, an arrow, a bracket.

    Its frame is where its points say, not in its middle. It may be concave, and touches by convex prisms.
    """

    kind: Literal["extrusion"]
    outline: list[Vec2] = Field(min_length=3, max_length=400)
    """Corners [m] in x and z, in order, either way round."""
    holes: list[Annotated[list[Vec2], Field(min_length=3, max_length=400)]] = Field(default_factory=list, max_length=50)
    """Outlines of holes right through it [m]."""
    depth: Length
    """Thickness [m] along y, about y = 0."""
    smooth: Bool = False
    """Whether outline and holes are smooth closed curves through their points, as of a cam; else edges are straight."""


FlatShape = Text | Sketch | Extrusion
"""Shapes that are a form in x and z with a depth along y."""


class Stream(Model):
    """A stream from a mouth, as of a tap or hose. Only for what flows.

    It comes out during the run, and is round. Its volume is `pi radius^2 speed duration`. What has not come out yet
    waits in the mouth, at its origin, and counts there in measures. An invisible pipe of two `cell` leads to the mouth:
    keep both free of solids that touch, or give a spout `touch_soft: false`.
    """

    kind: Literal["stream"]
    radius: Length
    """Radius [m] of the mouth. It needs two cells of the grid or more across."""
    speed: Positive
    """Speed [m/s] at the mouth. A falling stream gets thinner: `v^2 = speed^2 + 2 g h` after a height h."""
    duration: Positive
    """How long it flows [s]."""
    start: NonNegative = 0.0
    """When it begins to flow [s]."""
    direction: Axis = (0.0, 0.0, -1.0)
    """Its direction at the mouth, in its frame; `[0, 0, 1]` is a fountain."""

    @property
    def volume(self) -> float:
        """Volume [m3] that comes out."""
        return pi * self.radius**2 * self.speed * self.duration


_Solid = (
    Box
    | Sphere
    | Cylinder
    | Capsule
    | Cone
    | Polyhedron
    | Rock
    | Ellipsoid
    | Torus
    | Tube
    | Cup
    | Funnel
    | Mesh
    | Text
    | Sketch
    | Extrusion
)
SolidShape = Annotated[_Solid, ByKind()]


class Part(Model):
    """One piece of a compound."""

    shape: SolidShape
    """Shape of the piece: any but `sculpt` and `compound`."""
    pose: Pose = Pose.model_construct()
    """Pose of the piece in the body's frame."""
    density: Density | None = None
    """Density [kg/m3], if it differs from the body's material."""
    look: Look | None = None
    """Look, if it differs from the body's."""
    repeat: Multiple | None = None
    """Number of such parts, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""
    decor: Bool = False
    """Only draw the piece, such as a hoop, handle, eye or button, without mass and contact."""

    @model_validator(mode="after")
    def _weightless(self) -> "Part":
        if self.decor and self.density is not None:
            raise ValueError("a part that is only drawn (decor: true) has no density")
        return self


class Compound(Model):
    """Several pieces that move as one body. Their masses add up: overlaps count twice."""

    kind: Literal["compound"]
    parts: dict[Name, Part] = Field(min_length=1, max_length=200)
    """Pieces by name; 200 with copies."""

    @model_validator(mode="after")
    def _solid(self) -> "Compound":
        if not self.solids:
            raise ValueError("all its parts are only drawn (decor: true); at least one must have mass")
        return self

    @property
    def solids(self) -> dict[str, Part]:
        """The pieces with mass and contact, by name."""
        return {name: part for name, part in self.parts.items() if not part.decor}


Shape = Annotated[_Solid | Sculpt | Compound, ByKind()]
StaticShape = Annotated[Plane | _Solid | Sculpt | Compound, ByKind()]
AnyShape = Annotated[Plane | _Solid | Sculpt | Compound | Stream, ByKind()]
FlowShape = Annotated[_Solid | Sculpt | Compound | Stream, ByKind()]
"""The shape of what flows: a volume that is there at the start, or a stream."""
