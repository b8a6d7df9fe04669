"""Section `scene`: time, gravity, solver, and what never moves."""

from typing import Annotated, Literal

from pydantic import Field

from text2sim.spec_schema.models.base import Bool, Bounds, Integer, Model, Name, Pose, Positive, Real, Selector, Vec3
from text2sim.spec_schema.models.materials import Look, Material
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.repeat import Repeat
from text2sim.spec_schema.models.shapes import StaticShape
from text2sim.spec_schema.models.solvers import Fem, Ipc, Mpm, Pbd


class PairFriction(Model):
    """Friction between two bodies that is not the larger of their own."""

    between: tuple[Selector, Selector]
    """Two bodies or statics, or copies or links of them."""
    friction: Real = Field(ge=0.01, le=5.0)
    """Coulomb coefficient."""


class Contact(Model):
    """How bodies touch. What is left out is derived from the scene, and `check --settings` says why."""

    model: Literal["rigid", "particle", "sap", "ipc"] | None = None
    """Contact between the families of bodies. `rigid`: of rigid bodies alone. `particle`: rigid bodies with mpm and
    pbd bodies, both ways. `sap`: rigid bodies with fem bodies, in double precision. `ipc`: rigid bodies with cloth and
    fem bodies, with friction; needs CUDA. If left out, what the bodies of the case need."""
    friction_cone: Literal["pyramidal", "elliptic"] | None = None
    """`elliptic` is Coulomb's law. `pyramidal` lets what rests on a slope creep (the lint `creeps` says how fast), but
    survives hard impacts on trees of links, and piles with the `cg` solver, in which `elliptic` ends in nan or lets
    stacks shift. If left out, `elliptic` in scenes of free bodies with slopes or with bodies that lean."""
    timeconst: Positive | None = None
    """Time [s] in which the solver undoes a penetration; at least two substeps. Smaller is stiffer."""
    max_pairs: Annotated[Integer, Field(ge=1, le=1_000_000)] | None = None
    """How many pairs of geometries may touch at once."""
    pairs: dict[Name, PairFriction] = Field(default_factory=dict)
    """Friction of pairs of rigid bodies, by names of your own: `ice: {between: [puck, rink], friction: 0.02}`. Other
    pairs rub with the larger of their two coefficients. Where several mean the same pair, the last counts."""


class Solver(Model):
    """The constraint solver."""

    kind: Literal["newton", "cg"] | None = None
    """`newton` for few contacts, `cg` for more than about a hundred touching bodies, nets and long chains."""
    iterations: Annotated[Integer, Field(ge=1, le=1000)] | None = None
    """Iterations per substep."""
    tolerance: Positive | None = None
    """Relative improvement at which it stops."""
    noslip_iterations: Annotated[Integer, Field(ge=0, le=100)] = 0
    """Extra iterations against creeping, with the pyramidal cone: 10 stop what friction holds with less than half of
    what it could (tan of the slope below half the coefficient); what needs more creeps on as before."""
    hibernation: Bool = False
    """Let bodies that came to rest sleep: faster for scenes that settle."""


class Record(Model):
    """What a run keeps."""

    rate: Positive | None = None
    """Recorded frames per simulated second, rounded to a whole number of time steps; 100 if left out, 50 in a scene
    with deformable bodies, whose frames are large."""
    contacts: Bool = True
    """Keep every contact of every time step."""


class Domain(Bounds):
    """The space in which the bodies are expected to stay; `left_domain` events refer to it."""


class Static(Model):
    """Something that never moves."""

    shape: StaticShape
    """What it is shaped like."""
    material: Material = Material.model_construct()
    """Friction and bounce; it needs no mass."""
    pose: Pose | None = None
    """Where it is; the origin if left out."""
    place: Place | None = None
    """Where it is, said in relation to another static or body."""
    repeat: Repeat | None = None
    """Make several copies."""
    look: Look = Look.model_construct()
    """Colour and surface."""


class Scene(Model):
    """The stage: time, gravity, solver, and what never moves."""

    duration: Positive = Field(le=600.0)
    """Simulated time [s]."""
    dt: Positive = Field(default=0.01, le=0.1)
    """Time step [s]."""
    substeps: Annotated[Integer, Field(ge=1, le=200)] | None = None
    """Solver steps in each time step. If left out, steps of at most 5 ms with two loose bodies or more, 2.5 ms with
    chains, nets and loops, 0.5 ms with restitution; shorter for taut ropes, and for what is fast
    against the thinnest piece."""
    gravity: Vec3 = (0.0, 0.0, -9.81)
    """Acceleration [m/s2]."""
    seed: Annotated[Integer, Field(ge=0, le=2**31 - 1)] = 0
    """Seed of the engine."""
    max_speed: Positive | None = None
    """A body faster than this [m/s] counts as diverged, and the run stops: 1000 if left out; with deformable bodies,
    whose solvers do not look at their own numbers, some times what the scene can give (`check --settings`)."""
    contact: Contact = Contact.model_construct()
    """How bodies touch."""
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
    """What a run keeps."""
    domain: Domain | None = None
    """The space in which the bodies are expected to stay."""
    statics: dict[Name, Static] = Field(default_factory=dict)
    """What never moves, by name."""
