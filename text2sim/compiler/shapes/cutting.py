"""Shapes cut into the cells of a Voronoi diagram, so that they can shatter.

Two cells meet in a plane. So what is cut touches face to face, and the convex hulls of what lies in different cells do
not overlap.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from manifold3d import Manifold, Mesh64, OpType
from scipy.spatial import KDTree, Voronoi

from text2sim.assets.answer_cache import cached_answer
from text2sim.compiler.memory import Memory
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.geometry import key_of, visual_mesh, volume
from text2sim.compiler.shapes.hulls import outward_hull
from text2sim.compiler.shapes.rotation import quat_of
from text2sim.compiler.shapes.sculpting import Sculpted
from text2sim.compiler.shapes.surface import VisualMesh, surface
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.base import content_of
from text2sim.spec_schema.models.shapes import Compound

if TYPE_CHECKING:
    from text2sim.spec_schema.models.repeat import Fragments

SAME = 1e-9
"""Distance below which vertices of a surface are one, over its size."""
SAMPLES_PER_CELL = 100
"""Points that stand for a cell while the cells are spread."""
POINTS_PER_SAMPLE = 20
"""Points of which one is chosen by its distance from the focus."""
COLUMNS = 8192
"""Vertical lines on which these points lie."""
ROUNDS = 3
"""Steps of Lloyd's iteration, which moves each seed to the middle of its cell: no two are close, yet cells differ."""
FOCUS_RADIUS = 0.1
"""Distance from the focus at which seeds are an eighth as dense as there, over the longest side of the shape."""
SPLINTER = 0.01
"""Of the separate pieces of a cell, those with less of its volume than this are left out."""
MAX_TRIANGLES = 50_000
"""Most triangles of a surface that is cut."""
MAX_CUTS = 6
"""How often a cell is cut again, so that hulls of its pieces do not overlap."""
CONVEX = 0.7
"""Share of its convex hull that a fragment fills, above which it touches by its hull."""
MAX_HALVINGS = 2
"""How often a fragment that fills less is cut in half for contact."""

_KNOWN: "Memory[list[Fragment]]" = Memory(64)


def cuttings(shape: Any, cut: "Fragments", folder: Path) -> list[Fragment]:
    """Return the fragments of a shape: from its focus outwards or, without one, upwards.

    Args:
        shape: Any shape with a closed surface.
        cut: How it is cut.
        folder: The case's folder.

    Raises:
        AssetError: if its surface is not closed, or its file cannot be used.
    """
    key = (key_of(shape, folder), content_of(cut))
    return _KNOWN.recall(key, lambda: _cuttings(shape, cut, folder))


def _cuttings(shape: Any, cut: "Fragments", folder: Path) -> list[Fragment]:
    vertices, normals, faces = closed_surface(shape, folder)
    question = (b"fragments", repr(cut).encode(), *(array.tobytes() for array in (vertices, normals, faces)))
    rows = cached_answer(question, lambda: _cut(vertices, normals, faces, cut))
    made = [Sculpted(**row, looks=np.full(len(row["faces"]), -1), names=()) for row in rows]
    centers = [solid.center for solid in made]
    # A surface of flat triangles lacks a little of a round shape; together the fragments weigh what the shape does.
    share = volume(shape, folder) / sum(solid.volume for solid in made)
    bounds = tuple(tuple(corner.tolist()) for corner in (vertices.min(axis=0), vertices.max(axis=0)))
    found = []
    for solid, row, center in zip(made, rows, centers, strict=True):
        hulls = [(corners - center, net) for corners, net in row["hulls"]]
        own = Sculpted(solid.vertices - center, solid.faces, solid.normals, solid.looks, hulls, ())
        found.append(Fragment.model_construct(solid=own, volume=share * solid.volume, place=center, bounds=bounds))
    return found


