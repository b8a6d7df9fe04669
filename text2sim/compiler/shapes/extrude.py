"""Solids from flat forms with holes: upright, drawn in x and z, thick along y.

Front and back have the same triangles, of about one size; their outline keeps every corner of the form.
"""

import math

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from text2sim.spec_schema.errors import AssetError

OUTLINE_TOLERANCE = 0.05
"""How far outlines may be from the form's own, in edges: nothing finer than the triangles can be shown."""
MAX_HALVINGS = 12
"""How often edges of the outline are halved that no triangle has."""
INNER_DISTANCE = 0.62
"""Distance of inner points from the outline, in edges."""
ROW_HEIGHT = math.sqrt(3) / 2


def polygons_of(form: BaseGeometry) -> list[Polygon]:
    """Return the connected parts of a form, outlines counterclockwise and holes clockwise."""
    parts = getattr(form, "geoms", [form])
    return [orient(part) for part in parts if isinstance(part, Polygon) and part.area > 0]


def extruded(form: Polygon | MultiPolygon, depth: float, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the closed surface of a form that is `depth` [m] thick about y = 0.

    Args:
        form: In x and z [m].
        depth: Thickness [m] along y.
        edge: Wanted length [m] of edges.

    Returns:
        Vertices (n, 3) [m] and faces (m, 3), counterclockwise from outside.

    Raises:
        AssetError: if the form cannot be cut into triangles.
    """
    rows = max(1, round(depth / edge))
    heights = np.linspace(-depth / 2, depth / 2, rows + 1)
    vertices, faces, total = [], [], 0
    for polygon in polygons_of(form.simplify(OUTLINE_TOLERANCE * edge)):
        flat, net, rings = net_of(polygon, edge)
        n = len(flat)
        # The front looks to -y: x to the right and z up are counterclockwise there.
        layers = [np.arange(n) + total]
        vertices.append(np.column_stack([flat[:, 0], np.full(n, heights[0]), flat[:, 1]]))
        total += n
        border = np.concatenate(rings)
        for y in heights[1:-1]:
            layer = np.full(n, -1)
            layer[border] = np.arange(len(border)) + total
            layers.append(layer)
            vertices.append(np.column_stack([flat[border, 0], np.full(len(border), y), flat[border, 1]]))
            total += len(border)
        layers.append(np.arange(n) + total)
        vertices.append(np.column_stack([flat[:, 0], np.full(n, heights[-1]), flat[:, 1]]))
        total += n
        faces += [layers[0][net], layers[-1][net[:, ::-1]]]
        for ring in rings:
            ahead = np.roll(ring, -1)
            for k, (low, high) in enumerate(zip(layers, layers[1:], strict=False)):
                a, b, c, d = low[ring], low[ahead], high[ahead], high[ring]
                even = ((np.arange(len(ring)) + k) % 2 == 0)[:, None]
                faces.append(np.where(even, np.stack([a, c, b], 1), np.stack([a, d, b], 1)))
                faces.append(np.where(even, np.stack([a, d, c], 1), np.stack([b, d, c], 1)))
    return np.concatenate(vertices), np.concatenate(faces)


def net_of(polygon: Polygon, edge: float) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Cut a polygon into triangles with edges of about `edge`.

    Its outline is divided, points are spread over its inside, and Delaunay makes the triangles. Edges of the outline
    that no triangle has are halved until there are none.

    Returns:
        Points (n, 2), triangles (m, 3) counterclockwise, and the points of each ring in their order.

    Raises:
        AssetError: if some are left after all rounds.
    """
    from scipy.spatial import Delaunay, QhullError

    rings = [_divided(np.array(ring.coords)[:-1], edge) for ring in (polygon.exterior, *polygon.interiors)]
    inner = _strewn(polygon, edge)
    for _ in range(MAX_HALVINGS):
        border = np.concatenate(rings)
        points = np.concatenate([border, inner])
        try:
            net = Delaunay(points).simplices
        except QhullError as error:
            raise AssetError("has a part that is too thin to be cut into triangles") from error
        a, b, c = points[net].transpose(1, 0, 2)
        u, v = b - a, c - a
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        net = np.where(area[:, None] < 0, net[:, ::-1], net)
        middle = (a + b + c) / 3
        net = net[shapely.contains_xy(polygon, middle[:, 0], middle[:, 1]) & (np.abs(area) > 1e-9 * edge**2)]
        present = np.concatenate([net[:, k].astype(np.int64) * len(points) + net[:, (k + 1) % 3] for k in range(3)])
        first, done, missing = 0, [], []
        for ring in rings:
            index = np.arange(len(ring)) + first
            ahead = np.roll(index, -1)
            lacks = ~np.isin(index * len(points) + ahead, present)
            missing.append(lacks)
            done.append(index)
            first += len(ring)
        if not any(lacks.any() for lacks in missing):
            # Each edge of the outline belongs to one triangle, and every other edge to two: nothing is missing.
            return points, net, done
        rings = [_halved(ring, lacks) for ring, lacks in zip(rings, missing, strict=True)]
    raise AssetError("has a part that is too thin to be cut into triangles")


def _divided(ring: np.ndarray, edge: float) -> np.ndarray:
    """Return the points of a ring with more between them."""
    ahead = np.roll(ring, -1, axis=0)
    counts = np.maximum(np.round(np.linalg.norm(ahead - ring, axis=1) / edge).astype(int), 1)
    return np.concatenate(
        [a + (b - a) * (np.arange(n) / n)[:, None] for a, b, n in zip(ring, ahead, counts.tolist(), strict=True)]
    )


def _halved(ring: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    where = np.flatnonzero(chosen)
    return np.insert(ring, where + 1, ((ring + np.roll(ring, -1, axis=0)) / 2)[where], axis=0)


def _strewn(polygon: Polygon, edge: float) -> np.ndarray:
    """Return points of a triangular lattice inside a polygon, not too near to its outline."""
    room = polygon.buffer(-INNER_DISTANCE * edge)
    if room.is_empty:
        return np.zeros((0, 2))
    low_x, low_z, high_x, high_z = polygon.bounds
    rows = np.arange(low_z, high_z + edge, ROW_HEIGHT * edge)
    columns = np.arange(low_x, high_x + edge, edge)
    x = columns[None, :] + np.where(np.arange(len(rows)) % 2, edge / 2, 0.0)[:, None]
    z = np.repeat(rows[:, None], len(columns), axis=1)
    inside = shapely.contains_xy(room, x.ravel(), z.ravel())
    return np.stack([x.ravel()[inside], z.ravel()[inside]], axis=1)


def convex_parts(form: Polygon | MultiPolygon) -> list[list[tuple[float, float]]]:
    """Cut a form into a few convex polygons, counterclockwise: triangles, joined as long as they stay convex.

    After Hertel and Mehlhorn: at most four times as many as there must be.
    """
    found = []
    for polygon in polygons_of(form):
        found += _join_triangles(polygon)
    return found


def _join_triangles(polygon: Polygon) -> list[list[tuple[float, float]]]:
    cut = polygons_of(shapely.constrained_delaunay_triangles(polygon))
    cells = {k: [(x, y) for x, y in part.exterior.coords[:-1]] for k, part in enumerate(cut)}
    owner = {}
    for k, cell in cells.items():
        for a, b in zip(cell, cell[1:] + cell[:1], strict=True):
            owner[a, b] = k
    # Long seams first, since what they join is wide.
    seams = sorted(((a, b) for a, b in owner if (b, a) in owner and a < b), key=lambda seam: (-math.dist(*seam), seam))
    for a, b in seams:
        left, right = owner[a, b], owner[b, a]
        if left == right:
            continue
        one, other = _rotate_to(cells[left], b), _rotate_to(cells[right], a)  # b … a, and a … b
        whole = one + other[1:-1]
        at = len(one) - 1
        if _turns_left(whole, at) and _turns_left(whole, 0):
            cells[left] = whole
            del cells[right]
            for c, d in zip(other, other[1:], strict=False):
                owner[c, d] = left
    return [_drop_straight_corners(cell) for cell in cells.values()]


def _rotate_to(cell: list[tuple[float, float]], start: tuple[float, float]) -> list[tuple[float, float]]:
    at = cell.index(start)
    return cell[at:] + cell[:at]


def _turns_left(cell: list[tuple[float, float]], at: int) -> bool:
    (ax, ay), (bx, by), (cx, cy) = cell[at - 1], cell[at], cell[(at + 1) % len(cell)]
    u, v, w, x = bx - ax, by - ay, cx - bx, cy - by
    return u * x - v * w >= -1e-9 * math.hypot(u, v) * math.hypot(w, x)


def _drop_straight_corners(cell: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Drop corners at which the outline goes straight on."""
    kept = list(cell)
    for point in cell:
        at = kept.index(point)
        (ax, ay), (bx, by), (cx, cy) = kept[at - 1], kept[at], kept[(at + 1) % len(kept)]
        u, v, w, x = bx - ax, by - ay, cx - bx, cy - by
        if len(kept) > 3 and abs(u * x - v * w) <= 1e-9 * math.hypot(u, v) * math.hypot(w, x):
            kept.pop(at)
    return kept
