"""Shapes. Each is centred on its frame's origin, with its axis along z, unless it says otherwise."""

from math import hypot, pi
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
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
    Real,
    Size2,
    Size3,
    Vec3,
)
from text2sim.spec_schema.models.materials import Look
from text2sim.spec_schema.models.sculpts import Sculpt

Segments = Annotated[Integer, Field(ge=6, le=64)]


FLATTEST = 1e-4
"""Least thickness of a polyhedron, as a part of its largest extent."""


def _cross(u: list[float], v: list[float]) -> tuple[float, float, float]:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


class Plane(Model):
    """The horizontal ground z = 0 of its frame, without end. For statics only."""

    kind: Literal["plane"]
    size: Length = 40.0
    """Side [m] of the square around its origin that is drawn and that bodies touch: beside it they fall."""


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
    """A cylinder along z with half spheres on both ends."""

    kind: Literal["capsule"]
    radius: Length
    """Radius [m]."""
    length: Length
    """Length [m] of the straight part: the whole is `length + 2 radius`."""


class Cone(Model):
    """A cone along z, its tip up; its frame is half way up."""

    kind: Literal["cone"]
    radius: Length
    """Radius [m] of the base."""
    height: Length
    """Height [m]."""


class Polyhedron(Model):
    """The convex hull of points, with flat faces: a wedge, a prism, a pyramid, a stone of an arch."""

    kind: Literal["polyhedron"]
    points: Annotated[list[Vec3], Field(min_length=4, max_length=64)]
    """Corners [m] in the body's frame, in any order; what lies inside of the others does not count."""

    @model_validator(mode="after")
    def _solid(self) -> "Polyhedron":
        a = self.points[0]
        away = [[c - o for c, o in zip(point, a, strict=True)] for point in self.points]
        u = max(away, key=lambda v: hypot(*v))
        normal = max((_cross(u, v) for v in away), key=lambda n: hypot(*n))
        size, area = hypot(*u), hypot(*normal)
        if size > 1e6:
            raise ValueError(f"its points are up to {size:g} m apart; 1000 km at most")
        heights = [sum(n * c for n, c in zip(normal, v, strict=True)) / area for v in away] if area > 0 else [0.0]
        thin = max(heights) - min(heights)
        if thin < max(1e-6, FLATTEST * size):
            raise ValueError(f"its points lie in one plane or line, within {thin:.2g} m: they enclose no volume")
        return self


class Ellipsoid(Model):
    """An ellipsoid."""

    kind: Literal["ellipsoid"]
    radii: Size3
    """Half lengths [m] along x, y, z."""


class Torus(Model):
    """A ring about z, made of capsules.

    Its hole is a polygon: clear to `radius cos(180 deg / segments) - bar_radius`. Rings that hang in each other have
    their middles at most `2 (radius - bar_radius)` apart.
    """

    kind: Literal["torus"]
    radius: Length
    """Radius [m] of the circle at the middle of the bar."""
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
    """A hollow cylinder along z, open at both ends, made of convex staves; its frame is half way up its axis."""

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
    """A tube with a floor, open at the top; made of convex pieces."""

    kind: Literal["cup"]
    radius: Length
    """Outer radius [m]."""
    height: Length
    """Height [m] over all."""
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
    """A cone's wall along z, open at both ends; made of convex staves.

    Its frame is half way up its axis, and its top at +z, whichever end is the wider. To lie along x,
    `euler_deg: [0, -90, 0]` turns the top to -x.
    """

    kind: Literal["funnel"]
    top_radius: Length
    """Inner radius [m] at the top."""
    bottom_radius: Length
    """Inner radius [m] at the bottom."""
    height: Length
    """Height [m]."""
    thickness: Length
    """Thickness [m] of the wall, measured along the radius."""
    segments: Segments = 24
    """Staves around the wall."""


class Mesh(Model):
    """A triangle mesh from the case's folder. Its own colours and picture hold unless the look has a `color`.

    Mass and centre of mass are those of the solid that the surface encloses, or, where it is open, of its
    convex hull. In .glb and .gltf files y points up; here that becomes z.
    """

    kind: Literal["mesh"]
    file: str = Field(max_length=200)
    """Path inside the case's folder: .obj, .stl, .ply, .glb or .gltf; `genesis:` before it means the engine's own
    assets."""
    scale: Positive = 1.0
    """Factor from the file's unit to metres."""
    collision: Literal["hull", "decompose", "exact"] = "hull"
    """Contact by its convex hull, by several convex pieces, which take seconds to find, or by the surface itself, with
    its holes and threads (a closed one, through a field of distances; see contact.md); all meshes of a body alike."""
    cell: Length | None = None
    """Of `exact`: distance [m] of the nodes of the field, within which edges are rounded. If left out, a 95th of its
    grid, which is a fifth longer than the mesh, or half of thinner walls, down to a 127th."""

    @model_validator(mode="after")
    def _gridded(self) -> "Mesh":
        if self.cell is not None and self.collision != "exact":
            raise ValueError(f"cell belongs to collision: exact (this mesh has collision: {self.collision})")
        return self


