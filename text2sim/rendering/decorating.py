"""Patterns and labels on meshes: texture coordinates, and the layer over the base colour."""

import random
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from text2sim.rendering.dots import dot_picture, dotted
from text2sim.rendering.meshes import RenderMesh
from text2sim.templates.painting import painted, places
from text2sim.templates.patterns import DEPTH, PLAIN, Decoration, fitted, size_for, tile
from text2sim.templates.unfolding import Sheet, Unfolded, is_round, unfold

Array = NDArray[np.floating]

WEAR, EVEN_WEAR = 0.07, 0.03
"""Largest relative difference in brightness between copies, with an uneven finish and with an even one."""
UNEVEN = (
    "wood",
    "cardboard",
    "brick",
    "concrete",
    "plaster",
    "paper",
    "leather",
    "felt",
    "marble",
    "peel",
    "foliage",
    "bark",
    "fur",
    "crust",
    "stone",
    "sand",
    "cloth",
)


@dataclass(frozen=True, eq=False)
class Layer:
    """A layer over the base colour of a surface; compares by value."""

    picture: Array
    """sRGB with alpha, 0 to 1, shape (h, w, 4)."""
    period: tuple[float, float]
    """Width and height [m] that it covers; it is repeated."""
    relief: Array | None = None
    """Height map, 0 to 1, shape (h, w)."""
    depth: float = 0.0
    """Depth of the relief [m]."""
    unit: float | None = None
    """Length [m] by which it may be shifted."""


def decorated(
    mesh: RenderMesh,
    decoration: Decoration,
    own: tuple[float, float, float],
    turn: Array,
    *,
    textured: bool = False,
    strand: bool = False,
) -> tuple[RenderMesh, Layer, NDArray[np.integer]]:
    """Lay a pattern on a mesh.

    Args:
        mesh: Mesh in the body's frame; a flat cloth has texture coordinates in metres.
        decoration: The pattern.
        own: Colour of the body, sRGB.
        turn: Rotation from the mesh's frame to the link's, shape (3, 3).
        textured: Whether the finish below has a texture, which uses the same texture coordinates.
        strand: Whether it is a capsule of a strand, see `strands.py`: the pattern runs on beyond its ends.

    Returns:
        The mesh with texture coordinates in metres, the layer, and the original vertex of each of its vertices.
    """
    upright = decoration.kind not in ("planks", "stripes")
    if mesh.uvs is None:
        vertices, normals = _upright(mesh, turn)
        flat = unfold(vertices, mesh.faces, normals, upright=upright, strand=strand)
    else:
        wide = np.ptp(mesh.uvs, axis=0)
        vertices = mesh.uvs if upright or wide[0] <= wide[1] else mesh.uvs[:, ::-1]  # boards run along the longer side
        own_sheet = Sheet("+z", *np.ptp(vertices, axis=0).tolist())
        flat = Unfolded(np.arange(len(vertices)), mesh.faces, np.zeros(len(vertices), int), vertices, [own_sheet])
    turned = flat.sheets[0].name == "side"
    if decoration.repeats:
        extents = np.ptp(vertices, axis=0)
        size = decoration.size or size_for(decoration.kind, extents, is_round=turned)
        if decoration.kind == "dots" and mesh.uvs is None and not textured:
            if (found := dotted(mesh.vertices, mesh.faces, size)) is not None:
                corners, layer = found.vertices, _dot_layer(decoration.color, own, size)
                return RenderMesh(mesh.vertices[corners], found.faces, mesh.normals[corners], found.uvs), layer, corners
        factors = np.array([fitted(decoration.kind, size, sheet.width, sheet.height) for sheet in flat.sheets])
        if strand:
            factors[:, 1] = 1.0
        uvs = flat.uvs * factors[flat.sheet]
        uvs = uvs[:, ::-1] if decoration.turned else uvs
        layer = _tiled(decoration.kind, decoration.color, () if decoration.kind in PLAIN else own, not turned, size)
    else:
        left, _ = places(flat.sheets)
        uvs = flat.uvs + np.stack([left[flat.sheet], np.zeros(len(flat.uvs))], axis=1)
        layer = _painted(decoration, tuple(flat.sheets), own)
    corners = flat.vertices
    return RenderMesh(mesh.vertices[corners], flat.faces, mesh.normals[corners], uvs), layer, corners


