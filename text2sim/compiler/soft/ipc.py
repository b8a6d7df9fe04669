"""Settings of the engine's ipc coupler for bodies.

It makes every rigid link an affine body, and handles contact and friction between all bodies itself: the friction of a
pair is the geometric mean of both coefficients. libuipc counts the thickness of a shell to each side of its middle, so
it gets half the thickness, which makes mass and stiffness right.
"""

from typing import Any

from text2sim.compiler.plan import EntityPlan
from text2sim.compiler.soft.setup import IpcSettings
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.soft_bodies import Cloth

PART_OF_EDGE = 0.1
"""Distance of contact, as a part of the shortest edge of cloth and soft bodies."""
MIN_DISTANCE, MAX_DISTANCE = 5e-4, 5e-3
"""Limits of this distance [m]: a smaller one needs more iterations, a larger one shows."""
YOUNG, POISSON, RIGIDITY = 1e6, 0.3, 2e-5
"""Defaults of a cloth [Pa, 1, N m]."""
RIGIDITY_OF_HINGES = 6.0
"""Flexural rigidity over libuipc's stiffness k of a hinge. Two triangles with a common edge L and the area A together
have the energy 3 k theta^2 L^2 / A. In a grid of right triangles that is bent along its threads to a curvature c, only
the edges across have an angle; that makes 3 k c^2 per area, which is half the rigidity times c^2."""


def settings(scene: Scene, edges: dict[str, float], why: dict[str, str]) -> IpcSettings:
    """Choose what the author left open, with a sentence in `why` for each.

    Args:
        scene: The section.
        edges: Edge [m] of the elements by body.
        why: Sentences by setting; added to.
    """
    reach = scene.ipc.contact_distance
    if reach is None:
        reach = min(max(PART_OF_EDGE * min(edges.values(), default=0.01), MIN_DISTANCE), MAX_DISTANCE)
        reach = float(f"{reach:.2g}")
        why["contact_distance"] = "a tenth of the shortest edge, so that gaps are small against folds"
    return IpcSettings(reach, scene.ipc.contact_resistance, scene.ipc.friction)


def cloth(model: Cloth) -> dict[str, Any]:
    """Return keyword arguments of the engine's material for cloth."""
    material = model.material
    young, nu, rigidity = material.youngs_modulus, material.poisson_ratio, material.rigidity
    return {
        "E": YOUNG if young is None else young,
        "nu": POISSON if nu is None else nu,
        "rho": float(f"{material.area_density / material.thickness:.6g}"),
        "thickness": material.thickness / 2,
        "bending_stiffness": float(f"{(RIGIDITY if rigidity is None else rigidity) / RIGIDITY_OF_HINGES:.6g}"),
        "friction_mu": material.friction,
    }


def rigid(
    entity: EntityPlan, friction: float, tree: Tree | None, acted_on: bool
) -> tuple[float | None, dict[str, Any]]:
    """Return density [kg/m3] and keyword arguments of the material of a rigid entity.

    A body that only contact and gravity move is left to the coupler. One that has joints or is acted on is computed by
    the rigid solver, and tied to its twin in the coupler by springs that act on both.

    Args:
        entity: The entity so far.
        friction: Its coefficient.
        tree: Its links; None for a primitive.
        acted_on: Whether a control acts on it.
    """
    options: dict[str, Any] = {"coup_friction": friction}
    density = entity.rho
    if tree is not None:
        # The coupler takes one density for all links of an entity.
        geoms = [geom for geom in tree.geoms() if geom.touches] + list(tree.fixtures)
        volume = sum(geom.piece.volume() for geom in geoms)
        if density is None and volume > 0.0:
            density = float(f"{sum(geom.density * geom.piece.volume() for geom in geoms) / volume:.6g}")
        joints = [joint.kind for _, joint in tree.joints()]
    else:
        joints = [] if entity.options.get("fixed") or entity.morph == "Plane" else ["free"]
    # The engine's collision detection skips only pairs whose kinds are given, so fixed bodies need one as well.
    driven = joints not in ([], ["free"]) or (joints == ["free"] and acted_on)
    options["coup_type"] = "two_way_soft_constraint" if driven else "ipc_only"
    return density, options
