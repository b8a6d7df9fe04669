"""Meshes of Mitsuba, built in memory."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.finishes import COLOR, SHADE, finish_of
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.tone import linear

Array = NDArray[np.floating]

DARKEST, DARKEST_METAL = 0.025, 0.2
"""Smallest linear brightness of a surface: black paint reflects some 3 % of the light, dull dark steel 20 %. With less,
a surface is a hole in the picture without visible shape."""


def mesh_shape(
    name: str,
    bsdf: Any,
    vertices: Array,
    faces: NDArray[np.integer],
    normals: Array,
    *,
    colors: Array | None = None,
    shades: Array | None = None,
    uvs: Array | None = None,
) -> Any:
    """Return a mesh of Mitsuba with its material.

    Args:
        name: Name for messages.
        bsdf: Its material.
        vertices: Positions [m], shape (n, 3).
        faces: Vertex indices, shape (f, 3).
        normals: Vertex normals, shape (n, 3).
        colors: Linear colour at each vertex, shape (n, 3); a face has that of its first vertex.
        shades: Colour at each vertex that the texture blends with, shape (n, 3).
        uvs: Texture coordinates, shape (n, 2).
    """
    mi = mitsuba()
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    mesh = mi.Mesh(
        name, len(vertices), len(faces), has_vertex_normals=True, has_vertex_texcoords=uvs is not None, props=properties
    )
    for attribute, values in ((COLOR, colors), (SHADE, shades)):
        if values is not None:
            mesh.add_attribute(attribute, 3, _flat(values[faces[:, 0]]))
    parameters = mi.traverse(mesh)
    parameters["faces"] = np.ascontiguousarray(faces, np.uint32).ravel()
    parameters["vertex_positions"] = _flat(vertices)
    parameters["vertex_normals"] = _flat(normals)
    if uvs is not None:
        parameters["vertex_texcoords"] = _flat(uvs)
    parameters.update()
    return mesh


def shaded(color: tuple[float, float, float], finish: str) -> tuple[Array, Array]:
    """Return the linear colour of a finish, and the shade that its texture blends with it, each of shape (3,)."""
    light = linear(np.asarray(color, float))
    light = light + max(0.0, (DARKEST_METAL if finish_of(finish).metallic else DARKEST) - float(light.max()))
    return light, np.clip(light * finish_of(finish).shade, 0.0, 1.0)


def filtering(color: Array, opacity: float) -> Array:
    """Return the fraction of the light, shape (3,), that a clear surface of a linear colour lets through."""
    return 1 - opacity * (1 - color) if opacity < 1 else np.ones(3)


def _flat(values: Array) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32).ravel()
