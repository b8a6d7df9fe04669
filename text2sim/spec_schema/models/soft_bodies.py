"""Bodies that change their shape: soft bodies, cloth, ropes, grains, liquids, snow."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Axis, Bool, Integer, Length, Model, NonNegative, Selector, Vec3
from text2sim.spec_schema.models.materials import Material
from text2sim.spec_schema.models.placed import Deformable, Linked
from text2sim.spec_schema.models.shapes import ClothShape, SoftShape
from text2sim.spec_schema.models.soft_materials import (
    ClothMaterial,
    GranularMaterial,
    LiquidMaterial,
    SnowMaterial,
    SoftMaterial,
)

ONLY_WITH = {
    "ipc": ("youngs_modulus", "poisson_ratio", "bending_stiffness"),
    "pbd": ("stretch_compliance", "bending_compliance", "air_resistance"),
}
"""Fields of a cloth's material that one solver knows and the other does not."""


class Soft(Deformable):
    """A volume that deforms: rubber, foam, jelly, clay."""

    kind: Literal["soft"]
    solver: Literal["fem", "mpm"] | None = None
    """`mpm` moves particles through a grid: any contact, large strains, coarse surfaces. `fem` moves the corners
    of tetrahedra: exact shapes, slow contact. If left out, what `scene.contact.model` goes with; else mpm."""
    shape: SoftShape
    """What it is shaped like before anything acts on it."""
    cell: Length | None = None
    """Wanted length [m] of an element: the grid's cell in mpm (one for the scene: the smallest that is given),
    the edge of a tetrahedron in fem. Derived if left out."""
    material: SoftMaterial = SoftMaterial.model_construct()
    """Stiffness and mass."""

    @model_validator(mode="after")
    def _fits(self) -> "Soft":
        if self.solver == "fem" and self.material.model == "elasto_plastic":
            raise ValueError("model elasto_plastic goes with solver mpm (got fem)")
        if self.material.yield_stress is not None and self.material.model != "elasto_plastic":
            raise ValueError(f"yield_stress goes with model elasto_plastic (got {self.material.model})")
        return self


class Cloth(Deformable):
    """A sheet that bends and folds."""

    kind: Literal["cloth"]
    solver: Literal["pbd", "ipc"] | None = None
    """`pbd` runs everywhere; `ipc` never lets anything through, and needs a CUDA device. If left out, what
    `scene.contact.model` goes with; else pbd."""
    shape: ClothShape
    """What it is shaped like before anything acts on it."""
    cell: Length | None = None
    """Wanted length [m] of an element: the distance of particles in pbd (one for the scene: the smallest that is
    given), the edge of a triangle in ipc. Derived if left out."""
    material: ClothMaterial = ClothMaterial.model_construct()
    """Mass, stiffness, friction."""

    @model_validator(mode="after")
    def _fits(self) -> "Cloth":
        if self.solver is not None:
            other = "pbd" if self.solver == "ipc" else "ipc"
            for name in ONLY_WITH[other]:
                if getattr(self.material, name) is not None:
                    raise ValueError(f"material.{name} goes with solver {other} (got {self.solver})")
        return self


class Granular(Deformable):
    """A heap of grains, as mpm particles."""

    kind: Literal["granular"]
    shape: SoftShape
    """The space that it fills at the start."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene: the smallest that is given). Derived if left out."""
    material: GranularMaterial = GranularMaterial.model_construct()
    """Mass and friction angle."""


class Liquid(Deformable):
    """A liquid, as mpm particles."""

    kind: Literal["liquid"]
    shape: SoftShape
    """The space that it fills at the start."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene: the smallest that is given). Derived if left out."""
    material: LiquidMaterial = LiquidMaterial.model_construct()
    """Mass and stiffness."""


class Snow(Deformable):
    """Snow, as mpm particles."""

    kind: Literal["snow"]
    shape: SoftShape
    """The space that it fills at the start."""
    cell: Length | None = None
    """Cell [m] of the grid (one for the scene: the smallest that is given). Derived if left out."""
    material: SnowMaterial = SnowMaterial.model_construct()
    """Mass, stiffness, and when it crumbles."""


LINKS = 24
"""Of a rope that does not say how many."""


class Round(Model):
    """A body that a rope goes round: a pulley, a drum, a post."""

    round: Selector
    """A cylinder or the like that turns about, or stands along, its own z."""
    side: Axis = (0.0, 0.0, 1.0)
    """Where the rope touches it, seen from its axis: on top if nothing is said, `[0, 0, -1]` is below."""
    turns: Annotated[Integer, Field(ge=0, le=50)] = 0
    """So many whole turns more, side by side along its axis."""
    radius: Length | None = None
    """Radius [m] on which the rope lies; that of its shape if left out."""


class Rope(Linked):
    """A rope of capsule links on ball joints, straight at the start or laid `along`; pose is that of its first end.

    Its links are named `link_0`, `link_1`, … from the first end on. On a drum about a level axis a turn that no
    pull holds flies off from `w^2 r > g` on (speed of turning w [rad/s], radius r).
    """

    kind: Literal["rope"]
    length: Length | None = None
    """Length [m]; follows from `along` where that is given."""
    along: list[Vec3 | Round] | None = Field(default=None, min_length=2, max_length=100)
    """Points [m] that it goes along at the start, and bodies that it goes round, in turn, such as
    `[[-0.1, 0, 0], {round: wheel}, [0.1, 0, 0]]`. In its own frame, which is the world's unless it has a pose."""
    radius: Length
    """Radius [m]."""
    segments: Annotated[Integer, Field(ge=2, le=200)] = LINKS
    """How many links; if left out, fewer for a short thick rope, so that each is at least as long as it is thick."""
    direction: Axis = (0.0, 0.0, -1.0)
    """Direction from its first end to its last."""
    anchored: Bool = True
    """Held by the world at its first end."""
    youngs_modulus: NonNegative = 0.0
    """Stiffness [Pa] against bending: each joint is a spring of `E I / segment length`. 0: a slack rope."""
    damping: NonNegative | None = None
    """Viscous damping [N m s/rad] of each joint; derived if left out."""
    self_collision: Bool = False
    """Let links that are not neighbours touch each other."""
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
                raise ValueError("along begins and ends with a point")
            if self.place is not None or self.direction != (0.0, 0.0, -1.0):
                raise ValueError("along says where it is and where it goes: leave out place and direction")
        elif self.length is not None and (link := self.length / self.segments) < 2 * self.radius * (1 - 1e-9):
            raise ValueError(
                f"a link must be at least twice as long as the radius (got {link:g} and "
                f"{self.radius:g}); take "
                + ("fewer segments" if self.segments > 2 else "a longer rope, or a rigid capsule")
            )
        return self

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return not self.anchored
