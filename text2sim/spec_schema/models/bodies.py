"""Section `bodies`: everything that moves."""

from typing import Annotated, Literal, get_args

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
from text2sim.spec_schema.models.soft_bodies import Cloth, Granular, Liquid, Rope, Snow, Soft


class FreeMount(Model):
    """The body moves freely."""

    kind: Literal["free"]


class FixedMount(Model):
    """The body is held by the world."""

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
    actuator: Actuator | None = None
    """The motor that a `drive` needs."""


class SliderMount(JointDynamics):
    """The body slides along an axis that is fixed in the world."""

    kind: Literal["slider"]
    axis: Axis = "z"
    """Direction in the body's frame."""
    range: Range | None = None
    """Limits [m] of the travel from the start; none if left out."""
    actuator: Actuator | None = None
    """The motor that a `drive` needs."""


class BallMount(JointDynamics):
    """The body turns freely about a point that is fixed in the world."""

    kind: Literal["ball"]
    anchor: Vec3 = (0.0, 0.0, 0.0)
    """The point [m] in the body's frame."""


Mount = Annotated[FreeMount | FixedMount | HingeMount | SliderMount | BallMount, ByKind()]


class Rigid(Placed):
    """One rigid body."""

    kind: Literal["rigid"]
    shape: Shape
    """What it is shaped like."""
    material: Material = Material.model_construct()
    """Mass and contact."""
    mount: Mount = FreeMount.model_construct(kind="free")
    """How it hangs in the world, as `{kind: fixed}`."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return self.mount.kind == "free"


class Driven(Placed):
    """A body with prescribed motion: named in the evidence, never subject of an event.

    It pushes what can move, and passes through what cannot: the ground, statics, bodies with a fixed mount, other
    driven bodies. Evidence says how far it came off its path, which only loads of tonnes bring about.
    """

    kind: Literal["driven"]
    shape: Shape
    """What it is shaped like."""
    material: Material = Material.model_construct()
    """Contact; its mass does not matter."""
    motion: Motion
    """How it moves."""


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
    """The link it hangs on; exactly one link, the root, has none."""
    shape: Shape
    """What the link is shaped like."""
    pose: Pose = Pose.model_construct()
    """Its frame in the parent's frame, at the start (the root: in the body's frame)."""
    joint: Joint | None = None
    """The joint to its parent, named like the link; the root has none (see `base`)."""
    material: Material | None = None
    """If it differs from the body's."""
    look: Look | None = None
    """If it differs from the body's."""
    repeat: Multiple | None = None
    """So many of these links, called `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each.
    With `parent: "NAME_${k - 1}"` each hangs on the one before, and number 0 is the root, without a joint."""


class Loop(Model):
    """A constraint that closes a loop of links."""

    kind: Literal["connect", "weld"] = "connect"
    """`connect` holds one point together, `weld` the whole frame."""
    between: tuple[Name, Name]
    """Two links; `world` may be the second."""
    anchor: Vec3 = (0.0, 0.0, 0.0)
    """The point [m] in the first link's frame."""


class JointOverride(Model):
    """Changes to a joint that came from a file; what is left out stays as the file has it."""

    damping: NonNegative | None = None
    """Viscous damping [N s/m for a slider, N m s/rad for a hinge or ball]."""
    friction: NonNegative | None = None
    """Dry friction of the joint [N or N m]."""
    armature: NonNegative | None = None
    """Inertia of the rotor that is added to the joint [kg or kg m2]."""
    spring: NonNegative | None = None
    """Stiffness of a spring to the position zero [N/m or N m/rad]."""
    actuator: Actuator | None = None
    """The motor that a `drive` needs, instead of the file's. Without `max_force` the limit of the file
    (`effort`, `forcerange`) holds."""


class Articulated(Placed):
    """Links and joints: written here, or read from an MJCF or URDF file.

    A file decides about its masses, its inner contacts, its start pose and its motors, and about its colours
    unless `look.color` is given. Links and joints go by the names in the file (in MJCF a joint without a name
    goes by that of its link). An MJCF file decides about friction as well, unless `material.friction` is
    given; a URDF has none, so that `material.friction` holds for all of it, and `material.density` for links
    without inertial. A joint of a URDF has no motor unless `joints` gives it one. Meshes touch by their
    convex hulls.
    """

    kind: Literal["articulated"]
    base: Literal["fixed", "free"] | None = None
    """Whether the root link is held by the world; `fixed` if left out, but with an MJCF file as the file has
    it."""
    links: dict[Name, Link] | None = Field(default=None, min_length=1, max_length=500)
    """The tree, by name of link."""
    file: str | None = Field(default=None, max_length=200)
    """Path inside the case's folder: .xml (MJCF) or .urdf; its meshes must lie in the folder, too. `genesis:` before
    the path means the engine's own assets. Instead of `links`."""
    joints: dict[Names, JointOverride] = Field(default_factory=dict)
    """With `file`: changes to its joints, by their names, or of many by a pattern (`"*_hip"`), which names overrule."""
    material: Material = Material.model_construct()
    """Of every link that has none of its own."""
    loops: dict[Name, Loop] = Field(default_factory=dict)
    """Constraints that close loops."""
    initial: dict[Names, Real] = Field(default_factory=dict)
    """Start position of hinge [rad] and slider [m] joints by name or pattern."""
    self_collision: Bool | None = None
    """With `links`: let links that are not neighbours touch each other; false if left out."""

    @model_validator(mode="after")
    def _one_source(self) -> "Articulated":
        if (self.links is None) == (self.file is None):
            raise ValueError("give either links or file")
        return self


