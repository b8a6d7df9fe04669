"""Solvers of deformable bodies, and the contact between their families."""

from collections.abc import Iterable
from typing import Any

from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.soft_bodies import FLOWING

FAMILIES = {"mpm": "mpm", "pbd": "pbd", "fem": "fem", "ipc": "fem"}
"""Solver of the engine by solver of the language: with ipc, cloth is a shell of the engine's fem solver."""


def is_soft(body: Any) -> bool:
    """Return whether a body is deformable: made of points, not of links."""
    return isinstance(body, Deformable)


def touches_soft(model: Any) -> bool:
    """Return whether deformable bodies feel a rigid one, or any of its links."""
    links = getattr(model, "links", None)
    if isinstance(links, dict):
        return len(unfelt_links(model)) < len(links)
    return getattr(getattr(model, "material", None), "touch_soft", True)


def unfelt_links(body: Any) -> frozenset[str]:
    """Return the links of a body that deformable bodies do not feel: what a link says counts before its body."""
    links = getattr(body, "links", None)
    if not isinstance(links, dict):
        return frozenset()

    def felt(link: Any) -> bool:
        says = link.material is not None and "touch_soft" in link.material.model_fields_set
        return (link if says else body).material.touch_soft

    return frozenset(name for name, link in links.items() if not felt(link))


def solver_of(body: Any, scene: Scene) -> str | None:
    """Return `mpm`, `pbd`, `fem` or `ipc`; None for a body of links, and for a static.

    Args:
        body: The validated model.
        scene: Its scene, whose contact model decides if the body names no solver.
    """
    kind = getattr(body, "kind", None)
    if kind in FLOWING:
        return "mpm"
    if kind == "soft":
        return body.solver or ("fem" if scene.contact.model in ("sap", "ipc") else "mpm")
    if kind == "cloth":
        return body.solver or ("ipc" if scene.contact.model == "ipc" else "pbd")
    return None


def solvers_of(bodies: Iterable[Body], scene: Scene) -> set[str]:
    """Return the solvers of all deformable bodies."""
    return {solver for body in bodies if (solver := solver_of(body, scene)) is not None}


def contact_model(bodies: Iterable[Body], scene: Scene) -> str:
    """Return the contact model of a scene: the one it names, or the one that its bodies need."""
    if scene.contact.model is not None:
        return scene.contact.model
    solvers = solvers_of(bodies, scene)
    if "ipc" in solvers:
        return "ipc"
    if "fem" in solvers:
        return "sap"
    return "particle" if solvers else "rigid"


def holds_up(kinds: Iterable[str]) -> bool:
    """Return whether the nodes of the grid near walls are stopped, so that liquids keep their level.

    Args:
        kinds: Of all mpm bodies of the scene. Grains and snow rub against walls at those nodes.
    """
    return set(kinds) <= {"liquid", "soft"}
