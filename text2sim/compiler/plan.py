"""The plan: a case with everything resolved, flat enough that templates only print it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from text2sim.compiler import digests
from text2sim.compiler.belts import Belt
from text2sim.compiler.literal import Code
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
class StartVelocity:
    """Initial velocity of a free body."""

    entity: str
    linear: Vec
    angular: Vec
    line: int
    control: str


@dataclass(frozen=True)
class DriveSegment:
    """What a joint follows from a time on; its mode is position, velocity or force."""

    start: float
    mode: str
    target: Code
    """Constructor of a function of time."""
    line: int
    control: str


@dataclass(frozen=True)
class JointDrive:
    """A joint, with targets that take over from each other."""

    entity: str
    joint: str
    segments: tuple[DriveSegment, ...]
    later: tuple["LaterDrive", ...] = ()


@dataclass(frozen=True)
class LaterDrive:
    """What a joint follows `when` an event happens, or from a time [s] on where events may come between."""

    when: str | float
    mode: str
    target: Code
    """Function of the target before it, which returns a function of time, or of the time since the event."""
    line: int
    control: str


@dataclass(frozen=True)
class Wrench:
    """A force and torque on a link over a span of time [s]."""

    entity: str
    link: str | None
    start: float
    end: float
    force: Vec
    torque: Vec
    scale: Code | None
    local: bool
    point: Vec | None
    line: int
    control: str


@dataclass(frozen=True)
class Weld:
    """A weld between two links that is made or undone at a time."""

    at: float
    on: bool
    a: str
    a_link: str | None
    b: str
    b_link: str | None
    line: int
    control: str
    event: str | None = None
    """The event whose first time undoes it, instead of `at`; None if there is none."""
    pivot: Vec | None = None
    """Point [m] in the frame of the first link about which the links turn freely; None for a rigid weld."""
    stiff: bool = False
    """Whether it gives even less than the engine's welds do."""


@dataclass(frozen=True)
class FaceBond:
    """Two bodies that are bonded at the face that they share, until the stress there is too high [Pa]."""

    a: str
    b: str
    center: Vec
    """Centre [m] of the face in the world, at the start."""
    normal: Vec
    """Unit vector from the first body to the second, likewise."""
    area: float
    """[m2]"""
    strength: float
    shear_strength: float
    line: int
    control: str


@dataclass(frozen=True)
class Friction:
    """Coefficient of friction between two sets of copies, or a link of each."""

    first: tuple[str, ...]
    first_link: str | None
    second: tuple[str, ...]
    second_link: str | None
    friction: float
    line: int


@dataclass(frozen=True)
class Removal:
    """A body that leaves the scene at a time [s], or at the first time of an event."""

    entity: str
    at: float | None
    event: str | None
    line: int
    control: str


@dataclass(frozen=True)
class Hold:
    """Points of a deformable body that are held from a time on [s]."""

    entity: str
    pose: tuple[Vec, Quaternion]
    """Of the copy, at the start."""
    region: Code
    """Constructor of a function that finds the points."""
    count: int | None
    """How many points; None for all."""
    to: tuple[str, ...]
    """Copies that hold them; none for the world."""
    link: str | None
    stiffness: float | None
    """[N/m] in all; None holds firmly."""
    both_ways: bool
    """Whether what holds them feels them."""
    start: float
    until: tuple[float | str, ...]
    """Times [s] and events, whichever comes first."""
    line: int
    control: str


@dataclass(frozen=True)
class Push:
    """A force on points of a deformable body over a span of time [s]; an impulse if start and end are equal."""

    entity: str
    pose: tuple[Vec, Quaternion]
    region: Code
    force: Vec
    """[N]; of an impulse [N s]."""
    scale: Code | None
    drag: float
    start: float
    end: float
    line: int
    control: str


@dataclass(frozen=True)
class Airflow:
    """Air that flows past a cloth over a span of time [s]."""

    entity: str
    velocity: Vec
    """[m/s]"""
    scale: Code | None
    strongest: float
    """Largest absolute value of the scale during the run."""
    gusts: float
    size: float
    seed: int
    start: float
    end: float
    line: int
    control: str


@dataclass(frozen=True)
class Field:
    """An acceleration that fills space, over a span of time [s]."""

    make: Code
    """Constructor."""
    start: float
    end: float
    line: int
    control: str
    scale: Code | None = None
    """Factor over time; None if it stays as it is."""
    drift: tuple[float, float, float] | None = None
    """Velocity [m/s] of the pattern; None if it stands still."""

    @property
    def changes(self) -> bool:
        """Whether it changes while it lasts."""
        return self.scale is not None or self.drift is not None


@dataclass(frozen=True)
class Watch:
    """An event that the program itself has to see, because something is released on it."""

    name: str
    make: Code
    """Constructor of what watches for it."""
    after: str | None
    """An event that has to come first, and is watched for too."""
    line: int


@dataclass(frozen=True)
class Prescribed:
    """A driven body: the joints that carry it, and where it is as functions of time."""

    entity: str
    joints: tuple[str, ...]
    position: tuple[Code, ...]
    """One function for each joint [m]; empty for a spin."""
    velocity: tuple[Code, ...]
    """For a spin: the function [rad/s]."""
    line: int


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
