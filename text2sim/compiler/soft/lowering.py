"""Copies of deformable bodies become entities of the engine."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import dist
from pathlib import Path
from typing import Any

from text2sim.compiler.looks import rgba_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import EntityPlan, SoftFacts, Surface
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.rotation import IDENTITY, Vec
from text2sim.compiler.shapes.tets import tet_options
from text2sim.compiler.soft import ipc
from text2sim.compiler.soft.meshes import MeshFiles
from text2sim.compiler.soft.room import extents_of
from text2sim.compiler.soft.scales import Scales
from text2sim.compiler.soft.solvers import FAMILIES, solver_of
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.soft_bodies import Cloth, Granular, Liquid, Snow, Soft

PRIMITIVES = {"box": "Box", "sphere": "Sphere", "cylinder": "Cylinder"}
"""Shapes that the engine can fill with grains itself."""
YIELD = 0.1
"""Yield stress of an elasto-plastic body that gives none, as a part of its stiffness."""
SOFTNESS, CELLS_OF_SOFTNESS = 0.002, 8
"""How far [m] contact of a rigid body reaches out, by the engine's choice, and how many of it make a grid's cell."""


@dataclass
class SoftLowering:
    """Makes entities of deformable bodies, and meshes for them."""

    scene: Scene
    model: str
    """Contact model of the scene."""
    scales: Scales
    meshes: MeshFiles
    acted_on: frozenset[str] = frozenset()
    """Bodies of which a control speaks."""

    def entity(self, model: Any, copy: Copy) -> tuple[EntityPlan, tuple[Vec, float]]:
        """Return the entity for one copy, and a ball [m] around it at the start, in the world.

        Raises:
            AssetError: if its shape cannot be cut, or a file not be read.
        """
        solver = solver_of(model, self.scene)
        assert solver is not None
        spacing = self.scales.spacing(copy.body, solver)
        morph, options, turned = self._morph(model, copy, solver, spacing)
        made = MATERIALS[model.kind, "ipc" if self.model == "ipc" and solver == "fem" else solver]
        material, values = made(model)
        entity = EntityPlan(
            copy.name,
            morph,
            options,
            copy.pos,
            IDENTITY if turned else copy.quat,
            surface=self._surface(model, copy, solver),
            family=FAMILIES[solver],
            material=material,
            material_options=values,
            soft=SoftFacts(model.kind, solver, spacing),
        )
        low, high = extents_of(copy, self.meshes.folder)
        middle = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
        return entity, (middle, dist(low, high) / 2)

    def coupled(self, entity: EntityPlan, model: Any, tree: Tree | None) -> EntityPlan:
        """Return a rigid entity with what the coupler must know of it: deformable bodies feel its friction."""
        material = getattr(model, "material", None)
        if entity.family != "rigid" or material is None:
            return entity
        if self.model == "ipc" and material.touch_soft:
            density, options = ipc.rigid(entity, material.friction, tree, entity.name.split("[")[0] in self.acted_on)
            return replace(entity, rho=density, material_options=options)
        options: dict[str, Any] = {}
        if not material.touch_soft:
            options["needs_coup"] = False
        elif self.model in ("particle", "sap"):
            options["coup_friction"] = material.friction
            softness = (self.scales.mpm_cell or 1.0) / CELLS_OF_SOFTNESS
            if softness < SOFTNESS:
                options["coup_softness"] = float(f"{softness:.3g}")
        return replace(entity, material_options=options)

    def _morph(self, model: Any, copy: Copy, solver: str, spacing: float) -> tuple[str, dict[str, Any], bool]:
        """Morph, its options, and whether the copy's orientation is in the mesh already."""
        shape = copy.shape
        if solver == "mpm" and model.kind != "soft" and shape.kind in PRIMITIVES:
            return PRIMITIVES[shape.kind], {k: v for k, v in shape.model_dump().items() if k != "kind"}, False
        if FAMILIES[solver] != "fem":
            # The engine cuts a cloth anew by itself, and follows the triangles of the file for the picture.
            path = self.meshes.write(copy.body, shape, spacing, coarsen=solver == "mpm")
            return "Mesh", {"file": path}, False
        # The engine turns the vertices of a fem body about their mean, which is not known before it made them.
        options: dict[str, Any] = {"file": self.meshes.write(copy.body, shape, spacing, copy.quat)}
        if model.kind == "soft":
            options |= tet_options(spacing)
        return "Mesh", options, True

    def _surface(self, model: Any, copy: Copy, solver: str) -> Surface:
        texture = getattr(copy.shape, "texture", None)
        return Surface(
            rgba_of(model.look, copy),
            model.look.finish,
            picture=self.meshes.picture(texture) if texture is not None else None,
            mode="particle" if solver == "mpm" else None,
        )


