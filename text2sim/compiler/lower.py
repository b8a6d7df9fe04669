"""Copies of bodies and statics become entities of the engine."""

from dataclasses import dataclass, field
from functools import singledispatchmethod
from hashlib import sha256
from pathlib import Path
from typing import Any

from text2sim.compiler import generators, geometry
from text2sim.compiler.articulated import articulated_tree
from text2sim.compiler.joints import joint_of
from text2sim.compiler.looks import rgba_of
from text2sim.compiler.mjcf import write_mjcf
from text2sim.compiler.piece import piece_ball, piece_thickness
from text2sim.compiler.placement import Copy
from text2sim.compiler.plan import EntityPlan, Motor, Surface
from text2sim.compiler.rotation import frame_apply, quat_conjugate, quat_rotate, vector_unit
from text2sim.compiler.tree import Tree, TreeGeom, TreeJoint, TreeLink, TreeVisual, link_colors, tree_balls, uncolored
from text2sim.spec_schema.bodies import Articulated, Chain, Driven, Net, Ragdoll, Rigid
from text2sim.spec_schema.materials import Look, Material
from text2sim.spec_schema.motion import Oscillate, Spin
from text2sim.spec_schema.scene import Static
from text2sim.spec_schema.shapes import Compound

NATIVE = {"box": "Box", "sphere": "Sphere", "cylinder": "Cylinder"}
IMMOVABLE = 1e5
"""Armature [kg or kg m2] of a driven body's joints: contact cannot push it back."""


