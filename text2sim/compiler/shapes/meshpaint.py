"""Colours and pictures of a case's mesh files."""

from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from text2sim.assets.foreign_files import named_errors
from text2sim.compiler.shapes.meshfile import MeshFile, open_mesh, read_mesh, turn_upright
from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

MAX_SMOOTHED_FACES = 60_000
MAX_SMOOTH_PATCHES = 10_000
"""Smooth patches of a surface. With more, it is so jagged that nothing in it is round."""
MAX_SMOOTH_ANGLE = 0.6
"""Edges [rad] below this angle are drawn round, where the file has no texture."""
MAX_PICTURE_SIDE = 2048


def read_mesh_and_paint(path: Path, root: Path) -> tuple[MeshFile, list[VisualMesh] | str]:
    """Read shape and looks of a file without limits of time and memory; for looks that cannot be read, say why.

    Raises:
        AssetError: if the shape cannot be used.
    """
    mesh = read_mesh(path, root)
    try:
        return mesh, read_paint(path, root)
    except AssetError as error:
        return mesh, str(error)


def read_paint(path: Path, root: Path) -> list[VisualMesh]:
    """Read the looks of a file, in its unit, without limits of time and memory.

    Raises:
        AssetError: if it cannot be used.
    """
    try:
        scene = open_mesh(path, root, force="scene")
    except AssetError:
        # The shape can be used without a material that is missing or outside the case's folder.
        scene = open_mesh(path, root, force="scene", skip_materials=True)
    with named_errors():
        return visuals_of(scene, path)


def visuals_of(scene: Any, path: PurePath) -> list[VisualMesh]:
    """Return the meshes of a scene of trimesh as they are drawn, z up, in the unit of the file that it comes from."""
    import numpy as np
    import trimesh

    parts = []
    for mesh in scene.dump():
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            continue
        uvs, picture, rgba = _material_of(mesh)
        if uvs is None and len(mesh.faces) <= MAX_SMOOTHED_FACES and _count_min_patches(mesh) <= MAX_SMOOTH_PATCHES:
            mesh = trimesh.graph.smooth_shade(mesh, angle=MAX_SMOOTH_ANGLE)
        normals = np.asarray(mesh.vertex_normals, float)
        vertices, normals = turn_upright(np.asarray(mesh.vertices, float), path), turn_upright(normals, path)
        faces = np.asarray(mesh.faces, np.int64)
        parts.append(VisualMesh(vertices, faces, normals, uvs=uvs, picture=picture, rgba=rgba))
    return parts


def _count_min_patches(mesh: Any) -> int:
    """Return the least number of smooth patches of a surface: its triangles, less the smooth edges that join them."""
    return len(mesh.faces) - int((mesh.face_adjacency_angles < MAX_SMOOTH_ANGLE).sum())


def _material_of(
    mesh: Any,
) -> "tuple[np.ndarray | None, bytes | None, tuple[float, float, float, float] | None]":
    """Return texture coordinates, picture and colour of a mesh of trimesh, as far as it has them."""
    import numpy as np
    from trimesh.visual.material import empty_material

    visual = mesh.visual
    if not getattr(visual, "defined", False):
        return None, None, None
    if visual.kind != "texture":
        rgba = np.asarray(visual.main_color, float) / 255
        return None, None, _rgba(rgba)
    material = visual.material
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    uvs = None if visual.uv is None else np.asarray(visual.uv, float)
    if hash(material) == hash(empty_material()):
        return None, None, None
    if picture is None or uvs is None or len(uvs) != len(mesh.vertices) or not np.isfinite(uvs).all():
        color = getattr(material, "main_color", None)
        return None, None, None if color is None else _rgba(np.asarray(color, float) / 255)
    return uvs, _png(picture), None


def _rgba(values: Any) -> tuple[float, float, float, float]:
    red, green, blue, alpha = (round(float(value), 4) for value in values)
    return (red, green, blue, alpha)


def _png(picture: Any) -> bytes:
    """Return a picture as a .png in three channels, small enough for a film."""
    try:
        picture = picture.convert("RGB")
        picture.thumbnail((MAX_PICTURE_SIDE, MAX_PICTURE_SIDE))
        return picture_bytes(picture, "PNG")
    except Exception as error:  # damaged pictures fail in every way there is
        raise AssetError(f"has a picture that cannot be read ({type(error).__name__}: {str(error)[:80]})") from error
