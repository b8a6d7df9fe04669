"""Liquids up to the walls that hold them.

The solver keeps particles about a cell away from rigid surfaces, and a surface around particles is round at its edges.
Drawn like that, water in a tank looks like a block of jelly that stands between its panes. So particles are added up to
the walls that a liquid touches and into them, and the surface around all of them is cut off at clear walls.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from text2sim.assets.surface import scaled_normals

Array = NDArray[np.floating]


class Wall(NamedTuple):
    """A rigid surface."""

    vertices: Array
    """Vertices [m], shape (n, 3)."""
    faces: NDArray[np.integer]
    """Triangles, counterclockwise from outside, shape (f, 3)."""
    clear: bool = False
    """Whether one sees through it."""


TOUCHING = 3.2
"""Distance [particle distances] up to which a liquid touches a surface. It rests two of them away, which is a cell."""
PAST_CLEAR, PAST_OPAQUE = 2.0, 1.0
"""Distance [particle distances] that added particles go beyond a wall: a clear one shows the face that is cut off,
an opaque one hides what is in it, and may be a cell thick."""
CLOSE = 0.6
"""Distance [particle distances] of two particles that count as one."""
BEFORE = 0.03
"""Distance [particle distances] from a clear wall at which a liquid is cut off, for surfaces that coincide flicker."""
NEAREST, NEAR = 6, 2.0
"""Number of places of walls beyond which a vertex may be, and their distance [particle distances] at most, besides
that of added particles."""
BESIDE = 1.5
"""Distance [particle distances] from the nearest place that a liquid touches, from which there is no wall."""
MAX_SAMPLES = 200_000
"""Points of walls; large faces are divided no further than that."""


class Wetting(NamedTuple):
    """Particles of a liquid, and those added beside and in walls."""

    points: Array
    """Positions [m], shape (n, 3); the liquid's own come first."""
    places: Array
    """Points of clear walls that it touches [m], shape (m, 3)."""
    normals: Array
    """Unit normals of the walls there, shape (m, 3)."""


def wetted(points: Array, spacing: float, walls: Sequence[Wall]) -> Wetting:
    """Return the particles of a liquid, and more between them and the surfaces that they touch.

    Args:
        points: Particles [m], shape (n, 3).
        spacing: Distance between neighbours [m].
        walls: Rigid surfaces.
    """
    wetting = Wetting(points, np.zeros((0, 3)), np.zeros((0, 3)))
    if not len(points):
        return wetting
    reach = TOUCHING * spacing
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    split = [_split(wall.vertices[wall.faces], spacing, low, high) for wall in walls]
    corners = np.concatenate([np.zeros((0, 3, 3)), *split])
    clear = np.repeat([wall.clear for wall in walls], [len(part) for part in split]).astype(bool)
    cross = scaled_normals(corners)
    size = np.linalg.norm(cross, axis=1)
    corners, clear, normals = corners[size > 0], clear[size > 0], cross[size > 0] / size[size > 0, None]
    places = corners.mean(axis=1) + BEFORE * spacing * normals
    # One direction after another, so that what is new beside one wall reaches the next: edges and corners fill, too.
    axis = np.abs(normals).argmax(axis=1)
    side = 2 * axis + (np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] < 0)
    for one in np.unique(side):
        own = side == one
        wetting = _filled(wetting, spacing, places[own], normals[own], clear[own])
    return wetting


def cut_off(vertices: Array, wetting: Wetting, spacing: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return the vertices of a surface around particles; those beyond a clear wall are moved onto it.

    Args:
        vertices: Vertices [m], shape (v, 3).
        wetting: The particles, some of them added.
        spacing: Distance between neighbours [m].

    Returns:
        The vertices [m], and whether each lies on a wall, (v,).
    """
    moved, on = vertices.copy(), np.zeros(len(vertices), bool)
    if len(wetting.places) < NEAREST:
        return moved, on
    tree, reach = KDTree(wetting.places), (PAST_CLEAR + NEAR) * spacing
    for _ in range(3):  # walls of a corner
        away, k = tree.query(moved, k=NEAREST, distance_upper_bound=reach)
        rows = np.flatnonzero(np.isfinite(away).all(axis=1))
        place, normal = wetting.places[k[rows]], wetting.normals[k[rows]]
        short = ((place - moved[rows, None]) * normal).sum(axis=2)
        # Of walls that meet in an edge which points into the liquid, only the nearest counts.
        behind = ((place - place[:, :1]) * normal[:, :1]).sum(axis=2) < -BEFORE * spacing
        short[behind] = -np.inf
        worst = short.argmax(axis=1)[:, None]
        short, normal = np.take_along_axis(short, worst, 1), np.take_along_axis(normal, worst[..., None], 1)[:, 0]
        past = short[:, 0] >= -BEFORE * spacing / 2
        moved[rows[past]] += (short * normal)[past]
        on[rows[past]] = True
    # Beside an edge, a wall is only an imaginary plane.
    beside = on & (tree.query(moved)[0] > BESIDE * spacing)
    moved[beside], on[beside] = vertices[beside], False
    return moved, on


def _filled(made: Wetting, spacing: float, places: Array, normals: Array, clear: NDArray[np.bool_]) -> Wetting:
    """Return particles with more on the way from them to the walls of one direction, and into these."""
    points, reach = made.points, TOUCHING * spacing
    away, nearest = KDTree(places).query(points, distance_upper_bound=reach + spacing)
    k = np.flatnonzero(np.isfinite(away))
    touching = np.asarray(nearest)[k]
    normal, place, glassy = normals[touching], places[touching], clear[touching]
    gap = ((points[k] - place) * normal).sum(axis=1)
    near = (gap > 0) & (gap <= reach)
    k, normal, gap, glassy = k[near], normal[near], gap[near], glassy[near]
    wet = np.unique(touching[near][glassy])
    made = Wetting(points, np.concatenate([made.places, places[wet]]), np.concatenate([made.normals, normals[wet]]))
    past = np.where(glassy, PAST_CLEAR, PAST_OPAQUE) * spacing
    found = [points[:0]]
    for step in range(1, math.ceil(TOUCHING + PAST_CLEAR) + 1):
        left = step * spacing <= gap + past
        found.append(points[k[left]] - normal[left] * step * spacing)
    new = np.concatenate(found)
    if not len(new):
        return made
    free = KDTree(points).query(new)[0] > CLOSE * spacing
    new = new[free]
    _, first = np.unique(np.round(new / (CLOSE * spacing)).astype(np.int64), axis=0, return_index=True)
    return made._replace(points=np.concatenate([points, new[np.sort(first)]]))


def _split(corners: Array, spacing: float, low: Array, high: Array) -> Array:
    """Return triangles (f, 3, 3) whose edges are no longer than `spacing`, as far as they reach into a box."""
    done = [corners[:0]]
    while True:
        near = ((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1)
        corners = corners[near]
        if not len(corners) or sum(map(len, done)) + len(corners) > MAX_SAMPLES:
            return np.concatenate([*done, corners])
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        small = edges.max(axis=1) <= spacing
        done.append(corners[small])
        corners, edges = corners[~small], edges[~small]
        # Edge k runs from corner k - 1 to corner k: halve the longest.
        k, rows = edges.argmax(axis=1), np.arange(len(corners))
        a, b, c = corners[rows, k - 1], corners[rows, k], corners[rows, (k + 1) % 3]
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