class Text(Model):
    """Letters as a solid, upright: width along x, height along z, depth along y; centred.

    The font is DejaVu Sans Bold.
    """

    kind: Literal["text"]
    text: str = Field(min_length=1, max_length=200)
    """What it says; after a line break a new line begins, 1.5 heights below, at the left."""
    height: Length
    """Height [m] of a capital letter."""
    depth: Length
    """Thickness [m] along y."""
    font: str | None = Field(default=None, max_length=200)
    """A .ttf or .otf file inside the case's folder instead of the built-in font."""
    part: Annotated[Integer, Field(ge=0, le=1000)] | None = None
    """Only this letter, counted from 0 without blanks; all if left out."""


class Sketch(Model):
    """What is drawn in a picture, as a solid, upright: width along x, height along z, depth along y; centred.

    Strokes and filled forms count where they are darker than the paper. Specks are left out.
    """

    kind: Literal["sketch"]
    file: str = Field(max_length=200)
    """Path inside the case's folder: .png or .jpg."""
    height: Length
    """Height [m] of the whole drawing."""
    depth: Length
    """Thickness [m] along y."""
    part: Annotated[Integer, Field(ge=0, le=1000)] | None = None
    """Only this connected piece, counted from 0 by rows from left to right; all if left out."""


class Sheet(Model):
    """A rectangle in the x-y plane, without thickness. For cloth only."""

    kind: Literal["sheet"]
    size: Size2
    """Lengths [m] along x and y."""
    sag: NonNegative = 0.0
    """How deep [m] its middle hangs at the start below its left and right edges, which come nearer to each other: a
    hammock, an awning; up to 0.45 of its length. It is a parabola as long as the sheet, L, with the origin between its
    ends; they are `L - 8/3 sag^2 / L` apart, within 1 % up to a fifth of L."""
    over: Length | None = None
    """It hangs over a bar along y at its origin, down on both sides: a scarf, a towel, a blanket on a line. Radius [m]
    of the fold: that of the bar, and the distance that cloth keeps from it (half a `cell`). `edge: left` is its hem on
    that side; `face: left` all that hangs there."""
    over_at: Annotated[Real, Field(gt=0, lt=1)] = 0.5
    """With `over`: part of its length that hangs to the left (-x) of the bar's top."""
    folds: int = Field(default=0, ge=0, le=200)
    """Waves along x in which it lies or hangs at the start, as a curtain does; they rise and fall along z, and begin at
    its left edge, halfway up. Its sides are then as near to each other as the waves make them."""
    fullness: Annotated[Real, Field(gt=1, le=4)] = 1.2
    """With `folds`: its length over the width that it takes up."""
    texture: str | None = Field(default=None, max_length=200)
    """A picture inside the case's folder, .png or .jpg, laid over it once."""

    @model_validator(mode="after")
    def _hangs(self) -> "Sheet":
        long = self.size[0]
        if self.sag > 0.45 * long:
            raise ValueError(f"a sheet of {long:g} m along x sags by {0.45 * long:g} m at most (got {self.sag:g} m)")
        if bool(self.sag) + (self.over is not None) + bool(self.folds) > 1:
            raise ValueError("give one of sag, over and folds")
        if self.over is None:
            return self
        shorter, fold = long * min(self.over_at, 1 - self.over_at), pi / 2 * self.over
        if shorter < fold:
            raise ValueError(f"its shorter side, {shorter:g} m, does not reach round the fold: at least {fold:.3g} m")
        return self


_Solid = (
    Box
    | Sphere
    | Cylinder
    | Capsule
    | Cone
    | Polyhedron
    | Ellipsoid
    | Torus
    | Tube
    | Cup
    | Funnel
    | Mesh
    | Text
    | Sketch
)
SolidShape = Annotated[_Solid, ByKind()]


class Part(Model):
    """One piece of a compound."""

    shape: SolidShape
    """What the piece is shaped like."""
    pose: Pose = Pose.model_construct()
    """Where the piece sits in the body's frame."""
    density: Density | None = None
    """Density [kg/m3], if it differs from the body's material."""
    look: Look | None = None
    """Look, if it differs from the body's."""
    repeat: Multiple | None = None
    """So many of these parts, called `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""
    decor: Bool = False
    """Only drawn, as hoops, handles, eyes and buttons are: it weighs nothing and touches nothing."""

    @model_validator(mode="after")
    def _weightless(self) -> "Part":
        if self.decor and self.density is not None:
            raise ValueError("what is only drawn (decor: true) has no density")
        return self


class Compound(Model):
    """Several pieces that move as one body. Each weighs by itself: where they overlap, what they share weighs twice."""

    kind: Literal["compound"]
    parts: dict[Name, Part] = Field(min_length=1, max_length=200)
    """The pieces by name."""

    @model_validator(mode="after")
    def _solid(self) -> "Compound":
        if not self.solids:
            raise ValueError("all its parts are only drawn (decor: true); one at least must have mass")
        return self

    @property
    def solids(self) -> dict[str, Part]:
        """The pieces that weigh and touch, by name."""
        return {name: part for name, part in self.parts.items() if not part.decor}


Shape = Annotated[_Solid | Sculpt | Compound, ByKind()]
StaticShape = Annotated[Plane | _Solid | Sculpt | Compound, ByKind()]
SoftShape = Shape
"""What deforms as a volume: any solid, and of a compound the union of its parts."""
ClothShape = Annotated[Sheet | Mesh, ByKind()]
"""A sheet, or a mesh that is an open surface."""
