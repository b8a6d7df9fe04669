"""Belts: statics whose surfaces move, which become sliders that the program sets back before every step."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, quat_rotate, vector_unit
from text2sim.compiler.soft.solvers import contact_model
from text2sim.compiler.trees.tree import TreeJoint
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.names.removal_references import fixed_because

DRIVEN_ARMATURE = 1e4
"""Armature [kg or kg m2] of the joints of belts and driven bodies: contact cannot push them back.

The solver's stopping criterion scales with the mean inertia of the scene: ten times as much here would make the
contacts of all other bodies ten times less exact."""


@dataclass(frozen=True)
class Belt:
    """A static whose surface moves along its only joint."""

    entity: str
    velocity: Vec
    """Of the surface, in its own frame [m/s]."""
    line: int


def check_belts(loaded: LoadedCase) -> list[Problem]:
    """Return why surfaces cannot move in a scene, at each static whose surface should."""
    case = loaded.case
    model = contact_model(case.bodies.values(), case.scene)
    scene = case.scene.model_copy(update={"contact": case.scene.contact.model_copy(update={"model": model})})
    why = fixed_because(scene, "what lies on it would not be carried while it sleeps", "has no moving surfaces")
    return [
        loaded.problem(
            ("scene", "statics", name, "surface_velocity"), f"no surface can move here: {why}", rule="moving-surface"
        )
        for name, static in case.scene.statics.items()
        if why and static.carries
    ]


def lower_belts(copies: dict[str, list[Copy]]) -> tuple[Belt, ...]:
    """Return the rows for statics whose surfaces move."""
    return tuple(Belt(copy.name, copy.model.surface_velocity, copy.line) for copy in carriers(copies))


def carriers(copies: dict[str, list[Copy]]) -> Iterable[Copy]:
    """Yield the copies of statics whose surfaces move."""
    return (copy for group in copies.values() for copy in group if carries(copy.model))


def carries(model: Any) -> bool:
    """Return whether a body or static is one whose surface moves."""
    return isinstance(model, Static) and model.carries


def world_velocity(copy: Copy) -> Vec:
    """Return the velocity [m/s] of the surface of a belt in the world."""
    return quat_rotate(copy.quat, copy.model.surface_velocity)


def slider_of_belt(model: Static) -> TreeJoint:
    """Return the joint on which a belt runs."""
    assert model.surface_velocity is not None
    return TreeJoint("slider", axis=vector_unit(model.surface_velocity), armature=DRIVEN_ARMATURE)
