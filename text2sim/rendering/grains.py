"""Sand and snow: particles drawn as flat grains that lie in the surface of their heap.

Round grains of a pixel's size would show no form: a heap of them is as bright on all sides. Grains that lie in the
surface are lit like it. What has come loose, spray and crumbs, is round instead: flat, it would look like chips.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from text2sim.recording.film_record import SoftPart
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.shapes import shaded
from text2sim.templates.shading import enclosed

Array = NDArray[np.floating]

SHADES = {"granular": (0.8, 0.92, 1.0, 1.06, 1.14), "snow": (0.97, 1.0)}
"""Factors on the colour, by which grains differ."""
BED = (0.8, 0.3, 0.8)
"""Mean radius and half thickness of the flat bodies that fill a heap below its grains, and their largest offset along
the ground, in particle distances."""
CRUMBS = {"granular": (8, 0.24, 1.15, 0.5), "snow": (8, 0.24, 0.7, 0.5)}
"""Number of grains per particle, their radius, and their largest offsets along and across the ground, in particle
distances: along it more than half a cell of the solver, whose steps would show in the outline."""
FLAT, TILT = 0.6, 0.14
"""Thickness of a grain relative to its width, and how much its tilt differs from that of the surface."""
LOOSE, HEAPED = 0.15, 0.3
"""Smoothed density up to which particles are loose, and from which on they are in a heap: a single one has 0.008, a
layer on the ground 0.2, the side of a heap 0.5."""
LUMP = 0.5
"""Radius of the round body of a loose particle, in particle distances."""
ENCLOSING = 1.5
"""Edge of the cells that hide a particle if all around it are occupied, in particle distances."""
MAX_GRAINS = 400_000
"""Largest number of grains drawn for a body."""
OUTSIDE, BEYOND = 1.0, 0.3
"""Percentage of grains on each side that count as flown away where they are further out than this fraction of the width
of the others."""
FLAT_SIDE = (0.45, 0.75)
"""Share of the outline of a body, seen along x or y, behind which particles lie in one plane: up to the first it has no
flat side there, from the second on it lies against a wall, beyond which no grain is drawn."""
AT_SIDE, PAST_SIDE, SIDE_CELL, ASTRAY = 1.0, 0.35, 2.0, 0.001
"""Depth of that plane, how far grains reach beyond its outermost particles, and the edge of the cells of the outline,
in particle distances; and the fraction of all particles that may be further out."""
SOFTENED, CELLS = 2.0, 96
"""Distance [particle distances] over which the surface is smoothed to find where it faces, and largest number of cells
along a side for that."""


class Grains:
    """Particles, each drawn as several grains; invisible ones inside a heap are skipped."""

    is_clear = False

    def __init__(self, name: str, part: SoftPart):
        self.name, self._spacing = name, float(part.row["spacing"])
        first, end = part.row["points"]
        count = end - first
        many, radius, along, across = CRUMBS.get(part.kind, CRUMBS["granular"])
        many = max(1, min(many, MAX_GRAINS // max(count, 1)))
        chance = np.random.default_rng(7)
        offsets = chance.standard_normal((count, many, 3))
        offsets *= (chance.uniform(0.1, 1.0, (count, many, 1)) ** (1 / 2)) / np.linalg.norm(
            offsets, axis=2, keepdims=True
        )
        self._offsets = offsets * (along * self._spacing, along * self._spacing, across * self._spacing)
        self._sizes = radius * self._spacing * chance.uniform(0.5, 1.3, (count, many, 3)) * (1, 1, FLAT)
        self._tilts = chance.standard_normal((count, many, 3)) * TILT
        wide, thick, astray = np.array(BED) * self._spacing
        self._bed_offsets = np.pad(chance.uniform(-astray, astray, (count, 2)), ((0, 0), (0, 1)))
        self._bed_sizes = chance.uniform(0.6, 1.2, (count, 1)) * (wide, wide, thick)
        shades = SHADES.get(part.kind, (1.0,))
        self._shade = chance.integers(len(shades), size=(count, many))
        look = part.look
        self._bsdfs = [
            mitsuba().load_dict({
                "type": "principled", "roughness": 0.8, "specular": 0.25,
                "base_color": {"type": "rgb", "value": np.clip(shaded(look.color, look.finish)[0] * f, 0, 1).tolist()},
            })
            for f in shades
        ]  # fmt: skip

    def shapes(self, points: Array, bsdf: Any = None) -> dict[str, Any]:
        """Return the grains for these particle positions [m]."""
        outside = ~enclosed(points, ENCLOSING * self._spacing)
        # What has not come out of a stream yet is last among its particles.
        count = len(points)
        facing, dense = (values[outside] for values in heap_surface(points, self._spacing))
        loose = np.clip((HEAPED - dense) / (HEAPED - LOOSE), 0.0, 1.0)[:, None]
        sides, surface = flat_sides(points, self._spacing), points[outside]
        on = np.full(len(surface), -1)
        for number, (axis, sign, end, flat) in enumerate(sides):
            on[sign * surface[:, axis] > end - (AT_SIDE + PAST_SIDE) * self._spacing] = number
            facing[on == number] += flat * (sign * np.eye(3)[axis] - facing[on == number])
        sizes, shade = self._sizes[:count][outside].copy(), self._shade[:count][outside]
        sizes[..., 2] /= FLAT + (1 - FLAT) * (1 - loose)
        centers = surface[:, None] + self._offsets[:count][outside]
        centers = _against(centers, on, sides, sizes[..., ::2])
        beds, aside = self._bed_sizes[:count][outside], self._bed_offsets[:count][outside]
        round_ = beds[:, :1] * LUMP / BED[0]
        beds, aside = beds + loose * (round_ - beds), aside * (1 - loose)
        axes = facing[:, None] + self._tilts[:count][outside]
        found = {}
        for k, own in enumerate(self._bsdfs):
            shown = shade == k
            at, size, axis = centers[shown], sizes[shown], axes[shown]
            if k == len(self._bsdfs) // 2:
                bed = _against((surface + aside)[:, None], on, sides, beds[:, None, ::2])
                at = np.concatenate([at, bed[:, 0]])
                size = np.concatenate([size, beds])
                axis = np.concatenate([axis, facing])
            if len(at):
                found[f"{self.name}_{k}"] = _ellipsoids(at, size, axis, bsdf or own)
        return found


class FlatSide(NamedTuple):
    """An upright side along x or y on which a body lies against a wall."""

    axis: int
    sign: float
    """Of the outward normal."""
    end: float
    """Largest coordinate along the normal [m] that a grain may have."""
    flat: float
    """How flat it is, from 0 to 1."""


def flat_sides(points: Array, spacing: float) -> list[FlatSide]:
    """Return the flat sides of a body.

    Args:
        points: Positions of the particles [m], shape (n, 3).
        spacing: Particle distance [m].
    """
    found = []
    for axis in (0, 1):
        cells = np.floor(points[:, [1 - axis, 2]] / (SIDE_CELL * spacing)).astype(np.int64)
        cells -= cells.min(axis=0)
        outline = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]  # one number for each cell: rows sort slowly
        whole = len(np.unique(outline))
        for sign in (-1.0, 1.0):
            outwards = sign * points[:, axis]
            last = -1 - int(ASTRAY * len(points))
            end = float(np.partition(outwards, last)[last])
            near = len(np.unique(outline[outwards > end - AT_SIDE * spacing]))
            flat = float(np.clip((near / whole - FLAT_SIDE[0]) / (FLAT_SIDE[1] - FLAT_SIDE[0]), 0.0, 1.0))
            if flat > 0:
                found.append(FlatSide(axis, sign, end + PAST_SIDE * spacing, flat))
    return found


def _against(centers: Array, on: NDArray[np.integer], sides: list[FlatSide], size: Array) -> Array:
    """Return centres with those of particles on a flat side at its plane, and others within the planes.

    Args:
        centers: What is drawn [m], shape (n, m, 3).
        on: Number of the side on which a particle lies, or -1, shape (n,).
        sides: As `flat_sides` returns them.
        size: Radius and half thickness of what is drawn [m], shape (n, m, 2): others keep away by the first, those on
            a side by the second.
    """
    for number, (axis, sign, end, flat) in enumerate(sides):
        outwards = sign * centers[..., axis]
        wanted = end - np.where((on == number)[:, None], size[..., 1], np.maximum(end - outwards, size[..., 0]))
        centers[..., axis] = sign * (outwards + flat * (wanted - outwards))
    return centers


def heap_surface(points: Array, spacing: float) -> tuple[Array, Array]:
    """Return where the surface of a heap faces near each particle, and how dense the particles are around it.

    Args:
        points: Positions of the particles [m], shape (n, 3).
        spacing: Particle distance [m].

    Returns:
        Unit vectors of shape (n, 3), none downward, and smoothed densities (n,): 1 inside a heap.
    """
    # Single grains that fly away do not coarsen the grid; where it ends, they face upward.
    low, high = np.percentile(points, OUTSIDE, axis=0), np.percentile(points, 100 - OUTSIDE, axis=0)
    wide = float((high - low).max()) * (1 + BEYOND) / spacing
    # In the world's grid, and in steps, so that the light on a heap at rest does not change.
    edge = spacing * 2.0 ** np.ceil(np.log2(max(wide / CELLS, 1.0)))
    margin, room = int(np.ceil(3 * SOFTENED)) + 1, BEYOND * (high - low) + 4 * spacing
    first, last = np.floor((low - room) / edge).astype(np.int64), np.floor((high + room) / edge).astype(np.int64)
    cells = np.floor(points / edge).astype(np.int64)
    first, last = np.maximum(first, cells.min(axis=0)), np.minimum(last, cells.max(axis=0))
    lone = ((cells < first) | (cells > last)).any(axis=1)
    cells = np.clip(cells, first, last) + margin - first
    size = tuple(last - first + 2 * margin + 1)
    filled = np.bincount(np.ravel_multi_index(tuple(cells[~lone].T), size), minlength=int(np.prod(size))).reshape(size)
    dense = gaussian_filter(np.minimum(filled, 1).astype(np.float32), SOFTENED * spacing / edge, truncate=3.0)
    sides: Any = np.gradient(dense)
    slope = -np.stack([side[tuple(cells.T)] for side in sides], axis=1).astype(float)
    slope[:, 2] = np.maximum(slope[:, 2], 0.0)  # a heap ends on the ground, which hides its lower side
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    known = (length > 1e-6) & ~lone[:, None]
    facing = np.where(known, slope / np.maximum(length, 1e-6), (0.0, 0.0, 1.0))
    return facing, np.where(lone, 0.0, dense[tuple(cells.T)])


def _ellipsoids(centers: Array, sizes: Array, axes: Array, bsdf: Any) -> Any:
    """Return ellipsoids with half axes [m] whose third axes point along vectors, shape (n, 3) each."""
    mi = mitsuba()
    axes = axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-9)
    axes = np.where(axes[:, 2:] < 0, -axes, axes)  # both ends of an axis are alike
    data = np.zeros((len(centers), 10), np.float32)
    data[:, :3], data[:, 3:6] = centers, sizes
    turn = np.stack([-axes[:, 1], axes[:, 0], np.zeros(len(axes)), 1 + axes[:, 2]], axis=1)
    data[:, 6:] = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    return mi.load_dict({"type": "ellipsoids", "data": mi.TensorXf(data), "extent": 1.0, "bsdf": bsdf})
