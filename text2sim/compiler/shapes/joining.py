"""Shapes of several parts as one closed surface, for what deforms: the union of a compound, the mesh of a sculpt."""

from collections import OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from text2sim.compiler.shapes.geometry import extents
from text2sim.compiler.shapes.remesh import divided, evened
from text2sim.compiler.shapes.rotation import IDENTITY, quat_of, quat_to_rows
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound, Mesh

if TYPE_CHECKING:
    from manifold3d import Manifold

FINE = 40
"""Edges along the longest side of a part, when its union with the others is made."""
_MEMORY = 32
_KNOWN: "OrderedDict[Any, Manifold]" = OrderedDict()


def joined_surface(
    shape: Sculpt | Compound, folder: Path, edge: float, *, coarsen: bool, most: int
) -> "tuple[np.ndarray, np.ndarray]":
    """Return vertices [m] and faces of the surface, in triangles whose edges are about `edge` [m] long.

    Args:
        shape: The shape.
        folder: The case's folder.
        edge: Wanted length [m].
        coarsen: Whether triangles that are smaller are melted together.
        most: How many triangles there may be.

    Raises:
        AssetError: if parts of a compound do not touch, or there would be too many triangles.
    """
    from text2sim.compiler.shapes.sculpting import sculpted
    from text2sim.compiler.shapes.softmesh import refuse_many

    if isinstance(shape, Sculpt):
        made = sculpted(shape)
        vertices, faces = made.vertices, made.faces
    else:
        mesh = union(shape, folder).to_mesh64()
        vertices, faces = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, np.int64)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    refuse_many(float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2), edge)
    if coarsen:
        vertices, faces = evened(vertices, faces, edge)
    vertices, faces, _ = divided(vertices, faces, edge)
    if len(faces) > most:
        raise AssetError(f"makes {len(faces):,} triangles; at most {most:,} are possible: take a larger `cell`")
    return vertices, faces.astype(np.int32)


def union(shape: Compound, folder: Path) -> "Manifold":
    """Return all solid parts of a compound as one: what several of them hold counts once.

    Raises:
        AssetError: if a part is no closed solid, or parts do not touch.
    """
    from manifold3d import Manifold, Mesh64, OpType

    from text2sim.compiler.shapes.geometry import key_of
    from text2sim.compiler.shapes.softmesh import soft_surface

    key = key_of(shape, folder)
    if key in _KNOWN:
        _KNOWN.move_to_end(key)
        return _KNOWN[key]
    solids = []
    for name, part in shape.solids.items():
        low, high = extents(part.shape, IDENTITY, folder)
        size = max(b - a for a, b in zip(low, high, strict=True))
        made = soft_surface(part.shape, folder, size / FINE, coarsen=not isinstance(part.shape, Mesh))
        turn = np.array(quat_to_rows(quat_of(part.pose))).T
        solid = Manifold(Mesh64(made.vertices @ turn + np.array(part.pose.pos), made.faces.astype(np.uint64)))
        if solid.is_empty():
            raise AssetError(f"part `{name}` is no closed solid, and cannot be part of a body that deforms")
        solids.append(solid)
    whole = Manifold.batch_boolean(solids, OpType.Add)
    apart = [one for one in whole.decompose() if one.volume() > 0]
    if len(apart) > 1:
        raise AssetError(
            f"is in {len(apart)} pieces: parts of a body that deforms must overlap, as they are joined into one volume"
        )
    if len(_KNOWN) >= _MEMORY:
        _KNOWN.popitem(last=False)
    _KNOWN[key] = whole
    return whole
