"""Surfaces of deformable bodies: closed ones of solids, open ones of cloth, in triangles of a wanted size.

Round shapes are made of rings (`rings.py`), letters and drawings of triangles in their plane (`extrude.py`); triangles
of meshes from files are divided or merged (`remesh.py`). Equal shapes give equal bytes.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.answer_cache import cached_answer
from text2sim.compiler.memory import Memory
from text2sim.compiler.shapes.boxes import sides
from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import key_of, volume
from text2sim.compiler.shapes.hulls import corners_and_sides
from text2sim.compiler.shapes.revolved import revolved_area, revolved_mesh
from text2sim.compiler.shapes.rings import Arc, profile, profile_of, turned
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, quat_of, quat_to_rows
from text2sim.compiler.shapes.sagging import points_along_sheet, sheet_lines
from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.compiler.shapes.triangles import MAX_TRIANGLES, check_triangle_count, surface_area
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.faceted import Faceted
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Box, Compound, Ellipsoid, FlatShape, Mesh, Torus
from text2sim.spec_schema.models.sheets import Disc, Revolve, Ribbon, Sheet, Sleeve

REGULAR_VOLUME = 1 / (6 * math.sqrt(2))
"""Volume of a regular tetrahedron of edge 1."""


# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np
    from manifold3d import Manifold

DIGITS = 8
"""Decimals of every coordinate [m]."""
_SURFACES: "Memory[SoftMesh]" = Memory(64)
"""Surfaces by shape, shared by copies and by all who only read them."""
HULL_EDGES = 24
"""Edges along the longest side of a solid, when its surface is measured."""
UNION_EDGES = 40
"""Edges along the longest side of a part, when its union with the others is made."""
THIN_ROWS, THIN_ROUND = {Sheet: 2, Disc: 2, Sleeve: 2, Revolve: 2, Ribbon: 2, Box: 8, Torus: 150}, 48
"""Triangles around shapes thinner than an edge: round ones keep their form."""
_UNIONS: "Memory[Manifold]" = Memory(64)


@dataclass(frozen=True, eq=False)
class SoftMesh:
    """Triangles in the shape's own frame, without duplicate vertices."""

    vertices: "np.ndarray"
    """(n, 3) float64 [m]"""
    faces: "np.ndarray"
    """(m, 3) int32, counterclockwise from outside; of a sheet, from above"""
    uvs: "np.ndarray | None" = None
    """(n, 2) float64: place of each vertex in the picture."""
    seams: int = 0
    """Of a cloth from a file: vertices with several places in the picture. If there are any, `uvs` is None."""


def soft_surface(shape: Any, folder: Path, edge: float, *, coarsen: bool = True) -> SoftMesh:
    """Return the surface of a shape in triangles whose edges are about `edge` [m] long.

    Args:
        shape: Any solid shape (a compound is the union of its parts), or a sheet. An open mesh is taken for cloth,
            and keeps its `uvs`.
        folder: The case's folder.
        edge: Wanted length [m]. Round shapes have shorter edges where they would lose their form.
        coarsen: Whether triangles of a mesh that are smaller than wanted are merged.

    Raises:
        AssetError: if a file cannot be used, or there would be too many triangles.
    """
    key = (key_of(shape, folder), float(edge), coarsen)
    return _SURFACES.recall(key, lambda: _surface(shape, folder, float(edge), coarsen))


