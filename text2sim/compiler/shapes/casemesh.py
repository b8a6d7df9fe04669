"""Shape and looks of a case's mesh files: read once for both, and remembered by content in the user's cache."""

from base64 import b64decode, b64encode
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.answer_cache import are_valid_rows, cached_answer, packed, unpacked
from text2sim.assets.confined import call_confined
from text2sim.compiler.shapes.meshfile import MeshFile, errors_about, mesh_path
from text2sim.compiler.shapes.meshpaint import MeshPaint, read_mesh_and_paint
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

SINGLE_FILE_SUFFIXES = (".obj", ".stl", ".ply")
"""Files whose shape needs no others."""
REFERRING_WORDS = (b"mtllib", b"TextureFile")
"""Words in such a file that name others, for its looks."""
Key = tuple[Path, Path, int, int]
"""File, folder that it may refer to, time of its last change, and size."""


def load_mesh(file: str, folder: Path) -> MeshFile:
    """Read a mesh file of a case; all its pieces become one mesh.

    Args:
        file: Path inside the case's folder, or `genesis:` and a path inside the engine's assets.
        folder: The case's folder.

    Raises:
        AssetError: if it cannot be used.
    """
    key = _key(file, folder)
    with errors_about(f"mesh file `{file}`"):
        return _mesh(key)


def load_paint(file: str, folder: Path) -> list[MeshPaint]:
    """Read what a mesh file of a case looks like, a part for each of its materials; see `load_mesh`.

    Raises:
        AssetError: if it cannot be used.
    """
    key = _key(file, folder)
    with errors_about(f"mesh file `{file}`"):
        return _paint(key)


def _key(file: str, folder: Path) -> Key:
    path, root = mesh_path(file, folder)
    stat = path.stat()
    return path, root, stat.st_mtime_ns, stat.st_size


@lru_cache(maxsize=4)
def _read_mesh_and_paint(key: Key) -> tuple[MeshFile, list[MeshPaint] | str]:
    return call_confined(read_mesh_and_paint, *key[:2])


@lru_cache(maxsize=64)
def _mesh(key: Key) -> MeshFile:
    path = key[0]
    if path.suffix.lower() not in SINGLE_FILE_SUFFIXES:
        return _read_mesh_and_paint(key)[0]
    members = {
        "vertices": str,
        "faces": str,
        "corners": str,
        "sides": str,
        "volume": float,
        "closed": bool,
        "flat": bool,
    }

    def ask() -> dict[str, Any]:
        mesh = _read_mesh_and_paint(key)[0]
        texts = (packed(array) for array in (mesh.vertices, mesh.faces, mesh.hull_vertices, mesh.hull_faces))
        return dict(zip(members, (*texts, mesh.volume, mesh.closed, mesh.flat), strict=True))

    found = cached_answer((b"mesh", *_content(path)), members, ask)
    vertices, faces = _net(found["vertices"], found["faces"])
    corners, sides = _net(found["corners"], found["sides"])
    if vertices is None or faces is None or corners is None or sides is None:
        return _read_mesh_and_paint(key)[0]
    return MeshFile(vertices, faces, corners, sides, found["volume"], found["closed"], found["flat"])


@lru_cache(maxsize=64)
def _paint(key: Key) -> list[MeshPaint]:
    path = key[0]
    content = path.read_bytes()
    if path.suffix.lower() not in SINGLE_FILE_SUFFIXES or any(word in content for word in REFERRING_WORDS):
        return _read_paints(key)

    def ask() -> dict[str, Any]:
        return {"parts": [
            [packed(part.vertices), packed(part.faces), packed(part.normals),
             None if part.uvs is None else packed(part.uvs),
             None if part.picture is None else b64encode(part.picture).decode(), part.rgba]
            for part in _read_paints(key)
        ]}  # fmt: skip

    found = [_part(row) for row in cached_answer((b"paint", *_content(path)), {"parts": list}, ask)["parts"]]
    parts = [part for part in found if part is not None]
    return parts if len(parts) == len(found) else _read_paints(key)


def _read_paints(key: Key) -> list[MeshPaint]:
    found = _read_mesh_and_paint(key)[1]
    if isinstance(found, str):
        raise AssetError(found)
    return found


def _part(row: Any) -> MeshPaint | None:
    """Return a part from the cache, or None if it is damaged."""
    try:
        points, net, slopes, places, drawn, rgba = row
        vertices, faces = _net(points, net)
        normals, uvs = unpacked(slopes, "f8", 3), None if places is None else unpacked(places, "f8", 2)
        picture = None if drawn is None else b64decode(drawn, validate=True)
        if rgba is not None:
            red, green, blue, alpha = (float(x) for x in rgba)
            rgba = (red, green, blue, alpha)
    except (TypeError, ValueError):
        return None
    if vertices is None or faces is None or normals is None or len(normals) != len(vertices):
        return None
    if places is not None and (uvs is None or len(uvs) != len(vertices)):
        return None
    return MeshPaint(vertices, faces, normals, uvs, picture, rgba)


def _net(points: str, net: str) -> "tuple[np.ndarray | None, np.ndarray | None]":
    """Return points and triangles from the cache; None for triangles that do not fit the points."""
    vertices, faces = unpacked(points, "f8", 3), unpacked(net, "i8", 3)
    return vertices, faces if vertices is not None and are_valid_rows(faces, vertices) else None


def _content(path: Path) -> tuple[bytes, bytes]:
    return path.suffix.lower().encode(), sha256(path.read_bytes()).digest()
