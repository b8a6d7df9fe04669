"""Writer of mesh files: .glb with colours and pictures, or .obj with the shape only."""

from typing import Any

import numpy as np

from text2sim.assets.surface import Paint, TriangleMesh
from text2sim.spec_schema.errors import AssetError

SUFFIXES = (".glb", ".obj")
CREASE = 0.6
"""Angle [rad] of an edge below which it is shaded smoothly."""


def suffix_for(surface: TriangleMesh) -> str:
    """Return the suffix of the format that loses nothing of a surface."""
    plain = surface.uv is None and surface.rgba is None and all(paint == Paint() for paint in surface.paints)
    return ".obj" if plain else ".glb"


def mesh_bytes(surface: TriangleMesh, suffix: str) -> bytes:
    """Return a surface as the content of a file.

    Args:
        surface: The surface, z up.
        suffix: `.glb`, whose format has y up, or `.obj`, which is written with z up.

    Raises:
        AssetError: if the suffix is another.
    """
    if suffix == ".obj":
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in (surface.vertices + 0.0).tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (surface.faces + 1).tolist()]
        return ("\n".join(lines) + "\n").encode()
    if suffix != ".glb":
        raise AssetError(f"`{suffix}` is not supported; use one of {', '.join(SUFFIXES)}")
    import trimesh

    normals = corner_normals(surface)
    scene = trimesh.Scene()
    for number, paint in enumerate(surface.paints):
        own = surface.part == number
        if own.any():
            scene.add_geometry(_mesh(surface.keep(own), normals[own], paint), geom_name=f"part_{number}")
    content = scene.export(file_type="glb", include_normals=True)
    assert isinstance(content, bytes)
    return content


def corner_normals(surface: TriangleMesh) -> np.ndarray:
    """Return the normal of each corner, (m, 3, 3): the mean over its triangles across edges below `CREASE`."""
    from scipy.sparse import coo_matrix

    weighted = surface.area_vectors
    length = np.linalg.norm(weighted, axis=1, keepdims=True)
    flat = weighted / np.maximum(length, 1e-300)
    count = len(surface.faces)
    touches = coo_matrix(
        (np.ones(3 * count), (np.repeat(np.arange(count), 3), surface.faces.reshape(-1))),
        (count, len(surface.vertices)),
    ).tocsc()
    sums = np.repeat(flat[:, None], 3, axis=1) * length[:, None]
    start, owner = touches.indptr, touches.indices
    first, size = start[surface.faces], (start[1:] - start[:-1])[surface.faces]
    for step in range(min(int(size.max()), 64)):  # a corner of more triangles is the tip of a fan
        rows, columns = np.nonzero(size > step)
        other = owner[first[rows, columns] + step]
        like = ((flat[rows] * flat[other]).sum(1) > np.cos(CREASE)) & (other != rows)
        np.add.at(sums, (rows[like], columns[like]), weighted[other[like]])
    return sums / np.maximum(np.linalg.norm(sums, axis=2, keepdims=True), 1e-300)


def _mesh(surface: TriangleMesh, normals: np.ndarray, paint: Paint) -> Any:
    """A part as a mesh of trimesh, with a vertex for every position, texture coordinate and normal."""
    import trimesh
    from trimesh.visual import ColorVisuals, TextureVisuals
    from trimesh.visual.material import PBRMaterial

    columns = [surface.faces.reshape(-1, 1).astype(float), np.round(normals.reshape(-1, 3), 4) + 0.0]
    if surface.uv is not None:
        columns.append(np.round(surface.uv.reshape(-1, 2), 7))
    if surface.rgba is not None:
        columns.append(surface.rgba.reshape(-1, 4).astype(float))
    rows, index = np.unique(np.concatenate(columns, axis=1), axis=0, return_inverse=True)
    vertices = to_gltf_axes(surface.vertices[rows[:, 0].astype(np.int64)])
    mesh = trimesh.Trimesh(vertices, index.reshape(-1, 3), vertex_normals=to_gltf_axes(rows[:, 1:4]), process=False)
    material = PBRMaterial(
        baseColorFactor=np.round(np.array(paint.rgba) * 255).astype(np.uint8), baseColorTexture=paint.picture,
        metallicFactor=paint.metallic, roughnessFactor=paint.roughness, doubleSided=False,
    )  # fmt: skip
    if surface.rgba is not None and paint.picture is None:
        mesh.visual = ColorVisuals(mesh, vertex_colors=rows[:, -4:].astype(np.uint8))
    else:
        uv = rows[:, 4:6] if surface.uv is not None else np.zeros((len(rows), 2))
        mesh.visual = TextureVisuals(uv=uv, material=material)
    return mesh


def to_gltf_axes(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (n, 3) in the frame of glTF, with y up."""
    return np.stack([vectors[:, 0], vectors[:, 2], -vectors[:, 1]], axis=1)