def _surface(shape: Any, folder: Path, edge: float, coarsen: bool) -> SoftMesh:
    import numpy as np

    if not edge > 0 or not math.isfinite(edge):
        raise AssetError(f"an element must have a length above 0 (got {edge:g} m)")
    if isinstance(shape, Mesh):
        from text2sim.compiler.shapes.remesh import file_surface

        return _build(*file_surface(shape, folder, edge, coarsen=coarsen))
    if isinstance(shape, Sculpt | Compound | Faceted):
        return _build(*_mesh_union(shape, folder, edge, coarsen=coarsen))
    rows = THIN_ROWS.get(type(shape), THIN_ROUND)
    check_triangle_count(_area(shape, folder), edge, rows * _longest(shape, folder))
    if isinstance(shape, Sheet):
        return _build(*_sheet(shape, edge))
    if isinstance(shape, Disc):
        return _build(*_disc(shape, edge))
    if isinstance(shape, Sleeve):
        (low, high), half = shape.radii, shape.height / 2
        return _build(*turned(profile_of([((low, -half), (high, half))], edge), edge, closed=False))
    if isinstance(shape, Revolve):
        return _build(*revolved_mesh(shape, edge))
    if isinstance(shape, Ribbon):
        return _build(*_ribbon(shape, edge))
    if isinstance(shape, Box):
        return _build(*_box(shape.size, edge))
    if isinstance(shape, Ellipsoid):
        return _build(*_ellipsoid(shape, edge))
    if isinstance(shape, FlatShape):
        from text2sim.compiler.shapes.extrude import extruded
        from text2sim.compiler.shapes.glyphs import whole

        form = whole(shape, folder)
        own = Path(__file__).with_name("extrude.py").read_bytes()
        question = (b"extruded", own, form.wkb, np.array([shape.depth, edge]).tobytes())
        return _build(*cached_answer(question, lambda: extruded(form, shape.depth, edge)))
    parts, closed = profile(shape)
    vertices, faces = turned(profile_of(parts, edge), edge, closed=closed)
    return _build(np.asarray(vertices), faces)


def _mesh_union(
    shape: Sculpt | Compound | Faceted, folder: Path, edge: float, *, coarsen: bool
) -> "tuple[np.ndarray, np.ndarray]":
    """Return vertices [m] and faces of the surface, in triangles whose edges are about `edge` [m] long.

    Args:
        shape: The shape.
        folder: The case's folder.
        edge: Wanted length [m].
        coarsen: Whether triangles that are smaller are merged.

    Raises:
        AssetError: if parts of a compound do not touch, or there would be too many triangles.
    """
    import numpy as np

    from text2sim.compiler.shapes.remesh import remesh_evenly, split_long_edges

    if isinstance(shape, Sculpt):
        sculpture = sculpted(shape)
        vertices, faces = sculpture.vertices, sculpture.faces
    elif isinstance(shape, Faceted):
        (vertices, faces), coarsen = corners_and_sides(shape.points), False
    else:
        mesh = union(shape, folder).to_mesh64()
        vertices, faces = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, np.int64)
    check_triangle_count(surface_area(vertices, faces), edge)
    if coarsen:
        vertices, faces = remesh_evenly(vertices, faces, edge)
    vertices, faces, _ = split_long_edges(vertices, faces, edge)
    if len(faces) > MAX_TRIANGLES:
        raise AssetError(
            f"makes {len(faces):,} triangles; at most {MAX_TRIANGLES:,} are possible: take a larger `cell`"
        )
    return vertices, faces.astype(np.int32)


def union(shape: Compound, folder: Path) -> "Manifold":
    """Return the union of the solid parts of a compound.

    Raises:
        AssetError: if a part is not a closed solid, or parts do not touch.
    """
    return _UNIONS.recall(key_of(shape, folder), lambda: _union(shape, folder))


def _union(shape: Compound, folder: Path) -> "Manifold":
    import numpy as np
    from manifold3d import Manifold, Mesh64, OpType

    solids = []
    for name, part in shape.solids.items():
        size = max(sides(extents(part.shape, IDENTITY, folder)))
        mesh = soft_surface(part.shape, folder, size / UNION_EDGES, coarsen=not isinstance(part.shape, Mesh))
        turn = np.array(quat_to_rows(quat_of(part.pose))).T
        solid = Manifold(Mesh64(mesh.vertices @ turn + np.array(part.pose.pos), mesh.faces.astype(np.uint64)))
        if solid.is_empty():
            raise AssetError(f"part `{name}` is not a closed solid, so it cannot be part of a deformable body")
        solids.append(solid)
    whole = Manifold.batch_boolean(solids, OpType.Add)
    apart = [piece for piece in whole.decompose() if piece.volume() > 0]
    if len(apart) > 1:
        raise AssetError(f"is in {len(apart)} pieces: parts of a deformable body must overlap, to make one volume")
    return whole


def hull_area(shape: Any, folder: Path) -> float:
    """Return the area [m2] of the surface of a solid, or of a mesh as it is in its file.

    Raises:
        AssetError: if a file of its shape cannot be used.
    """
    if isinstance(shape, Mesh):
        mesh = load_mesh(shape.file, folder)
        return surface_area(mesh.vertices, mesh.faces) * shape.scale**2
    hull = soft_surface(shape, folder, max(sides(extents(shape, IDENTITY, folder))) / HULL_EDGES)
    return surface_area(hull.vertices, hull.faces)


