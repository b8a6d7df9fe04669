"""Surfaces of sheets for drawing, with a mesh that is fine enough for the picture on them."""

from pathlib import Path
from typing import Any

import numpy as np

from text2sim.compiler.shapes.pictures import PREVIEW_SIDE, thumbnail
from text2sim.compiler.shapes.sagging import is_bent
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.models.sheets import Disc, Ribbon, Sheet

SHEET_CELLS = 48
"""Cells along the longer side of a sheet that is bent, or has a picture, because each triangle has one colour."""
RIBBON_CELLS = 2
"""Cells across a ribbon."""


def cloth_surfaces(shape: Any, folder: Path) -> list[VisualMesh] | None:
    """Return the surface of a disc, a ribbon, or a sheet with its picture if it has one; None for other shapes.

    Raises:
        AssetError: if the picture cannot be used.
    """
    if isinstance(shape, Disc):
        net = soft_surface(shape, folder, 2 * shape.radius / SHEET_CELLS)
        return [VisualMesh(net.vertices, net.faces, np.tile([0.0, 0.0, 1.0], (len(net.vertices), 1)))]
    if isinstance(shape, Ribbon):
        picture, bent, edge = None, True, shape.width / RIBBON_CELLS
    elif isinstance(shape, Sheet):
        picture = None if shape.texture is None else thumbnail(shape.texture, folder, PREVIEW_SIDE)
        bent = is_bent(shape)
        edge = max(shape.size) / (SHEET_CELLS if picture or bent else 1)
    else:
        return None
    net = soft_surface(shape, folder, edge)
    normals = np.tile([0.0, 0.0, 1.0], (len(net.vertices), 1))
    if bent:
        from trimesh import Trimesh  # slow to import

        normals = Trimesh(net.vertices, net.faces, process=False).vertex_normals
    return [VisualMesh(net.vertices, net.faces, normals, uvs=net.uvs, picture=picture)]