@dataclass
class Lowering:
    """Collects what the entities need besides themselves: model files, motors, start positions."""

    folder: Path
    files: dict[str, bytes] = field(default_factory=dict)
    motors: list[Motor] = field(default_factory=list)
    initial: dict[str, dict[str, float]] = field(default_factory=dict)
    trees: dict[str, Tree] = field(default_factory=dict)
    """Tree by name of the copy, for lookups of links and joints."""
    balls: dict[str, list[tuple[tuple[float, float, float], float]]] = field(default_factory=dict)
    """Balls around the pieces of each copy [m], at the start, in the world."""
    pieces: int = 0
    """Convex pieces made so far."""
    thinnest: float = 1e9
    """Smallest thickness [m] of any piece made so far."""

    @singledispatchmethod
    def entity(self, model: Any, copy: Copy) -> EntityPlan:
        """Return the entity for one copy of a body or static."""
        raise TypeError(f"no entity for {type(model).__name__}")

    @entity.register
    def _static(self, model: Static, copy: Copy) -> EntityPlan:
        if copy.shape.kind == "plane":
            side = copy.shape.size
            options = {"plane_size": (side, side)}
            return self._native(copy, "Plane", options, model.material, model.look, volume=None)
        return self._solid(copy, model.material, model.look, joint=None)

    @entity.register
    def _rigid(self, model: Rigid, copy: Copy) -> EntityPlan:
        mount = model.mount
        if mount.kind == "free":
            return self._solid(copy, model.material, model.look, joint=TreeJoint("free"))
        if mount.kind == "fixed":
            return self._solid(copy, model.material, model.look, joint=None)
        self._motor(copy.name, copy.body, mount)
        return self._solid(copy, model.material, model.look, joint=joint_of(mount))

    @entity.register
    def _driven(self, model: Driven, copy: Copy) -> EntityPlan:
        motion = model.motion
        if isinstance(motion, Spin):
            axes: dict[str, TreeJoint] = {"turn": TreeJoint("hinge", axis=self._local(copy, motion.axis), armature=IMMOVABLE)}
        elif isinstance(motion, Oscillate):
            axes = {"slide": TreeJoint("slider", axis=self._local(copy, motion.axis), armature=IMMOVABLE)}
        else:
            axes = {f"slide_{a}": TreeJoint("slider", axis=self._local(copy, a), armature=IMMOVABLE) for a in "xyz"}
        link = self._link(copy, model.material, model.look)
        link = TreeLink(link.name, joints=tuple(axes.items()), geoms=link.geoms, visuals=link.visuals)
        return self._model(copy, Tree((link,)))

    @entity.register
    def _chain(self, model: Chain, copy: Copy) -> EntityPlan:
        rgba = rgba_of(model.look, copy)
        payload = None
        if model.payload is not None:
            shape = model.payload.shape
            look = model.payload.look or model.look
            geoms = self._geoms(shape, model.payload.material, look, copy)
            low, high = geometry.extents(shape, (1.0, 0.0, 0.0, 0.0), self.folder)
            payload = (geoms, float(high[2]))
        tree = generators.chain_tree(model, vector_unit(model.direction), rgba, payload)
        return self._model(copy, tree)

    @entity.register
    def _net(self, model: Net, copy: Copy) -> EntityPlan:
        return self._model(copy, generators.net_tree(model, rgba_of(model.look, copy)))

    @entity.register
    def _ragdoll(self, model: Ragdoll, copy: Copy) -> EntityPlan:
        return self._model(copy, generators.ragdoll_tree(model, {"": rgba_of(model.look, copy)}))

    @entity.register
    def _articulated(self, model: Articulated, copy: Copy) -> EntityPlan:
        if model.file is not None:
            return self._from_file(model, copy)
        tree = articulated_tree(model, lambda link, shape, material, look: self._shaped(shape, material, look, copy, link))
        assert model.links is not None
        for name, link in model.links.items():
            if link.joint is not None and link.joint.kind != "fixed":
                self._motor(copy.name, name, link.joint)
        return self._model(copy, tree)

    # --- the two ways into the engine: a primitive of its own, or a model file --------------------------------

    def _solid(self, copy: Copy, material: Material, look: Look, joint: TreeJoint | None) -> EntityPlan:
        shape = copy.shape
        simple = joint is None or joint.kind == "free"
        if shape.kind in NATIVE and simple:
            options = {k: v for k, v in shape.model_dump().items() if k != "kind"}
            if joint is None:
                options["fixed"] = True
            (piece,) = geometry.pieces(shape, self.folder)
            self.thinnest = min(self.thinnest, piece_thickness(piece))
            center, radius = piece_ball(piece)
            self.balls[copy.name] = [(frame_apply(copy.pos, copy.quat, center), radius)]
            return self._native(copy, NATIVE[shape.kind], options, material, look, piece.volume())
        link = self._link(copy, material, look)
        link = TreeLink(link.name, joint=joint, geoms=link.geoms, visuals=link.visuals)
        return self._model(copy, Tree((link,)))

    def _native(self, copy: Copy, morph: str, options: dict, material: Material, look: Look, volume: float | None) -> EntityPlan:
        self.pieces += 1
        rho = generators.density_of(material, volume) if volume else None
        surface = Surface(rgba_of(look, copy), look.finish)
        if not look.visible:
            options["visualization"] = False
        return EntityPlan(copy.name, morph, options, copy.pos, copy.quat, rho, material.friction, surface)

    def _model(self, copy: Copy, tree: Tree) -> EntityPlan:
        meshes: dict[str, str] = {}
        for link in tree.links():
            for visual in link.visuals:
                name = f"{visual.mesh.digest[:12]}.obj"
                meshes[visual.mesh.digest] = name
                self.files.setdefault(f"models/{name}", visual.mesh.obj().encode())
            self.pieces += len(link.geoms)
        self.pieces += len(tree.fixtures)
        # One colour for all is given to the entity, so that copies in several colours share one file.
        colors = {rgba for link in tree.links() for rgba in link_colors(link)} | {geom.rgba for geom in tree.fixtures}
        surface = None
        if len(colors) == 1 and (rgba := colors.pop()) is not None:
            surface = Surface(rgba, copy.model.look.finish)
            tree = uncolored(tree)
        self.trees[copy.name] = tree
        self.balls[copy.name] = [(frame_apply(copy.pos, copy.quat, center), radius) for center, radius in tree_balls(tree)]
        if tree.initial:
            self.initial[copy.name] = tree.initial
        text = write_mjcf(tree, copy.body, meshes).encode()
        path = f"models/{copy.body}.xml"
        if self.files.get(path, text) != text:
            path = f"models/{copy.body}_{sha256(text).hexdigest()[:8]}.xml"
        self.files[path] = text
        return EntityPlan(copy.name, "MJCF", {"file": path}, copy.pos, copy.quat, surface=surface)

    def _from_file(self, model: Articulated, copy: Copy) -> EntityPlan:
        raise NotImplementedError

    # --- links ------------------------------------------------------------------------------------------------

    def _link(self, copy: Copy, material: Material, look: Look) -> TreeLink:
        geoms, visuals = self._shaped(copy.shape, material, look, copy, copy.body)
        return TreeLink(copy.body, geoms=geoms, visuals=visuals)

    def _shaped(self, shape: Any, material: Material, look: Look, copy: Copy, link: str) -> tuple[tuple[TreeGeom, ...], tuple[TreeVisual, ...]]:
        geoms = self._geoms(shape, material, look, copy)
        visuals = geometry.visual_mesh(shape, self.folder)
        if not look.visible:
            return tuple(_hidden(g) for g in geoms), ()
        if not visuals:
            return geoms, ()
        parts = shape.parts if isinstance(shape, Compound) else {}
        drawn = tuple(
            TreeVisual(mesh, rgba_of((parts[mesh.part].look if mesh.part in parts else None) or look, copy)) for mesh in visuals
        )
        meshed = {mesh.part for mesh in visuals}
        return tuple(_hidden(g) if g.piece.part in meshed else g for g in geoms), drawn

    def _geoms(self, shape: Any, material: Material, look: Look, copy: Copy) -> tuple[TreeGeom, ...]:
        parts = shape.parts if isinstance(shape, Compound) else {}
        pieces = geometry.pieces(shape, self.folder)
        density = generators.density_of(material, sum(piece.volume() for piece in pieces))
        self.thinnest = min(self.thinnest, *(piece_thickness(piece) for piece in pieces))
        found = []
        for piece in pieces:
            part = parts.get(piece.part) if piece.part else None
            own = part.density if part is not None and part.density is not None else density
            rgba = rgba_of((part.look if part is not None else None) or look, copy)
            found.append(TreeGeom(piece, own, material.friction, rgba))
        return tuple(found)

    def _motor(self, entity: str, joint: str, mount: Any) -> None:
        actuator = getattr(mount, "actuator", None)
        if actuator is not None:
            self.motors.append(Motor(entity, joint, actuator.stiffness, actuator.damping, actuator.max_force))

    def _local(self, copy: Copy, axis: Any) -> tuple[float, float, float]:
        """A world axis in the copy's frame."""
        return quat_rotate(quat_conjugate(copy.quat), vector_unit(axis))


def _hidden(geom: TreeGeom) -> TreeGeom:
    return TreeGeom(geom.piece, geom.density, geom.friction, geom.rgba, drawn=False)
