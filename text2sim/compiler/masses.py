"""Masses of bodies, and the speeds that the case gives them."""

from collections.abc import Iterable
from functools import cache
from math import hypot
from typing import TYPE_CHECKING

from text2sim.compiler.controls import ControlRows
from text2sim.compiler.lower import Lowering
from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import Group
from text2sim.compiler.shapes import geometry
from text2sim.compiler.soft.lowering import mass
from text2sim.compiler.soft.solvers import is_soft

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution


def masses(resolution: "Resolution") -> dict[str, float]:
    """Return the mass [kg] of every copy of a body, by its name; for a body from a file, the mass in the file."""
    copies = (copy for name in resolution.loaded.case.bodies for copy in resolution.placed[name])
    return masses_of(resolution.lowering, resolution.plan.bodies, copies)


def masses_of(lowering: Lowering, groups: Iterable[Group], copies: Iterable[Copy]) -> dict[str, float]:
    """Return the mass [kg] of copies of bodies, by their names.

    Args:
        lowering: Their trees.
        groups: Their entities.
        copies: Which ones.
    """
    densities = {entity.name: entity.rho for group in groups for entity in group.entities}
    found: dict[str, float] = {}

    @cache
    def volume(shape: ObjectKey) -> float:
        return sum(piece.volume() for piece in geometry.pieces(shape.value, lowering.folder))

    for copy in copies:
        tree = lowering.trees.get(copy.name)
        density = densities[copy.name]
        if is_soft(copy.model):
            found[copy.name] = mass(copy, lowering.folder)
        elif getattr(copy.model, "file", None) is not None:
            found[copy.name] = lowering.mechanisms[copy.model.file, copy.model.base].mass
        elif tree is not None:
            found[copy.name] = sum(geom.density * geom.piece.volume() for geom in tree.geoms())
        elif density is not None:
            found[copy.name] = density * volume(ObjectKey(copy.shape))
    return found


def known_speeds(
    lowering: Lowering, groups: Iterable[Group], copies: Iterable[Copy], rows: ControlRows
) -> dict[str, float]:
    """Return the largest speed [m/s] that start velocities and impulses alone give copies of bodies, by their names.

    An impulse J gives a body of mass m the speed J / m, wherever it strikes; impulses add up, as if in one direction.

    Args:
        lowering: What the copies became.
        groups: Their entities.
        copies: Copies of bodies.
        rows: Controls, lowered.
    """
    speeds = {row.entity: hypot(*row.linear) for row in rows.velocities}
    impulses = [row for row in rows.wrenches if row.start == row.end]
    if not impulses:
        return speeds
    struck = {row.entity for row in impulses}
    weights = masses_of(lowering, groups, (copy for copy in copies if copy.name in struck))
    for row in impulses:
        if weights.get(row.entity, 0.0) > 0.0:
            speeds[row.entity] = speeds.get(row.entity, 0.0) + hypot(*row.force) / weights[row.entity]
    return speeds
