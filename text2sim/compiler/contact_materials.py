"""What materials of bodies and links say about contact: restitution, and friction against rolling and spin."""

from collections.abc import Iterable, Mapping
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.settings import Settings
from text2sim.compiler.soft.solvers import is_soft
from text2sim.spec_schema.models.materials import Material

Restitutions = Mapping[str, float]
"""Restitution by copy (`ball`, `brick[3]`), or by link (`arm.hand`) where a link has its own."""


def materials_of(model: Any) -> dict[str, Material]:
    """Return the materials of a rigid model by link; the empty name stands for links without their own."""
    own, links = getattr(model, "material", None), getattr(model, "links", None)
    found: dict[str, Material] = {"": own} if isinstance(own, Material) else {}
    if isinstance(links, dict):
        found |= {name: link.material for name, link in links.items() if link.material is not None}
    if (payload := getattr(model, "payload", None)) is not None:
        found["payload"] = payload.material
    return found


def resists_rolling(models: Iterable[Any]) -> bool:
    """Return whether a material of these models has rolling or torsional friction."""
    return any(any(material.torques) for model in models for material in materials_of(model).values())


def restitutions(copies: Iterable[Copy]) -> dict[str, float]:
    """Return the restitution of copies and links that have one."""
    return {
        _selector(copy, link): material.restitution
        for copy in copies
        for link, material in materials_of(copy.model).items()
        if material.restitution is not None
    }


def contact_damping(
    placed: Mapping[str, list[Copy]], restitution_of: Restitutions, statics: set[str], settings: Settings, step: float
) -> dict[str, tuple[float, float]]:
    """Return time constant [s] and damping ratio by rigid copy, and by link with a material of its own.

    A contact gets the mean of both damping ratios. A static without a restitution of its own takes the largest of the
    scene, so that a ball bounces with its own value on a floor that gives none; where bodies bounce unequally, it
    takes that of each body that touches it (`templates/bounce.py`).

    Args:
        placed: Copies by static and body.
        restitution_of: Restitution by copy, and by link with a material of its own.
        statics: Names of statics.
        settings: Of the solver.
        step: Solver step [s].
    """
    if not restitution_of:
        return {}
    largest, values = max(restitution_of.values()), {}
    for name, group in placed.items():
        for copy in group:
            if is_soft(copy.model):  # points, whose contacts are not the rigid solver's
                continue
            default = largest if name in statics else 0.0
            for link in {"": None, **materials_of(copy.model)}:
                time, ratio = settings.contact_damping(restitution_of.get(_selector(copy, link), default), step)
                values[_selector(copy, link)] = (round(time, 9), round(ratio, 6))
    return values


def _selector(copy: Copy, link: str) -> str:
    return f"{copy.name}.{link}" if link else copy.name