def run_on(mesh: RenderMesh, away: Array, turn: Array, *, turned: bool) -> RenderMesh:
    """Return a mesh of a strand whose pattern goes on from that of the links before.

    Args:
        mesh: Mesh with texture coordinates [m].
        away: Way along the strand from the first link [m], in the link's frame, shape (3,).
        turn: Rotation from the mesh's frame to the link's, shape (3, 3).
        turned: Whether the pattern is rotated by 90 degrees.
    """
    along = _square(turn) @ turn.T @ away
    shift = along[np.abs(along).argmax()]
    assert mesh.uvs is not None
    return replace(mesh, uvs=mesh.uvs + ((shift, 0.0) if turned else (0.0, shift)))


def drift(mesh: RenderMesh, velocity: Array) -> Array:
    """Return how fast texture coordinates change, shape (n, 2) [m/s], if what they show moves along the surface.

    On each sheet of an unfolded body they are affine in the position, p -> A p + b: what comes to p in the time t was
    at p - v t, so that they change by -A v.

    Args:
        mesh: Mesh with texture coordinates [m], whose sheets share no vertices.
        velocity: Velocity of the surface [m/s], in the mesh's frame, shape (3,).
    """
    assert mesh.uvs is not None
    n, (a, b, c) = len(mesh.vertices), mesh.faces.T
    edges = coo_array((np.ones(2 * len(a)), (np.concatenate([a, b]), np.concatenate([b, c]))), shape=(n, n))
    rates, (count, sheet) = np.zeros((n, 2)), connected_components(edges, directed=False)
    for number in range(count):
        own = sheet == number
        points, uvs = mesh.vertices[own], mesh.uvs[own]
        slopes = np.linalg.lstsq(points - points.mean(axis=0), uvs - uvs.mean(axis=0), rcond=1e-6)[0]
        rates[own] = -velocity @ slopes
    return rates


def _square(turn: Array) -> Array:
    square = np.round(turn)
    return square if np.abs(square - turn).max() < 1e-3 else np.eye(3)


def _upright(mesh: RenderMesh, turn: Array) -> tuple[Array, Array]:
    """Return vertices and normals about the centre, with z up as in the link, or along the axis of a round part.

    The engine rotates meshes of parts to their principal axes. A part that is oblique in its link keeps its own frame.
    """
    square = _square(turn)
    vertices, normals = mesh.vertices @ square.T, mesh.normals @ square.T
    vertices = vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        if is_round(vertices[:, order], normals[:, order]):
            return vertices[:, order], normals[:, order]
    return vertices, normals


@lru_cache(maxsize=64)
def _tiled(kind: str, color: tuple[float, ...] | None, own: tuple[float, ...], joints: bool, size: float) -> Layer:
    picture = tile(kind, color, own, joints=joints)
    width, height = (size * period for period in picture.period)
    return Layer(picture.picture, (width, height), picture.relief, DEPTH.get(kind, 0.0) * size, size)


@lru_cache(maxsize=64)
def _dot_layer(color: tuple[float, ...] | None, own: tuple[float, ...], size: float) -> Layer:
    return Layer(dot_picture(color, own), (2 * size, 2 * size), unit=2 * size)


@lru_cache(maxsize=64)
def _painted(decoration: Decoration, sheets: tuple, own: tuple[float, ...]) -> Layer:
    _, period = places(list(sheets))
    return Layer(painted(decoration, list(sheets), own)[::-1], period)


def shifted(mesh: RenderMesh, body: str, size: float | None) -> RenderMesh:
    """Return a mesh whose texture is offset by an amount that depends on the body.

    Args:
        mesh: Mesh with texture coordinates [m].
        body: Name of the body.
        size: Offsets are multiples of this length [m]; any length if None.
    """
    chance = random.Random(body)
    away = np.array([chance.uniform(0, 8), chance.uniform(0, 8)])
    assert mesh.uvs is not None
    return replace(mesh, uvs=mesh.uvs + (away if size is None else np.round(away) * size))


def toned(color: tuple[float, float, float], body: str, finish: str) -> tuple[float, float, float]:
    """Return the colour of a copy, slightly lighter or darker than that of the others.

    Args:
        color: Its colour, RGB from 0 to 1.
        body: Name of the copy, which determines the factor.
        finish: Its finish.
    """
    most = WEAR if finish in UNEVEN else EVEN_WEAR
    factor = 1 + most * random.Random(f"tone {body}").uniform(-1, 1)
    red, green, blue = (min(factor * x, 1.0) for x in color)
    return red, green, blue
