"""Section `bodies`: everything that moves."""

from typing import Annotated, Any, Literal, get_args

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import (
    Axis,
    Bool,
    ByKind,
    Fraction,
    Integer,
    Length,
    Model,
    Multiple,
    Name,
    Names,
    NonNegative,
    Pose,
    Range,
    Real,
    Size2,
    Vec3,
)
from text2sim.spec_schema.models.materials import Actuator, JointDynamics, Look, Material
from text2sim.spec_schema.models.motion import Motion
from text2sim.spec_schema.models.placed import Linked, Placed
from text2sim.spec_schema.models.shapes import Shape, SolidShape
from text2sim.spec_schema.models.soft_bodies import Beam, Cloth, Granular, Liquid, Rope, Snow, Soft


class FreeMount(Model):
    """The body moves freely."""

    kind: Literal["free"]
    damping: NonNegative = 0.0
    """Rate [1/s] at which velocity and spin decay: `v' = -damping v`. Falling, it approaches `g / damping`."""


class FixedMount(Model):
    """The body is fixed in the world."""

    kind: Literal["fixed"]


class HingeMount(JointDynamics):
    """The body turns about an axis that is fixed in the world."""

    kind: Literal["hinge"]
    axis: Axis = "z"
    """Axis in the body's frame."""
    anchor: Vec3 = (0.0, 0.0, 0.0)
    """A point [m] of the axis in the body's frame."""
    range_deg: Range | None = None
    """Limits [deg] of the angle from the start; none if left out."""
    initial_velocity: Real = 0.0
    """Speed at the start [rad/s]."""
    actuator: Actuator | None = None
    """The motor that a `drive` needs."""


class SliderMount(JointDynamics):
    """The body slides along an axis that is fixed in the world."""

    kind: Literal["slider"]
    axis: Axis = "z"
    """Direction in the body's frame."""
    range: Range | None = None
    """Limits [m] of the travel from the start; none if left out."""
    initial_velocity: Real = 0.0
    """Speed at the start [m/s]."""
    actuator: Actuator | None = None
    """The motor that a `drive` needs."""


class BallMount(JointDynamics):
    """The body turns freely about a point that is fixed in the world."""

    kind: Literal["ball"]
    anchor: Vec3 = (0.0, 0.0, 0.0)
    """The point [m] in the body's frame."""


Mount = Annotated[FreeMount | FixedMount | HingeMount | SliderMount | BallMount, ByKind()]


def _gives_energy(joint: Any) -> bool:
    return bool(getattr(joint, "actuator", None) or getattr(joint, "spring", 0.0))


class Rigid(Placed):
    """One rigid body."""

    kind: Literal["rigid"]
    shape: Shape
    """Its shape."""
    material: Material = Material.model_construct()
    """Mass and contact."""
    mount: Mount = FreeMount.model_construct(kind="free")
    """Its connection to the world, such as `{kind: fixed}`."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return self.mount.kind == "free"

    @property
    def passive(self) -> bool:
        """Whether it can only lose energy by itself."""
        return not _gives_energy(self.mount)


class Driven(Placed):
    """A body with prescribed motion: listed in the evidence, never subject of an event.

    It pushes what can move, and passes through what cannot: the ground, statics, bodies with a fixed mount, other
    driven bodies. Evidence says how far it came off its path, which takes loads of tonnes, and what is
    jammed against something that cannot move.
    """

    kind: Literal["driven"]
    shape: Shape
    """Its shape."""
    material: Material = Material.model_construct()
    """Contact; its mass does not matter."""
    motion: Motion
    """Its motion."""


class HingeJoint(HingeMount):
    """The link turns about an axis of its parent."""


class SliderJoint(SliderMount):
    """The link slides along an axis of its parent."""


class BallJoint(BallMount):
    """The link turns freely about a point of its parent."""


class FixedJoint(Model):
    """The link is part of its parent."""

    kind: Literal["fixed"]


Joint = Annotated[HingeJoint | SliderJoint | BallJoint | FixedJoint, ByKind()]


class Link(Model):
    """One link of a tree."""

    parent: Name | None = None
    """Its parent link; exactly one link, the root, has none."""
    shape: Shape
    """Its shape."""
    pose: Pose = Pose.model_construct()
    """Its frame in the parent's frame, at the start (the root: in the body's frame)."""
    joint: Joint | None = None
    """The joint to its parent, named like the link; the root has none (see `base`)."""
    material: Material | None = None
    """If it differs from the body's."""
    look: Look | None = None
    """If it differs from the body's."""
    repeat: Multiple | None = None
    """Number of such links, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each.
    With `parent: "NAME_${k - 1}"` they form a chain, and number 0 is the root, without a joint."""


