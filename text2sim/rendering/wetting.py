"""Liquids up to the walls that hold them.

The solver keeps particles about a cell away from rigid surfaces, and a surface around particles is round at its edges.
Drawn like that, water in a tank looks like a block of jelly that stands between its panes. So particles are added up to
the walls that a liquid touches and into them, and the surface around all of them is cut off at clear walls.
"""

import math
from collections.abc import Callable, Sequence
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
NEAR = 2.0
"""Distance [particle distances] of the surface beyond added particles, at most."""
OPPOSITE = 0.5
"""Cosine of the angle between two walls from which they face each other."""
FACING = 0.25
"""Cosine of the angle between the normal of a surface and a way, from which it leads out of a body there."""
BESIDE = 2.0
"""Distance [particle distances] from the nearest place that a liquid touches, from which there is no wall."""
CREASE = 0.8
"""Cosine of the angle between parts of a liquid's surface on walls from which there is an edge between them."""
BETWEEN = 0.5
"""Distance [particle distances] of the points on the way to a surface at which another one may be in between."""
ASIDE = 1.2
"""Distance [particle distances] along a wall from its nearest point, from which a particle is not in front of it."""
NEIGHBOURS = 8
"""Points of surfaces next to one of them that are looked at."""
FLAT, FLUSH = 0.99, 0.02
"""Cosine from which two surfaces face each other flatly, and gap [particle distances] up to which they are joined."""
MAX_SAMPLES = 200_000
"""Points of walls; large faces are divided no further than that."""


class Wetting(NamedTuple):
    """Particles of a liquid, and those added beside and in walls."""

    points: Array
    """Positions [m], shape (n, 3); the liquid's own come first."""
    beyond: Array
    """Normal of the wall in which a particle was added, shape (n, 3); 0 for others."""
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
    wetting = Wetting(points, np.zeros_like(points), np.zeros((0, 3)), np.zeros((0, 3)))
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
    owner = np.repeat(np.arange(len(walls)), [len(part) for part in split])[size > 0]
    places = corners.mean(axis=1) + BEFORE * spacing * normals
    if len(places):
        bare = ~_covered(places, normals, spacing)
        places, normals, clear, owner = places[bare], normals[bare], clear[bare], owner[bare]
    if not len(places):
        return wetting
    faces = KDTree(places)

    def hidden(point: Array, place: Array) -> NDArray[np.bool_]:
        """Return whether one leaves a body on the way from a point to a place."""
        found, way = np.zeros(len(point), bool), place - point
        long = np.linalg.norm(way, axis=1)
        for part in np.arange(BETWEEN, TOUCHING + 1, BETWEEN) * spacing:
            k = np.flatnonzero(part < long - CLOSE * spacing)
            ahead = way[k] / long[k, None]
            away, index = faces.query(point[k] + part * ahead, distance_upper_bound=CLOSE * spacing)
            seen = np.isfinite(away)
            found[k[seen]] |= (normals[np.asarray(index)[seen]] * ahead[seen]).sum(axis=1) > FACING
        return found

    # One direction after another, so that what is new beside one wall reaches the next: edges and corners fill, too.
    side = _sides(normals)
    for one in np.unique(side):
        own = side == one
        wetting = _filled(wetting, spacing, places[own], normals[own], clear[own], owner[own], hidden)
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
    if not len(wetting.places):
        return moved, on
    sides, deepest = _sides(wetting.normals), (PAST_CLEAR + NEAR) * spacing
    reach = deepest + TOUCHING * spacing  # what is nearer to a corner than the particles was not touched
    present = np.unique(sides).tolist()
    walls = [(KDTree(wetting.places[sides == one]), np.flatnonzero(sides == one)) for one in present]
    opposite = [(k, k + 1) for k, side in enumerate(present) if side % 2 == 0 and side + 1 in present]
    for _ in range(3):  # walls of a corner
        found = [tree.query(moved, distance_upper_bound=reach) for tree, _ in walls]
        away = np.stack([distance for distance, _ in found], axis=1)
        own = [np.append(index, 0)[k] for (_, k), (_, index) in zip(found, walls, strict=True)]
        rows = np.flatnonzero(np.isfinite(away).any(axis=1))
        k, away = np.stack(own, axis=1)[rows], away[rows]
        place, normal = wetting.places[k], wetting.normals[k]
        first = away.argmin(axis=1)[:, None, None]
        from_first = place - np.take_along_axis(place, first, 1)
        # Of walls that meet in an edge which points into the liquid, only the nearest counts. What is past both is
        # moved along both normals, or the surface would cut the edge off.
        nearest = np.take_along_axis(normal, first, 1)
        behind = (from_first * nearest).sum(axis=2) < -BEFORE * spacing
        short = ((place - moved[rows, None]) * normal).sum(axis=2)
        aside = np.linalg.norm(moved[rows, None] + short[..., None] * normal - place, axis=2) > ASIDE * spacing
        edge = behind & ~aside & (short > 0) & (short <= deepest)
        edge &= (normal * nearest).sum(axis=2) > -OPPOSITE
        short[behind | np.isinf(away) | (short > deepest)] = -np.inf
        for one, other in opposite:  # back to back, as between two vessels: it is past the nearer one only
            between = np.minimum(short[:, one], short[:, other]) > 0
            farther = np.where(short[:, one] > short[:, other], one, other)
            short[between, farther[between]] = -np.inf
        worst = short.argmax(axis=1)[:, None]
        edge &= worst == first[:, 0]
        along = np.take_along_axis(normal, worst[..., None], 1)[:, 0] + (normal * edge[..., None]).sum(axis=1)
        short = np.take_along_axis(short, worst, 1)
        past = short[:, 0] >= -BEFORE * spacing / 2
        moved[rows[past]] += short[past] * along[past]
        on[rows[past]] = True
    # Beside an edge, a wall is only an imaginary plane.
    beside = on & (KDTree(wetting.places).query(moved)[0] > BESIDE * spacing)
    moved[beside], on[beside] = vertices[beside], False
    return moved, on


