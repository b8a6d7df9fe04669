"""Controls: actions on bodies."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    ByKind,
    Integer,
    Name,
    NonNegative,
    Positive,
    Seconds,
    Selector,
    Selectors,
    Vec3,
    Window,
    exactly_one_of,
)
from text2sim.spec_schema.models.colors import Color
from text2sim.spec_schema.models.fields import Acting, Airflow, Attraction, Drag, Turbulence, Vortex, Wind
from text2sim.spec_schema.models.motion import Schedule
from text2sim.spec_schema.models.regions import BodyRegion


class InitialVelocity(Acting):
    """The start velocity of a free body."""

    kind: Literal["initial_velocity"]
    body: Selector
    """A free rigid body, a ragdoll, or a deformable body; or its copies."""
    linear: Vec3 = (0.0, 0.0, 0.0)
    """Velocity of the centre of mass [m/s], in the world."""
    angular: Vec3 = (0.0, 0.0, 0.0)
    """Angular velocity [rad/s], in the world. Fragments (`repeat: {kind: fragments}`) turn as one body, unless only
    some are selected."""


class Impulse(Acting):
    """An impulse within one time step."""

    kind: Literal["impulse"]
    body: Selector
    """A body, or one link of it (`arm.hand`)."""
    impulse: Vec3
    """[N s], in the world."""
    at: Seconds
    """Time [s]."""
    point: Vec3 | BodyRegion | None = None
    """Where it acts: a point [m] or region in the body's frame; by default the centre of mass."""


class Force(Acting):
    """A force on a body over a span of time."""

    kind: Literal["force"]
    body: Selector
    """A body, or one link of it; or a deformable body."""
    force: Vec3
    """The force [N]; multiplied by `scale`. On a deformable body it is distributed by mass, so that all points of the
    region get the same acceleration."""
    scale: Schedule = 1.0
    """Factor that may change with time."""
    during: Window | None = None
    """Start and end [s]; by default the whole run."""
    frame: Literal["world", "body"] = "world"
    """The frame of `force`."""
    point: Vec3 | BodyRegion | None = None
    """Where it acts: a point [m] or region in the body's frame, moving with it; by default the centre of mass. For
    rigid bodies."""
    region: BodyRegion | None = None
    """For deformable bodies: the part that it acts on, chosen at the start and moving with it; by default the whole
    body."""
    drag: NonNegative = 0.0
    """For deformable bodies: resistance [N s/m] to the velocity of that part while the force acts, which limits it to
    `force / drag`. It acts on each point by its mass: one that is faster is slowed down."""


class Torque(Acting):
    """A torque on a body over a span of time."""

    kind: Literal["torque"]
    body: Selector
    """A body, or one link of it."""
    torque: Vec3
    """The torque [N m]; multiplied by `scale`."""
    scale: Schedule = 1.0
    """Factor that may change with time."""
    during: Window | None = None
    """Start and end [s]; by default the whole run."""
    frame: Literal["world", "body"] = "world"
    """The frame of `torque`."""


class Drive(Acting):
    """A target for a joint's actuator, until another drive of the same joint begins.

    A drive begins at the `start` or first time of its target. Before the first begins, the actuator holds the start
    position, zero velocity, or zero force. The actuator of a joint without any drive does nothing.
    """

    kind: Literal["drive"]
    joint: Selector
    """A mounted body (`drum`), its copies (`hook[*]`), or a joint of an articulated body (`arm.elbow`), or several
    (`dog.*_hip`)."""
    position: Schedule | None = None
    """Target [rad or m], relative to the pose in the case, or for a body from a file to the file's zero; needs
    `stiffness`."""
    velocity: Schedule | None = None
    """Target [rad/s or m/s]; needs `damping`."""
    force: Schedule | None = None
    """Force [N] or torque [N m], whatever the gains; 0 disconnects the motor."""
    on: Name | None = None
    """Name of an event (see `release`): the drive begins at its first time, from which the times of the target count. A
    ramp without `from` starts at the previous target."""

    _one_target = exactly_one_of("position", "velocity", "force")


