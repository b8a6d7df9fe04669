"""Meshes from files in triangles of a wanted size: large ones are divided, small ones merged."""

from functools import lru_cache
from hashlib import file_digest
from pathlib import Path

import numpy as np

from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.confined import call_confined, call_in_child
from text2sim.assets.foreign_files import named_errors
from text2sim.assets.isotropic import remesh_isotropically
from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.shapes.casemesh import SINGLE_FILE_SUFFIXES, load_mesh
from text2sim.compiler.shapes.meshfile import mesh_path, open_mesh, turn_upright
from text2sim.compiler.shapes.triangles import MAX_TRIANGLES, check_triangle_count, enclosed_volume, surface_area
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.shapes import Mesh

MAX_EDGE_RATIO = 4 / 3
"""Edges longer than this many wanted ones are halved: the halves are then no farther from the wanted length."""
MIN_MEAN_EDGE = 0.6
"""Triangles are merged if the mean of their edges is shorter than this many wanted ones."""
SHARP_ANGLE = 0.17
"""Angle [rad], ten degrees: where tetgen begins to put many tetrahedra around a corner."""
ATTEMPTS = ((4, 1.0), (8, 1.0), (4, 0.7), (4, 0.5), (8, 0.5))
"""Attempts in turn: with how many times the wanted triangles a rough simplification comes first, and a factor of the
wanted edge. Thin parts need shorter edges."""
SHARP_EDGE_DEG, SHARP_EDGE_SHARE = 60.0, 0.002
"""A surface has sharp edges if more than this part of its edges are bent by more than this."""
MAX_VOLUME_LOSS = 0.06
"""Part of the volume that merging triangles may lose."""
MAX_PASSES = 40
CLOSED_BY = 1e-9
"""Two places of a vertex in a picture count as one if they are nearer than this."""


def file_surface(
    shape: Mesh, folder: Path, edge: float, *, coarsen: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, int]:
    """Return vertices [m], faces, places in the picture if there are any, and how many vertices lie on seams.

    Args:
        shape: The mesh.
        folder: The case's folder.
        edge: Wanted length [m].
        coarsen: Whether small triangles are merged.

    Raises:
        AssetError: if the file cannot be used, or there would be too many triangles.
    """
    mesh = load_mesh(shape.file, folder)
    vertices, faces = mesh.vertices * shape.scale, mesh.faces
    area = surface_area(vertices, faces)
    check_triangle_count(area, edge)
    uvs, seams = None, 0
    if mesh.closed:
        if coarsen:
            vertices, faces = remesh_evenly(vertices, faces, edge)
    else:
        uvs, seams = _places(shape.file, folder, mesh.vertices)
    vertices, faces, uvs = split_long_edges(vertices, faces, edge, uvs)
    if len(faces) > MAX_TRIANGLES:
        raise AssetError(
            f"mesh file `{shape.file}` makes {len(faces):,} triangles with elements of {edge:g} m; at most "
            f"{MAX_TRIANGLES:,} are possible: take a larger `cell`, or a simpler mesh"
        )
    return vertices, faces.astype(np.int32), uvs, seams


def split_long_edges(
    vertices: np.ndarray, faces: np.ndarray, edge: float, uvs: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Halve edges until none is longer than 4/3 of `edge`; the surface keeps its form and stays closed.

    Every pass halves the longest edge of a triangle first, which keeps angles from becoming small (Rivara, 1984).

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3).
        edge: Wanted length [m].
        uvs: (n, 2), places in the picture, which are halved likewise.
    """
    faces = faces.astype(np.int64)
    for _ in range(MAX_PASSES):
        ahead = np.roll(faces, -1, axis=1)
        own = np.linalg.norm(vertices[faces] - vertices[ahead], axis=2)
        if own.max(initial=0.0) <= MAX_EDGE_RATIO * edge:
            break
        keys = np.minimum(faces, ahead) * len(vertices) + np.maximum(faces, ahead)
        keys, of = np.unique(keys, return_inverse=True)
        of, edges = of.reshape(-1, 3), np.stack([keys // len(vertices), keys % len(vertices)], axis=1)
        # Measured once for each edge, so that rounding is the same for both of its triangles.
        own = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)[of]
        wanted = np.zeros(len(edges), bool)
        wanted[of[(own >= 0.999 * own.max(axis=1, keepdims=True)) & (own > MAX_EDGE_RATIO * edge)]] = True
        if not wanted.any():
            break
        middle = np.where(wanted, np.cumsum(wanted) - 1 + len(vertices), -1)
        halves = edges[wanted]
        vertices = np.concatenate([vertices, vertices[halves].mean(axis=1)])
        if uvs is not None:
            uvs = np.concatenate([uvs, uvs[halves].mean(axis=1)])
        faces = _cut(faces, middle[of], own)
    return vertices, faces, uvs


def _cut(faces: np.ndarray, middle: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Divide triangles at the middles of their edges (-1: none); edge k goes from corner k to the next."""
    # Each triangle is turned so that its longest edge with a middle comes first.
    rank = np.where(middle >= 0, length, -1.0)
    turn = (np.argmax(rank, axis=1)[:, None] + np.arange(3)) % 3
    row = np.arange(len(faces))[:, None]
    (a, b, c), (p, q, r) = faces[row, turn].T, middle[row, turn].T
    found = [faces[p < 0]]
    for second, third in ((False, False), (True, False), (False, True), (True, True)):
        k = (p >= 0) & ((q >= 0) == second) & ((r >= 0) == third)
        # Both halves, each divided again if its other edge has a middle.
        left = [(a, p, r), (r, p, c)] if third else [(a, p, c)]
        right = [(p, b, q), (p, q, c)] if second else [(p, b, c)]
        found += [np.stack([x[k], y[k], z[k]], axis=1) for x, y, z in (*left, *right)]
    return np.concatenate(found)