def solid_volume(shape: Any, folder: Path) -> float:
    """Return the volume [m3] of a deformable shape; for a compound, that of the union of its parts."""
    return float(union(shape, folder).volume()) if isinstance(shape, Compound) else volume(shape, folder)


def _build(vertices: "np.ndarray", faces: "np.ndarray", uvs: "np.ndarray | None" = None, seams: int = 0) -> SoftMesh:
    import numpy as np

    # Rounded as in a file, since tetgen reacts to every digit; read-only, since the arrays are shared.
    found = [
        np.ascontiguousarray(np.round(np.asarray(vertices, np.float64), DIGITS) + 0.0),
        np.ascontiguousarray(faces, np.int32),
    ]
    if uvs is not None:
        found.append(np.ascontiguousarray(uvs, np.float64))
    for array in found:
        array.flags.writeable = False
    return SoftMesh(found[0], found[1], found[2] if uvs is not None else None, seams)


def _area(shape: Any, folder: Path) -> float:
    """Return roughly the area [m2] of a surface, from which the number of triangles follows."""
    if isinstance(shape, Sheet):
        return shape.size[0] * shape.size[1]
    if isinstance(shape, Disc | Sleeve):
        return shape.area
    if isinstance(shape, Revolve):
        return revolved_area(shape)
    if isinstance(shape, Ribbon):
        return _ribbon_length(shape) * shape.width
    if isinstance(shape, Box):
        x, y, z = shape.size
        return 2 * (x * y + y * z + z * x)
    if isinstance(shape, Ellipsoid):
        # Knud Thomsen's formula, within 1.1 %.
        a, b, c = (r**1.6075 for r in shape.radii)
        return 4 * math.pi * ((a * b + b * c + c * a) / 3) ** (1 / 1.6075)
    if isinstance(shape, FlatShape):
        from text2sim.compiler.shapes.glyphs import whole

        flat = whole(shape, folder)
        return 2 * flat.area + flat.length * shape.depth
    parts, _ = profile(shape)
    total = 0.0
    for part in parts:
        points = part.points(part.length / 64) if isinstance(part, Arc) else part
        total += sum(math.pi * (a[0] + b[0]) * math.dist(a, b) for a, b in zip(points, points[1:], strict=False))
    return total


def _longest(shape: Any, folder: Path) -> float:
    """Return the longest side [m] of a shape."""
    if isinstance(shape, Sheet):
        return max(shape.size)
    if isinstance(shape, Ribbon):
        return _ribbon_length(shape)
    return max(sides(extents(shape, IDENTITY, folder)))


def _sheet(sheet: Sheet, edge: float) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Return a grid, row by row along x; its diagonals alternate, so that it bends the same both ways."""
    import numpy as np

    nx, ny = (max(1, round(side / edge)) for side in sheet.size)
    u, v = np.meshgrid(np.linspace(0.0, 1.0, nx + 1), np.linspace(0.0, 1.0, ny + 1))
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    curve = points_along_sheet(sheet, nx)
    vertices = np.array([line.at(point) for line in sheet_lines(sheet, ny) for point in curve])
    return vertices, grid_faces(nx, ny), uvs


def _disc(disc: Disc, edge: float) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Return rings of triangles, and their places in a picture that is as wide as the disc."""
    across = profile_of([((disc.radius, 0.0), (disc.hole, 0.0))], edge)
    vertices, faces = turned(across, edge, closed=False)
    return vertices, faces, vertices[:, :2] / (2 * disc.radius) + 0.5


