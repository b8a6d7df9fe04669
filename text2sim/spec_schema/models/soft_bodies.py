"""Deformable bodies: soft bodies, cloth, ropes, beams, grains, liquids, snow."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    Axis,
    Bool,
    Fraction,
    Integer,
    Length,
    Model,
    NonNegative,
    Positive,
    Selector,
    Size3,
    Vec3,
)
from text2sim.spec_schema.models.materials import Material
from text2sim.spec_schema.models.placed import Deformable, Linked
from text2sim.spec_schema.models.shapes import FlowShape, Shape
from text2sim.spec_schema.models.sheets import ClothShape, Disc, Revolve, Ribbon, Sheet, Sleeve
from text2sim.spec_schema.models.soft_materials import (
    ClothMaterial,
    GranularMaterial,
    LiquidMaterial,
    SnowMaterial,
    SoftMaterial,
)

FLOWING = ("granular", "liquid", "snow")
"""Kinds of body that flow: they have a free surface, and can leak."""
ONLY_WITH = {
    "ipc": ("poisson_ratio",),
    "pbd": (
        "prestretch",
        "stretch_compliance",
        "bending_compliance",
        "crease_radius",
        "rest_shape",
        "pressure",
        "gas_modulus",
        "damping",
        "air_resistance",
    ),
}
"""Fields of a cloth's material that only one solver supports."""


class Soft(Deformable):
    """A deformable solid: rubber, jelly, clay; or cream, foam, paste, by `yield_stress` and `adhesion`.

    Ends that are attached to driven bodies, of which one spins, twist it until its folds press on each other. With
    mpm, edges that get more than about twice as long tear: two turns take a mat five times as long as wide.
    """

    kind: Literal["soft"]
    solver: Literal["fem", "mpm"] | None = None
    """`mpm` moves particles through a grid: any contact, large strains, coarse surfaces. `fem` moves the corners of
    tetrahedra: exact shapes, slow contact. By default the one that `scene.contact.model` implies, otherwise mpm."""
    shape: Shape
    """Its undeformed shape."""
    cell: Length | None = None
    """Desired length [m] of an element: the grid's cell in mpm (one for the scene, the smallest given), the edge of a
    tetrahedron in fem. Derived by default."""
    material: SoftMaterial = SoftMaterial.model_construct()
    """Stiffness and mass."""

    @model_validator(mode="after")
    def _fits(self) -> "Soft":
        if self.solver == "fem" and self.material.model == "elasto_plastic":
            raise ValueError("model elasto_plastic needs solver mpm (got fem)")
        if self.material.yield_stress is not None and self.material.model != "elasto_plastic":
            raise ValueError(f"yield_stress needs model elasto_plastic (got {self.material.model})")
        if self.solver == "fem" and self.material.adhesion:
            raise ValueError("material.adhesion needs solver mpm (got fem)")
        if self.material.viscosity and self.material.model != "elasto_plastic":
            raise ValueError(
                f"viscosity needs model elasto_plastic (got {self.material.model}); what does not keep a shape at all "
                "is a liquid, which takes a viscosity, too"
            )
        if self.material.tear_stretch is not None:
            if self.solver == "fem":
                raise ValueError("material.tear_stretch needs solver mpm (got fem)")
            if self.material.model == "elasto_plastic":
                raise ValueError("tear_stretch needs model elastic or neo_hookean (got elasto_plastic)")
        return self