class Reach(Acting):
    """Positions of a link, converted to targets of its joints by inverse kinematics.

    All hinges and sliders from the world to that link move, and their actuators need a stiffness. They stop at each
    target; like drives, they replace earlier ones. A loaded joint sags by load over stiffness, as with every drive. A
    target out of reach is an error of `check`.
    """

    kind: Literal["reach"]
    body: Selector
    """The link (`arm.hand`)."""
    times: list[Seconds] = Field(min_length=1, max_length=100)
    """Times of the targets [s], ascending."""
    positions: list[Vec3] = Field(min_length=1, max_length=100)
    """Positions [m] in the world, one for each time."""
    euler_deg: Vec3 | list[Vec3] | None = None
    """Orientations of the link's frame [deg], one for all or one for each: rotations about the world's x, then y, then
    z axis. By default any."""
    point: Vec3 = (0.0, 0.0, 0.0)
    """The point of the link, in its frame [m], such as the tip of a tool."""
    start: Seconds = 0.0
    """Start of the motion to the first target [s]."""
    ease: Literal["linear", "smooth"] = "smooth"
    """Motion of the joints between targets; `smooth` starts and ends at rest."""

    @model_validator(mode="after")
    def _one_for_each(self) -> "Reach":
        counts = {"positions": len(self.positions)}
        if isinstance(self.euler_deg, list):
            counts["euler_deg"] = len(self.euler_deg)
        for key, count in counts.items():
            if count != len(self.times):
                raise ValueError(f"times and {key} must have the same length (got {len(self.times)} and {count})")
        if any(b <= a for a, b in pairwise([self.start, *self.times])):
            raise ValueError("times must be ascending, and the first must be later than start")
        return self

    @property
    def turns(self) -> list[Vec3] | None:
        """Orientation at each target [deg]; None for any."""
        return [self.euler_deg] * len(self.times) if isinstance(self.euler_deg, tuple) else self.euler_deg


class Attach(Acting):
    """An attachment of two bodies from a time on.

    They keep their relative pose of that time, or, if they are rigid, turn about a `pivot`. Two links that are attached
    do not collide, other links of the two bodies do. Soft bodies and cloth are attached by points: pins, hooks, clamps.
    A soft body (mpm) pulls its holder, and cloth (pbd) does, unless that is driven or has a motor; fem bodies do not.
    Cloth is sewn to cloth, also to itself, by threads as long as its points are apart.
    """

    kind: Literal["attach"]
    body: Selector
    """The attached body, or one link of it."""
    region: BodyRegion | None = None
    """For deformable bodies: the attached part; by default the whole body."""
    points: Annotated[Integer, Field(ge=1, le=10_000)] | None = None
    """For deformable bodies: number of points of the region, evenly distributed; by default all. With several copies in
    `to`, each holds the nearest."""
    to: Selector
    """The holder: a body, static or link, or `world`, which holds the body where it is. Copies pair one to one, or all
    with the one; several copies hold one deformable body together."""
    to_region: BodyRegion | None = None
    """For deformable bodies, cloth sewn to cloth: the part of `to` in which each point is sewn to the nearest one."""
    pivot: Vec3 | BodyRegion | None = None
    """Of rigid bodies: point [m] or region of `body`, in its frame, about which it turns freely, as on a hook."""
    stiffness: Positive | None = None
    """For mpm and fem bodies: total stiffness [N/m] of springs that hold the points. Without, they are held firmly."""
    strength: Positive | None = None
    """Force [N] at which it breaks: of rigid bodies held from the start on, or of cloth (pbd), in all at a holder."""
    at: Seconds = 0.0
    """Time [s]."""


