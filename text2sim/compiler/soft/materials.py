"""Materials of deformable bodies in the engine's terms: a class and its keyword arguments."""

from collections.abc import Callable
from math import sqrt
from typing import Any

from text2sim.compiler.soft import ipc
from text2sim.spec_schema.models.soft_bodies import Cloth, Granular, Liquid, Snow, Soft

YIELD = 0.1
"""Yield stress of an elasto-plastic body that gives none, as a part of its stiffness."""
STRETCH, BENDING = 1e-7, 1e-4
"""Defaults of a pbd cloth: compliance of threads [m/N], as in the engine, and of folds [rad/N]. The
engine's folds are ten times stiffer, and make a few broad waves."""
AIR = 0.25
"""Drag of still air on a point of a cloth, for the square of its cell [kg/m3]: `rho C / 2` with 1.2 kg/m3, a drag
coefficient of 0.5, and an area of sqrt(3)/2 cells squared. A flat plate has 1.2 across the flow and next to nothing
along it (Hoerner, Fluid-Dynamic Drag, 1965); the engine's drag knows no direction."""
DAMPING = 0.5
"""Default rate [1/s] at which a fem body loses velocity, as in the engine."""

Made = tuple[str, dict[str, Any]]


def made_of(model: Any, solver: str, spacing: float) -> Made:
    """Return the class of material, the engine's or one of `templates`, and its keyword arguments.

    Args:
        model: The body.
        solver: mpm, pbd, fem or ipc.
        spacing: Distance of its particles, or edge of its elements [m].
    """
    name, values = _MATERIALS[model.kind, solver](model)
    if name == "PBD.Cloth" and values["air_resistance"] is None:
        values["air_resistance"] = still_air(spacing)
    return name, values


def still_air(spacing: float) -> float:
    """Return the drag coefficient [kg/m] of a point of a cloth with a spacing [m] in still air."""
    return float(f"{AIR * spacing**2:.2g}")


def open_values(model: Any, solver: str, spacing: float) -> dict[str, tuple[float, str]]:
    """Return the defaults of fields of a material that depend on the body, each with its reason.

    Args:
        model: The body.
        solver: mpm, pbd, fem or ipc.
        spacing: Distance of its particles, or edge of its elements [m].
    """
    material = model.material
    if model.kind == "soft" and material.model == "elasto_plastic":
        return {"yield_stress": (YIELD * material.youngs_modulus, "a tenth of its stiffness")}
    if solver == "pbd":
        return {
            "stretch_compliance": (STRETCH, "as the engine has it"),
            "bending_compliance": (BENDING, "ten times what the engine has: folds, not broad waves"),
            "air_resistance": (still_air(spacing), "still air on a cell of this size"),
        }
    if model.kind == "cloth":
        return {
            "youngs_modulus": (ipc.YOUNG, "a woven cloth"),
            "poisson_ratio": (ipc.POISSON, "a woven cloth"),
            "rigidity": (ipc.RIGIDITY, "a light cloth"),
        }
    return {}


def _elastic(material: Any) -> dict[str, Any]:
    return {"E": material.youngs_modulus, "nu": material.poisson_ratio, "rho": material.density}


def _mpm_soft(model: Soft) -> Made:
    material, values = model.material, _elastic(model.material)
    if material.model == "elasto_plastic":
        # The engine compares the norm of the deviatoric stress, which is sqrt(2/3) of the von Mises stress.
        limit = sqrt(2 / 3) * (material.yield_stress or YIELD * material.youngs_modulus)
        values["von_mises_yield_stress"] = float(f"{limit:.6g}")
        if material.viscosity:
            return "Viscoplastic", values | {"viscosity": material.viscosity}
        return "MPM.ElastoPlastic", values
    if material.model == "neo_hookean":
        values["model"] = "neohooken"
    if material.tear_stretch is not None:
        return "TearingSolid", values | {"tear_stretch": material.tear_stretch}
    return ("MPM.Elastic" if "model" in values else "Corotated"), values


def _fem_soft(model: Soft) -> Made:
    # The implicit solver has no other model that is right for large rotations.
    values = _elastic(model.material) | {"model": "linear_corotated", "friction_mu": model.material.friction}
    modulus = model.material.hydroelastic_modulus
    return "FEM.Elastic", values if modulus is None else values | {"hydroelastic_modulus": modulus}


def _ipc_soft(model: Soft) -> Made:
    # The coupler always uses its own model; the name only has to be one that the engine can build.
    values = _elastic(model.material) | {"model": "stable_neohookean", "friction_mu": model.material.friction}
    return "FEM.Elastic", values


def _or_default(value: float | None, default: float) -> float:
    return default if value is None else value


def _pbd_cloth(model: Cloth) -> Made:
    material = model.material
    return "PBD.Cloth", {
        "rho": material.area_density,
        "static_friction": material.friction,
        "kinetic_friction": material.friction,
        "stretch_compliance": _or_default(material.stretch_compliance, STRETCH),
        "bending_compliance": _or_default(material.bending_compliance, BENDING),
        "air_resistance": material.air_resistance,
    }


def _granular(model: Granular) -> Made:
    values = _elastic(model.material) | {"friction_angle": model.material.friction_angle_deg}
    cohesion = model.material.cohesion
    return ("DampSand", values | {"cohesion": cohesion}) if cohesion else ("MPM.Sand", values)


def _liquid(model: Liquid) -> Made:
    # Lamé's first parameter resists compression: E is chosen so that it equals the stiffness.
    nu = 0.2
    modulus = model.material.stiffness * (1 + nu) * (1 - 2 * nu) / nu
    values = {"E": float(f"{modulus:.6g}"), "nu": nu, "rho": model.material.density}
    if model.material.viscosity:
        return "ViscousLiquid", values | {"viscous": True, "viscosity": model.material.viscosity}
    return "MPM.Liquid", values | {"viscous": model.material.viscous}


def _snow(model: Snow) -> Made:
    material = model.material
    return "HardeningSnow", _elastic(material) | {"yield_lower": material.crush, "yield_higher": material.crumble}


_MATERIALS: dict[tuple[str, str], Callable[[Any], Made]] = {
    ("soft", "mpm"): _mpm_soft,
    ("soft", "fem"): _fem_soft,
    ("soft", "ipc"): _ipc_soft,
    ("cloth", "pbd"): _pbd_cloth,
    ("cloth", "ipc"): lambda model: ("FEM.Cloth", ipc.cloth(model)),
    ("granular", "mpm"): _granular,
    ("liquid", "mpm"): _liquid,
    ("snow", "mpm"): _snow,
}
"""By kind of body and solver."""
