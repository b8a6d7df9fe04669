"""Patterns of copies: which copies there are, and where each stands relative to the position of its body.

Offsets are along the world's axes, except those of a running bond, which is a wall along its body's x axis.
Stacks and packings need the size of every copy, and are resolved in `placement.py`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, Vec, quat_from_yaw
from text2sim.spec_schema.models.repeat import Divided, Grid, Line, Repeat, Ring, RunningBond, Spiral
from text2sim.spec_schema.models.shapes import Box
from text2sim.spec_schema.names.name_table import count_copies

Variables = dict[str, int | float]
"""`i`, `n`, `u`, `row`, `column`, `layer` of a copy."""
Rows = Sequence[tuple[int, int]]
"""Row and column of each part of a shape: letters of a text, pieces of a sketch, fragments."""

MAX_COPIES = 100_000

SINGLE: Variables = {"i": 0, "n": 1, "u": 0.0, "row": 0, "column": 0, "layer": 0}


@dataclass(frozen=True)
class PatternSlot:
    """Where a copy stands in its pattern."""

    offset: Vec
    """[m], from the body's own position."""
    turn: Quaternion = IDENTITY
    """Turn in the world that comes after the body's own orientation."""
    size: Vec | None = None
    """Size [m] of a box that differs from the body's."""


def copy_count(repeat: Repeat, parts: Rows = ()) -> int:
    """Return how many copies a pattern makes; see `copy_variables`."""
    return len(parts) if isinstance(repeat, Divided) else count_copies(repeat)


def copy_variables(repeat: Repeat, parts: Rows = ()) -> list[Variables]:
    """Return the variables of every copy, in the order of their numbers.

    A grid counts columns along x, rows along y and layers along z, columns fastest; a running bond counts
    columns along the wall and rows upwards; letters and pieces count rows downwards and columns along the row. In the
    other patterns the column is the number of the copy.

    Args:
        repeat: The pattern.
        parts: Row and column of each letter, piece or fragment, where these are the copies.
    """
    cells: list[tuple[int, int, int]]
    if isinstance(repeat, Divided):
        cells = [(row, column, 0) for row, column in parts]
    elif isinstance(repeat, Grid):
        nx, ny, nz = (*repeat.counts, 1)[:3]
        cells = [(row, column, layer) for layer in range(nz) for row in range(ny) for column in range(nx)]
    elif isinstance(repeat, RunningBond):
        cells = [(row, column, 0) for row in range(repeat.rows) for column in range(_row_count(repeat, row))]
    else:
        cells = [(0, column, 0) for column in range(repeat.count)]
    n = len(cells)
    last = max(n - 1, 1)
    return [
        {"i": i, "n": n, "u": i / last, "row": row, "column": column, "layer": layer}
        for i, (row, column, layer) in enumerate(cells)
    ]


def pattern_slots(repeat: Line | Grid | Ring | Spiral) -> list[PatternSlot]:
    """Return the place of every copy in a pattern that does not depend on the copies' size."""
    if isinstance(repeat, Line):
        x, y, z = repeat.step
        return [PatternSlot((i * x, i * y, i * z)) for i in range(repeat.count)]
    if isinstance(repeat, Grid):
        return _grid_slots(repeat)
    return _ring_slots(repeat) if isinstance(repeat, Ring) else _spiral_slots(repeat)


def pattern_middle(repeat: Repeat) -> Vec:
    """Return the middle of a pattern in x and y [m], from the body's own position."""
    if isinstance(repeat, Line):
        x, y, _ = repeat.step
        return ((repeat.count - 1) / 2 * x, (repeat.count - 1) / 2 * y, 0.0)
    return (0.0, 0.0, 0.0)


