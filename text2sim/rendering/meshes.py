"""Meshes for rendering: bevelled edges, smooth round shapes, generated texture coordinates.

Simulated shapes have perfectly sharp edges, which look artificial. Here the edges of convex shapes get a small radius.
Faces stay in place, so contacts stay visible.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import HalfspaceIntersection, QhullError

from text2sim.assets.surface import scaled_normals, triangle_areas
from text2sim.compiler.shapes.hulls import outward_hull
from text2sim.compiler.shapes.surface import rings
from text2sim.templates.shading import Shell

Array = NDArray[np.floating]
Indices = NDArray[np.integer]

BEVEL = 0.06
"""Radius of an edge, as a fraction of the smallest extent of its shape."""
WIDEST = 0.012
"""Largest radius of an edge [m]."""
SIDES = 96
"""Sides of a cylinder."""
SHARP = np.cos(np.radians(25.0))
"""Cosine of the smallest angle between faces that form an edge."""
WOUND = 0.9
"""Length of the mean normal below which a curved face goes around its corner, as at the tip of a cone."""
PLANES = 400
"""Largest number of faces of a convex shape that gets bevels: one with more is a scan, and has no edges."""
CAPSULE_SIDES, CAPSULE_RINGS = 32, 7
"""Sides and rings of a capsule; few, because ragdolls, ropes and nets have many capsules."""
STEPS = 4
"""Strips around an edge of 90 degrees."""
LARGEST = 4000
"""Largest number of vertices of a mesh that is tested for convexity."""


@dataclass(frozen=True)
class RenderMesh:
    """Triangles for rendering, with vertex normals."""

    vertices: Array
    """Positions [m], shape (n, 3)."""
    faces: Indices
    """Vertex indices, shape (f, 3)."""
    normals: Array
    """Unit normals, shape (n, 3)."""
    uvs: Array | None = None
    """Texture coordinates, shape (n, 2); the origin of pictures is at the lower left."""


def read_mesh(path: Path, *, rounded: bool = True) -> RenderMesh:
    """Read a recorded mesh and prepare it for rendering; as it was recorded, if not `rounded`."""
    with np.load(path) as arrays:
        vertices, faces = arrays["vertices"].astype(float), arrays["faces"].astype(np.int64)
        uvs = arrays["uvs"].astype(float) if "uvs" in arrays and len(arrays["uvs"]) == len(vertices) else None
    return presentable(vertices, faces, uvs) if rounded else _smooth(vertices, faces, uvs)


def presentable(vertices: Array, faces: Indices, uvs: Array | None = None) -> RenderMesh:
    """Return a mesh with smooth normals, and with bevelled edges if it is convex and has no texture.

    Args:
        vertices: Vertices, shape (n, 3) [m].
        faces: Triangles, shape (m, 3).
        uvs: Texture coordinates, shape (n, 2).
    """
    if uvs is None and 4 < len(vertices) <= LARGEST:
        round_one = _ball(vertices, faces) or _cylinder(vertices) or _cone(vertices) or _capsule(vertices)
        if (rounded := round_one or _bevelled(vertices, faces)) is not None:
            return rounded
    return _smooth(vertices, faces, uvs)


def _smooth(vertices: Array, faces: Indices, uvs: Array | None) -> RenderMesh:
    shell = Shell(vertices, faces)
    drawn_uvs = None if uvs is None else uvs[shell.sources]
    return RenderMesh(
        vertices[shell.sources], shell.faces.astype(np.int64), shell.normals(vertices).astype(float), drawn_uvs
    )


def boxed_uvs(mesh: RenderMesh, longest: int | None = None) -> RenderMesh:
    """Return the mesh with box-mapped texture coordinates in metres: each face is projected along its dominant axis.

    Args:
        mesh: The mesh.
        longest: Number of the axis along which the grain lies; by default that along which it is longest.
    """
    axis = np.abs(scaled_normals(mesh.vertices[mesh.faces])).argmax(axis=1)
    corners = np.stack([mesh.faces.ravel(), np.repeat(axis, 3)], axis=1)
    drawn, faces = np.unique(corners, axis=0, return_inverse=True)
    vertices = mesh.vertices[drawn[:, 0]]
    across = np.array([(1, 2), (0, 2), (0, 1)])[drawn[:, 1]]
    # The grain of wood is along v, and should run along the longest side.
    longest = int(np.ptp(mesh.vertices, axis=0).argmax()) if longest is None else longest
    across = np.where((across[:, 0] == longest)[:, None], across[:, ::-1], across)
    uvs = np.take_along_axis(vertices, across, axis=1)
    return RenderMesh(vertices, faces.reshape(-1, 3), mesh.normals[drawn[:, 0]], uvs)


def joined(meshes: list[RenderMesh]) -> RenderMesh:
    """Merge meshes, without texture coordinates."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)])
    return RenderMesh(np.concatenate([m.vertices for m in meshes]), faces, np.concatenate([m.normals for m in meshes]))


