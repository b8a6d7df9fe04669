"""Shape and looks of a case's mesh files: read once for both, and remembered by content in the user's cache."""

from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.confined import call_confined
from text2sim.compiler.shapes.meshfile import MeshFile, errors_about, mesh_path
from text2sim.compiler.shapes.meshpaint import read_mesh_and_paint
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.errors import AssetError

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


def load_paint(file: str, folder: Path) -> list[VisualMesh]:
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
def _read_mesh_and_paint(key: Key) -> tuple[MeshFile, list[VisualMesh] | str]:
    return call_confined(read_mesh_and_paint, *key[:2])


@lru_cache(maxsize=64)
def _mesh(key: Key) -> MeshFile:
    path = key[0]
    if path.suffix.lower() not in SINGLE_FILE_SUFFIXES:
        return _read_mesh_and_paint(key)[0]
    return MeshFile(**cached_answer((b"mesh", *_content(path)), lambda: vars(_read_mesh_and_paint(key)[0])))


@lru_cache(maxsize=64)
def _paint(key: Key) -> list[VisualMesh]:
    path = key[0]
    content = path.read_bytes()
    if path.suffix.lower() not in SINGLE_FILE_SUFFIXES or any(word in content for word in REFERRING_WORDS):
        return _read_paints(key)

    found = cached_answer((b"paint", *_content(path)), lambda: [vars(part) for part in _read_paints(key)])
    return [VisualMesh(**part | {"rgba": part["rgba"] and tuple(part["rgba"])}) for part in found]


def _read_paints(key: Key) -> list[VisualMesh]:
    found = _read_mesh_and_paint(key)[1]
    if isinstance(found, str):
        raise AssetError(found)
    return found


def _content(path: Path) -> tuple[bytes, bytes]:
    return path.suffix.lower().encode(), sha256(path.read_bytes()).digest()
