"""Copies at random in a region, without overlap and wholly inside; the same seed gives the same packing.

Copies are placed one after the other, each at the first random place that is free. This spreads them loosely
through the whole region, which costs a contact solver much less than a heap. Where it jams, a jittered lattice
takes over.

A sphere is tested as a sphere, everything else as its bounding box in its own frame (and a ball around it,
which settles most pairs). Other bodies and statics are ignored: choose a region that is free of them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.boxes import Bounds, middle, sides
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    Quaternion,
    Rows,
    Vec,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_to_rows,
    rows_apply,
    vector_times,
)
from text2sim.compiler.shapes.space import Space
from text2sim.spec_schema.models.repeat import Packing

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np


_MAX_TRIES = 2000
_CELLS = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]


class PackingError(ValueError):
    """The copies do not fit; the message says how many do."""


@dataclass(frozen=True)
class Grain:
    """What the packing knows of a shape."""

    middle: Vec
    """Middle [m] of its bounding box in its own frame."""
    half: Vec
    """Half lengths [m] of that box."""
    radius: float
    """Radius [m] of a ball around the middle that holds the shape."""
    round: bool
    """Whether the shape is exactly that ball."""
    outline: tuple[Vec, ...]
    """Points [m], relative to the middle: the shape is inside their convex hull, thickened by `rounding` [m]."""
    rounding: float


def grain_of(kind: str | None, bounds: Bounds) -> Grain:
    """Return what the packing needs to know of a shape.

    Args:
        kind: Kind of the shape; None for what is only known by its bounds.
        bounds: Its bounds [m] in its own frame.
    """
    center, half = middle(bounds), vector_times(sides(bounds), 0.5)
    hx, hy, hz = half
    if kind == "sphere":
        return Grain(center, half, hx, True, (ORIGIN,), hx)
    if kind == "capsule":
        return Grain(center, half, hz, False, ((0.0, 0.0, hz - hx), (0.0, 0.0, hx - hz)), hx)
    if kind == "ellipsoid":
        radius = max(half)
    else:
        radius = math.hypot(hx, hz) if kind in ("cylinder", "cup", "tube") else math.hypot(hx, hy, hz)
    if kind in ("cylinder", "tube", "cup"):
        # A polygon around the rims, 0.5 % wider than they are.
        wide = hx / math.cos(math.pi / 32)
        turns = [2 * math.pi * k / 32 for k in range(32)]
        outline = tuple((wide * math.cos(a), wide * math.sin(a), z) for a in turns for z in (-hz, hz))
    else:
        outline = tuple((x, y, z) for x in (-hx, hx) for y in (-hy, hy) for z in (-hz, hz))
    return Grain(center, half, radius, False, outline, 0.0)


def pack(packing: Packing, grains: Sequence[Grain], quats: Sequence[Quaternion]) -> list[tuple[Vec, Quaternion]]:
    """Return position [m] and orientation of every copy.

    Args:
        packing: The pattern.
        grains: The copies.
        quats: The body's own orientation of every copy, on which `turn` builds.

    Raises:
        PackingError: if not all copies fit.
        SpaceError: if the region has no volume.
    """
    space = Space(packing.region)
    filled = sum(8 * g.half[0] * g.half[1] * g.half[2] * (math.pi / 6 if g.round else 1.0) for g in grains)
    if filled > space.volume:
        raise PackingError(
            f"{len(grains)} copies cannot fit: they fill {filled:.3g} m3, the region {space.volume:.3g} m3"
        )
    placed = _scatter(packing, grains, quats, space)
    missing = placed.count(None)
    if missing:
        lattice = _lattice(packing, grains, quats, space)
        fit = max(sum(p is not None for p in lattice), len(placed) - missing)
        if None in lattice:
            raise PackingError(f"only about {fit} of {len(grains)} copies fit; make the region larger or count smaller")
        placed = lattice
    found = []
    for where, grain in zip(placed, grains, strict=True):
        assert where is not None
        (x, y, z), quat = where
        a, b, c = quat_rotate(quat, grain.middle)
        found.append(((x - a, y - b, z - c), quat))
    return found


def _orientations(packing: Packing, rng: "np.random.Generator") -> Iterator[Quaternion]:
    """Yield random turns, drawn in blocks: one number at a time is slow."""
    while True:
        if packing.turn == "none":
            yield IDENTITY
        elif packing.turn == "yaw":
            for angle in (rng.random(256) * math.pi).tolist():
                yield (math.cos(angle), 0.0, 0.0, math.sin(angle))
        else:
            for row in rng.normal(size=(256, 4)).tolist():
                yield quat_normalize(row)


def _numbers(rng: "np.random.Generator") -> Iterator[Vec]:
    while True:
        yield from map(tuple, rng.random((512, 3)).tolist())


Spot = tuple[Vec, Quaternion]


class _Placed:
    """Grains that are already placed, in a grid of cells, so that neighbours are found quickly."""

    def __init__(self, cell: float, gap: float) -> None:
        self.cell, self.gap = cell, gap
        self.cells: dict[tuple[int, int, int], list[tuple[Vec, Rows, Grain]]] = {}

    def _key(self, p: Vec) -> tuple[int, int, int]:
        return (math.floor(p[0] / self.cell), math.floor(p[1] / self.cell), math.floor(p[2] / self.cell))

    def add(self, p: Vec, rows: Rows, grain: Grain) -> None:
        self.cells.setdefault(self._key(p), []).append((p, rows, grain))

    def free(self, p: Vec, rows: Rows, grain: Grain) -> bool:
        """Return whether a grain keeps its gap from all others here."""
        x, y, z = p
        i, j, k = self._key(p)
        gap = self.gap
        near = []
        for a, b, c in _CELLS:
            for other in self.cells.get((i + a, j + b, k + c), ()):
                (ox, oy, oz), _, g = other
                square = (ox - x) ** 2 + (oy - y) ** 2 + (oz - z) ** 2
                if square >= (grain.radius + g.radius + gap) ** 2:
                    continue
                if (grain.round and g.round) or square < (min(grain.half) + min(g.half)) ** 2:
                    return False
                near.append((square, other))
        near.sort(key=lambda item: item[0])
        return all(_are_separated(p, rows, grain, q, others, g, gap) for _, (q, others, g) in near)


def _are_separated(p: Vec, rows: Rows, grain: Grain, q: Vec, other_rows: Rows, other: Grain, gap: float) -> bool:
    """Return whether one of the fifteen axes of two boxes separates them by the gap.

    A sphere has its radius as half length along every axis.
    """
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    (ha, hb, hc), (ga, gb, gc) = grain.half, other.half
    own_axes, other_axes = tuple(zip(*rows, strict=True)), tuple(zip(*other_rows, strict=True))

    def separates(u: Vec) -> bool:
        ux, uy, uz = u
        reach = gap
        if grain.round:
            reach += ha
        else:
            (a, b, c), (e, f, g), (h, i, j) = own_axes
            reach += (
                ha * abs(a * ux + b * uy + c * uz)
                + hb * abs(e * ux + f * uy + g * uz)
                + hc * abs(h * ux + i * uy + j * uz)
            )
        if other.round:
            reach += ga
        else:
            (a, b, c), (e, f, g), (h, i, j) = other_axes
            reach += (
                ga * abs(a * ux + b * uy + c * uz)
                + gb * abs(e * ux + f * uy + g * uz)
                + gc * abs(h * ux + i * uy + j * uz)
            )
        return abs(d[0] * ux + d[1] * uy + d[2] * uz) >= reach

    for u in (*own_axes, *other_axes):
        if separates(u):
            return True
    for ax, ay, az in own_axes:
        for bx, by, bz in other_axes:
            cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            norm = math.sqrt(cx * cx + cy * cy + cz * cz)
            if norm > 1e-9 and separates((cx / norm, cy / norm, cz / norm)):
                return True
    return False


def _scatter(packing: Packing, grains: Sequence[Grain], quats: Sequence[Quaternion], space: Space) -> list[Spot | None]:
    import numpy as np

    rng = np.random.Generator(np.random.PCG64(packing.seed))
    turns, numbers = _orientations(packing, rng), _numbers(rng)
    placed = _Placed(2 * max(g.radius for g in grains) + packing.gap, packing.gap)
    spots: list[Spot | None] = [None] * len(grains)
    # Counted, not timed, so that every machine gives up at the same point.
    budget = 10_000 + 40 * len(grains)
    # Large ones first: small ones still find room between them.
    for index in sorted(range(len(grains)), key=lambda k: -grains[k].radius):
        grain = grains[index]
        for _ in range(min(_MAX_TRIES, budget)):
            budget -= 1
            p = space.sample(next(numbers), min(grain.half))
            quat = quats[index] if packing.turn == "none" else quat_multiply(next(turns), quats[index])
            rows = quat_to_rows(quat)
            if placed.free(p, rows, grain) and space.contains(
                p, [rows_apply(rows, v) for v in grain.outline], grain.rounding
            ):
                placed.add(p, rows, grain)
                spots[index] = (p, quat)
                break
        else:
            break
    return spots


def _lattice(packing: Packing, grains: Sequence[Grain], quats: Sequence[Quaternion], space: Space) -> list[Spot | None]:
    """Return one copy in each cell of the widest lattice with enough cells, shifted and turned as the cell allows."""
    import numpy as np

    rng = np.random.Generator(np.random.PCG64([packing.seed, 1]))
    boxes = [_bounds(quat_to_rows(q), g) for q, g in zip(quats, grains, strict=True)]
    gap = packing.gap
    size = tuple(max(b[k] for b in boxes) * 2 + gap for k in range(3))

    def cells(scale: float) -> list[Vec]:
        return space.lattice((size[0] * scale, size[1] * scale, size[2] * scale), gap)

    low, high = 1.0, 1.0
    best = cells(low)
    while len(best) >= len(grains) and high < 64:
        wider = cells(high * 1.25)
        if len(wider) < len(grains):
            break
        low, high, best = high * 1.25, high * 1.25, wider
    order = rng.permutation(len(best)).tolist()
    turns = _orientations(packing, rng)
    spots: list[Spot | None] = []
    for index, grain in enumerate(grains):
        if index >= len(order):
            spots.append(None)
            continue
        quat, bounds = quats[index], boxes[index]
        slack = tuple((s * low - gap) / 2 for s in size)
        for share in (1.0, 0.5, 0.25, 0.1):
            w, x, y, z = next(turns)
            turn = quat_multiply(
                quat_normalize((1 - share + share * abs(w), share * x, share * y, share * z)), quats[index]
            )
            turned = _bounds(quat_to_rows(turn), grain)
            if all(b <= s for b, s in zip(turned, slack, strict=True)):
                quat, bounds = turn, turned
                break
        shift = ((rng.random(3) * 2 - 1) * [max(s - b, 0.0) for s, b in zip(slack, bounds, strict=True)]).tolist()
        cx, cy, cz = best[order[index]]
        spots.append(((cx + shift[0], cy + shift[1], cz + shift[2]), quat))
    return spots


def _bounds(rows: Rows, grain: Grain) -> Vec:
    if grain.round:
        return grain.half
    x, y, z = (max(abs(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) for v in grain.outline) + grain.rounding for u in rows)
    return (x, y, z)
