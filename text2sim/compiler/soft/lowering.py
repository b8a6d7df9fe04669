"""Turns copies of deformable bodies into entities of the engine."""

from dataclasses import dataclass, replace
from math import dist
from pathlib import Path
from typing import Any

from text2sim.compiler.looks import decoration_of, finish_of_body, one_color, rgba_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import EntityPlan, Surface
from text2sim.compiler.shapes.boxes import middle
from text2sim.compiler.shapes.piece import Ball
from text2sim.compiler.shapes.revolved import revolved_area
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, Vec, quat_rotate
from text2sim.compiler.shapes.softmesh import hull_area, solid_volume, tet_options
from text2sim.compiler.soft import ipc
from text2sim.compiler.soft.gas import gas_row
from text2sim.compiler.soft.materials import made_of
from text2sim.compiler.soft.meshes import MeshFiles
from text2sim.compiler.soft.scales import CONTACT_REACH, Scales
from text2sim.compiler.soft.setup import SoftRecord
from text2sim.compiler.soft.solver_domain import extents_of
from text2sim.compiler.soft.solvers import FAMILIES, solver_of, touches_soft, unfelt_links
from text2sim.compiler.soft.streams import stream_arguments
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.materials import LEAST_FRICTION
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound
from text2sim.spec_schema.models.sheets import Sleeve
from text2sim.spec_schema.models.soft_bodies import Cloth

PRIMITIVES = {"box": "Box", "sphere": "Sphere", "cylinder": "Cylinder"}
"""Shapes that the engine can fill with grains itself."""


@dataclass
class SoftLowering:
    """Makes entities of deformable bodies, and meshes for them."""

    scene: Scene
    model: str
    """Contact model of the scene."""
    scales: Scales
    meshes: MeshFiles
    acted_on: frozenset[str]
    """Bodies that controls name."""

    def entity(self, model: Any, copy: Copy) -> tuple[EntityPlan, Ball]:
        """Return the entity for one copy, and a ball [m] around it at the start, in the world.

        Raises:
            AssetError: if its shape cannot be meshed, or a file cannot be read.
        """
        solver = solver_of(model, self.scene)
        assert solver is not None
        spacing = self.scales.spacing(copy.body, solver)
        morph, options, turned = self._morph(model, copy, solver, spacing)
        weight = float(f"{mass(copy, self.meshes.folder):.9g}")
        material, values = made_of(model, "ipc" if self.model == "ipc" and solver == "fem" else solver, spacing)
        entity = EntityPlan(
            copy.name,
            morph,
            options,
            copy.pos,
            IDENTITY if turned else copy.quat,
            surface=self._surface(model, copy, solver, spacing),
            family=FAMILIES[solver],
            material=material,
            material_options=values,
            soft=SoftRecord(
                model.kind,
                solver,
                spacing,
                copy.pos,
                copy.quat,
                weight,
                _bending(model, solver),
                _elastic(model, solver, copy.quat),
                gas_row(copy, self.meshes.folder),
                getattr(model.material, "damping", None) or None if solver in ("pbd", "mpm") else None,
                stream_arguments(copy, spacing),
                getattr(model.material, "adhesion", None) or None,
            ),
        )
        box = extents_of(copy, self.meshes.folder)
        return entity, (middle(box), dist(*box) / 2)

    def coupled(self, entity: EntityPlan, model: Any, tree: Tree | None) -> EntityPlan:
        """Return a rigid entity with what the coupler must know about it, such as its friction on deformable bodies.

        Args:
            entity: The entity.
            model: The body or static that it comes from.
            tree: Its tree of links, if it has one.

        Raises:
            AssetError: if the contact model does not support `collision: exact`.
        """
        material = getattr(model, "material", None)
        if entity.family != "rigid" or material is None:
            return entity
        if self.model != "particle" and entity.options.get("contact") == "exact":
            raise AssetError(
                f"contact model `{self.model}` has no `collision: exact`; use `decompose`, or solver mpm for "
                "soft bodies"
            )
        if self.model == "ipc" and touches_soft(model):
            density, options = ipc.rigid(entity, material.friction, tree, entity.name.split("[")[0] in self.acted_on)
            return replace(entity, rho=density, material_options=entity.material_options | options)
        options: dict[str, Any] = {}
        unfelt = unfelt_links(model)
        if not touches_soft(model):
            options["needs_coup"] = False
        elif self.model in ("particle", "sap"):
            options["coup_friction"] = material.friction if material.friction > LEAST_FRICTION else 0.0
            reach = material.soft_reach or self.scales.reach or CONTACT_REACH
            if reach != CONTACT_REACH:
                options["coup_softness"] = float(f"{reach:.3g}")
            if unfelt and self.model == "particle":
                options["coup_links"] = [name for name in model.links if name not in unfelt]
        return replace(entity, material_options=entity.material_options | options)

    def _morph(self, model: Any, copy: Copy, solver: str, spacing: float) -> tuple[str, dict[str, Any], bool]:
        """Return the morph, its options, and whether the mesh already has the copy's orientation."""
        shape = copy.shape
        if shape.kind == "stream":
            return "Nowhere", {}, False
        if solver == "mpm" and model.kind != "soft" and shape.kind in PRIMITIVES:
            return PRIMITIVES[shape.kind], {name: value for name, value in shape if name != "kind"}, False
        if FAMILIES[solver] != "fem":
            # The engine remeshes a cloth itself, and uses the triangles of the file to draw it.
            return "Mesh", {"file": self.meshes.write(copy.body, shape, spacing, coarsen=_merges(shape, solver))}, False
        # The engine turns the vertices of a fem body about their mean, which is not known until it has made them.
        options: dict[str, Any] = {"file": self.meshes.write(copy.body, shape, spacing, copy.quat)}
        if model.kind == "soft":
            options |= tet_options(spacing)
        return "Mesh", options, True

    def _surface(self, model: Any, copy: Copy, solver: str, spacing: float) -> Surface:
        shape, regions, parts = copy.shape, None, ()
        texture = getattr(shape, "texture", None)
        if model.kind == "soft" and isinstance(shape, Compound | Sculpt) and not one_color(shape):
            regions = self.meshes.part_looks(copy.body, shape, spacing, coarsen=_merges(shape, solver))
            looks = [part.look for part in shape.parts.values()]
            parts = tuple(look and Surface(rgba_of(look, copy), look.finish) for look in looks)
        return Surface(
            rgba_of(model.look, copy),
            finish_of_body(model),
            picture=self.meshes.picture(texture) if texture is not None else None,
            mode="particle" if solver == "mpm" else None,
            decoration=decoration_of(model.look),
            regions=regions,
            parts=parts,
        )