def closed_surface(shape: Any, folder: Path) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Return the surface of a shape: vertices (n, 3) [m], their normals (n, 3) and triangles (m, 3).

    On sharp edges vertices occur twice, each with its own normal. A compound is the union of its parts.

    Raises:
        AssetError: if it is not closed, or a file cannot be used.
    """
    if isinstance(shape, Compound):
        parts = []
        for name, part in shape.solids.items():
            turned = [mesh.at(part.pose.pos, quat_of(part.pose), name) for mesh in _drawn(part.shape, folder)]
            parts.append(_closed(turned, f"the surface of part `{name}`"))
        solid = Manifold.batch_boolean(parts, OpType.Add)
    else:
        solid = _closed(_drawn(shape, folder), "its surface")
    mesh = solid.to_mesh64()
    return mesh.vert_properties[:, :3].copy(), mesh.vert_properties[:, 3:].copy(), mesh.tri_verts.astype(np.int64)


def _drawn(shape: Any, folder: Path) -> list[VisualMesh]:
    return visual_mesh(shape, folder) or [surface(shape)]


def _closed(meshes: list[VisualMesh], what: str) -> Manifold:
    solid = _manifold(meshes)
    if solid.volume() <= 0:
        raise AssetError(f"{what} is open, or its triangles face different ways: only a closed one can be cut")
    return solid


def _manifold(meshes: list[VisualMesh]) -> Manifold:
    """Return the solid within surfaces, with their normals as its properties; an empty one if they are not closed."""
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices, normals = (np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in ("vertices", "normals"))
    faces = np.concatenate([mesh.faces + first for mesh, first in zip(meshes, firsts[:-1], strict=True)])
    if len(faces) > MAX_TRIANGLES:
        raise AssetError(f"has {len(faces):,} triangles; at most {MAX_TRIANGLES:,} can be cut")
    low = vertices.min(axis=0)
    grid = np.round((vertices - low) / (SAME * np.ptp(vertices, axis=0).max())).astype(np.int64)
    _, first, place = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    same = first[place.reshape(-1)]
    a, b, c = same[faces].T
    faces = faces[(a != b) & (b != c) & (c != a)]
    twice = np.flatnonzero(same != np.arange(len(same)))
    return Manifold(
        Mesh64(
            np.hstack([vertices, normals]),
            faces.astype(np.uint64),
            merge_from_vert=twice.astype(np.uint64),
            merge_to_vert=same[twice].astype(np.uint64),
        )
    )


def _cut(
    vertices: "np.ndarray", normals: "np.ndarray", faces: "np.ndarray", cut: "Fragments"
) -> "list[dict[str, Any]]":
    """Return the fragments as arrays, see `Sculpted`, in the frame of the whole."""
    whole = _manifold([VisualMesh(vertices, faces, normals)])
    stretch = np.array(cut.stretch)
    focus = None if cut.focus is None else np.array(cut.focus)
    seeds = _seeds(vertices[faces], cut.count, focus, stretch, np.random.default_rng(cut.seed))
    pieces = []
    for corners in _cells(seeds, vertices / stretch):
        cell = Manifold.hull_points(corners * stretch)
        part = whole ^ cell
        if part.volume() > 0:
            pieces += _apart(part, {cell.original_id()})
    rows = [_row(piece, ids) for piece, ids in pieces]
    middles = np.array([_middle(piece) for piece, _ in pieces])
    first = middles[:, 2] if focus is None else np.linalg.norm(middles - focus, axis=1)
    size = float(np.ptp(vertices, axis=0).max())
    # Rounded, so that rounding errors do not decide the order.
    order = np.lexsort((*np.round(middles.T / size, 7), np.round(first / size, 7)))
    return [rows[k] for k in order]


def _seeds(
    triangles: "np.ndarray", count: int, focus: "np.ndarray | None", stretch: "np.ndarray", dice: np.random.Generator
) -> "np.ndarray":
    """Return the seeds (count, 3) of the cells, in coordinates divided by `stretch`."""
    wanted = SAMPLES_PER_CELL * count
    points = _points_within(triangles, POINTS_PER_SAMPLE * wanted if focus is not None else wanted, dice)
    if focus is not None:
        scale = FOCUS_RADIUS * np.ptp(triangles.reshape(-1, 3), axis=0).max()
        weight = (1 + np.linalg.norm(points - focus, axis=1) / scale) ** -3.0
        points = points[dice.choice(len(points), wanted, replace=False, p=weight / weight.sum())]
    points = points / stretch
    seeds = points[dice.choice(len(points), count, replace=False)]
    for _ in range(ROUNDS):
        _, nearest = KDTree(seeds).query(points)
        size = np.bincount(nearest, minlength=count)
        total = np.stack([np.bincount(nearest, points[:, k], minlength=count) for k in range(3)], axis=1)
        seeds = np.where(size[:, None] > 0, total / np.maximum(size, 1)[:, None], seeds)
    return seeds


def _points_within(triangles: "np.ndarray", count: int, dice: np.random.Generator) -> "np.ndarray":
    """Return random points (count, 3) [m] within a closed surface (n, 3, 3), evenly spread."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    columns = dice.uniform(low[:2], high[:2], (COLUMNS, 2))
    columns = columns[np.argsort(columns[:, 0], kind="stable")]
    begin = np.searchsorted(columns[:, 0], triangles[:, :, 0].min(axis=1))
    end = np.searchsorted(columns[:, 0], triangles[:, :, 0].max(axis=1))
    column, height = [], []
    for (a, b, c), first, last in zip(triangles, begin.tolist(), end.tolist(), strict=True):
        u, v = b[:2] - a[:2], c[:2] - a[:2]
        area = u[0] * v[1] - u[1] * v[0]
        if first == last or area == 0.0:
            continue
        x, y = (columns[first:last] - a[:2]).T
        s, t = (x * v[1] - y * v[0]) / area, (u[0] * y - u[1] * x) / area
        hit = np.flatnonzero((s >= 0) & (t >= 0) & (s + t <= 1))
        column.append(first + hit)
        height.append(a[2] + s[hit] * (b[2] - a[2]) + t[hit] * (c[2] - a[2]))
    columns_hit, heights = (
        np.concatenate([*rows, np.empty(0, kind)]) for rows, kind in ((column, int), (height, float))
    )
    order = np.lexsort((heights, columns_hit))
    columns_hit, heights = columns_hit[order], heights[order]
    # A column enters and leaves the solid in turn; one that meets an edge may count twice there, and is left out.
    even = np.bincount(columns_hit, minlength=len(columns)) % 2 == 0
    kept = even[columns_hit]
    spans = np.column_stack([columns_hit[kept][::2], np.flatnonzero(kept)[::2], np.flatnonzero(kept)[1::2]])
    lengths = heights[spans[:, 2]] - heights[spans[:, 1]]
    if not lengths.sum() > 0:
        raise AssetError("is too thin to be cut")
    chosen = dice.choice(len(spans), count, p=lengths / lengths.sum())
    z = heights[spans[chosen, 1]] + dice.random(count) * lengths[chosen]
    return np.column_stack([columns[spans[chosen, 0]], z])