def mass(copy: Copy, folder: Path) -> float:
    """Mass [kg] of a copy of a deformable body.

    Raises:
        AssetError: if a file of its shape cannot be used.
    """
    material = copy.model.material
    if isinstance(copy.model, Cloth):
        return material.area_density * area(copy.shape, folder)
    return material.density * geometry.volume(copy.shape, folder)


def area(shape: Any, folder: Path) -> float:
    """Area [m2] of one side of a cloth.

    Raises:
        AssetError: if a file of its shape cannot be used.
    """
    if shape.kind == "sheet":
        return shape.size[0] * shape.size[1]
    import numpy as np

    from text2sim.compiler.shapes.meshfile import load_mesh

    mesh = load_mesh(shape.file, folder)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2) * shape.scale**2


# --- materials: the engine's class, and its keyword arguments ---------------------------------------------------

_Made = tuple[str, dict[str, Any]]


def _elastic(material: Any) -> dict[str, Any]:
    return {"E": material.youngs_modulus, "nu": material.poisson_ratio, "rho": material.density}


def _mpm_soft(model: Soft) -> _Made:
    material, values = model.material, _elastic(model.material)
    if material.model == "elasto_plastic":
        limit = material.yield_stress or YIELD * material.youngs_modulus
        return "MPM.ElastoPlastic", values | {"von_mises_yield_stress": limit}
    return "MPM.Elastic", values | {"model": {"elastic": "corotation", "neo_hookean": "neohooken"}[material.model]}


def _fem_soft(model: Soft) -> _Made:
    # The implicit solver knows no other model that bears large turns; under ipc the coupler has its own.
    return "FEM.Elastic", _elastic(model.material) | {
        "model": "linear_corotated",
        "friction_mu": model.material.friction,
    }


def _ipc_soft(model: Soft) -> _Made:
    # The coupler's own model, whatever is said here; the engine's explicit solver has one of that name to build with.
    values = _elastic(model.material) | {"model": "stable_neohookean", "friction_mu": model.material.friction}
    return "FEM.Elastic", values


def _given(value: float | None, default: float) -> float:
    return default if value is None else value


def _ipc_cloth(model: Cloth) -> _Made:
    return "FEM.Cloth", ipc.cloth(model)


def _pbd_cloth(model: Cloth) -> _Made:
    material = model.material
    return "PBD.Cloth", {
        "rho": material.area_density,
        "static_friction": material.friction,
        "kinetic_friction": material.friction,
        "stretch_compliance": _given(material.stretch_compliance, 1e-7),
        "bending_compliance": _given(material.bending_compliance, 1e-4),
        "air_resistance": _given(material.air_resistance, 1e-3),
    }


def _granular(model: Granular) -> _Made:
    return "MPM.Sand", _elastic(model.material) | {"friction_angle": model.material.friction_angle_deg}


def _liquid(model: Liquid) -> _Made:
    # The first of Lame's moduli is what resists compression: E is chosen so that it is the stiffness.
    nu = 0.2
    modulus = model.material.stiffness * (1 + nu) * (1 - 2 * nu) / nu
    values = {"E": float(f"{modulus:.6g}"), "nu": nu, "rho": model.material.density}
    return "MPM.Liquid", values | {"viscous": model.material.viscous}


def _snow(model: Snow) -> _Made:
    material = model.material
    return "MPM.Snow", _elastic(material) | {"yield_lower": material.crush, "yield_higher": material.crumble}


MATERIALS: dict[tuple[str, str], Callable[[Any], _Made]] = {
    ("soft", "mpm"): _mpm_soft,
    ("soft", "fem"): _fem_soft,
    ("soft", "ipc"): _ipc_soft,
    ("cloth", "pbd"): _pbd_cloth,
    ("cloth", "ipc"): _ipc_cloth,
    ("granular", "mpm"): _granular,
    ("liquid", "mpm"): _liquid,
    ("snow", "mpm"): _snow,
}
"""By kind of body and solver."""