def _merges(shape: Any, solver: str) -> bool:
    """Return whether triangles smaller than wanted are merged: not where borders of looks follow them."""
    if solver == "mpm":
        return not (isinstance(shape, Sculpt) and not one_color(shape))
    return FAMILIES[solver] == "fem"


def _bending(model: Any, solver: str) -> tuple[float | None, float | None, bool] | None:
    """Return rigidity [N m], crease radius [m], and whether it is at rest as it starts; None if it asks for none."""
    if solver != "pbd":
        return None
    own = model.material
    row = own.rigidity, own.crease_radius, own.rest_shape == "start"
    return row if any(row) else None


def _elastic(model: Any, solver: str, quat: Quaternion) -> tuple[float, float, Vec | None] | None:
    """Return tension modulus [N/m], length over length at rest, and the direction without it; None if not elastic."""
    modulus = model.material.tension_modulus if solver == "pbd" else None
    if modulus is None:
        return None
    across = quat_rotate(quat, (0.0, 0.0, 1.0)) if isinstance(model.shape, Sleeve) else None
    return modulus, model.material.prestretch or 1.0, across


def mass(copy: Copy, folder: Path) -> float:
    """Return the mass [kg] of a copy of a deformable body.

    Raises:
        AssetError: if a file of its shape cannot be used.
    """
    material = copy.model.material
    if isinstance(copy.model, Cloth):
        return material.area_density * area(copy.shape, folder)
    return material.density * solid_volume(copy.shape, folder)


def area(shape: Any, folder: Path) -> float:
    """Return the area [m2] of the outside of a cloth.

    Raises:
        AssetError: if a file of its shape cannot be used.
    """
    if shape.kind == "sheet":
        return shape.size[0] * shape.size[1]
    if shape.kind in ("disc", "sleeve"):
        return shape.area
    if shape.kind == "revolve":
        return revolved_area(shape)
    return hull_area(shape, folder)