class Cloth(Deformable):
    """A sheet that bends and folds, or the hull of a solid, which may enclose gas."""

    kind: Literal["cloth"]
    solver: Literal["pbd", "ipc"] | None = None
    """`pbd` runs everywhere; `ipc` never lets anything through, and needs a CUDA device. By default the one that
    `scene.contact.model` implies, otherwise pbd."""
    shape: ClothShape
    """Its undeformed shape."""
    cell: Length | None = None
    """Desired length [m] of an element: the particle distance in pbd (one for the scene, the smallest given), the edge
    of a triangle in ipc. Derived by default."""
    material: ClothMaterial = ClothMaterial.model_construct()
    """Mass, stiffness, friction."""

    @model_validator(mode="after")
    def _closed(self) -> "Cloth":
        if self.material.has_gas and isinstance(self.shape, Sheet | Disc | Sleeve | Revolve | Ribbon):
            raise ValueError(f"a {self.shape.kind} encloses no gas: pressure and gas_modulus need the hull of a solid")
        return self

    @model_validator(mode="after")
    def _fits(self) -> "Cloth":
        if self.solver is not None:
            other = "pbd" if self.solver == "ipc" else "ipc"
            for name in ONLY_WITH[other]:
                if getattr(self.material, name) is not None:
                    raise ValueError(f"material.{name} needs solver {other} (got {self.solver})")
        if self.material.prestretch is not None and self.material.youngs_modulus is None:
            raise ValueError("material.prestretch needs a youngs_modulus, such as 1e6 for rubber")
        if self.material.youngs_modulus is not None and self.material.stretch_compliance is not None:
            raise ValueError("give either material.youngs_modulus or material.stretch_compliance, not both")
        return self


class Granular(Deformable):
    """A heap or stream of grains, as mpm particles."""

    kind: Literal["granular"]
    shape: FlowShape
    """The volume that it fills at the start, or a stream."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene, the smallest given). Derived by default."""
    material: GranularMaterial = GranularMaterial.model_construct()
    """Mass and friction angle."""


class Liquid(Deformable):
    """A liquid, as mpm particles: a volume, or a `stream` from a tap or nozzle."""

    kind: Literal["liquid"]
    shape: FlowShape
    """The volume that it fills at the start, or a stream. Prefab `tank` holds it behind thin panes of glass."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene, the smallest given). Derived by default."""
    material: LiquidMaterial = LiquidMaterial.model_construct()
    """Mass and stiffness."""


class Snow(Deformable):
    """Snow, as mpm particles."""

    kind: Literal["snow"]
    shape: FlowShape
    """The volume that it fills at the start, or a stream."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene, the smallest given). Derived by default."""
    material: SnowMaterial = SnowMaterial.model_construct()
    """Mass, stiffness, and limits of crumbling."""


LINKS = 24
"""Default number of links of a rope."""


class Round(Model):
    """A body that a rope runs around: a pulley, a drum, a post."""

    round: Selector
    """A cylinder or similar body that turns about, or extends along, its own z axis."""
    side: Axis = (0.0, 0.0, 1.0)
    """Direction from its axis to the rope: by default on top; `[0, 0, -1]` is below."""
    turns: Annotated[Integer, Field(ge=0, le=50)] = 0
    """Number of additional full turns, side by side along its axis."""
    radius: Length | None = None
    """Radius [m] of the surface under the rope; by default that of its shape."""


