"""Repair of a mesh file of any origin: whole, upright, of the right size, and not too fine."""

import math
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from text2sim.assets.mesh_intake import Up
from text2sim.assets.mesh_output import mesh_bytes, suffix_for
from text2sim.assets.mesh_report import faults
from text2sim.assets.mesh_steps import decimated, filled, oriented, unknotted, without_debris, without_doubles, wrapped
from text2sim.assets.surface import TriangleMesh, welded
from text2sim.spec_schema.errors import AssetError

Origin = Literal["base", "mass", "keep"]
MERGE = 1e-6
"""Vertices that are nearer to each other than this part of the diagonal are one."""
LARGEST, SMALLEST = 1000.0, 1e-4
"""Extents [m] that can be asked for."""
OPENING = 0.3
"""A hole that is wider than this part of the diagonal is meant."""
FINENESS = 0.01
"""Smallest gap that a wrap goes into, as a part of the diagonal."""

_SIZE = re.compile(r"(?:([xyz])=)?(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)")


@dataclass(frozen=True)
class RepairGoal:
    """What a mesh shall become."""

    size: float | None = None
    """Wanted extent [m] along `along`; as the file has it if None."""
    along: Literal["x", "y", "z"] | None = None
    """Which extent is meant, z up; the largest if None."""
    up: Up | None = None
    """The axis of the file that points up; as its format has it if None."""
    origin: Origin = "base"
    """Where the origin comes to lie: middle of the base, centre of mass, or where it is."""
    triangles: int = 20_000
    """So many there may be at most."""
    debris: float = 0.02
    """A loose piece whose diagonal is less than this part of the largest piece's goes."""
    holes: int = 200
    """A hole of more edges than this stays open."""
    openings: bool = False
    """Close wide openings as well: those of more than `OPENING` of the diagonal, as of a bowl or a boat."""
    wrap: bool = False
    """Put a closed skin around it if it cannot be closed otherwise; pictures are lost with that."""

    def __post_init__(self) -> None:
        if self.size is not None and not SMALLEST <= self.size <= LARGEST:
            raise AssetError(f"a size of {self.size:g} m is not possible: from {SMALLEST:g} m to {LARGEST:g} m")
        if not 4 <= self.triangles <= 200_000:
            raise AssetError(f"{self.triangles} triangles are not possible: from 4 to 200000")


@dataclass(frozen=True)
class Repaired:
    """A repaired mesh."""

    surface: TriangleMesh
    done: tuple[str, ...]
    """What was done, in words."""
    remains: tuple[str, ...]
    """What is still wrong, in words."""

    def file(self, suffix: str | None = None) -> tuple[str, bytes]:
        """Return the suffix and the content of its file: the kind that loses nothing, or one that is asked for."""
        suffix = suffix or suffix_for(self.surface)
        return suffix, mesh_bytes(self.surface, suffix)


def parse_size(text: str) -> tuple[float, Literal["x", "y", "z"] | None]:
    """Return what a size means: `0.3` is the largest extent [m], `z=0.3` the height.

    Raises:
        AssetError: if it is neither.
    """
    found = _SIZE.fullmatch(text.strip())
    if found is None:
        raise AssetError(f"`{text[:40]}` is not a size; write 0.3 for the largest extent in metres, or z=0.3")
    axis = found[1]
    return float(found[2]), axis if axis in ("x", "y", "z") else None  # type: ignore[return-value]


def repair(surface: TriangleMesh, wish: RepairGoal) -> Repaired:
    """Return what a surface becomes.

    Raises:
        AssetError: if nothing of it is left, or it has no extent.
    """
    done: list[str] = []
    if surface.diagonal <= 0:
        raise AssetError("has no extent: all its vertices lie in one point")
    surface = _cleaned(surface, wish, done)
    surface = _closed(surface, wish, done)
    surface = _simpler(surface, wish.triangles, done)
    if wish.wrap and not surface.watertight:
        surface = wrapped(surface, FINENESS)
        done.append("put a closed skin around it, without its picture, as it could not be closed otherwise")
        surface = _simpler(surface, wish.triangles, done)
    surface = _scaled(surface, wish, done)
    surface = _moved(surface, wish.origin, done)
    return Repaired(surface, tuple(done), tuple(faults(surface)))


def _cleaned(surface: TriangleMesh, wish: RepairGoal, done: list[str]) -> TriangleMesh:
    before = len(surface.vertices), len(surface.faces)
    surface = without_doubles(welded(surface, MERGE * surface.diagonal))
    if not len(surface.faces):
        raise AssetError("has no triangles with an area")
    merged, dropped = before[0] - len(surface.vertices), before[1] - len(surface.faces)
    if merged:
        done.append(f"merged {_count(merged, 'vertex', 'vertices')} with neighbours")
    if dropped:
        done.append(f"dropped {_count(dropped, 'triangle')} that had no area or were there twice")
    surface, specks = without_debris(surface, wish.debris)
    if specks:
        done.append(f"dropped {_count(specks, 'loose speck')} smaller than {wish.debris:.0%} of the rest")
    return surface


def _closed(surface: TriangleMesh, wish: RepairGoal, done: list[str]) -> TriangleMesh:
    surface, turned = oriented(surface)
    if surface.edge_counts[0] and not surface.flat:
        surface, added = filled(surface, wish.holes, 1.0 if wish.openings else OPENING)
        if added:
            done.append(f"closed holes with {_count(added, 'triangle')}")
    if surface.edge_counts[1]:
        knots = surface.edge_counts[1]
        better = unknotted(surface, wish.holes)
        if better is not surface:
            surface = better
            done.append(f"repaired {_count(knots, 'edge')} on which more than two triangles met")
    surface, again = oriented(surface)
    if turned or again:
        done.append(f"turned {_count(max(turned, again), 'triangle')} to face outwards")
    return surface


def _simpler(surface: TriangleMesh, most: int, done: list[str]) -> TriangleMesh:
    count = len(surface.faces)
    fewer = decimated(surface, most)
    if len(fewer.faces) < count:
        done.append(f"simplified from {count:,} to {len(fewer.faces):,} triangles")
    return fewer


def _scaled(surface: TriangleMesh, wish: RepairGoal, done: list[str]) -> TriangleMesh:
    if wish.size is None:
        return surface
    extent = surface.extent
    length = float(extent.max() if wish.along is None else extent["xyz".index(wish.along)])
    if length <= 1e-9 * surface.diagonal:
        raise AssetError(f"is flat along {wish.along}, so that no scale gives it {wish.size:g} m there")
    factor = wish.size / length
    if not math.isclose(factor, 1.0, rel_tol=1e-9):
        done.append(f"scaled by {factor:.4g}")
    return surface.move(surface.vertices * factor)


def _moved(surface: TriangleMesh, origin: Origin, done: list[str]) -> TriangleMesh:
    if origin == "keep":
        return surface
    used = surface.used
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    if origin == "base":
        middle[2] = used[:, 2].min()
    elif surface.watertight:
        middle = _center_of_mass(surface)
    if np.abs(middle).max() > 1e-9 * surface.diagonal:
        word = "middle of its base" if origin == "base" else "centre of mass"
        done.append(f"put the origin into the {word}")
    return surface.move(surface.vertices - middle)


def _center_of_mass(surface: TriangleMesh) -> np.ndarray:
    middle = surface.used.mean(axis=0)
    corners = surface.vertices[surface.faces] - middle
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    return middle + (corners.sum(axis=1) * volumes[:, None]).sum(axis=0) / (4.0 * volumes.sum())


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}"