def creased(vertices: Array, faces: NDArray[np.integer], on: NDArray[np.bool_]) -> tuple[Array, NDArray[np.integer]]:
    """Return a surface whose parts on different walls share no vertices: there are edges between them.

    Args:
        vertices: Vertices [m], shape (v, 3).
        faces: Triangles, shape (f, 3).
        on: Whether each vertex lies on a wall, shape (v,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    flat = np.flatnonzero(on[faces].all(axis=1))
    normals = scaled_normals(vertices[faces[flat]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    ends = np.sort(faces[flat][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    a, b = order[1:][same] // 3, order[:-1][same] // 3
    joined = (normals[a] * normals[b]).sum(axis=1) > CREASE
    a, b = a[joined], b[joined]
    group = np.zeros(len(faces), np.int64)
    group[flat] = 1 + connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(len(flat),) * 2))[1]
    many = int(group.max()) + 1
    pairs, faces = np.unique(many * faces + group[:, None], return_inverse=True)
    return vertices[pairs // many], faces.reshape(-1, 3)


def _filled(
    made: Wetting,
    spacing: float,
    places: Array,
    normals: Array,
    clear: NDArray[np.bool_],
    owner: NDArray[np.integer],
    hidden: Callable[[Array, Array], NDArray[np.bool_]],
) -> Wetting:
    """Return particles with more on the way from them to the walls of one direction, and into these."""
    points, reach = made.points, TOUCHING * spacing
    away, nearest = KDTree(places).query(points, distance_upper_bound=reach + spacing)
    k = np.flatnonzero(np.isfinite(away))
    touching = np.asarray(nearest)[k]
    normal, place, glassy = normals[touching], places[touching], clear[touching]
    gap = ((points[k] - place) * normal).sum(axis=1)
    # A particle in a wall does not touch the end of another pane there, nor the other side of a thin wall.
    near = (gap > 0) & (gap <= reach) & ((made.beyond[k] * normal).sum(axis=1) > -OPPOSITE)
    # A liquid does not touch what is behind a pane. What was added in a pane may lie behind it, and touches only what
    # the liquid touches elsewhere.
    its = np.asarray(~made.beyond[k].any(axis=1))
    near &= ~its | (np.linalg.norm(points[k] - place - gap[:, None] * normal, axis=1) < ASIDE * spacing)
    seen = np.flatnonzero(near & its)
    near[seen] = ~hidden(points[k[seen]], place[seen])
    near &= its | np.isin(owner[touching], owner[touching[near & its]])
    k, normal, gap, glassy = k[near], normal[near], gap[near], glassy[near]
    wet = np.unique(touching[near][glassy & its[near]])
    found, beyond = [points], [made.beyond]
    past = np.where(glassy, PAST_CLEAR, PAST_OPAQUE) * spacing
    for step in range(1, math.ceil(TOUCHING + PAST_CLEAR) + 1):
        left = step * spacing <= gap + past
        found.append(points[k[left]] - normal[left] * step * spacing)
        beyond.append(np.where((step * spacing > gap[left])[:, None], normal[left], made.beyond[k[left]]))
    new, own = np.concatenate(found), len(points)
    free = np.flatnonzero(KDTree(points).query(new[own:])[0] > CLOSE * spacing) + own
    _, first = np.unique(np.round(new[free] / (CLOSE * spacing)).astype(np.int64), axis=0, return_index=True)
    kept = np.append(np.arange(own), free[np.sort(first)])
    return Wetting(
        new[kept],
        np.concatenate(beyond)[kept],
        np.concatenate([made.places, places[wet]]),
        np.concatenate([made.normals, normals[wet]]),
    )


def _covered(places: Array, normals: Array, spacing: float) -> NDArray[np.bool_]:
    """Return which points of surfaces (n, 3) another surface lies upon: no liquid comes between two joined panes."""
    away, index = KDTree(places).query(places, k=NEIGHBOURS, distance_upper_bound=CLOSE * spacing)
    index = np.where(np.isfinite(away), index, np.arange(len(places))[:, None])
    ahead = ((places[index] - places[:, None]) * normals[:, None]).sum(axis=2)
    facing = (normals[index] * normals[:, None]).sum(axis=2) < -FLAT
    return (facing & (ahead > -(2 * BEFORE + FLUSH) * spacing)).any(axis=1)


def _sides(normals: Array) -> NDArray[np.integer]:
    """Return the number of the direction, of six, in which each normal (n, 3) points."""
    axis = np.abs(normals).argmax(axis=1)
    return 2 * axis + (np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] < 0)


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