def _cells(seeds: "np.ndarray", vertices: "np.ndarray") -> "list[np.ndarray]":
    """Return the corners of the Voronoi cells of seeds; cells go far beyond the vertices of the shape."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    far = 4 * float(np.linalg.norm(high - low))
    # Seeds far around close the cells; none of their own cells reaches the shape.
    around = [(low + high) / 2 + far * side for side in (*np.eye(3), *-np.eye(3))]
    diagram = Voronoi(np.concatenate([seeds, around]))
    return [diagram.vertices[diagram.regions[diagram.point_region[k]]] for k in range(len(seeds))]


def _apart(part: Manifold, ids: set[int], depth: int = 0) -> list[tuple[Manifold, set[int]]]:
    """Return the separate pieces of what lies in a cell, whose hulls do not overlap, with the ids of cut faces."""
    pieces = [piece for piece in part.decompose() if piece.volume() > SPLINTER * part.volume()]
    hulls = [piece.hull() for piece in pieces]
    overlap = any((hulls[i] ^ hulls[j]).volume() > 1e-6 * part.volume() for j in range(len(pieces)) for i in range(j))
    if not overlap or depth >= MAX_CUTS:
        return [(piece, ids) for piece in pieces]
    largest = sorted(pieces, key=lambda piece: -piece.volume())[:2]
    a, b = (np.array(_middle(piece)) for piece in largest)
    away = float(np.linalg.norm(b - a))
    normal = (b - a) / away if away else np.eye(3)[2]  # one within the other
    found = []
    for side in part.split_by_plane(normal.tolist(), float(normal @ (a + b) / 2)):
        if side.volume() > SPLINTER * part.volume():
            found += _apart(side, ids, depth + 1)
    return found


def _middle(solid: Manifold) -> "np.ndarray":
    mesh = solid.to_mesh64()
    corners = mesh.vert_properties[:, :3][mesh.tri_verts.astype(np.int64)]
    six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return (six[:, None] * corners.sum(axis=1)).sum(axis=0) / (4 * six.sum())


def _row(piece: Manifold, ids: set[int]) -> "dict[str, Any]":
    """Return a fragment as arrays: smooth where the shape is, flat where it was cut."""
    mesh = piece.to_mesh64()
    places, normals = mesh.vert_properties[:, :3], mesh.vert_properties[:, 3:6]
    faces = mesh.tri_verts.astype(np.int64)
    cut = np.zeros(len(faces), bool)
    bounds = [k // 3 for k in mesh.run_index]
    for number, first, last in zip(mesh.run_original_id, bounds, bounds[1:], strict=False):
        cut[first:last] = number in ids
    corners = places[faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
    shading = normals[faces]
    shading[cut] = flat[cut][:, None]
    long = np.linalg.norm(shading, axis=2, keepdims=True)
    shading = np.where(long > 0.1, shading / np.maximum(long, 1e-300), flat[:, None])
    table = np.concatenate([corners, np.round(shading, 6)], axis=2).reshape(-1, 6)
    _, first, index = np.unique(table, axis=0, return_index=True, return_inverse=True)
    hulls = []
    for part in _nearly_convex(piece):
        points = part.to_mesh64().vert_properties[:, :3]
        used, net = outward_hull(points)
        hulls.append((points[used], net))
    return {
        "vertices": table[first, :3],
        "normals": table[first, 3:],
        "faces": index.reshape(-1, 3),
        "hulls": hulls,
    }


def _nearly_convex(piece: Manifold, depth: int = 0) -> list[Manifold]:
    """Cut a fragment across its longest direction until its parts nearly fill their hulls."""
    if depth == MAX_HALVINGS or piece.volume() > CONVEX * piece.hull().volume():
        return [piece]
    places = piece.hull().to_mesh64().vert_properties[:, :3]
    _, _, axes = np.linalg.svd(places - places.mean(axis=0), full_matrices=False)
    normal = axes[0] * np.sign(axes[0][np.abs(axes[0]).argmax()])
    halves = piece.split_by_plane(normal.tolist(), float(normal @ _middle(piece)))
    return [part for half in halves if half.volume() > 0 for part in _nearly_convex(half, depth + 1)]
