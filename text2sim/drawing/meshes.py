"""Triangles of pieces and surfaces in their own frames, with limited detail."""

import math
from io import BytesIO
from typing import NamedTuple

import numpy as np

from text2sim.assets.surface import scaled_normals, triangle_areas
from text2sim.compiler.shapes.hulls import outward_hull
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.surface import VisualMesh, bands, rings, surface
from text2sim.spec_schema.models.shapes import Box

MAX_SMOOTH_DIFFERENCE = 0.5
"""Difference of normals above which neighbours stay apart when a surface is simplified."""


class Triangles(NamedTuple):
    """A surface."""

    corners: np.ndarray
    """Corners [m], counterclockwise from outside, (n, 3, 3) float."""
    normals: np.ndarray
    """Unit normals at the corners, (n, 3, 3) float."""
    colors: np.ndarray | None = None
    """Colours of the triangles in 0..1, (n, 3) float, if the surface has a picture."""


def box() -> Triangles:
    """Return a cube of edge length 1."""
    cube = surface(Box(kind="box", size=(1.0, 1.0, 1.0)))
    return Triangles(cube.vertices[cube.faces], cube.normals[cube.faces])


def square() -> Triangles:
    """Return a square of edge length 1 in the x-y plane."""
    corners = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])
    return Triangles(corners[np.array([(0, 1, 2), (0, 2, 3)])], np.broadcast_to((0.0, 0.0, 1.0), (2, 3, 3)))


def lathe(profile: list[tuple[float, float]], slopes: list[tuple[float, float]], sides: int) -> Triangles:
    """Revolve a profile about z.

    Args:
        profile: Radius and height [m] of its points, from bottom to top, with the solid on the left.
        slopes: Normal of each point: radial and vertical component.
        sides: Number of sides.
    """
    radii = [radius for radius, _ in profile]
    return Triangles(bands(rings(profile, sides), radii), bands(rings(slopes, sides), radii))


