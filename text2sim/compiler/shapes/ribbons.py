"""Ribbons: strips along a smooth curve, with as little twist as the curve allows.

The curve is the cubic spline through the points with their centripetal parameters (Lee, Choosing nodes in parametric
curve interpolation, 1989); frames along it come from double reflections (Wang et al., Computation of rotation
minimizing frames, 2008).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from text2sim.assets.surface import unit_rows
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.sagging import SHEET_BOXES, SHEET_THICKNESS
from text2sim.spec_schema.models.sheets import Ribbon

Array = NDArray[np.float64]

FINE = 64
"""Samples between two points, from which lengths along the curve are computed."""
BOXES, MOST_BOXES = 4, 64
"""Boxes between two points that stand for a ribbon when bodies are placed and compared, and the most in all."""
UPRIGHT = 0.2
"""Sine of the angle between a tangent and z below which a ribbon begins upright."""


class Course(NamedTuple):
    """Evenly spaced places along a ribbon."""

    places: Array
    """Positions of its middle [m], (n + 1, 3)."""
    along: Array
    """Unit tangents, (n + 1, 3)."""
    across: Array
    """Unit vectors along its width, (n + 1, 3)."""
    length: float
    """Length of the ribbon [m]."""


def course(ribbon: Ribbon, count: int) -> Course:
    """Return `count + 1` places along a ribbon, from its left end to its right one."""
    return _course(tuple(ribbon.points), ribbon.closed, ribbon.turns, count)


def ribbon_length(ribbon: Ribbon) -> float:
    """Return the length [m] of a ribbon."""
    return course(ribbon, 1).length


def ribbon_corners(ribbon: Ribbon, count: int) -> tuple[Array, Array]:
    """Return the left and right borders of a ribbon at `count + 1` places [m], two arrays of shape (count + 1, 3)."""
    found = course(ribbon, count)
    half = ribbon.width / 2 * found.across
    return found.places - half, found.places + half


def ribbon_pieces(ribbon: Ribbon) -> list[Piece]:
    """Return the boxes that stand for a ribbon when bodies are placed and compared."""
    found = course(ribbon, _boxes(ribbon))
    pieces = []
    for k in range(len(found.places) - 1):
        a, b = found.places[k : k + 2]
        along = (b - a) / np.linalg.norm(b - a)
        across = found.across[k] + found.across[k + 1]
        across -= along * (across @ along)
        across /= max(np.linalg.norm(across), 1e-9)
        x, y, z, w = Rotation.from_matrix(np.column_stack([along, across, np.cross(along, across)])).as_quat()
        box = Piece("box", size=(float(np.linalg.norm(b - a)), ribbon.width, SHEET_THICKNESS))
        pieces.append(box.at(tuple(((a + b) / 2).tolist()), (float(w), float(x), float(y), float(z))))
    return pieces


def ribbon_reach(ribbon: Ribbon, u: Vec) -> float:
    """Return how far [m] a ribbon reaches in a direction from its frame."""
    borders = np.concatenate(ribbon_corners(ribbon, 4 * _boxes(ribbon)))
    return float((borders @ np.asarray(u)).max()) + SHEET_THICKNESS / 2


def _boxes(ribbon: Ribbon) -> int:
    return min(max(SHEET_BOXES, BOXES * (len(ribbon.points) - 1)), MOST_BOXES)


@lru_cache(maxsize=64)
def _course(points: tuple[Vec, ...], closed: bool, turns: float, count: int) -> Course:
    given = np.array([*points[:-1], points[0]] if closed else points)
    nodes = np.concatenate([[0.0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(given, axis=0), axis=1)))])
    spline = CubicSpline(nodes, given, bc_type="periodic" if closed else "not-a-knot")
    fine = np.linspace(0.0, nodes[-1], FINE * (len(points) - 1) + 1)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(spline(fine), axis=0), axis=1))])
    # Frames are carried along the fine samples, so that they do not depend on the count.
    across = _carried(spline(fine), unit_rows(spline(fine, 1)))
    wanted = np.interp(np.linspace(0.0, lengths[-1], count + 1), lengths, fine)
    along = unit_rows(spline(wanted, 1))
    level = np.column_stack([np.interp(wanted, fine, across[:, k]) for k in range(3)])
    level = unit_rows(level - (level * along).sum(axis=1, keepdims=True) * along)
    angle = 2 * np.pi * turns
    if closed:  # what is carried around a loop that is not flat comes back at an angle
        angle += np.arctan2(np.cross(across[-1], across[0]) @ along[0], across[-1] @ across[0])
    angle *= np.linspace(0.0, 1.0, count + 1)[:, None]
    turned = np.cos(angle) * level + np.sin(angle) * np.cross(along, level)
    return Course(spline(wanted), along, turned, float(lengths[-1]))


def _carried(places: Array, along: Array) -> Array:
    """Return a vector that is level at the first place and moves along with as little twist as possible, (n, 3)."""
    start = np.cross((0.0, 0.0, 1.0), along[0])
    if np.linalg.norm(start) < UPRIGHT:
        start = np.array([0.0, 1.0, 0.0]) - along[0, 1] * along[0]
    found = [unit_rows(start)]
    for k in range(len(places) - 1):
        step = places[k + 1] - places[k]
        square = max(step @ step, 1e-300)
        mirrored = found[-1] - 2 / square * (step @ found[-1]) * step
        ahead = along[k] - 2 / square * (step @ along[k]) * step
        other = along[k + 1] - ahead
        square = other @ other
        found.append(mirrored if square < 1e-24 else mirrored - 2 / square * (other @ mirrored) * other)
    return np.array(found)
