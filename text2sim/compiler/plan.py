"""The plan: a case with everything resolved, flat enough that templates only print it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from text2sim.compiler import digests
from text2sim.compiler.action_rows import (
    Airflow,
    FaceBond,
    Field,
    Friction,
    Hold,
    JointDrive,
    Prescribed,
    Push,
    Removal,
    Spring,
    StartVelocity,
    Watch,
    Weld,
    Wrench,
)
from text2sim.compiler.belts import Belt
from text2sim.compiler.settings import Settings
from text2sim.compiler.shapes.rotation import Quaternion, Vec
from text2sim.compiler.soft.setup import SoftRecord


@dataclass(frozen=True)
class Surface:
    """What the engine needs to draw an entity in one colour."""

    rgba: tuple[float, float, float, float]
    finish: str
    picture: str | None = None
    """Path in the program's folder of a picture that takes the place of the colour."""
    mode: str | None = None
    """How the engine is to draw it, where its default would be slow; None for the default."""
    flat: bool = False
    """Whether it is drawn with sharp edges."""
    decoration: dict[str, Any] = field(default_factory=dict)
    """Pattern, label, and whether copies are alike, for what draws them; empty without any."""
    regions: str | None = None
    """For a deformable body: path in the program's folder of the regions in which parts have looks of their own."""
    parts: "tuple[Surface | None, ...]" = ()
    """These looks, by number of the part; None where a part has the look of the body."""


@dataclass(frozen=True)
class EntityPlan:
    """One entity of the engine: a copy of a body, or a static."""

    name: str
    """Name of the copy: `ball`, `brick[3]`."""
    morph: str
    """Box, Sphere, Cylinder, Plane, Mesh, MJCF, URDF, or Nowhere for a stream."""
    options: dict[str, Any]
    """Keyword arguments of the morph besides pos and quat."""
    pos: Vec
    quat: Quaternion
    rho: float | None = None
    friction: float | None = None
    """Density [kg/m3] and coefficient of friction; None where the model file gives them."""
    surface: Surface | None = None
    """None where the model file has its own colours."""
    part_surfaces: "dict[str, tuple[Surface | None, ...]]" = field(default_factory=dict)
    """Looks of what is drawn of each link, in order; None for own colours of a mesh. Empty if alike or as in a file."""
    family: str = "rigid"
    """Solver of the engine that holds it: rigid, mpm, pbd or fem."""
    material: str = "Rigid"
    """Class of the engine's materials, with its family before it where it is not rigid: `MPM.Elastic`."""
    material_options: dict[str, Any] = field(default_factory=dict)
    """Keyword arguments of the material besides rho and friction; of a deformable body, all of them."""
    soft: SoftRecord | None = None
    """None of a rigid body."""


@dataclass(frozen=True)
class Group:
    """All copies of one body: one function of the program."""

    name: str
    line: int
    """Line of the case at which it is described."""
    entities: tuple[EntityPlan, ...]


@dataclass(frozen=True)
class Motor:
    """Gains of an actuated joint."""

    entity: str
    joint: str
    stiffness: float
    damping: float
    max_force: float | None


@dataclass(frozen=True)
class JointChange:
    """What the case changes about a joint that came from a file; None leaves it as it is."""

    entity: str
    joint: str
    damping: float | None
    friction: float | None
    armature: float | None
    spring: float | None


@dataclass(frozen=True)
class Plan:
    """Everything that the templates print and the harness needs to know."""

    case: str
    dt: float
    steps: int
    every: int
    """Steps from one recorded frame to the next."""
    gravity: Vec
    seed: int
    max_speed: float
    settings: Settings
    statics: tuple[Group, ...]
    bodies: tuple[Group, ...]
    motors: tuple[Motor, ...]
    contact: dict[str, tuple[float, float]]
    """Time constant [s] and damping ratio of contacts by entity or link (`arm.hand`); empty unless a body bounces."""
    silent: tuple[str, ...]
    """Entities without a restitution, which take that of whatever hits them."""
    initial: dict[str, dict[str, float]]
    joint_velocities: dict[str, dict[str, float]]
    """Start positions of joints by entity, and start velocities other than zero."""
    velocities: tuple[StartVelocity, ...]
    drives: tuple[JointDrive, ...]
    wrenches: tuple[Wrench, ...]
    welds: tuple[Weld, ...]
    springs: tuple[Spring, ...]
    prescribed: tuple[Prescribed, ...]
    belts: tuple[Belt, ...]
    render: dict[str, Any]
    """Cameras, lights and cadence, resolved."""
    holds: tuple[Hold, ...]
    pushes: tuple[Push, ...]
    airflows: tuple[Airflow, ...]
    fields: tuple[Field, ...]
    frictions: tuple[Friction, ...]
    removals: tuple[Removal, ...]
    bonds: tuple[FaceBond, ...]
    watches: tuple[Watch, ...]
    """Each follows the one that it waits for (`after`)."""
    changes: tuple[JointChange, ...]
    """Of joints that came from files."""
    damped: dict[str, float]
    """Rates [1/s] at which free bodies lose velocity and spin, by entity."""
    unpowered: tuple[str, ...]
    """Entities whose joints the engine gives gains that nobody asked for."""
    files: Mapping[str, bytes]
    """Models and meshes by path inside the program's folder."""
    notes: tuple[str, ...]
    """Why derived settings are what they are."""
    warnings: tuple[Any, ...]
    """Problems that do not stop anything."""

    @cached_property
    def sim_digest(self) -> str:
        """Digest of everything that the simulation depends on."""
        return digests.sim_digest(self)

    @cached_property
    def render_digest(self) -> str:
        """Digest of what else the film depends on."""
        return digests.render_digest(self)

    @property
    def entities(self) -> list[EntityPlan]:
        """Entities of all statics and bodies, in order."""
        return [entity for group in (*self.statics, *self.bodies) for entity in group.entities]

    @property
    def deformables(self) -> dict[str, SoftRecord]:
        """Deformable bodies by copy, in order."""
        return {entity.name: entity.soft for entity in self.entities if entity.soft is not None}
