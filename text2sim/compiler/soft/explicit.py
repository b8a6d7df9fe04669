"""Derived values of deformable bodies, written out in a case."""

from typing import Any

from text2sim.compiler.build import Resolution
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.soft.materials import open_values
from text2sim.compiler.soft.solvers import solver_of
from text2sim.spec_schema.models.soft_bodies import Cloth, Granular, Liquid, Snow, Soft
from text2sim.spec_schema.text.document import Path


def add_soft(data: dict[str, Any], comments: dict[Path, str], resolution: Resolution) -> None:
    """Write solvers, their settings and the elements of deformable bodies into the plain data of a case.

    Args:
        data: The case.
        comments: Comments behind values; added to.
        resolution: Of the case.
    """
    soft = resolution.settings.soft
    scene, case = data["scene"], resolution.loaded.case
    for section in ("mpm", "pbd", "fem", "ipc"):
        # A solver without bodies is left out, unless the case has its section.
        if getattr(soft, section, None) is None and section not in case.scene.model_fields_set:
            del scene[section]
    if soft is None:
        scene["contact"]["model"] = "rigid"
        return
    if "max_speed" in soft.why:
        comments["scene", "max_speed"] = f"derived: {soft.why['max_speed']}"
    places: dict[str, tuple[Path, Any]] = {"model": (("contact", "model"), soft.model)}
    if soft.mpm is not None:
        places["mpm_cell"] = ("mpm", "cell"), soft.mpm.cell
        places["mpm_bounds"] = ("mpm", "bounds"), _bounds(soft.mpm.low, soft.mpm.high)
    if soft.pbd is not None:
        places["pbd_size"] = ("pbd", "particle_size"), soft.pbd.particle_size
        places["pbd_bounds"] = ("pbd", "bounds"), _bounds(soft.pbd.low, soft.pbd.high)
        places["stretch_iterations"] = ("pbd", "stretch_iterations"), soft.pbd.stretch_iterations
        places["bending_iterations"] = ("pbd", "bending_iterations"), soft.pbd.bending_iterations
    if soft.fem is not None and soft.model != "ipc":
        places["newton_iterations"] = ("fem", "newton_iterations"), soft.fem.newton_iterations
        places["damping_beta"] = ("fem", "damping_beta"), soft.fem.damping_beta
    if soft.ipc is not None:
        places["contact_distance"] = ("ipc", "contact_distance"), soft.ipc.contact_distance
    for name, ((section, key), value) in places.items():
        scene.setdefault(section, {})[key] = value
        if name in soft.why:
            comments["scene", section, key] = f"derived: {soft.why[name]}"
    assert resolution.lowering.soft is not None
    scales = resolution.lowering.soft.scales
    edges = scales.edges
    for name, body in case.bodies.items():
        if not isinstance(body, Soft | Cloth | Granular | Liquid | Snow):
            continue
        own, root = data["bodies"][name], ("bodies", name)
        solver = solver_of(body, case.scene)
        if isinstance(body, Soft | Cloth) and body.solver is None:
            own["solver"] = solver
            comments[*root, "solver"] = "derived: goes with scene.contact.model"
        if name in edges and body.cell is None:
            own["cell"] = edges[name]
            comments[*root, "cell"] = f"derived: {soft.why[f'{solver}_edge']}"
        values = open_values(body, str(solver), scales.spacing(name, str(solver)))
        if solver == "fem" and soft.fem is not None:  # there is none if the contact model has no such bodies
            why = soft.why.get("damping_alpha", "the largest that a body has: the engine knows one for all")
            values = {"damping": (soft.fem.damping_alpha, why)}
        _add_material(own, comments, root, values)


def _add_material(own: Any, comments: dict[Path, str], root: Path, values: dict[str, tuple[float, str]]) -> None:
    for name, (value, why) in values.items():
        if own["material"].get(name) is None:
            own["material"][name] = value
            comments[*root, "material", name] = f"derived: {why}"


def _bounds(low: Vec, high: Vec) -> dict[str, list[float]]:
    return {"min": list(low), "max": list(high)}
