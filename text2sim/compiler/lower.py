"""Turns copies of bodies and statics into entities of the engine."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import singledispatchmethod
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.mechanism import Mechanism, Mechanisms, load_mechanism
from text2sim.compiler.belts import DRIVEN_ARMATURE, slider_of_belt
from text2sim.compiler.files import Files
from text2sim.compiler.looks import Rgba, colors_of, decoration_of, one_color, rgba_of
from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import EntityPlan, JointChange, Motor, Surface
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.piece import Ball
from text2sim.compiler.shapes.rotation import IDENTITY, frame_apply, quat_conjugate, quat_rotate, vector_unit
from text2sim.compiler.trees import generators
from text2sim.compiler.trees.articulated import articulated_tree
from text2sim.compiler.trees.beams import beam_tree
from text2sim.compiler.trees.dolls import ragdoll_tree
from text2sim.compiler.trees.file_bodies import file_changes, file_motors, mechanism_tree
from text2sim.compiler.trees.joints import joint_of
from text2sim.compiler.trees.model_files import ModelFiles, Written, count_pieces
from text2sim.compiler.trees.shaped_links import geoms_of, shaped_link
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink, tree_balls, with_torques
from text2sim.spec_schema.models.base import content_of
from text2sim.spec_schema.models.bodies import Articulated, Chain, Driven, Net, Ragdoll, Rigid
from text2sim.spec_schema.models.materials import Look, Material
from text2sim.spec_schema.models.motion import Oscillate, Spin
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.soft_bodies import Beam, Cloth, Granular, Liquid, Rope, Snow, Soft

if TYPE_CHECKING:
    from text2sim.compiler.soft.lowering import SoftLowering

NATIVE_MORPHS = {"box": "Box", "sphere": "Sphere", "cylinder": "Cylinder"}
PLACEMENT_KEYS = ("pose", "place", "repeat")


@dataclass
class Lowering:
    """Collects what the entities need besides themselves: model files, motors, start positions."""

    folder: Path
    named: Mapping[str, Collection[str]] = field(default_factory=dict)
    """Links and joints that the case names, by body."""
    motors: list[Motor] = field(default_factory=list)
    changes: list[JointChange] = field(default_factory=list)
    held_by_files: dict[str, set[str]] = field(default_factory=dict)
    """Joints on which a file puts motors with a stiffness, by copy."""
    damped: dict[str, float] = field(default_factory=dict)
    """Rates [1/s] at which free bodies lose velocity and spin, by copy."""
    unpowered: list[str] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)
    """What was done to files, each once."""
    initial: dict[str, dict[str, float]] = field(default_factory=dict)
    joint_velocities: dict[str, dict[str, float]] = field(default_factory=dict)
    mechanisms: Mechanisms = field(default_factory=dict)
    trees: dict[str, Tree] = field(default_factory=dict)
    """Trees by copy, in which links and joints are looked up."""
    balls: dict[str, list[Ball]] = field(default_factory=dict)
    """Balls around the pieces of each copy [m], at the start, in the world."""
    alike: dict[tuple[Any, ...], Written] = field(default_factory=dict)
    """Models already written, by everything in which copies can differ."""
    contents: dict[ObjectKey, Any] = field(default_factory=dict)
    """Contents of models without their place."""
    pieces: int = 0
    """Convex pieces made so far."""
    thinnest: float = 1e9
    """Smallest thickness [m] of any piece made so far."""
    rolls: bool = False
    """Whether contacts of the scene resist rolling and spin."""
    soft: "SoftLowering | None" = None
    """Makes the deformable bodies, in a scene that has any."""

    def __post_init__(self) -> None:
        self.models = ModelFiles(self.folder)

    @property
    def files(self) -> Files:
        """Models and meshes by path inside the program's folder."""
        return self.models.files

    @singledispatchmethod
    def entity(self, model: Any, copy: Copy) -> EntityPlan:
        """Return the entity for one copy of a body or static.

        Raises:
            TypeError: if there is no entity for this kind of model.
        """
        raise TypeError(f"no entity for {type(model).__name__}")

    @entity.register
    def _static(self, model: Static, copy: Copy) -> EntityPlan:
        if copy.shape.kind == "plane":
            side = copy.shape.size
            options: dict[str, Any] = {"plane_size": (side, side)}
            if self.soft is not None and self.soft.model == "sap":
                options["collision"] = False  # the coupler has a floor of its own
            return self._native(copy, "Plane", options, model.material, model.look, volume=None)
        if model.carries:
            # Its weight must not accelerate it down a slope.
            light = model.material.model_copy(update={"density": 1.0, "mass": None})
            return self._solid(copy, light, model.look, joint=slider_of_belt(model))
        return self._solid(copy, model.material, model.look, joint=None)

    @entity.register
    def _rigid(self, model: Rigid, copy: Copy) -> EntityPlan:
        mount = model.mount
        if mount.kind == "free":
            if mount.damping:
                self.damped[copy.name] = mount.damping
            return self._solid(copy, model.material, model.look, joint=TreeJoint("free"))
        if mount.kind == "fixed":
            return self._solid(copy, model.material, model.look, joint=None)
        self._motor(copy.name, copy.body, mount)
        return self._solid(copy, model.material, model.look, joint=joint_of(mount))

    @entity.register
    def _driven(self, model: Driven, copy: Copy) -> EntityPlan:
        motion = model.motion
        if isinstance(motion, Spin):
            axes: dict[str, TreeJoint] = {
                "turn": TreeJoint("hinge", axis=self._local(copy, motion.axis), armature=DRIVEN_ARMATURE)
            }
        elif isinstance(motion, Oscillate):
            axes = {"slide": TreeJoint("slider", axis=self._local(copy, motion.axis), armature=DRIVEN_ARMATURE)}
        else:
            axes = {
                f"slide_{a}": TreeJoint("slider", axis=self._local(copy, a), armature=DRIVEN_ARMATURE) for a in "xyz"
            }
        link = replace(self._link(copy, model.material, model.look), joints=tuple(axes.items()))
        return self._model(copy, Tree((link,)))

    @entity.register
    def _chain(self, model: Chain, copy: Copy) -> EntityPlan:
        rgba = rgba_of(model.look, copy)
        payload = None
        if model.payload is not None:
            shape = model.payload.shape
            look = model.payload.look or model.look
            geoms = geoms_of(shape, model.payload.material, look, copy, self.folder)
            self._take_in_thickness(geoms)
            low, high = extents(shape, IDENTITY, self.folder)
            payload = (geoms, float(high[2]))
        tree = generators.chain_tree(model, vector_unit(model.direction), rgba, payload)
        return self._model(copy, tree)

    @entity.register
    def _rope(self, model: Rope, copy: Copy) -> EntityPlan:
        return self._model(copy, generators.rope_tree(model, vector_unit(model.direction), rgba_of(model.look, copy)))

    @entity.register
    def _beam(self, model: Beam, copy: Copy) -> EntityPlan:
        tree = beam_tree(model, rgba_of(model.look, copy))
        self._take_in_thickness(tree.geoms())
        entity = self._model(copy, tree)
        # Smoothed over their edges, boxes in a row look like scales.
        return replace(entity, surface=entity.surface and replace(entity.surface, flat=True))

    @entity.register
    def _net(self, model: Net, copy: Copy) -> EntityPlan:
        return self._model(copy, generators.net_tree(model, rgba_of(model.look, copy)))

    @entity.register
    def _ragdoll(self, model: Ragdoll, copy: Copy) -> EntityPlan:
        return self._model(copy, ragdoll_tree(model, {"": rgba_of(model.look, copy)}))

    @entity.register
    def _deformable(self, model: Soft | Cloth | Granular | Liquid | Snow, copy: Copy) -> EntityPlan:
        assert self.soft is not None
        entity, ball = self.soft.entity(model, copy)
        self.balls[copy.name] = [ball]
        return entity

    @entity.register
    def _articulated(self, model: Articulated, copy: Copy) -> EntityPlan:
        if model.file is not None:
            return self._from_file(model, copy)
        tree = articulated_tree(
            model, lambda link, shape, material, look: self._shaped(shape, material, look, copy, link)
        )
        assert model.links is not None
        for name, link in model.links.items():
            if link.joint is not None and link.joint.kind != "fixed":
                self._motor(copy.name, name, link.joint)
        return self._model(copy, tree)

    # --- the two ways into the engine: a primitive of its own, or a model file --------------------------------

    def _solid(self, copy: Copy, material: Material, look: Look, joint: TreeJoint | None) -> EntityPlan:
        shape = copy.shape
        simple = joint is None or joint.kind == "free"
        if shape.kind in NATIVE_MORPHS and simple:
            options: dict[str, Any] = {name: value for name, value in shape if name != "kind"}
            if joint is None:
                options["fixed"] = True
            (piece,) = geometry.pieces(shape, self.folder)
            self.thinnest = min(self.thinnest, piece.thickness)
            center, radius = piece.ball
            self.balls[copy.name] = [(frame_apply(copy.pos, copy.quat, center), radius)]
            return self._native(copy, NATIVE_MORPHS[shape.kind], options, material, look, piece.volume())
        # Copies that differ only in where they are, and perhaps in a colour of their own, share one model.
        plain = one_color(shape)
        key = (
            copy.body,
            self._content(copy.model),
            self._content(shape),
            *(() if plain else colors_of(shape, look, copy)),
        )
        written = self.alike.get(key)
        if written is None:
            link = replace(self._link(copy, material, look), joint=joint)
            written = self.alike[key] = self.models.write(copy.body, Tree((link,)))
        return self._entity_of(copy, written, rgba_of(look, copy) if plain else written.color)

    def _content(self, model: Any) -> Any:
        """Return the content of a model, without where its copies are."""
        key = ObjectKey(model)
        if key not in self.contents:
            there = {field: None for field in PLACEMENT_KEYS if field in type(model).model_fields}
            self.contents[key] = content_of(model.model_copy(update=there))
        return self.contents[key]

    def _native(
        self, copy: Copy, morph: str, options: dict, material: Material, look: Look, volume: float | None
    ) -> EntityPlan:
        self.pieces += 1
        rho = generators.density_of(material, volume) if volume else None
        surface = _surface(look, rgba_of(look, copy))
        if not look.visible:
            options["visualization"] = False
        return EntityPlan(
            copy.name, morph, options, copy.pos, copy.quat, rho, material.friction, surface,
            material_options=self._torques(material),
        )  # fmt: skip

    def _torques(self, material: Material) -> dict[str, Any]:
        """Keyword arguments of the engine's material; without them it has friction of its own against rolling."""
        torsional, rolling = material.torques
        return {"friction_torsional": torsional, "friction_rolling": rolling} if self.rolls else {}

    def _model(self, copy: Copy, tree: Tree) -> EntityPlan:
        if any(torques := copy.model.material.torques) and copy.model.kind != "articulated":
            tree = with_torques(tree, torques)
        written = self.models.write(copy.body, tree)
        return self._entity_of(copy, written, written.color)

    def _entity_of(self, copy: Copy, made: Written, color: Rgba | None) -> EntityPlan:
        self._take_in(copy, made.tree, made.balls, made.pieces)
        self.notes |= {f"{copy.body}: {note}": None for note in made.notes}
        own = copy.model.look
        surface = None if made.color is None or color is None else _surface(own, color, copy.shape)
        part_surfaces = {link.name: _part_surfaces(link, own, copy) for link in made.tree.links()}
        if all(part == surface for row in part_surfaces.values() for part in row):
            part_surfaces = {}
        return EntityPlan(
            copy.name, "MJCF", dict(made.options), copy.pos, copy.quat, surface=surface, part_surfaces=part_surfaces,
            material_options=dict(made.grid),
        )  # fmt: skip

    def _take_in(self, copy: Copy, tree: Tree, balls: list[Ball], pieces: int) -> None:
        """Remember what the rest of the compiler asks about a tree."""
        self.trees[copy.name] = tree
        if balls:
            self.balls[copy.name] = [(frame_apply(copy.pos, copy.quat, center), radius) for center, radius in balls]
        if tree.initial:
            self.initial[copy.name] = tree.initial
        joints = (joint for link in tree.links() for joint in link.all_joints())
        if speeds := {name: joint.velocity for name, joint in joints if joint.velocity}:
            self.joint_velocities[copy.name] = speeds
        self.pieces += pieces

    def _from_file(self, model: Articulated, copy: Copy) -> EntityPlan:
        assert model.file is not None
        mechanism = self._mechanism(model.file, model.base)
        tree = mechanism_tree(mechanism, model)
        self._take_in(copy, tree, tree_balls(tree), count_pieces(tree))
        self._take_in_thickness(geom for geom in tree.geoms() if geom.touches)
        self.motors += file_motors(mechanism, model, copy.name)
        self.held_by_files[copy.name] = {
            j.name for j in mechanism.joints if j.motor is not None and j.motor.stiffness > 0
        }
        self.changes += file_changes(mechanism, model, copy.name)
        self.notes |= {f"{copy.body}: {note}": None for note in mechanism.notes}
        urdf = mechanism.kind == "urdf"
        options: dict[str, Any] = {"file": self.models.add_mechanism(copy.body, mechanism), "contact": "hull"}
        if urdf:
            options["fixed"] = model.base != "free"
            options["keep"] = tuple(sorted({*self.named.get(copy.body, ())} & {*mechanism.link_names}))
            if mechanism.joints:
                self.unpowered.append(copy.name)
        if not model.look.visible:
            options["visualization"] = False
        look = model.look
        surface = None if look.color is None else _surface(look, rgba_of(look, copy))
        # An MJCF file sets the friction of every geom, if only by MuJoCo's defaults; a URDF cannot.
        friction = model.material.friction if urdf or "friction" in model.material.model_fields_set else None
        rho = generators.density_of(model.material, 1.0) if urdf and mechanism.inertialess else None
        gives_torques = urdf or model.material.model_fields_set & {"rolling_friction", "torsional_friction"}
        return EntityPlan(
            copy.name, mechanism.kind.upper(), options, copy.pos, copy.quat, rho, friction, surface,
            material_options=self._torques(model.material) if gives_torques else {},
        )  # fmt: skip

    def held_joints(self) -> dict[str, set[str]]:
        """Return the joints whose actuators have a stiffness, set by the case or by a file, by copy."""
        found: dict[str, set[str]] = {name: set(joints) for name, joints in self.held_by_files.items()}
        for motor in self.motors:
            found.setdefault(motor.entity, set()).discard(motor.joint)
            if motor.stiffness > 0:
                found[motor.entity].add(motor.joint)
        return found

    def _mechanism(self, file: str, base: str | None) -> Mechanism:
        key = (file, base)
        if key not in self.mechanisms:
            self.mechanisms[key] = load_mechanism(self.folder, file, base=base)
        return self.mechanisms[key]

    def _link(self, copy: Copy, material: Material, look: Look) -> TreeLink:
        return self._shaped(copy.shape, material, look, copy, copy.body)

    def _shaped(self, shape: Any, material: Material, look: Look, copy: Copy, link: str) -> TreeLink:
        made = shaped_link(shape, material, look, copy, link, self.folder)
        self._take_in_thickness(made.geoms)
        return made

    def _take_in_thickness(self, geoms: Iterable[TreeGeom]) -> None:
        self.thinnest = min([self.thinnest, *(geom.piece.thickness for geom in geoms)])

    def _motor(self, entity: str, joint: str, mount: Any) -> None:
        actuator = getattr(mount, "actuator", None)
        if actuator is not None:
            self.motors.append(Motor(entity, joint, actuator.stiffness, actuator.damping, actuator.max_force))

    def _local(self, copy: Copy, axis: Any) -> tuple[float, float, float]:
        """Return a world axis in the frame of a copy."""
        return quat_rotate(quat_conjugate(copy.quat), vector_unit(axis))


def _part_surfaces(link: TreeLink, own: Look, copy: Copy) -> tuple[Surface | None, ...]:
    """Return the looks of what is drawn of a link; None for a mesh in colours of its own.

    Args:
        link: The link.
        own: The look of its body.
        copy: The copy that it belongs to.
    """
    looks = [part.look or (own if isinstance(part, TreeGeom) else None) for part in link.drawn()]
    return tuple(look and _surface(look, rgba_of(look, copy), copy.shape) for look in looks)


def _surface(look: Look, rgba: Rgba, shape: Any = None) -> Surface:
    decoration = decoration_of(look)
    if isinstance(shape, Fragment):  # before it breaks, the whole looks like one body
        decoration |= {"alike": True, "cut": {"place": shape.place, "bounds": shape.bounds}}
    return Surface(rgba, look.finish, decoration=decoration)