def remesh_evenly(vertices: np.ndarray, faces: np.ndarray, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Give a closed surface triangles of one size, if its own are smaller than wanted or have sharp angles.

    Where that would open or fold the surface, it is left as it is.

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3) int.
        edge: Wanted length of edges [m].
    """
    area = surface_area(vertices, faces)
    count = int(area / (np.sqrt(3) / 4 * edge**2))
    fine = count < MIN_MEAN_EDGE**2 * len(faces)
    if not fine and np.percentile(_sharpest(vertices, faces), 2) > SHARP_ANGLE:
        return vertices, faces
    question = (b"evened apart", np.float64(edge).tobytes(), vertices.tobytes(), faces.astype(np.int64).tobytes())
    vertices, faces = cached_answer(question, lambda: _remesh(vertices, faces, edge, count))
    return vertices, faces


def _remesh(vertices: np.ndarray, faces: np.ndarray, edge: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    import trimesh
    from fast_simplification import simplify

    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max())
    # A surface with edges keeps them; on one without, what simplification makes look like an edge is none.
    bends = trimesh.Trimesh(vertices, faces, process=False).face_adjacency_angles
    feature = SHARP_EDGE_DEG if np.mean(bends > np.radians(SHARP_EDGE_DEG)) > SHARP_EDGE_SHARE else 180.0
    for many, finer in ATTEMPTS:
        points, net = (vertices - low) / size, faces
        if len(faces) > many * count / finer**2:
            few = max(round(many / 2 * count / finer**2), 200)
            points, net, *_ = simplify(points.astype(np.float32), net.astype(np.int32), target_count=few)
        points, net = call_in_child(remesh_isotropically, points.astype(float), net, finer * edge / size, feature)
        mesh = trimesh.Trimesh(points * size + low, net, process=False)
        if mesh.is_volume and abs(mesh.volume / enclosed_volume(vertices, faces) - 1) < MAX_VOLUME_LOSS:
            return np.asarray(mesh.vertices), np.asarray(mesh.faces)
    return vertices, faces


def _sharpest(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the smallest angle [rad] of each triangle, by the law of cosines."""
    corners = vertices[faces]
    a, b, c = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1).T
    return np.arccos(np.clip((b**2 + c**2 - a**2) / np.maximum(2 * b * c, 1e-300), -1, 1))


def _places(file: str, folder: Path, vertices: np.ndarray) -> tuple[np.ndarray | None, int]:
    """Return the place of each vertex in the picture, or else None and how many have several."""
    path, root = mesh_path(file, folder)
    stat = path.stat()
    return _read_places(path, root, stat.st_mtime_ns, stat.st_size, ObjectKey(vertices))


@lru_cache(maxsize=16)
def _read_places(path: Path, root: Path, _mtime: int, _size: int, rows: ObjectKey) -> tuple[np.ndarray | None, int]:
    def find() -> tuple[np.ndarray | None, int]:
        return call_confined(_find_places, path, root, rows.value)

    if path.suffix.lower() not in SINGLE_FILE_SUFFIXES:
        return find()
    with path.open("rb") as stream:
        digest = file_digest(stream, "sha256").digest()
    uvs, seams = cached_answer((b"places", path.suffix.lower().encode(), digest), find)
    return uvs, seams


def _find_places(path: Path, root: Path, vertices: np.ndarray) -> tuple[np.ndarray | None, int]:
    """Return the places (n, 2) of vertices in the picture if each has one, or else None and how many have several."""
    try:
        mesh = open_mesh(path, root, force="mesh", skip_materials=True)
    except AssetError:
        return None, 0
    try:
        with named_errors():
            uvs = getattr(mesh.visual, "uv", None)
            sound = uvs is not None and len(uvs) == len(mesh.vertices) and bool(np.isfinite(uvs).all())
    except AssetError:
        return None, 0
    if not sound:
        return None, 0
    return _matched(turn_upright(np.asarray(mesh.vertices, float), path), np.asarray(uvs, float), vertices)


def _matched(points: np.ndarray, uvs: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray | None, int]:
    """Match vertices to the points of the file, which has a point for each place of a vertex in the picture."""
    from scipy.spatial import KDTree

    owner = np.asarray(KDTree(vertices).query(points)[1])
    found = np.full((len(vertices), 2), np.nan)
    found[owner[::-1]] = uvs[::-1]
    seams = len(np.unique(owner[np.abs(found[owner] - uvs).max(axis=1) > CLOSED_BY]))
    return (None, seams) if seams or np.isnan(found).any() else (found, 0)