class Rope(Linked):
    """A rope of capsule links on ball joints, straight at the start or laid `along`; `pose` is that of its first end.

    Its links are named `link_0`, `link_1`, … from the first end on. To twist it, attach an end, not `anchored`, to a
    driven body that spins: a `youngs_modulus` carries the twist, and with `self_collision` a slack rope throws a loop
    and winds around itself. On a horizontal drum, a turn without tension flies off above `w^2 r = g` (w [rad/s]).
    """

    kind: Literal["rope"]
    length: Length | None = None
    """Length [m]; give either this or `along`, which determines it."""
    along: list[Vec3 | Round] | None = Field(default=None, min_length=2, max_length=100)
    """Points [m] of its path at the start and bodies that it runs around, in order, such as
    `[[-0.1, 0, 0], {round: wheel}, [0.1, 0, 0]]`, in its own frame, which is the world's unless it has a pose."""
    radius: Length
    """Radius [m]."""
    segments: Annotated[Integer, Field(ge=2, le=200)] = LINKS
    """Number of links; by default fewer for a short thick rope, so that each is at least as long as thick."""
    direction: Axis = (0.0, 0.0, -1.0)
    """Direction from its first end to its last."""
    anchored: Bool = True
    """Attach its first end to the world."""
    youngs_modulus: NonNegative = 0.0
    """Young's modulus E [Pa]: each joint is a spring of `E I / segment length`, `I = pi radius^4 / 4`, against bending
    and twist. 0 is a limp rope."""
    damping: NonNegative | None = None
    """Viscous damping [N m s/rad] of each joint; derived by default."""
    self_collision: Bool = False
    """Let links that are not neighbours collide."""
    material: Material = Material.model_construct()
    """Density and friction."""

    @model_validator(mode="before")
    @classmethod
    def _links(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "segments" in data:
            return data
        length, radius = data.get("length"), data.get("radius")
        if not isinstance(length, int | float) or not isinstance(radius, int | float) or not 0 < radius < length:
            return data
        return data | {"segments": max(2, min(LINKS, int(length / radius / 2 * (1 + 1e-9))))}

    @model_validator(mode="after")
    def _slender(self) -> "Rope":
        if (self.length is None) == (self.along is None):
            raise ValueError("give either length or along")
        if self.along is not None:
            if isinstance(self.along[0], Round) or isinstance(self.along[-1], Round):
                raise ValueError("along must begin and end with a point")
            if self.place is not None or self.direction != (0.0, 0.0, -1.0):
                raise ValueError("along determines position and direction: leave out place and direction")
        elif self.length is not None and (link := self.length / self.segments) < 2 * self.radius * (1 - 1e-9):
            raise ValueError(
                f"a link must be at least twice as long as the radius (got {link:g} and "
                f"{self.radius:g}); use "
                + ("fewer segments" if self.segments > 2 else "a longer rope, or a rigid capsule")
            )
        return self

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return not self.anchored


SEGMENTS = 10
"""Default number of links of a beam."""


class Beam(Linked):
    """A straight elastic strip clamped at one end: slat, springboard, ruler, leaf spring, reed, catapult arm.

    It extends along the x axis of its frame, from the middle of its first end; its width lies along y, its thickness
    along z. It bends about y alone, and neither twists nor stretches. With `I = width thickness^3 / 12`, a force F at
    its tip bends it by `F length^3 / (3 E I)`, and it swings at `0.1615 thickness / length^2 sqrt(E / density)` [Hz]
    (for 10 segments 0.2 % less; the difference is `0.21 / segments^2`). Its links are `link_0`, `link_1`, … from the
    first end on, each with its frame at its first end.
    """

    kind: Literal["beam"]
    size: Size3
    """Length, width and thickness [m], the thickness the least of them."""
    segments: Annotated[Integer, Field(ge=2, le=50)] = SEGMENTS
    """Number of links; by default fewer for a short thick beam, so that each is at least as long as thick."""
    youngs_modulus: Positive
    """Young's modulus E [Pa]: about 5e6 for rubber, 3e9 for plastic, 1e10 for wood, 2e11 for steel."""
    damping_ratio: Fraction = 0.02
    """Damping ratio z of its first swing while one end is clamped: each swing is `e^(-2 pi z)` times as wide as the one
    before, 0.88 by default. The smaller, the shorter the substeps; 0 takes very many."""
    anchored: Bool = True
    """Clamp its first end to the world. Attached to a body by `link_0` instead, it bends from the middle of that link
    on."""
    material: Material = Material.model_construct()
    """Density and friction."""

    @model_validator(mode="before")
    @classmethod
    def _links(cls, data: Any) -> Any:
        size = data.get("size") if isinstance(data, dict) and "segments" not in data else None
        if not isinstance(size, list | tuple) or len(size) != 3:
            return data
        if not all(isinstance(side, int | float) and side > 0 for side in size):
            return data
        return data | {"segments": max(2, min(SEGMENTS, int(size[0] / size[2] * (1 + 1e-9))))}

    @model_validator(mode="after")
    def _slender(self) -> "Beam":
        length, width, thickness = self.size
        if thickness > min(length, width):
            raise ValueError(f"size is length, width, thickness: the thickness must be the least (got {thickness:g})")
        if (link := length / self.segments) < thickness * (1 - 1e-9):
            raise ValueError(
                f"a link must be at least as long as thick (got {link:g} and {thickness:g}); use "
                + ("fewer segments" if self.segments > 2 else "a longer beam, or a rigid box")
            )
        return self

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return not self.anchored