class Loop(Model):
    """A constraint between two links or joints: it closes a loop of links, or gears joints together."""

    kind: Literal["connect", "weld", "gear"] = "connect"
    """`connect` joins one point, `weld` the whole frame. `gear` couples the hinges or sliders of the two links, as
    ideal teeth, a rack, a belt or the works of a dial do: the first is at `ratio` times the position of the second, and
    each feels the load of the other."""
    between: tuple[Name, Name]
    """Two links; with `connect` and `weld`, `world` may be the second."""
    anchor: Vec3 = (0.0, 0.0, 0.0)
    """With `connect` and `weld`: the point [m] in the first link's frame."""
    ratio: Real | None = None
    """With `gear`: position of the first link's joint per that of the second's, negative if it turns the other way: -2
    for 20 teeth on 40, 1/r [rad/m] for a pinion of radius r on a rack."""

    @model_validator(mode="after")
    def _fields_of_kind(self) -> "Loop":
        if self.kind == "gear":
            if not self.ratio:
                raise ValueError("gear needs a ratio other than 0: position of the first joint per that of the second")
            if any(self.anchor):
                raise ValueError("a gear couples joints and has no anchor")
        elif self.ratio is not None:
            raise ValueError(f"ratio belongs to kind gear, not to {self.kind}")
        return self


class JointOverride(Model):
    """Changes to a joint from a file; missing fields keep the values of the file."""

    damping: NonNegative | None = None
    """Viscous damping [N s/m for a slider, N m s/rad for a hinge or ball]."""
    friction: NonNegative | None = None
    """Dry friction of the joint [N or N m]."""
    armature: NonNegative | None = None
    """Inertia of the rotor that is added to the joint [kg or kg m2]."""
    spring: NonNegative | None = None
    """Stiffness of a spring to the position zero [N/m or N m/rad]."""
    actuator: Actuator | None = None
    """The motor that a `drive` needs, instead of the file's. Without `max_force`, the limit of the file (`effort`,
    `forcerange`) applies."""


class Articulated(Placed):
    """Links, joints, closed loops and gears: written here, or read from an MJCF or URDF file.

    A file determines masses, self-collision, start pose and motors, and colours unless `look.color` is given. Links and
    joints have the names of the file (in MJCF a joint without a name has that of its link). An MJCF file also
    determines friction, unless `material.friction` is given; a URDF has none, so `material.friction` applies to all of
    it, and `material.density` to links without inertial. A joint of a URDF has no motor unless `joints` gives it one.
    Meshes collide by their convex hulls.
    """

    kind: Literal["articulated"]
    base: Literal["fixed", "free"] | None = None
    """Whether the root link is fixed in the world; by default `fixed`, and with an MJCF file as in the file."""
    links: dict[Name, Link] | None = Field(default=None, min_length=1, max_length=500)
    """The tree, by name of link."""
    file: str | None = Field(default=None, max_length=200)
    """Path inside the case's folder: .xml (MJCF) or .urdf; its meshes must be in the folder, too. The prefix `genesis:`
    means the engine's own assets. Instead of `links`."""
    joints: dict[Names, JointOverride] = Field(default_factory=dict)
    """With `file`: changes to its joints, by name or pattern (`"*_hip"`); names override patterns."""
    material: Material = Material.model_construct()
    """Material of links without their own."""
    loops: dict[Name, Loop] = Field(default_factory=dict)
    """Constraints that close loops of links, or gear joints together."""
    initial: dict[Names, Real] = Field(default_factory=dict)
    """Start position of hinge [rad] and slider [m] joints by name or pattern."""
    self_collision: Bool | None = None
    """With `links`: whether links that are not neighbours collide; by default false."""

    @model_validator(mode="after")
    def _one_source(self) -> "Articulated":
        if (self.links is None) == (self.file is None):
            raise ValueError("give either links or file")
        return self

    @property
    def passive(self) -> bool:
        """Whether it can only lose energy by itself; of a file, that is not known."""
        known = self.links is not None and not self.loops
        return known and not any(_gives_energy(link.joint) for link in (self.links or {}).values())


