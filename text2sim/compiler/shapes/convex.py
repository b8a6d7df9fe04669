"""Convex pieces of a sculpted shape, for contact: as few of each part as follow the surface."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from text2sim.compiler.shapes.distances import Array, spread_directions
from text2sim.spec_schema.models.sculpts import Sculpt

if TYPE_CHECKING:
    from text2sim.compiler.shapes.levelset import PlacedPart

MAX_PIECES = 40
"""Pieces of a shape; beyond that they follow the surface less closely."""
MAX_DEVIATION, MAX_DEVIATION_CELLS = 0.012, 1.2
"""How far a piece may stand out of the surface: the larger of this part of the longest side and so many cells."""
CORNER_DIRECTIONS = 80
"""Directions in which a piece may have a corner, besides the axes."""


def convex_pieces(
    shape: Sculpt,
    parts: "list[PlacedPart]",
    vertices: Array,
    field: Callable[[Array], Array],
    cell: float,
) -> list[Array]:
    """Return the corners (k, 3) [m] of convex pieces.

    Args:
        shape: The shape.
        parts: Its parts.
        vertices: Of its surface [m].
        field: Distance [m] from the surface, negative inside.
        cell: Cell [m] of the grid on which it was made.
    """
    if shape.collision != "parts":
        return [_corners(vertices)]
    cut = any(placed.part.op == "cut" for placed in parts)
    rows: list[list[Array]] = []
    for placed in parts:
        if placed.part.op != "add":
            continue
        bits = list(placed.bits())
        for k, atoms in enumerate(placed.atoms()):
            row = []
            for atom in atoms:
                kept = atom[field(atom) < 0.5 * cell] if cut else atom
                if cut and len(kept) < len(atom):
                    # The surface of the cut inside the atom bounds what is left of it.
                    low, high = atom.min(0) - cell / 2, atom.max(0) + cell / 2
                    inside = vertices[((vertices >= low) & (vertices <= high)).all(axis=1)]
                    if len(inside):
                        own = bits[k * len(placed.form.bits) : (k + 1) * len(placed.form.bits)]
                        near = np.minimum.reduce([bit.distance(inside) for bit in own])
                        kept = np.concatenate([kept, inside[near < cell / 2]])
                if len(kept) > 3 and np.linalg.matrix_rank(kept - kept[0], tol=1e-9) == 3:
                    row.append(kept)
            rows.append(row)
    low, high = vertices.min(0), vertices.max(0)
    off = max(MAX_DEVIATION * float((high - low).max()), MAX_DEVIATION_CELLS * cell)
    found: list[Array] = []
    for _ in range(8):
        found = [_corners(piece) for row in rows for piece in _join_neighbours(row, field, off)]
        if len(found) <= MAX_PIECES:
            break
        off *= 1.6
    return found or [_corners(vertices)]


def _join_neighbours(row: list[Array], field: Callable[[Array], Array], off: float) -> list[Array]:
    """Join neighbours as long as their hull stays near the surface, or where they are already."""
    found: list[Array] = []
    for atom in row:
        if found and _stays(found[-1], atom, field, off):
            found[-1] = np.concatenate([found[-1], atom])
        else:
            found.append(atom)
    return found


def _stays(one: Array, other: Array, field: Callable[[Array], Array], off: float) -> bool:
    """Return whether the hull of two pieces stands out no farther than each of them does: a cut is filled by both."""
    from scipy.spatial import ConvexHull

    points = np.concatenate([one, other])
    a, b, c = (points[ConvexHull(points).simplices[:, k]] for k in range(3))
    samples = np.concatenate([(a + b + c) / 3, (a + b) / 2, (b + c) / 2, (c + a) / 2])
    far = samples[field(samples) >= off]
    if not len(far):
        return True
    faces = [ConvexHull(piece).equations for piece in (one, other)]
    return bool(np.any([(far @ rows[:, :3].T + rows[:, 3] < 1e-9).all(axis=1) for rows in faces], axis=0).all())


def _corners(points: Array) -> Array:
    """Return the points that lie farthest in directions spread over the sphere."""
    return points[np.unique((points @ spread_directions(CORNER_DIRECTIONS).T).argmax(axis=0))]
