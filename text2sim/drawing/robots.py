"""Visual shapes of bodies from URDF files."""

from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from math import degrees
from pathlib import PurePosixPath
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from text2sim.assets.mechanism import Mechanism
from text2sim.compiler.shapes.meshpaint import visuals_of
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Vec, quat_from_euler_deg
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.compiler.trees.tree import TreeGeom, TreeVisual

Rgba = tuple[float, float, float, float]
LinkVisuals = tuple[tuple[TreeGeom, ...], tuple[TreeVisual, ...]]


def urdf_visuals(mechanism: Mechanism) -> dict[str, LinkVisuals]:
    """Return visual primitives and meshes by link, for links whose files can be read.

    Args:
        mechanism: A body from a URDF file.
    """
    root = ET.fromstring(mechanism.text)
    palette = {name: color for node in root.iter("material") if (name := node.get("name")) and (color := _rgba(node))}
    files = dict(mechanism.files)
    found: dict[str, LinkVisuals] = {}
    for link in root.iter("link"):
        try:
            parts = [part for node in link.findall("visual") for part in _parts(node, palette, files)]
        except Exception:  # readers of untrusted files can raise anything; collision shapes are drawn instead
            continue
        geoms = tuple(part for part in parts if isinstance(part, TreeGeom))
        visuals = tuple(part for part in parts if isinstance(part, TreeVisual))
        if parts:
            found[link.get("name", "")] = geoms, visuals
    return found


def _parts(node: ET.Element, palette: dict[str, Rgba], files: dict[str, bytes]) -> Iterator[TreeGeom | TreeVisual]:
    origin, shape, material = node.find("origin"), node.find("geometry/*"), node.find("material")
    pos = _numbers(origin, "xyz", (0.0, 0.0, 0.0))
    x, y, z = (degrees(angle) for angle in _numbers(origin, "rpy", (0.0, 0.0, 0.0)))
    quat = quat_from_euler_deg((x, y, z))
    color = None if material is None else _rgba(material) or palette.get(material.get("name", ""))
    if shape is None:
        return
    if shape.tag == "mesh":
        scale = np.array(_numbers(shape, "scale", (1.0, 1.0, 1.0)))
        name = shape.get("filename", "")
        for mesh in _meshes(name, files, scale):
            placed = mesh.at(pos, quat, None)
            own = placed.rgba if placed.rgba is not None or placed.picture is not None else color
            yield TreeVisual(placed, own)
        return
    sizes: dict[str, tuple[float, ...]] = {
        "box": _numbers(shape, "size", (1.0, 1.0, 1.0)),
        "sphere": (float(shape.get("radius", 1.0)),),
        "cylinder": (float(shape.get("radius", 1.0)), float(shape.get("length", 1.0))),
    }
    yield TreeGeom(Piece(shape.tag, pos, quat, sizes[shape.tag]), 0.0, 0.0, color, touches=False)


def _meshes(name: str, files: dict[str, bytes], scale: np.ndarray) -> list[VisualMesh]:
    import trimesh

    suffix = PurePosixPath(name).suffix.lower()
    scene: Any = trimesh.load(
        BytesIO(files[name]), file_type=suffix[1:], force="scene", process=False, resolver=_Files(files)
    )  # type: ignore[arg-type]
    return [replace(mesh, vertices=mesh.vertices * scale) for mesh in visuals_of(scene, PurePosixPath(name))]


class _Files(dict[str, bytes]):
    """Resolver of the files that a mesh file refers to."""

    def get(self, name: str, default: Any = None) -> Any:
        return super().get(PurePosixPath(name).name, default)


def _numbers(node: ET.Element | None, key: str, default: Vec) -> Vec:
    text = None if node is None else node.get(key)
    if text is None:
        return default
    x, y, z = (float(word) for word in text.split())
    return (x, y, z)


def _rgba(material: ET.Element) -> Rgba | None:
    node = material.find("color")
    text = None if node is None else node.get("rgba")
    if text is None:
        return None
    red, green, blue, alpha = (min(max(float(word), 0.0), 1.0) for word in text.split())
    return (red, green, blue, alpha)