class Payload(Model):
    """A load at the end of a chain."""

    shape: SolidShape
    """Its shape."""
    material: Material = Material.model_construct()
    """Mass and contact."""
    look: Look | None = None
    """Colour and surface, if they differ from the chain's."""


class Chain(Linked):
    """Capsule links on ball joints that hang from a point of the world; the pose is that of the point.

    Its links are `link_0` (the upper one) to `link_N`, and `payload`; each has its frame at its upper joint and extends
    along its own -z. It does not stretch.
    """

    kind: Literal["chain"]
    links: Annotated[Integer, Field(ge=1, le=200)]
    """Number of links."""
    link_length: Length
    """Distance [m] between neighbouring joints."""
    radius: Length
    """Radius [m] of the bars."""
    direction: Axis = (0.0, 0.0, -1.0)
    """Direction at the start, from its upper end."""
    anchored: Bool = True
    """Whether its upper end is fixed in the world."""
    payload: Payload | None = None
    """A load at the end."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Every joint; by default, damping is 0.05 m L^2 per second and armature 0.02 m L^2, with mass m and length L of a
    link. With a payload, the armature is at least 2e-6 of its mass times the square of the chain's length, or rounding
    makes the chain fly apart. Attached at both ends and slack, it may fly apart with substeps of 2.5 ms; 0.8 ms, or 50
    times the damping, keep it stable."""
    material: Material = Material.model_construct(density=7800.0)
    """Material of the bars."""

    @model_validator(mode="after")
    def _slender(self) -> "Chain":
        if self.link_length < 2 * self.radius:
            sizes = f"{self.link_length:g} and {self.radius:g}"
            raise ValueError(f"link_length must be at least twice the radius (got {sizes})")
        return self

    @property
    def passive(self) -> bool:
        """Whether it can only lose energy by itself."""
        return not self.joint.spring


class Net(Linked):
    """A rectangular net of capsule links and ball joints in the x-y plane, with edges fixed in the world.

    Strands do not stretch: a load pulls a net hardly deeper than its `sag`. The strands along x are `x1`, `x2`, … from
    the -y edge, those along y `y1`, … from the -x edge; their links are `x1_0`, `x1_1`, … from the strand's first end,
    each with its frame there and the net's axes.
    """

    kind: Literal["net"]
    cells: tuple[Annotated[Integer, Field(ge=2, le=20)], Annotated[Integer, Field(ge=2, le=20)]]
    """Meshes along x and y."""
    size: Size2
    """Lengths [m] along x and y."""
    sag: NonNegative = 0.0
    """Depth [m] of its centre below its edges at the start; a net that is built flat stays flat."""
    radius: Length
    """Radius [m] of the strands."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Every joint; by default, damping is 8 m L^2 per second and armature 0.4 m L^2, with mass m and length L of a
    link."""
    material: Material = Material.model_construct()
    """Material of the strands."""

    @model_validator(mode="after")
    def _open(self) -> "Net":
        mesh = min(length / cells for length, cells in zip(self.size, self.cells, strict=True))
        if mesh <= 2 * self.radius:
            raise ValueError(f"the strands are too thick for its meshes (got radius {self.radius:g}, meshes {mesh:g})")
        return self


class Ragdoll(Linked):
    """A doll of eleven capsules on ball joints. Its frame is at the pelvis, z along the spine, x forward.

    Links: pelvis, chest, head, arm_l, forearm_l, thigh_l, shin_l, and the same with _r; left is +y. With the height h,
    the chest is 0.15 h thick, thighs 0.086 h, forearms 0.05 h; the volume is 0.0165 h^3: 88 kg for 1.75 m at
    1000 kg/m3.
    """

    kind: Literal["ragdoll"]
    height: Length
    """Height [m]."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Every joint; damping and armature are derived by default."""
    material: Material = Material.model_construct()
    """Material of the whole ragdoll."""
    limb_spread: Fraction = 0.3
    """0: arms and legs straight down; 1: spread wide."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return True


Body = Annotated[
    Rigid | Driven | Articulated | Chain | Net | Ragdoll | Soft | Cloth | Rope | Beam | Granular | Liquid | Snow,
    ByKind(),
]
LINKED = tuple(
    get_args(model.model_fields["kind"].annotation)[0]
    for model in get_args(get_args(Body)[0])
    if issubclass(model, Linked | Articulated)
)
"""Kinds of bodies that can be trees of several joints."""
