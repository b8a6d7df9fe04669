"""Letters, drawings and extrusions: convex prisms for contact, and surfaces to draw, smooth where outlines are."""

from pathlib import Path

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from text2sim.compiler.shapes.extrude import convex_parts, polygons_of
from text2sim.compiler.shapes.glyphs import whole
from text2sim.compiler.shapes.lettering import areas, signed_area
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.models.shapes import Extrusion, FlatShape

PRISM_TOLERANCE = 0.01
"""How far prisms may be from the true outline, as a part of the height of a letter or drawing."""
CURVE_TOLERANCE = 3e-3
"""How far those of smooth outlines may be, as a part of their smaller extent; straight ones are exact."""
MIN_PRISM_SHARE = 1e-4
"""Prisms smaller than this part of the whole are left out: the engine refuses bodies without volume."""
SHARP_DEG = 40.0
"""Corners of an outline sharper than this angle are drawn as edges."""


def prisms(shape: FlatShape, folder: Path) -> list[Piece]:
    """Return a flat shape as convex prisms, a few for each letter.

    Raises:
        AssetError: if the shape has no part of that number, or its font, picture or outline cannot be used.
    """
    form = whole(shape, folder)
    rough = areas(form.simplify(_tolerance(shape, form)))
    half, least = shape.depth / 2, MIN_PRISM_SHARE * form.area
    found = []
    for cell in convex_parts(rough):
        if abs(signed_area(cell)) < least:
            continue
        n = len(cell)
        corners = [*((x, -half, z) for x, z in cell), *((x, half, z) for x, z in cell)]
        faces = [(0, k, k + 1) for k in range(1, n - 1)] + [(n, n + k + 1, n + k) for k in range(1, n - 1)]
        for k in range(n):
            j = (k + 1) % n
            faces += [(k, n + j, j), (k, n + k, n + j)]
        found.append(Piece("hull", vertices=tuple(corners), faces=tuple(faces)))
    return found


def _tolerance(shape: FlatShape, form: BaseGeometry) -> float:
    """Return how far prisms may be from the outline [m]."""
    left, low, right, high = form.bounds
    if isinstance(shape, Extrusion):
        return CURVE_TOLERANCE * min(right - left, high - low) if shape.smooth else 0.0
    return PRISM_TOLERANCE * min(shape.height, high - low)


def reach(shape: FlatShape, u: Vec, folder: Path) -> float:
    """Return the largest `u . x` over all points x [m] of a flat shape.

    Args:
        shape: The shape.
        u: Direction, a unit vector in the body's frame.
        folder: Folder of the case, for fonts and drawings.
    """
    hull = shapely.get_coordinates(whole(shape, folder).convex_hull).tolist()
    return max(u[0] * x + u[2] * z for x, z in hull) + abs(u[1]) * shape.depth / 2


def flat_surface(shape: FlatShape, folder: Path) -> VisualMesh:
    """Return the surface to draw for a flat shape: smooth where the outline is, with edges front and back.

    Raises:
        AssetError: if the shape has no part of that number, or its font, picture or outline cannot be used.
    """
    form = whole(shape, folder)
    low_x, low_z, high_x, high_z = form.bounds
    form = areas(form.simplify(5e-4 * max(high_x - low_x, high_z - low_z)))
    half, parts = shape.depth / 2, []
    for polygon in polygons_of(form):
        parts += _caps(polygon, half)
        parts += [_walls(np.array(ring.coords)[:-1], half) for ring in (polygon.exterior, *polygon.interiors)]
    places, normals, nets = zip(*parts, strict=True)
    firsts = np.cumsum([0, *(len(place) for place in places[:-1])]).tolist()
    moved = [net + first for net, first in zip(nets, firsts, strict=True)]
    return VisualMesh(np.concatenate(places), np.concatenate(moved), np.concatenate(normals))


def _caps(polygon: Polygon, half: float) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return vertices, normals and triangles of the front and of the back."""
    cut = polygons_of(shapely.constrained_delaunay_triangles(polygon))
    corners = np.array([part.exterior.coords[:3] for part in cut]).reshape(-1, 2)
    flat, index = np.unique(corners, axis=0, return_inverse=True)
    net = index.reshape(-1, 3)
    found = []
    for side in (-1.0, 1.0):
        places = np.column_stack([flat[:, 0], np.full(len(flat), side * half), flat[:, 1]])
        found.append((places, np.tile((0.0, side, 0.0), (len(flat), 1)), net if side < 0 else net[:, ::-1]))
    return found


def _walls(ring: np.ndarray, half: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the wall along an outline with the solid on its left; it is smooth where the outline turns little."""
    ahead = np.roll(ring, -1, axis=0)
    edge = ahead - ring
    edge /= np.maximum(np.linalg.norm(edge, axis=1, keepdims=True), 1e-300)
    own = np.stack([edge[:, 1], -edge[:, 0]], axis=1)  # outwards, of the edge from k to k + 1
    before = np.roll(own, 1, axis=0)
    mean = own + before
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-9)
    smooth = ((own * before).sum(axis=1) > np.cos(np.radians(SHARP_DEG)))[:, None]
    start, end = np.where(smooth, mean, own), np.roll(np.where(smooth, mean, before), -1, axis=0)
    places, normals = [], []
    for spot, normal in ((ring, start), (ahead, end)):
        for y in (-half, half):
            places.append(np.column_stack([spot[:, 0], np.full(len(ring), y), spot[:, 1]]))
            normals.append(np.column_stack([normal[:, 0], np.zeros(len(ring)), normal[:, 1]]))
    n = np.arange(len(ring))
    a, d, b, c = n, n + len(ring), n + 2 * len(ring), n + 3 * len(ring)
    return (
        np.concatenate(places),
        np.concatenate(normals),
        np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]),
    )
