"""Repair of a mesh: closed, oriented, scaled, and simplified."""

import math
import re
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from text2sim.assets.mesh_intake import Up
from text2sim.assets.mesh_report import MAX_TRIANGLES
from text2sim.assets.mesh_steps import (
    decimate,
    fill_holes,
    orient,
    repair_non_manifold,
    without_debris,
    without_duplicates,
    wrap,
)
from text2sim.assets.surface import TriangleMesh, signed_volumes, welded
from text2sim.spec_schema.errors import AssetError

Origin = Literal["base", "mass", "keep"]
MERGE_DISTANCE = 1e-6
"""Distance, as a part of the diagonal, below which vertices are merged."""
MAX_EXTENT, MIN_EXTENT = 1000.0, 1e-4
"""Allowed extents [m]."""
MIN_OPENING = 0.3
"""Diameter of a hole, as a part of the diagonal, above which it is an opening of the object."""
FINENESS = 0.01
"""Smallest gap that a wrap enters, as a part of the diagonal."""

_SIZE = re.compile(r"(?:([xyz])=)?(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)")


@dataclass(frozen=True)
class RepairGoal:
    """Goal of a repair."""

    size: float | None = None
    """Extent [m] along `along`; unchanged if None."""
    along: Literal["x", "y", "z"] | None = None
    """Axis of `size`, z up; that of the largest extent if None."""
    up: Up | None = None
    """Axis of the file that points up; the one of its format if None."""
    origin: Origin = "base"
    """Position of the origin: middle of the base, centre of mass, or unchanged."""
    triangles: int = 20_000
    """Largest number of triangles."""
    debris: float = 0.02
    """Diagonal of a loose piece, as a part of that of the largest piece, below which it is removed."""
    holes: int = 200
    """Number of edges of a hole above which it stays open."""
    openings: bool = False
    """Whether to close openings wider than `MIN_OPENING`, too, as of a bowl or a boat."""
    wrap: bool = False
    """Whether to wrap a closed skin, without pictures, around a mesh that cannot be closed otherwise."""

    def __post_init__(self) -> None:
        if self.size is not None and not MIN_EXTENT <= self.size <= MAX_EXTENT:
            raise AssetError(f"a size of {self.size:g} m is not possible: from {MIN_EXTENT:g} m to {MAX_EXTENT:g} m")
        if not 4 <= self.triangles <= MAX_TRIANGLES:
            raise AssetError(f"{self.triangles} triangles are not possible: from 4 to {MAX_TRIANGLES}")


@dataclass(frozen=True)
class Repaired:
    """A repaired mesh."""

    surface: TriangleMesh
    done: tuple[str, ...]
    """Repairs, in words."""


def parse_size(text: str) -> tuple[float, Literal["x", "y", "z"] | None]:
    """Parse a size: `0.3` is the largest extent [m], `z=0.3` the height.

    Raises:
        AssetError: if it is neither.
    """
    found = _SIZE.fullmatch(text.strip())
    if found is None:
        raise AssetError(f"`{text[:40]}` is not a size; write 0.3 for the largest extent in metres, or z=0.3")
    axis = found[1]
    return float(found[2]), axis if axis in ("x", "y", "z") else None  # type: ignore[return-value]


def repair(surface: TriangleMesh, goal: RepairGoal) -> Repaired:
    """Repair a surface.

    Raises:
        AssetError: if nothing of it is left, or it has no extent.
    """
    done: list[str] = []
    if surface.diagonal <= 0:
        raise AssetError("has no extent: all its vertices are in one point")
    surface = _cleaned(surface, goal, done)
    surface = _closed(surface, goal, done)
    surface = _simplify(surface, goal.triangles, done)
    if goal.wrap and not surface.watertight:
        surface = wrap(surface, FINENESS)
        done.append("wrapped a closed skin, without pictures, around it, as it could not be closed otherwise")
        surface = _simplify(surface, goal.triangles, done)
    surface = _scaled(surface, goal, done)
    surface = _move_origin(surface, goal.origin, done)
    return Repaired(surface, tuple(done))


