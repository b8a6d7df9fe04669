"""Section `scene`: time, gravity, solvers and statics."""

from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from text2sim.spec_schema.models.base import Bool, Bounds, Integer, Model, Name, Pose, Positive, Real, Selector, Vec3
from text2sim.spec_schema.models.materials import Look, Material
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.repeat import Repeat
from text2sim.spec_schema.models.shapes import StaticShape
from text2sim.spec_schema.models.solvers import Fem, Ipc, Mpm, Pbd


class PairFriction(Model):
    """Friction between two bodies, instead of the larger of their own values."""

    between: tuple[Selector, Selector]
    """Two bodies or statics, or copies or links of them."""
    friction: Real = Field(ge=0.01, le=5.0)
    """Coulomb coefficient."""


class Contact(Model):
    """Contact between bodies. Values that are left out are derived from the scene; `check --settings` says why."""

    model: Literal["rigid", "particle", "sap", "ipc"] | None = None
    """Contact between the families of bodies. `rigid`: rigid bodies only. `particle`: rigid bodies with mpm and pbd
    bodies, in both directions. `sap`: rigid bodies with fem bodies, in double precision. `ipc`: rigid bodies with cloth
    and fem bodies, with friction; needs CUDA. By default the one that the bodies of the case need."""
    friction_cone: Literal["pyramidal", "elliptic"] | None = None
    """`elliptic` is Coulomb's law. `pyramidal` lets bodies creep on a slope and in a grip (the lint rule `creeps` says
    how fast), but survives hard impacts on chains and closed loops, and piles with the `cg` solver, for which
    `elliptic` ends in nan or lets stacks shift. By default `elliptic` in scenes of free bodies with slopes, leaning
    bodies or rolling friction, and where motors close parts of mechanisms on each other, with a free body in the
    scene."""
    timeconst: Positive | None = None
    """Time constant [s] with which the solver resolves a penetration; at least two substeps. Smaller is stiffer."""
    max_pairs: Annotated[Integer, Field(ge=1, le=1_000_000)] | None = None
    """Largest number of pairs of geometries in contact at once."""
    pairs: dict[Name, PairFriction] = Field(default_factory=dict)
    """Friction of pairs of rigid bodies, by any name: `ice: {between: [puck, rink], friction: 0.02}`. For other pairs
    the larger of their two coefficients applies. If several entries match a pair, the last one applies."""


class Solver(Model):
    """The constraint solver."""

    kind: Literal["newton", "cg"] | None = None
    """`newton` for few contacts, `cg` for more than about a hundred touching bodies, nets and long chains."""
    iterations: Annotated[Integer, Field(ge=1, le=1000)] | None = None
    """Iterations per substep."""
    tolerance: Positive | None = None
    """Relative improvement at which it stops."""
    noslip_iterations: Annotated[Integer, Field(ge=0, le=100)] = 0
    """Extra iterations against creeping, with the pyramidal cone: 10 stop bodies that need less than half of the
    available friction (tan of the slope below half the coefficient); others creep as before."""
    hibernation: Bool = False
    """Let bodies at rest sleep, which is faster for scenes that settle."""


class Record(Model):
    """Recording of a run."""

    rate: Positive | None = None
    """Recorded frames per simulated second, rounded to a whole number of time steps; by default 100, or 50 in a scene
    with deformable bodies, whose frames are large."""
    contacts: Bool = True
    """Record every contact of every time step."""


class Domain(Bounds):
    """The space in which the bodies are expected to stay; `left_domain` events refer to it."""


class Static(Model):
    """An object that never moves."""

    shape: StaticShape
    """Its shape."""
    material: Material = Material.model_construct()
    """Friction and restitution; its mass does not matter."""
    surface_velocity: Vec3 | None = None
    """Velocity [m/s] of the surface of a `box` in its own frame, as of a conveyor belt: the box stays in its place,
    and its friction carries what lies on it. At least one component is 0; the ends push at this speed. In path-traced
    films a repeating pattern moves along."""
    pose: Pose | None = None
    """Its pose; by default the origin."""
    place: Place | None = None
    """Instead of `pose`: its position relative to another static or body."""
    repeat: Repeat | None = None
    """A pattern of copies."""
    look: Look = Look.model_construct()
    """Colour and surface."""

    @field_validator("surface_velocity")
    @classmethod
    def _along_faces(cls, value: Vec3 | None, info: ValidationInfo) -> Vec3 | None:
        kind = getattr(info.data.get("shape"), "kind", "box")
        if value is not None and kind != "box":
            roller = "; a roller is a `driven` body with the motion `spin`" if kind in ("cylinder", "capsule") else ""
            raise ValueError(f"only the surface of a `box` can move, and this is a `{kind}`{roller}")
        if value is not None and all(value):
            raise ValueError("a surface moves along the faces of its box: at least one component is 0")
        return value

    @property
    def carries(self) -> bool:
        """Whether its surface moves."""
        return any(self.surface_velocity or ())


class Scene(Model):
    """The stage: time, gravity, solvers and statics."""

    duration: Positive = Field(le=600.0)
    """Simulated time [s]."""
    dt: Positive = Field(default=0.01, le=0.1)
    """Time step [s]."""
    substeps: Annotated[Integer, Field(ge=1, le=200)] | None = None
    """Solver steps in each time step. By default steps of at most 5 ms with two or more loose bodies, 2.5 ms with
    chains, nets and loops, 0.5 ms with restitution; shorter for taut ropes, and for bodies that are fast relative to
    the thinnest piece."""
    gravity: Vec3 = (0.0, 0.0, -9.81)
    """Acceleration [m/s2]."""
    seed: Annotated[Integer, Field(ge=0, le=2**31 - 1)] = 0
    """Seed of the engine."""
    max_speed: Positive | None = None
    """Speed [m/s] above which a body counts as diverged and the run stops, by default 1000. With deformable bodies,
    whose solvers do not check their own numbers, it is a few times the speed that the scene can produce
    (`check --settings`)."""
    contact: Contact = Contact.model_construct()
    """Contact between bodies."""
    solver: Solver = Solver.model_construct()
    """The constraint solver."""
    mpm: Mpm = Mpm.model_construct()
    """Solver of soft bodies, grains, liquids and snow."""
    pbd: Pbd = Pbd.model_construct()
    """Solver of cloth."""
    fem: Fem = Fem.model_construct()
    """Solver of soft bodies made of tetrahedra."""
    ipc: Ipc = Ipc.model_construct()
    """Solver of cloth and soft bodies under contact model ipc."""
    record: Record = Record.model_construct()
    """Recording of a run."""
    domain: Domain | None = None
    """The space in which the bodies are expected to stay."""
    statics: dict[Name, Static] = Field(default_factory=dict)
    """Objects that never move, by name."""