def _ball(vertices: Array, faces: Indices) -> RenderMesh | None:
    """Return a sphere with four times the triangles; None if the mesh is not a sphere."""
    radius, extent = np.linalg.norm(vertices, axis=1), np.ptp(vertices, axis=0)
    # The corners of a thin rod are also equidistant from its centre, but its extents differ.
    if len(vertices) < 100 or np.ptp(radius) > 1e-4 * radius.max() or np.ptp(extent) > 0.05 * extent.max():
        return None
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    middles = vertices[edges].mean(axis=1)
    normals = np.concatenate([vertices, middles])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    ab, bc, ca = (edge.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    finer = np.concatenate([np.stack(part, axis=1) for part in parts])
    return RenderMesh(normals * radius.mean(), finer, normals)


def _cylinder(vertices: Array) -> RenderMesh | None:
    """Return a cylinder about z with a bevelled rim; None if the mesh is not a cylinder."""
    radius, tall = np.hypot(vertices[:, 0], vertices[:, 1]), np.abs(vertices[:, 2])
    r, h = radius.max(), tall.max()
    rim = radius > 1e-6 * r
    flat = np.abs(tall - h).max() < 1e-5 * h
    if (
        not flat
        or np.abs(radius[rim] - r).max() > 1e-4 * r
        or not (vertices[rim, 2].min() < 0 < vertices[rim, 2].max())
        or len(np.unique(np.round(vertices[:, :2] / r, 4), axis=0)) < 12
    ):
        return None  # a square prism is not a cylinder
    edge = min(BEVEL * min(2 * r, 2 * h), WIDEST)
    turn = np.linspace(0, np.pi / 2, STEPS + 1)
    # From the centre of the bottom to that of the top; rim points appear once for each of the surfaces that they join.
    low = np.stack([r - edge + edge * np.sin(turn), -h + edge - edge * np.cos(turn)], axis=1)
    profile = np.concatenate([[(0.0, -h)], low, low[::-1] * (1, -1), [(0.0, h)]])
    slope = np.stack([np.sin(turn), -np.cos(turn)], axis=1)
    slopes = np.concatenate([[(0.0, -1.0)], slope, slope[::-1] * (1, -1), [(0.0, 1.0)]])
    return revolved(profile, slopes)


def _cone(vertices: Array) -> RenderMesh | None:
    """Return a cone about z with a bevelled rim, its tip up or down; None if the mesh is not a cone."""
    radius, z = np.hypot(vertices[:, 0], vertices[:, 1]), vertices[:, 2]
    r = float(radius.max())
    rim = radius > 1e-6 * r
    base, h = float(z[rim].mean()), float(np.ptp(z))
    tip = float(z[np.abs(z - base).argmax()])
    ends = np.minimum(np.abs(z - base), np.abs(z - tip)).max()
    if (
        h < 1e-6 * r
        or max(np.ptp(z[rim]), ends) > 1e-5 * h
        or np.abs(radius[rim] - r).max() > 1e-4 * r
        or len(np.unique(np.round(vertices[rim, :2] / r, 4), axis=0)) < 12
    ):
        return None  # a pyramid is not a cone
    slant = np.hypot(r, h)
    edge = min(BEVEL * min(2 * r, h), WIDEST, h * r / (r + slant) / 2)
    turn = np.linspace(-np.pi / 2, np.arctan2(r, h), STEPS + 1)  # from the base's normal to that of the side
    slopes = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rounded = (r - edge * (r + slant) / h, edge) + edge * slopes
    profile = np.concatenate([[(0.0, 0.0)], rounded, [(0.0, h)]])
    slopes = np.concatenate([[(0.0, -1.0)], slopes, slopes[-1:]])
    if tip < base:
        profile, slopes = profile[::-1] * (1, -1), slopes[::-1] * (1, -1)
    return revolved(profile + (0.0, base), slopes)


def _capsule(vertices: Array) -> RenderMesh | None:
    """Return a smooth capsule about z; None if the mesh is not a capsule."""
    tall = np.abs(vertices[:, 2])
    r = float(np.hypot(vertices[:, 0], vertices[:, 1]).max())
    half = float(tall.max()) - r
    away = np.hypot(np.hypot(vertices[:, 0], vertices[:, 1]), np.maximum(tall - half, 0.0))
    if half < 1e-3 * r or len(vertices) < 24 or np.abs(away - r).max() > 2e-3 * r:
        return None
    turn = np.linspace(0, np.pi / 2, CAPSULE_RINGS + 1)
    slopes = np.stack([np.sin(turn), -np.cos(turn)], axis=1)
    slopes = np.concatenate([slopes, slopes[::-1] * (1, -1)])
    ends = np.repeat([-half, half], CAPSULE_RINGS + 1)
    return revolved(r * slopes + np.stack([np.zeros_like(ends), ends], axis=1), slopes, CAPSULE_SIDES)


def revolved(profile: Array, slopes: Array, sides: int = SIDES) -> RenderMesh:
    """Return the surface of revolution of a profile about the z axis.

    Args:
        profile: Radius and height [m] of its points, shape (n, 2), with the outside to the right of the path.
        slopes: Normals at these points, radial and vertical component, shape (n, 2).
        sides: Number of sides.
    """
    vertices, normals = (rings(rows, sides).reshape(-1, 3) for rows in (profile, slopes))
    here = np.arange(len(profile) - 1)[:, None] * sides + np.arange(sides)
    beside = here - np.arange(sides) + (np.arange(sides) + 1) % sides
    faces = np.concatenate(
        [np.stack([here, beside, here + sides], axis=-1), np.stack([beside, beside + sides, here + sides], axis=-1)]
    ).reshape(-1, 3)
    return RenderMesh(vertices, faces[triangle_areas(vertices[faces]) > 5e-15], normals)


def _bevelled(vertices: Array, faces: Indices) -> RenderMesh | None:
    """Return a convex shape with bevelled edges; None if it is not convex or has no edges.

    It is the morphological opening by a small ball: the hull of balls about the corners of the shrunken shape.
    """
    planes = _planes(vertices, faces)
    if planes is None or not 4 <= len(planes) <= PLANES:
        return None
    radius = min(BEVEL * float(np.ptp(vertices, axis=0).min()), WIDEST)
    middle = vertices.mean(axis=0)
    try:
        inner = HalfspaceIntersection(planes + np.array([0, 0, 0, radius]), middle).intersections
    except QhullError:
        return None
    corners = np.unique(np.round(inner, 9), axis=0)
    at = np.abs(corners @ planes[:, :3].T + planes[:, 3] + radius) < 1e-6 * (1 + np.abs(planes[:, 3]))
    points, normals, sharp = [], [], False
    for corner, touched in zip(corners, at, strict=True):
        directions = _directions(planes[touched, :3])
        sharp |= len(directions) > 1
        points.append(corner + radius * directions)
        normals.append(directions)
    if not sharp:
        return None
    cloud, directions = np.concatenate(points), np.concatenate(normals)
    try:
        used, triangles = outward_hull(cloud, "Qt")
    except QhullError:
        return None
    return RenderMesh(cloud[used], triangles, directions[used])


def _planes(vertices: Array, faces: Indices) -> Array | None:
    """Return the planes n x + d <= 0 of a convex mesh, shape (p, 4); None if it is not convex."""
    a, normals = vertices[faces[:, 0]], scaled_normals(vertices[faces])
    size = np.linalg.norm(normals, axis=1)
    extent = np.ptp(vertices, axis=0)
    solid = size > 1e-9 * extent.max() ** 2
    if extent.min() < 1e-5 or solid.sum() < 4:
        return None
    normals, a = normals[solid] / size[solid, None], a[solid]
    planes = np.column_stack([normals, -(normals * a).sum(axis=1)])
    planes = planes[np.unique(np.round(planes / np.array([1, 1, 1, extent.max()]), 4), axis=0, return_index=True)[1]]
    if len(planes) > PLANES:
        return None
    outside = (vertices @ planes[:, :3].T + planes[:, 3]).max()
    return planes if outside < 2e-4 * extent.max() else None


def _directions(normals: Array) -> Array:
    """Return the normals of a rounded corner, shape (n, 3), between those of the faces that meet there.

    Faces that meet at a small angle count as one curved face.
    """
    groups: list[list[Array]] = []
    for normal in normals:
        for group in groups:
            if max(float(normal @ other) for other in group) > SHARP:
                group.append(normal)
                break
        else:
            groups.append([normal])
    means = np.array([np.mean(group, axis=0) for group in groups])
    length = np.linalg.norm(means, axis=1, keepdims=True)
    axis = normals.mean(axis=0)
    if length.min() < WOUND and np.linalg.norm(axis) > 1e-3:
        axis = axis / np.linalg.norm(axis)
        fans = [((STEPS - s) * normals + s * axis) / STEPS for s in range(STEPS + 1)]
        normals = np.concatenate(fans)
        return np.unique(np.round(normals / np.linalg.norm(normals, axis=1, keepdims=True), 6), axis=0)
    means = means[length[:, 0] > 0.5] / length[length[:, 0] > 0.5]
    if len(means) < 2:
        return means if len(means) else normals[:1]
    grid = []
    triples = [(0, 1, 1)] if len(means) == 2 else [(0, i, i + 1) for i in range(1, len(means) - 1)]
    if len(means) > 3:  # in order around their mean
        means = _in_order(means)
    for i, j, k in triples:
        for u in range(STEPS + 1):
            for v in range(STEPS + 1 - u):
                grid.append((u * means[i] + v * means[j] + (STEPS - u - v) * means[k]) / STEPS)
    normals = np.array(grid)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals[length[:, 0] > 1e-3] / length[length[:, 0] > 1e-3]
    return np.unique(np.round(normals, 6), axis=0)


def _in_order(normals: Array) -> Array:
    axis = normals.mean(axis=0)
    axis = axis / max(np.linalg.norm(axis), 1e-9)
    side = np.cross(axis, normals[0])
    angle = np.arctan2((normals @ np.cross(side, axis)), normals @ side)
    return normals[np.argsort(angle)]
