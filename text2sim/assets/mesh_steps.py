"""Steps of mesh repair, each on the shape only; texture coordinates and colours follow."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from text2sim.assets.surface import TriangleMesh, welded

Array = np.ndarray
MAX_VOLUME_CHANGE = 0.02
"""Part of the volume that may change where edges of more than two triangles are repaired."""


def without_duplicates(surface: TriangleMesh) -> TriangleMesh:
    """Return a surface without degenerate and duplicate triangles."""
    faces = np.sort(surface.faces, axis=1)
    real = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    _, first = np.unique(faces, axis=0, return_index=True)
    once = np.zeros(len(faces), bool)
    once[first] = True
    return surface.keep(real & once)


def without_debris(surface: TriangleMesh, max_share: float) -> tuple[TriangleMesh, int]:
    """Return a surface without specks, and their number.

    Args:
        surface: The surface.
        max_share: Diagonal of a piece, as a part of that of the largest piece, below which it is a speck.
    """
    length = surface.diagonals_of_components()
    small = length < max_share * length.max()
    return (surface.keep(~small[surface.components[1]]), int(small.sum())) if small.any() else (surface, 0)


def orient(surface: TriangleMesh) -> tuple[TriangleMesh, int]:
    """Return a surface whose triangles face outwards, and how many were flipped.

    First, neighbours are made coherent. Then, pieces with negative volume are flipped, unless a larger piece encloses
    them: those are walls of cavities.
    """
    flipped = np.zeros(len(surface.faces), bool)
    if not surface.coherent:
        flipped = _triangles_to_flip(surface)
        surface = surface.flip(flipped)
    volumes = surface.volumes()
    low, high = surface.bounds_of_components()
    _, own = surface.components
    inward = [
        number for number in np.flatnonzero(volumes < 0) if not _is_enclosed(low, high, np.abs(volumes), int(number))
    ]
    turned = np.isin(own, inward)
    return surface.flip(turned), int((flipped ^ turned).sum())


def _is_enclosed(low: Array, high: Array, volumes: Array, number: int) -> bool:
    around = (low <= low[number]).all(axis=1) & (high >= high[number]).all(axis=1) & (volumes > volumes[number])
    return bool(around.any())


def _triangles_to_flip(surface: TriangleMesh) -> Array:
    """The triangles to flip such that neighbours are coherent, as far as possible, as a mask."""
    import pymeshlab
    import trimesh

    try:
        found = _apply_filter(surface, lambda scene: scene.meshing_re_orient_faces_coherently())
        faces = found.faces
    except pymeshlab.PyMeshLabException:  # type: ignore[attr-defined]  # edges of more than two triangles
        mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
        trimesh.repair.fix_winding(mesh)
        faces = np.asarray(mesh.faces, np.int64)
    turned = [np.roll(surface.faces[:, ::-1], shift, axis=1) for shift in range(3)]
    return np.any([(faces == corners).all(axis=1) for corners in turned], axis=0)


def fill_holes(surface: TriangleMesh, max_edges: int, max_share: float = 1.0) -> tuple[TriangleMesh, int]:
    """Return a surface whose holes are closed, and the number of new triangles.

    Args:
        surface: A coherent surface.
        max_edges: Number of edges above which holes stay open.
        max_share: Diagonal, as a part of that of the surface, above which holes stay open, as intended openings.
    """
    import pymeshlab

    try:
        found = _apply_filter(
            surface, lambda scene: scene.meshing_close_holes(maxholesize=max_edges, selfintersection=True)
        )
    except pymeshlab.PyMeshLabException:  # type: ignore[attr-defined]  # edges of more than two triangles
        return surface, 0
    faces, old = found.faces, len(surface.faces)
    if len(faces) <= old or len(found.vertices) != len(surface.vertices):
        return surface, 0
    added = faces[old:]
    added = added[_lid_sizes(surface, added) <= max_share * surface.diagonal]
    if not len(added):
        return surface, 0
    # A new triangle takes colours and part from the corners that it shares.
    source = surface.corner_of_vertices()[added]
    parts = surface.part[source[:, 0] // 3]
    return (
        replace(
            surface,
            faces=np.concatenate([surface.faces, added]),
            part=np.concatenate([surface.part, parts]),
            uv=_with_corners(surface.uv, source),
            rgba=_with_corners(surface.rgba, source),
        ),
        len(added),
    )


def _lid_sizes(surface: TriangleMesh, faces: Array) -> Array:
    """The diagonal [m] of the lid that each of some new triangles belongs to."""
    lids = TriangleMesh(surface.vertices, faces, np.zeros(len(faces), np.int64), surface.paints)
    return lids.diagonals_of_components()[lids.components[1]]


def _with_corners(values: Array | None, source: Array) -> Array | None:
    return None if values is None else np.concatenate([values, values.reshape(-1, values.shape[-1])[source]])


def repair_non_manifold(surface: TriangleMesh, max_edges: int) -> TriangleMesh:
    """Return a surface without edges of more than two triangles, if it can be closed there; else the same surface."""
    import pymeshlab

    before = np.abs(surface.volumes()).sum()
    try:
        found = _apply_filter(surface, lambda scene: scene.meshing_repair_non_manifold_edges(method=0))
    except pymeshlab.PyMeshLabException:  # type: ignore[attr-defined]
        return surface
    kept = found.tags
    if not 0 < len(kept) < len(surface.faces):
        return surface
    better, _ = orient(without_debris(surface.keep(kept), 1e-3)[0])
    better, _ = orient(fill_holes(better, max_edges)[0])
    changed = abs(np.abs(better.volumes()).sum() - before)
    return better if better.watertight and changed <= MAX_VOLUME_CHANGE * before else surface


def decimate(surface: TriangleMesh, max_triangles: int) -> TriangleMesh:
    """Return a surface with at most this many triangles, if possible, and nearly the same shape."""
    fewer = surface
    for careful in (True, False):
        if len(fewer.faces) > max_triangles:
            step = _decimate_unpainted if fewer.uv is None else _decimate_painted
            fewer = without_duplicates(welded(step(fewer, max_triangles, careful), 0.0))
    if fewer is surface:
        return surface
    if surface.watertight and not fewer.watertight:
        fewer, _ = orient(fewer)
        fewer, _ = fill_holes(fewer, 100)
    return fewer


def _decimate_unpainted(surface: TriangleMesh, max_triangles: int, careful: bool) -> TriangleMesh:
    from scipy.spatial import KDTree

    vertices, faces, part = _apply_filter(
        surface,
        lambda scene: scene.meshing_decimation_quadric_edge_collapse(
            targetfacenum=max_triangles, preserveboundary=careful, preservenormal=careful, planarquadric=True,
            preservetopology=careful and surface.watertight,
        ),
        surface.part,
    )  # fmt: skip
    rgba = None
    if surface.rgba is not None:
        used = np.unique(surface.faces)
        _, near = KDTree(surface.vertices[used]).query(vertices)
        rgba = surface.rgba.reshape(-1, 4)[surface.corner_of_vertices()[used[near]]][faces]
    return replace(surface, vertices=vertices, faces=faces, part=part, rgba=rgba)


def _decimate_painted(surface: TriangleMesh, max_triangles: int, careful: bool) -> TriangleMesh:
    """A surface with fewer triangles and the same picture on it.

    The library only supports textures of files that it reads. Shifted texture coordinates keep the parts apart.
    """
    import pymeshlab
    from PIL import Image

    assert surface.uv is not None
    span = max(float(np.ptp(surface.uv[..., 0])), 1e-3)
    shift = 2.0 * span * surface.part - surface.uv[..., 0].min()
    places = surface.uv.reshape(-1, 2).copy()
    places[:, 0] += np.repeat(shift, 3)
    with tempfile.TemporaryDirectory(prefix="text2sim-") as name:
        folder = Path(name)
        Image.new("RGB", (2, 2)).save(folder / "picture.png")
        (folder / "mesh.mtl").write_text("newmtl paint\nmap_Kd picture.png\n", "ascii")
        order = np.arange(1, len(places) + 1).reshape(-1, 3)
        rows = np.stack([surface.faces + 1, order], axis=2).reshape(-1, 6)
        with (folder / "mesh.obj").open("w", encoding="ascii") as stream:
            stream.write("mtllib mesh.mtl\nusemtl paint\n")
            np.savetxt(stream, surface.vertices, fmt="v %.9g %.9g %.9g")
            np.savetxt(stream, places, fmt="vt %.9g %.9g")
            np.savetxt(stream, rows, fmt="f %d/%d %d/%d %d/%d")
        scene = pymeshlab.MeshSet(verbose=False)  # type: ignore[attr-defined]
        scene.load_new_mesh(str(folder / "mesh.obj"))
        scene.meshing_decimation_quadric_edge_collapse_with_texture(
            targetfacenum=max_triangles, preserveboundary=careful, preservenormal=careful, planarquadric=True
        )
        found = scene.current_mesh()
        faces, vertices = np.array(found.face_matrix(), np.int64), np.array(found.vertex_matrix(), float)
        uv = np.array(found.wedge_tex_coord_matrix(), float).reshape(-1, 3, 2)
    part = np.clip(np.floor(uv[..., 0].mean(1) / (2.0 * span) + 0.25), 0, len(surface.paints) - 1).astype(np.int64)
    uv[..., 0] -= (2.0 * span * part - surface.uv[..., 0].min())[:, None]
    rgba = None if surface.rgba is None else np.full((len(faces), 3, 4), 255, np.uint8)
    return replace(surface, vertices=vertices, faces=faces, part=part, uv=uv, rgba=rgba)


def wrap(surface: TriangleMesh, fineness: float) -> TriangleMesh:
    """Return a closed skin around any surface, without pictures.

    Args:
        surface: The surface.
        fineness: Smallest gap that the skin enters, as a part of the diagonal.
    """
    from pymeshlab import PercentageValue  # type: ignore[attr-defined]

    alpha, offset = PercentageValue(100 * fineness), PercentageValue(5 * fineness)
    found = _apply_filter(surface, lambda scene: scene.generate_alpha_wrap(alpha=alpha, offset=offset))
    faces = found.faces
    paint = replace(surface.paints[int(np.bincount(surface.part).argmax())], picture=None)
    return TriangleMesh(found.vertices, faces, np.zeros(len(faces), np.int64), (paint,))


class _FilterResult(NamedTuple):
    """The result of a filter, copied, because the library's arrays are freed with its scene."""

    vertices: Array
    faces: Array
    tags: Array


def _apply_filter(surface: TriangleMesh, work: Callable[[Any], object], scalar: Array | None = None) -> _FilterResult:
    """Apply a filter of the library to a shape; the tags of triangles are their indices, or `scalar`."""
    import pymeshlab

    tags = np.arange(len(surface.faces)) if scalar is None else scalar
    scene = pymeshlab.MeshSet(verbose=False)  # type: ignore[attr-defined]
    scene.add_mesh(
        pymeshlab.Mesh(  # type: ignore[attr-defined]
            vertex_matrix=surface.vertices,
            face_matrix=surface.faces.astype(np.int32),
            f_scalar_array=tags.astype(float),
        )
    )
    work(scene)
    mesh = scene.current_mesh()
    return _FilterResult(
        np.array(mesh.vertex_matrix(), float),
        np.array(mesh.face_matrix(), np.int64),
        np.round(np.array(mesh.face_scalar_array(), float)).astype(np.int64)
        if mesh.has_face_scalar()
        else np.zeros(mesh.face_number(), np.int64),
    )