class Payload(Model):
    """What hangs at the end of a chain."""

    shape: SolidShape
    """What it is shaped like."""
    material: Material = Material.model_construct()
    """Mass and contact."""
    look: Look | None = None
    """Colour and surface, if they differ from the chain's."""


class Chain(Linked):
    """Capsule links on ball joints, hung from a point of the world; pose is that of the point.

    Its links are `link_0` (the upper one) to `link_N`, and `payload`; each has its frame at its upper joint and runs
    along its own -z. It does not stretch.
    """

    kind: Literal["chain"]
    links: Annotated[Integer, Field(ge=1, le=200)]
    """How many links."""
    link_length: Length
    """Distance [m] between neighbouring joints."""
    radius: Length
    """Radius [m] of the bars."""
    direction: Axis = (0.0, 0.0, -1.0)
    """Direction in which it is stretched at the start, from its upper end."""
    anchored: Bool = True
    """Held by the world at its upper end."""
    payload: Payload | None = None
    """What hangs at the end."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Of every joint; of what is left out, damping is 0.05 m L^2 per second and armature 0.02 m L^2, with mass m and
    length L of a link. With a payload, the armature is at least 2e-6 of the payload's mass times the square of the
    chain's length: less is lost in rounding beside a heavy payload, and the chain flies apart."""
    material: Material = Material.model_construct(density=7800.0)
    """Of the bars."""

    @model_validator(mode="after")
    def _slender(self) -> "Chain":
        if self.link_length < 2 * self.radius:
            sizes = f"{self.link_length:g} and {self.radius:g}"
            raise ValueError(f"link_length must be at least twice the radius (got {sizes})")
        return self


class Net(Linked):
    """A rectangular net of capsule links and ball joints in the x-y plane, its edges held by the world.

    Strands do not stretch: what falls into a net pulls it hardly deeper than `sag` built it. The strands along x are
    `x1`, `x2`, … from the -y edge, those along y `y1`, … from the -x edge; their links are `x1_0`, `x1_1`, … from the
    strand's first end, each with its frame there and the net's axes.
    """

    kind: Literal["net"]
    cells: tuple[Annotated[Integer, Field(ge=2, le=20)], Annotated[Integer, Field(ge=2, le=20)]]
    """Meshes along x and y."""
    size: Size2
    """Lengths [m] along x and y."""
    sag: NonNegative = 0.0
    """How far [m] its middle hangs below its edges at the start; a net that is built flat stays flat."""
    radius: Length
    """Radius [m] of the strands."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Of every joint; of what is left out, damping is 8 m L^2 per second and armature 0.4 m L^2, with mass m and
    length L of a link."""
    material: Material = Material.model_construct()
    """Of the strands."""

    @model_validator(mode="after")
    def _open(self) -> "Net":
        mesh = min(length / cells for length, cells in zip(self.size, self.cells, strict=True))
        if mesh <= 2 * self.radius:
            raise ValueError(f"the strands are too thick for its meshes (got radius {self.radius:g}, meshes {mesh:g})")
        return self


class Ragdoll(Linked):
    """A doll of eleven capsules on ball joints. Its frame is at the pelvis, z along the spine, x forward.

    Links: pelvis, chest, head, arm_l, forearm_l, thigh_l, shin_l, and the same with _r; left is +y. Of a doll of the
    height h the chest is 0.15 h thick, thighs 0.086 h, forearms 0.05 h; its volume is 0.0165 h^3: 88 kg for 1.75 m at
    1000 kg/m3.
    """

    kind: Literal["ragdoll"]
    height: Length
    """From sole to crown [m]."""
    joint: JointDynamics = JointDynamics.model_construct()
    """Of every joint; damping and armature are derived if left out."""
    material: Material = Material.model_construct()
    """Of the whole doll."""
    limb_spread: Fraction = 0.3
    """0: arms and legs straight down; 1: spread wide."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return True


Body = Annotated[
    Rigid | Driven | Articulated | Chain | Net | Ragdoll | Soft | Cloth | Rope | Granular | Liquid | Snow,
    ByKind(),
]
LINKED = tuple(
    get_args(model.model_fields["kind"].annotation)[0]
    for model in get_args(get_args(Body)[0])
    if issubclass(model, Linked | Articulated)
)
"""Kinds of bodies that can be trees of several joints."""