def _grid_slots(grid: Grid) -> list[PatternSlot]:
    nx, ny, nz = (*grid.counts, 1)[:3]
    spacing = grid.spacing
    sx, sy, sz = (spacing,) * 3 if isinstance(spacing, float | int) else (*spacing, spacing[-1])[:3]
    return [
        PatternSlot(((i - (nx - 1) / 2) * sx, (j - (ny - 1) / 2) * sy, k * sz))
        for k in range(nz)
        for j in range(ny)
        for i in range(nx)
    ]


def _ring_slots(ring: Ring) -> list[PatternSlot]:
    # A whole circle must not end where it began.
    gaps = ring.count if ring.arc_deg >= 360 else max(ring.count - 1, 1)
    step = math.radians(ring.arc_deg) / gaps
    slots = []
    for i in range(ring.count):
        angle = math.radians(ring.start_deg) + i * step
        offset = (ring.radius * math.cos(angle), ring.radius * math.sin(angle), 0.0)
        slots.append(PatternSlot(offset, quat_from_yaw(angle) if ring.turn else IDENTITY))
    return slots


def _spiral_slots(spiral: Spiral) -> list[PatternSlot]:
    """Copies at equal lengths of an Archimedean spiral r = inner + b angle; their y axis lies along it."""
    b = spiral.pitch / (2 * math.pi)

    def length(r: float) -> float:
        return (r * math.hypot(r, b) + b * b * math.asinh(r / b)) / (2 * b)

    slots = []
    r, begin = spiral.inner_radius, length(spiral.inner_radius)
    for i in range(spiral.count):
        # The length grows convexly with r, so that Newton's steps converge from the previous copy.
        for _ in range(50):
            step = (begin + i * spiral.spacing - length(r)) * b / math.hypot(r, b)
            r += step
            if abs(step) < 1e-12 * r:
                break
        angle = math.radians(spiral.start_deg) + (r - spiral.inner_radius) / b
        # The curve leaves the circle outwards by atan(b / r): dominoes follow it exactly.
        slots.append(
            PatternSlot((r * math.cos(angle), r * math.sin(angle), 0.0), quat_from_yaw(angle - math.atan2(b, r)))
        )
    return slots if spiral.outward else slots[::-1]


def _row_count(bond: RunningBond, row: int) -> int:
    return bond.columns + 1 if bond.ends == "half" and row % 2 else bond.columns


def bond_slots(bond: RunningBond, box: Box) -> list[PatternSlot]:
    """Return the place of every box of a wall in the body's axes; the middle of the lowest row is the origin.

    `gap` separates the boxes of a row; rows lie on each other, because a wall that is built with gaps
    between its rows collapses into them when the run begins. Half boxes are `(length - gap) / 2` long, so
    that both ends of every row are flush. Toothed rows stand a quarter of a box to the left and right of
    the middle in turn.

    Raises:
        ValueError: if a half box would have no length.
    """
    length, depth, height = box.size
    gap, columns = bond.gap, bond.columns
    half = (length - gap) / 2
    if bond.ends == "half" and half <= 0:
        raise ValueError(f"gap must be smaller than the box's length {length:g} (got {gap:g})")
    left = -(columns * length + (columns - 1) * gap) / 2
    slots = []
    for row in range(bond.rows):
        z = row * height
        if bond.ends == "open":
            shift = (length + gap) / 4 * (0 if bond.rows == 1 else 1 if row % 2 else -1)
            slots += [PatternSlot((left + shift + length / 2 + k * (length + gap), 0.0, z)) for k in range(columns)]
        elif row % 2 == 0:
            slots += [PatternSlot((left + length / 2 + k * (length + gap), 0.0, z)) for k in range(columns)]
        else:
            short = (half, depth, height)
            slots.append(PatternSlot((left + half / 2, 0.0, z), size=short))
            slots += [
                PatternSlot((left + half + gap + length / 2 + k * (length + gap), 0.0, z)) for k in range(columns - 1)
            ]
            slots.append(PatternSlot((-left - half / 2, 0.0, z), size=short))
    return slots