def _ribbon(ribbon: Ribbon, edge: float) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Return a grid, row by row along the ribbon; at the seam of a band, u falls from almost 1 to 0."""
    import numpy as np

    from text2sim.compiler.shapes.ribbons import ribbon_corners

    nx, ny = max(1, round(_ribbon_length(ribbon) / edge)), max(1, round(ribbon.width / edge))
    if ribbon.closed:
        nx = max(4, nx + nx % 2)  # so that diagonals alternate across the seam
    left, right = ribbon_corners(ribbon, nx)
    u, v = np.meshgrid(np.linspace(0.0, 1.0, nx + 1), np.linspace(0.0, 1.0, ny + 1))
    vertices, faces, uvs = left + v[..., None] * (right - left), grid_faces(nx, ny), np.stack([u, v], axis=2)
    if ribbon.closed:
        vertices, uvs = vertices[:, :-1], uvs[:, :-1]
        faces = faces // (nx + 1) * nx + faces % (nx + 1) % nx
    return vertices.reshape(-1, 3), faces, uvs.reshape(-1, 2)


def _ribbon_length(ribbon: Ribbon) -> float:
    from text2sim.compiler.shapes.ribbons import ribbon_length

    return ribbon_length(ribbon)


def grid_faces(nx: int, ny: int) -> "np.ndarray":
    """Return the triangles of a grid of nx by ny cells whose vertices lie row by row along its first axis."""
    import numpy as np

    i, j = (index.ravel() for index in np.meshgrid(np.arange(nx), np.arange(ny)))
    a = j * (nx + 1) + i
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return np.stack([first, second], axis=1).reshape(-1, 3)


def _box(size: tuple[float, float, float], edge: float) -> "tuple[np.ndarray, np.ndarray]":
    """Return six grids that share their edges."""
    import numpy as np

    counts = [max(1, round(side / edge)) for side in size]
    places, faces, total = [], [], 0
    for axis in range(3):
        p, q = (axis + 1) % 3, (axis + 2) % 3
        b, a = np.meshgrid(np.arange(counts[q] + 1), np.arange(counts[p] + 1), indexing="ij")
        for side in (0, counts[axis]):
            place = np.empty((a.size, 3), np.int64)
            place[:, axis], place[:, p], place[:, q] = side, a.ravel(), b.ravel()
            net = grid_faces(counts[p], counts[q])
            faces.append((net if side else net[:, ::-1]) + total)
            places.append(place)
            total += len(place)
    unique, index = np.unique(np.concatenate(places), axis=0, return_inverse=True)
    vertices = (unique / np.array(counts) - 0.5) * np.array(size)
    return vertices, index.reshape(-1)[np.concatenate(faces)]


def _ellipsoid(shape: Ellipsoid, edge: float) -> "tuple[np.ndarray, np.ndarray]":
    """Return rings about the longest axis, scaled to ellipses."""
    axis = max(range(3), key=lambda k: shape.radii[k])
    a, b = shape.radii[(axis + 1) % 3], shape.radii[(axis + 2) % 3]
    mean = (a + b) / 2
    # Perimeter of an ellipse over that of the circle with the mean radius, by Ramanujan's second formula.
    h = ((a - b) / (a + b)) ** 2
    stretch = 1 + 3 * h / (10 + math.sqrt(4 - 3 * h))
    arc = Arc(0.0, 0.0, mean, shape.radii[axis], -math.pi / 2, math.pi / 2)
    vertices, faces = turned(arc.points(edge), edge, closed=False, stretch=stretch)
    vertices = vertices * (a / mean, b / mean, 1.0)
    return vertices[:, [(k - axis - 1) % 3 for k in range(3)]], faces


def write_obj(mesh: SoftMesh, quat: Quaternion = IDENTITY) -> bytes:
    """Return a surface as an .obj file, turned by `quat`."""
    import numpy as np

    vertices = mesh.vertices if quat == IDENTITY else mesh.vertices @ np.array(quat_to_rows(quat)).T
    faces = mesh.faces + 1
    found = [_rows("v %.10g %.10g %.10g\n", np.round(vertices, DIGITS) + 0.0)]
    if mesh.uvs is None:
        found.append(_rows("f %d %d %d\n", faces))
    else:
        found += [_rows("vt %.6g %.6g\n", mesh.uvs + 0.0), _rows("f %d/%d %d/%d %d/%d\n", np.repeat(faces, 2, axis=1))]
    return "".join(found).encode()


def _rows(form: str, table: "np.ndarray") -> str:
    """Return a line for each row, formatted all at once in half the time."""
    return (form * len(table)) % tuple(table.ravel().tolist())


def tet_options(edge: float) -> dict[str, Any]:
    """Return the options of a morph that let the engine cut a body into tetrahedra with edges of about `edge` [m].

    The surface already has such edges (`soft_surface`) and stays as it is, which gives better tetrahedra than when
    tetgen divides it too. Most are smaller than the limit; their mean edge is 0.8 to 1 of the wanted one.
    """
    return {"maxvolume": float(f"{REGULAR_VOLUME * edge**3:.4g}"), "nobisect": True}