def _cleaned(surface: TriangleMesh, goal: RepairGoal, done: list[str]) -> TriangleMesh:
    before = len(surface.vertices), len(surface.faces)
    surface = without_duplicates(welded(surface, MERGE_DISTANCE * surface.diagonal))
    if not len(surface.faces):
        raise AssetError("has no triangles with an area")
    merged, dropped = before[0] - len(surface.vertices), before[1] - len(surface.faces)
    if merged:
        done.append(f"merged {_count(merged, 'vertex', 'vertices')} with neighbours")
    if dropped:
        done.append(f"removed {_count(dropped, 'triangle')} without area or with a duplicate")
    surface, specks = without_debris(surface, goal.debris)
    if specks:
        done.append(f"removed {_count(specks, 'loose speck')} smaller than {goal.debris:.0%} of the rest")
    return surface


def _closed(surface: TriangleMesh, goal: RepairGoal, done: list[str]) -> TriangleMesh:
    surface, turned = orient(surface)
    if surface.edge_counts[0] and not surface.flat:
        surface, added = fill_holes(surface, goal.holes, 1.0 if goal.openings else MIN_OPENING)
        if added:
            done.append(f"closed holes with {_count(added, 'triangle')}")
    if surface.edge_counts[1]:
        knots = surface.edge_counts[1]
        better = repair_non_manifold(surface, goal.holes)
        if better is not surface:
            surface = better
            done.append(f"repaired {_count(knots, 'edge')} with more than two triangles")
    surface, again = orient(surface)
    if turned or again:
        done.append(f"turned {_count(max(turned, again), 'triangle')} to face outwards")
    return surface


def _simplify(surface: TriangleMesh, max_triangles: int, done: list[str]) -> TriangleMesh:
    count = len(surface.faces)
    fewer = decimate(surface, max_triangles)
    if len(fewer.faces) < count:
        done.append(f"simplified from {count:,} to {len(fewer.faces):,} triangles")
    return fewer


def _scaled(surface: TriangleMesh, goal: RepairGoal, done: list[str]) -> TriangleMesh:
    if goal.size is None:
        return surface
    extent = surface.extent
    length = float(extent.max() if goal.along is None else extent["xyz".index(goal.along)])
    if length <= 1e-9 * surface.diagonal:
        raise AssetError(f"is flat along {goal.along}, so that it cannot be scaled to {goal.size:g} m there")
    factor = goal.size / length
    if not math.isclose(factor, 1.0, rel_tol=1e-9):
        done.append(f"scaled by {factor:.4g}")
    return replace(surface, vertices=surface.vertices * factor)


def _move_origin(surface: TriangleMesh, origin: Origin, done: list[str]) -> TriangleMesh:
    if origin == "keep":
        return surface
    used = surface.used
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    if origin == "base":
        middle[2] = used[:, 2].min()
        word = "middle of its base"
    elif surface.watertight and not surface.flat:
        middle = _center_of_mass(surface)
        word = "centre of mass"
    else:
        word = "middle of its extent, as it encloses no volume"
    if np.abs(middle).max() > 1e-9 * surface.diagonal:
        done.append(f"moved the origin to the {word}")
    return replace(surface, vertices=surface.vertices - middle)


def _center_of_mass(surface: TriangleMesh) -> np.ndarray:
    middle = surface.used.mean(axis=0)
    corners = surface.vertices[surface.faces] - middle
    volumes = signed_volumes(corners)
    return middle + (corners.sum(axis=1) * volumes[:, None]).sum(axis=0) / (4.0 * volumes.sum())


def _count(number: int, one: str, plural: str = "") -> str:
    return f"{number:,} {one if number == 1 else plural or one + 's'}"