class Spring(Acting):
    """A coil spring or an elastic cord between points of two bodies.

    It pulls its ends together with the force `stiffness (d - length) + damping d'`, d being their distance. It has no
    mass and touches nothing; films show it. The force is worked out once in each `scene.dt`, not in its substeps: a
    stiff spring on a light body needs a short one.
    """

    kind: Literal["spring"]
    body: Selector
    """A rigid or articulated body, or one link of it (`arm.hand`, `rope.link_0`)."""
    point: Vec3 | BodyRegion = (0.0, 0.0, 0.0)
    """Its end on it: a point [m] or region in the body's frame."""
    to: Selector
    """What it pulls that body to: another body, a static or a link. Copies pair one to one, or all with the one."""
    to_point: Vec3 | BodyRegion = (0.0, 0.0, 0.0)
    """Its end on that, likewise."""
    stiffness: Positive
    """[N/m]. A mass m hangs `m g / stiffness` lower on it, and swings with the period `2 pi sqrt(m / stiffness)`."""
    damping: NonNegative = 0.0
    """[N s/m]. With `2 sqrt(stiffness m)` it does not swing."""
    length: NonNegative | None = None
    """Length [m] without load; by default the distance of its ends as it begins."""
    form: Literal["coil", "cord"] = "coil"
    """A `coil` also pushes. A `cord`, such as a rubber band, does not, and hangs slack between ends that are near."""
    radius: Positive | None = None
    """Radius [m] of the coil or cord as it is drawn; by default 0.09 of its length, or 0.012 of a cord's."""
    color: Color | None = None
    """By default that of steel, or of rubber."""
    during: Window | None = None
    """Start and end [s]; by default the whole run."""


class Release(Acting):
    """The end of an `attach`, at a time or at an event."""

    kind: Literal["release"]
    attach: Name
    """The name of the control that attached it."""
    at: Seconds | None = None
    """Time [s]."""
    on: Name | None = None
    """Name of an event: at its first time after the attachment. One that the program detects during the run: contact or
    rest (known after its `for`) of rigid bodies, a region entered or left, a release or removal, a threshold of a
    position, displacement, velocity, speed, distance or joint_position."""

    _one_moment = exactly_one_of("at", "on")


class Remove(Acting):
    """The removal of a body from the scene, at a time or at an event.

    It is permanent. The body is disabled: nothing touches or moves it, and no picture shows it. Bodies attached to it
    become free, its measures have no values from then on, and it is in no region. Evidence lists the time under
    `removed`.
    """

    kind: Literal["remove"]
    body: Selector
    """A rigid or articulated body, a driven body or a static, or copies of one."""
    at: Seconds | None = None
    """Time [s]."""
    on: Name | None = None
    """Name of an event: at its first time. The program has to detect it, as for `release`."""

    _one_moment = exactly_one_of("at", "on")


class Bond(Acting):
    """Bonds between rigid bodies that touch face to face at the start.

    Mortar, glue, or what holds a body together that will shatter (`repeat: {kind: fragments}`). Neighbours keep their
    relative pose, and do not collide, until their bond breaks. For the force and the moment that it carries, on a round
    face of the same area A and radius R, that is when the tension `F / A + 4 M / (pi R^3)` reaches `strength` or the
    shear stress `V / A + 2 T / (pi R^3)` reaches `shear_strength`. Bonds are as stiff as their faces are large.
    Contacts last some 10 ms here, so that blows are softer than real ones: 0.1e6 to 1e6 Pa for what a thrown ball or
    a fall of a metre shall break. Evidence lists under `bonds` what broke, and the largest load as a fraction of the
    strength; the measure `pieces` counts what still hangs together.
    """

    kind: Literal["bond"]
    of: Selectors
    """The bodies: rigid or driven ones and statics, or copies; all neighbours among them are bonded. For
    a link, use `attach` with `strength`."""
    strength: Positive
    """Tensile strength [Pa]."""
    shear_strength: Positive | None = None
    """Shear strength [Pa]; `strength` by default."""
    gap: NonNegative = Field(default=0.0005, le=0.1)
    """Largest distance [m] between faces that are bonded."""


Control = Annotated[
    InitialVelocity
    | Impulse
    | Force
    | Torque
    | Drive
    | Reach
    | Attach
    | Spring
    | Release
    | Remove
    | Bond
    | Wind
    | Airflow
    | Drag
    | Attraction
    | Vortex
    | Turbulence,
    ByKind(),
]
