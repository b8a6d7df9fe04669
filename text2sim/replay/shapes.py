"""Rigid bodies for the page: meshes with limited detail, and their poses."""

from pathlib import Path
from typing import Any

import numpy as np

from text2sim.exchange.materials import ExportMaterial
from text2sim.exchange.scenery import Scenery
from text2sim.rendering.meshes import RenderMesh
from text2sim.rendering.tone import bytes_of, encoded
from text2sim.replay.packing import Blob
from text2sim.replay.pictures import Pictures
from text2sim.templates.shading import Shell

MOST_TRIANGLES = 100_000
"""Largest total number of triangles; above, all meshes are reduced in proportion."""
MIN_REDUCED_TRIANGLES = 400
"""Number of triangles up to which a mesh is not reduced."""


def pack_shapes(scenery: Scenery, blob: Blob, pictures: Pictures, rows: dict[int, int], notes: list[str]) -> dict:
    """Pack the meshes of all links, and their uses.

    Args:
        scenery: The run.
        blob: Collects the arrays.
        pictures: Collects the pictures.
        rows: Track number of each moving link.
        notes: Collects notes about omissions.

    Returns:
        `meshes`, and `pieces` with their bodies.
    """
    meshes = {piece.mesh for link in scenery.links for piece in link.pieces}
    total = sum(len(scenery.mesh(path).faces) for path in meshes)
    keep = min(1.0, MOST_TRIANGLES / max(total, 1))
    if keep < 1:
        notes.append(f"meshes have {keep:.0%} of their triangles")
    numbers: dict[Path, int] = {}
    meshes, pieces = [], []
    pos, quat = (values[0] for values in scenery.poses)
    for link in scenery.links:
        for piece in link.pieces:
            if piece.mesh not in numbers:
                numbers[piece.mesh] = len(meshes)
                meshes.append(_packed(_reduced(scenery.mesh(piece.mesh), keep), blob))
            row: dict[str, Any] = {"mesh": numbers[piece.mesh], "body": link.body}
            row |= _pose_data([*piece.pos], [*piece.quat])
            if link.row in rows:
                row["track"] = rows[link.row]
            else:
                row["base"] = _pose_data(pos[link.row].tolist(), quat[link.row].tolist())
            pieces.append(row | surface_of(piece.material, pictures))
    return {"meshes": meshes, "pieces": pieces}


def surface_of(material: ExportMaterial, pictures: Pictures) -> dict[str, Any]:
    """Return the look of a surface: colour in sRGB, roughness, metallic, picture."""
    color = bytes_of(encoded(np.asarray(material.color, float))).tolist()
    row = {"color": [*color, round(255 * material.opacity)], "rough": round(material.roughness, 3)}
    if material.metallic:
        row["metal"] = material.metallic
    if material.picture is not None and (number := pictures.add(material.picture)) is not None:
        row["picture"] = number
    return row


def _pose_data(pos: list[float], quat: list[float]) -> dict[str, list[float]]:
    return {"pos": [round(x, 7) for x in pos], "quat": [round(x, 7) for x in quat]}


def _reduced(mesh: RenderMesh, keep: float) -> RenderMesh:
    if keep >= 1 or len(mesh.faces) <= MIN_REDUCED_TRIANGLES:
        return mesh
    import fast_simplification

    # Vertices at sharp edges are duplicates, and must be merged, or the mesh would tear there.
    places, own = np.unique(np.round(mesh.vertices, 7), axis=0, return_inverse=True)
    faces = own.ravel()[mesh.faces]
    away = 1 - max(keep, MIN_REDUCED_TRIANGLES / len(faces))
    fewer = fast_simplification.simplify(np.asarray(places, np.float64), faces.astype(np.int32), away)
    vertices, left = np.asarray(fewer[0], float), np.asarray(fewer[1])
    shell = Shell(vertices, left)
    return RenderMesh(vertices[shell.sources], shell.faces, shell.normals(vertices))


def _packed(mesh: RenderMesh, blob: Blob) -> dict[str, Any]:
    row = {
        "points": blob.add_points(mesh.vertices),
        "normals": blob.add(np.rint(mesh.normals * 127).astype(np.int8)),
        "faces": pack_faces(mesh.faces, blob),
    }
    if mesh.uvs is not None:
        row["uvs"] = blob.add(mesh.uvs.astype(np.float32))
    return row


def pack_faces(faces: Any, blob: Blob) -> dict[str, Any]:
    """Pack vertex indices of triangles."""
    return blob.add(faces.astype(np.uint16 if not faces.size or faces.max() < 65535 else np.uint32))
