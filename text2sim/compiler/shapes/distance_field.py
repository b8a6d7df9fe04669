"""The signed distance field by which a mesh touches exactly: its grid, and what it costs.

The engine (genesis-world 1.4.5, `SignedDistanceFieldDescription`) keeps the distance to the surface at the nodes of a
grid around the mesh, wider than it by a tenth of its longest side on each side, and interpolates between them.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.assets.answer_cache import cached_answer
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

GRID_MARGIN = 0.2
"""Part of the longest side by which the grid is longer than the mesh, along each axis."""
LEAST_NODES, MIN_NODES, MAX_NODES = 16, 96, 128
"""Nodes along a side: the fewest that the engine makes, and the limits along the longest one without `cell`."""
MOST_NODES = 4_000_000
"""Nodes of one field: 80 MB in a run, 0.7 GB while it is made."""
MOST_TRIANGLES = 50_000
"""With more, the engine warns, a field may take ten minutes and 20 GB."""
BYTES_PER_NODE = 20
"""Bytes of a node in a run: distance, its gradient and the nearest corner."""
WALL_RAYS = 250
"""About how many rays measure the walls."""
THIN_WALL_SHARE = 0.25
"""Part of the surface with walls thinner than the thickness that is given for them."""
MAX_TESTED_PAIRS = 1_000_000
"""Rays times triangles that are tested at once."""


@dataclass(frozen=True)
class DistanceField:
    """The grid of a mesh."""

    cell: float
    """Largest distance [m] of neighbouring nodes."""
    sides: tuple[float, float, float]
    """Lengths of the grid [m]."""
    wall: float
    """Thickness [m] of the walls of the mesh: a quarter of its surface has thinner ones."""

    @cached_property
    def most(self) -> int:
        """Most nodes along a side."""
        return max(LEAST_NODES, math.ceil(max(self.sides) / self.cell - 1e-6) + 1)

    @cached_property
    def nodes(self) -> tuple[int, int, int]:
        """Nodes along each side."""
        target = min(self.cell, self.wall / 2)
        cells = (min(max(target, side / (self.most - 1)), side / (LEAST_NODES - 1)) for side in self.sides)
        a, b, c = (math.ceil(side / cell - 1e-6) + 1 for side, cell in zip(self.sides, cells, strict=True))
        return a, b, c

    def __str__(self) -> str:
        a, b, c = self.nodes
        return (
            f"through a field of {a} x {b} x {c} nodes ({a * b * c * BYTES_PER_NODE / 1e6:.2g} MB), "
            f"{self.cell * 1e3:.3g} mm apart; its walls are {self.wall * 1e3:.3g} mm thick"
        )


def field_of(vertices: "np.ndarray", faces: "np.ndarray", cell: float | None) -> DistanceField:
    """Choose the grid of a closed mesh.

    Args:
        vertices: Corners [m], shape (n, 3).
        faces: Triangles, counterclockwise from outside, shape (m, 3).
        cell: Distance [m] of neighbouring nodes; None for half of the walls, as far as 128 nodes along a side allow.

    Raises:
        AssetError: if it would be too large.
    """
    if len(faces) > MOST_TRIANGLES:
        raise AssetError(
            f"has {len(faces):,} triangles, and exact contact takes {MOST_TRIANGLES:,} at most; simplify it, or take "
            "`collision: decompose`"
        )
    span = vertices.max(axis=0) - vertices.min(axis=0)
    a, b, c = (span + GRID_MARGIN * span.max()).tolist()
    longest, wall = max(a, b, c), wall_of(vertices, faces)
    if cell is None:
        cell = min(max(wall / 2, longest / (MAX_NODES - 1)), longest / (MIN_NODES - 1))
    field = DistanceField(cell, (a, b, c), wall)
    if math.prod(field.nodes) > MOST_NODES:
        least = max((a * b * c / MOST_NODES) ** (1 / 3), cell)
        while math.prod(DistanceField(least, (a, b, c), wall).nodes) > MOST_NODES:
            least *= 1.02
        x, y, z = field.nodes
        raise AssetError(
            f"with a `cell` of {cell:.3g} m needs a field of {x:,} x {y:,} x {z:,} nodes, and {MOST_NODES:,} are "
            f"possible: take {rounded_up(least):g} m or more"
        )
    return field


def rounded_up(value: float) -> float:
    """Return a value rounded up to two digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / digit) * digit:.2g}")


def rounded_down(value: float) -> float:
    """Return a value rounded down to two digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / digit) * digit:.2g}")


def wall_of(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    """Return how thick [m] the walls of a closed mesh are: a quarter of its surface has thinner ones.

    Rays go inward from the middles of triangles to the opposite side, as those of the engine do, which refines its
    grid to two cells in a wall.
    """
    own = Path(__file__).read_bytes()
    question = (b"wall", own, sha256(vertices.tobytes()).digest(), sha256(faces.tobytes()).digest())
    return cached_answer(question, lambda: _wall(vertices, faces))


def _wall(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    import numpy as np

    corners = vertices[faces]
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    area = np.linalg.norm(normal, axis=1)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    sound = np.flatnonzero(area > 1e-12 * size**2)
    chosen = sound[:: max(1, len(sound) // WALL_RAYS)]
    directions = -normal[chosen] / area[chosen, None]
    skin = 1e-4 * size
    starts = corners[chosen].mean(axis=1) + skin * directions
    found = np.full(len(chosen), np.inf)
    block = max(1, MAX_TESTED_PAIRS // len(faces))
    for first in range(0, len(chosen), block):
        direction, start = directions[first : first + block, None], starts[first : first + block, None]
        # Möller and Trumbore 1997.
        across = np.cross(direction, v)
        volume = np.einsum("rij,ij->ri", across, u)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = start - a
            p = np.einsum("rij,rij->ri", away, across) / volume
            over = np.cross(away, u)
            q = np.einsum("rkj,rij->ri", direction, over) / volume
            far = np.einsum("rij,ij->ri", over, v) / volume
            hit = (p >= -1e-9) & (q >= -1e-9) & (p + q <= 1 + 1e-9) & (far > skin)
        found[first : first + block] = np.where(hit, far + skin, np.inf).min(axis=1)
    hits = np.isfinite(found)
    if not hits.any():
        return size
    order = np.argsort(found[hits])
    covered = np.cumsum(area[chosen][hits][order])
    return float(found[hits][order][np.searchsorted(covered, THIN_WALL_SHARE * covered[-1])])
