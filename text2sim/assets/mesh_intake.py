"""Reader of untrusted mesh files: with limits, without access to other folders, z up."""

import logging
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np

from text2sim.assets.foreign_files import NamedFiles, check_disguise, check_gltf, named_errors
from text2sim.assets.safe_write import MAX_FILE, read_file
from text2sim.assets.surface import Paint, TriangleMesh, welded
from text2sim.spec_schema.errors import AssetError

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb", ".gltf")
COMPANION_SUFFIXES = (".mtl", ".png", ".jpg", ".jpeg", ".bmp", ".tga")
"""Suffixes of files that an .obj file may refer to."""
MAX_BESIDE = 32
MAX_TRIANGLES = 2_000_000
MAX_COORDINATE = 1e9
MAX_PICTURE = 2048
"""Side of a picture [pixels]; larger ones are scaled down."""
MAX_PIXELS = 100_000_000
UPRIGHT = {"x": ((2, -1), (1, 1), (0, 1)), "y": ((0, 1), (2, -1), (1, 1)), "z": ((0, 1), (1, 1), (2, 1))}
"""Coordinate and sign that become x, y and z, by the axis that points up."""

Up = Literal["x", "y", "z"]


def read_surface(path: Path, up: Up | None = None) -> tuple[TriangleMesh, tuple[str, ...]]:
    """Return a mesh file as a surface, and notes on files that were left out.

    Args:
        path: The file, in any folder.
        up: Its axis that points up; the one of its format if None.

    Raises:
        AssetError: if it cannot be used.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise AssetError(f"`{path.name}` must end in one of {', '.join(SUFFIXES)}")
    content = read_file(path)
    try:
        check_disguise(content)
        if suffix in (".glb", ".gltf"):
            check_gltf(content, suffix, beside=False)
        neighbours = _Beside(path.parent)
        scene = _load(content, suffix, neighbours)
        surface = _surface(scene)
    except AssetError as error:
        raise AssetError(f"`{path.name}` {error}") from None
    axes = UPRIGHT[up or ("y" if suffix in (".glb", ".gltf") else "z")]
    turned = np.stack([surface.vertices[:, axis] * sign for axis, sign in axes], axis=1)
    notes = tuple(f"left out: `{name}`, which is not beside the file" for name in neighbours.refused)
    return welded(replace(surface, vertices=turned), 0.0), notes


def _load(content: bytes, suffix: str, neighbours: "_Beside") -> Any:
    import trimesh

    if not trimesh.util.log.handlers:
        trimesh.util.log.addHandler(logging.NullHandler())  # exceptions report the problems of a file
    with named_errors():
        return trimesh.load(
            BytesIO(content), file_type=suffix[1:], process=False, force="scene",
            resolver=neighbours if suffix == ".obj" else None,
        )  # fmt: skip


def _surface(scene: Any) -> TriangleMesh:
    """All meshes of a scene as one surface, in the coordinates of the file."""
    import trimesh

    meshes = {n: g for n, g in scene.geometry.items() if isinstance(g, trimesh.Trimesh) and len(g.faces)}
    placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
    shown = [(matrix, meshes[name]) for matrix, name in placed if name in meshes]
    count = sum(len(mesh.faces) for _, mesh in shown)
    if not count:
        raise AssetError("has no triangles")
    if count > MAX_TRIANGLES:
        raise AssetError(f"has too many triangles ({count:,}; at most {MAX_TRIANGLES:,})")
    known: dict[int, int] = {}
    paints: list[Paint] = []
    columns: dict[str, list[np.ndarray]] = {name: [] for name in ("vertices", "faces", "part", "uv", "rgba")}
    painted, coloured, first = False, False, 0
    for matrix, mesh in shown:
        vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise AssetError("has triangles that refer to missing vertices")
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces
        key = id(mesh.visual)
        if key not in known:
            known[key] = len(paints)
            paints.append(_paint(mesh))
        uv, rgba = _corners(mesh, faces)
        painted, coloured = painted or uv is not None, coloured or rgba is not None
        columns["vertices"].append(vertices)
        columns["faces"].append(faces + first)
        columns["part"].append(np.full(len(faces), known[key]))
        columns["uv"].append(np.zeros((len(faces), 3, 2)) if uv is None else uv)
        columns["rgba"].append(np.full((len(faces), 3, 4), 255, np.uint8) if rgba is None else rgba)
        first += len(vertices)
    rows = {name: np.concatenate(parts) for name, parts in columns.items()}
    if not np.isfinite(rows["vertices"]).all():
        raise AssetError("has vertices that are not finite")
    if np.abs(rows["vertices"]).max() > MAX_COORDINATE:
        raise AssetError(f"has coordinates above {MAX_COORDINATE:g}")
    found = TriangleMesh(rows["vertices"], rows["faces"], rows["part"], tuple(paints), rows["uv"], rows["rgba"])
    return replace(found, uv=found.uv if painted else None, rgba=found.rgba if coloured else None)


def _corners(mesh: Any, faces: np.ndarray) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Texture coordinates and colours of the corners, None where the file has none."""
    visual = mesh.visual
    uv = getattr(visual, "uv", None)
    if uv is not None and np.shape(uv) == (len(mesh.vertices), 2) and np.isfinite(uv).all():
        return np.asarray(uv, float)[faces], None
    if getattr(visual, "kind", None) in ("vertex", "face"):
        return None, np.asarray(visual.vertex_colors, np.uint8)[faces]
    return None, None


def _paint(mesh: Any) -> Paint:
    material = getattr(mesh.visual, "material", None)
    if material is None:
        return Paint((1.0, 1.0, 1.0, 1.0) if getattr(mesh.visual, "kind", None) else Paint.rgba)
    try:
        material = material.to_pbr() if hasattr(material, "to_pbr") else material
        picture = small_picture(material.baseColorTexture)
        factor = material.baseColorFactor
        rgba = (1.0,) * 4 if factor is None else tuple(float(c) / 255 for c in np.asarray(factor, np.uint8))
        metallic, roughness = material.metallicFactor, material.roughnessFactor
    except Exception as error:  # readers of untrusted pictures can raise anything
        raise AssetError(f"has a material that cannot be read ({type(error).__name__}: {str(error)[:100]})") from None
    shine = (0.0 if metallic is None else float(metallic), 0.9 if roughness is None else float(roughness))
    return Paint((rgba[0], rgba[1], rgba[2], rgba[3]), picture, *shine)


def small_picture(picture: Any) -> Any:
    """Return a picture, scaled down if it is large; None for None.

    Raises:
        AssetError: if it has too many pixels to be read.
    """
    if picture is None:
        return None
    if picture.width * picture.height > MAX_PIXELS:
        raise AssetError(f"has a picture of {picture.width} x {picture.height} pixels")
    picture = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
    picture.thumbnail((MAX_PICTURE, MAX_PICTURE))
    return picture


class _Beside(NamedFiles):
    """Reads materials and pictures of an .obj file from its folder or below."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.refused: list[str] = []
        self._read = 0

    def __getitem__(self, name: str) -> bytes:
        name = str(name).strip().replace("\\", "/")
        path = self.folder / name
        inside = path.resolve().is_relative_to(self.folder) and path.resolve() == Path(str(path.absolute()))
        self._read += 1
        if not inside or path.suffix.lower() not in COMPANION_SUFFIXES or not path.is_file() or self._read > MAX_BESIDE:
            self.refused.append("".join(c for c in name if c.isprintable())[:80])
            raise KeyError(name)
        with path.open("rb") as stream:
            return stream.read(MAX_FILE)