def ball(sides: int) -> Triangles:
    """Return a ball of radius 1."""
    angles = [math.pi * (k / (sides // 2) - 0.5) for k in range(sides // 2 + 1)]
    profile = [(math.cos(a) if abs(a) < 1.57 else 0.0, math.sin(a)) for a in angles]
    return lathe(profile, profile, sides)


def cylinder(sides: int) -> Triangles:
    """Return a cylinder of radius 1 and height 1."""
    profile = [(0.0, -0.5), (1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (1.0, 0.5), (0.0, 0.5)]
    slopes = [(0.0, -1.0), (0.0, -1.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 1.0)]
    return _without_slivers(lathe(profile, slopes, sides))


def _capsule(radius: float, length: float, sides: int) -> Triangles:
    """Return a capsule about z."""
    steps = max(sides // 4, 2)
    caps = [math.pi / 2 * (k / steps) for k in range(steps + 1)]
    slopes = [(math.sin(a) if k else 0.0, -math.cos(a)) for k, a in enumerate(caps)]
    slopes += [(out, -up) for out, up in reversed(slopes)]
    half = length / 2
    profile = [(radius * out, radius * up + (half if k > steps else -half)) for k, (out, up) in enumerate(slopes)]
    return _without_slivers(lathe(profile, slopes, sides))


def _without_slivers(mesh: Triangles) -> Triangles:
    area = triangle_areas(mesh.corners)
    keep = area > 1e-9 * max(float(area.max(initial=0.0)), 1e-30)
    return Triangles(mesh.corners[keep], mesh.normals[keep], None if mesh.colors is None else mesh.colors[keep])


def solid(piece: Piece, sides: int) -> Triangles:
    """Return the surface of a convex piece in its own frame; for kinds that scale, see `unit`."""
    if piece.kind == "capsule":
        return _capsule(piece.size[0], piece.size[1], sides)
    corners = np.array(piece.vertices, float)
    if piece.faces:
        return flat_shaded(corners[np.array(piece.faces)])
    from scipy.spatial import QhullError

    try:
        used, faces = outward_hull(corners)
    except (QhullError, ValueError):
        return flat_shaded(np.zeros((0, 3, 3)))
    return flat_shaded(corners[used][faces])


def flat_shaded(corners: np.ndarray) -> Triangles:
    """Return triangles (n, 3, 3) with flat normals."""
    normals = scaled_normals(corners)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return Triangles(corners, np.repeat(normals[:, None], 3, axis=1))


def unit(kind: str, sides: int) -> Triangles:
    """Return the unit shape that scales to a box, sphere, ellipsoid or cylinder."""
    return box() if kind == "box" else cylinder(sides) if kind == "cylinder" else ball(sides)


def scale_of(kind: str, size: tuple[float, ...]) -> tuple[float, float, float] | None:
    """Return the scale from `unit` to a piece; None for kinds without a unit shape."""
    if kind in ("box", "ellipsoid"):
        return (size[0], size[1], size[2])
    if kind == "sphere":
        return (size[0], size[0], size[0])
    return (size[0], size[0], size[1]) if kind == "cylinder" else None


def limited_surface(mesh: VisualMesh, max_triangles: int, *, picture: bool = True) -> Triangles:
    """Return a surface of the compiler with limited detail.

    Args:
        mesh: The surface.
        max_triangles: Number of triangles above which it is simplified.
        picture: Whether to take colours from its picture, if it has one.
    """
    vertices, normals, faces = mesh.vertices, mesh.normals, mesh.faces
    uvs = mesh.uvs if picture and mesh.picture is not None else None
    if len(faces) > max_triangles:
        vertices, normals, faces, uvs = _simplified(vertices, normals, faces, uvs, max_triangles)
    colors = None if uvs is None or mesh.picture is None else _sampled(mesh.picture, uvs[faces].mean(axis=1))
    return _without_slivers(Triangles(vertices[faces], normals[faces], colors))


def _simplified(
    vertices: np.ndarray, normals: np.ndarray, faces: np.ndarray, uvs: np.ndarray | None, max_triangles: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Merge near vertices with similar normals until the number of triangles is small enough."""
    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max())
    cells = max(int(math.sqrt(max_triangles / 6)), 2)
    while True:
        spot = np.floor((vertices - low) * (cells / max(size, 1e-30)) + 0.5).astype(np.int64)
        _, place, cell = np.unique(spot @ (1, 4096, 4096**2), return_index=True, return_inverse=True)
        # Vertices of a cell get one position, so that no cracks open, but those with other normals stay apart.
        facing = np.round(normals / MAX_SMOOTH_DIFFERENCE / 2).astype(np.int64) + 1
        keys = cell.reshape(-1) * 27 + facing @ (1, 3, 9)
        _, first, merged = np.unique(keys, return_index=True, return_inverse=True)
        corners = cell.reshape(-1)[faces]
        a, b, c = corners.T
        left = (a != b) & (b != c) & (c != a)
        if left.sum() <= 1.5 * max_triangles or cells <= 2:
            break
        cells = max(int(cells * 0.7), 2)
    moved = vertices[place][cell.reshape(-1)[first]]
    return moved, normals[first], merged.reshape(-1)[faces[left]], None if uvs is None else uvs[first]


def _sampled(picture: bytes, uvs: np.ndarray) -> np.ndarray:
    """The colours (n, 3) of a picture at texture coordinates (n, 2)."""
    from PIL import Image

    pixels = np.asarray(Image.open(BytesIO(picture)).convert("RGB"), np.float32) / 255
    height, width = pixels.shape[:2]
    x = (np.mod(uvs[:, 0], 1.0) * (width - 1)).astype(int)
    y = ((1.0 - np.mod(uvs[:, 1], 1.0)) * (height - 1)).astype(int)
    return pixels[y, x]
