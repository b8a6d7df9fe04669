"""Mesh files of a case: read, checked and limited."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np


SUFFIXES = (".obj", ".stl", ".ply", ".glb", ".gltf")
MAX_BYTES = 64 * 1024 * 1024
MAX_FACES = 200_000
"""What MuJoCo reads of a mesh."""
MAX_SMOOTHED = 60_000
SMOOTH = 0.6
"""Edges [rad] below this angle are drawn round, where the file has no texture."""
MAX_PICTURE = 2048


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A triangle mesh in its file's unit, with its convex hull."""

    vertices: "np.ndarray"
    """(n, 3) float"""
    faces: "np.ndarray"
    """(m, 3) int"""
    hull_vertices: "np.ndarray"
    """(k, 3) float"""
    hull_faces: "np.ndarray"
    """(l, 3) int, counterclockwise from outside"""
    volume: float
    """Enclosed volume, or that of the hull where the surface is not closed."""
    closed: bool
    """Whether the surface encloses a volume."""
    solid: tuple["np.ndarray", "np.ndarray"]
    """Vertices and faces with every corner once, as contact and mass need them."""


@dataclass(frozen=True, eq=False)
class MeshPaint:
    """A part of a mesh file as it is drawn, in the file's unit."""

    vertices: "np.ndarray"
    """(n, 3) float"""
    faces: "np.ndarray"
    """(m, 3) int"""
    normals: "np.ndarray"
    """(n, 3) float, unit length"""
    uvs: "np.ndarray | None"
    """(n, 2) float"""
    picture: bytes | None
    """A .png that `uvs` refer to."""
    rgba: tuple[float, float, float, float] | None
    """Colour, each channel in 0..1; None where the file says none."""


def mesh_path(file: str, folder: Path) -> Path:
    """Return the path of a mesh of a case.

    Raises:
        AssetError: if it leaves the case's folder, does not exist, is too large or of a kind that is not
        read.
    """
    root = folder.resolve()
    path = (root / file).resolve()
    if not path.is_relative_to(root):
        raise AssetError(f"mesh file `{file}` is outside the case's folder")
    if path.suffix.lower() not in SUFFIXES:
        raise AssetError(f"mesh file `{file}` must end in one of {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise AssetError(f"mesh file `{file}` does not exist in the case's folder")
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise AssetError(
            f"mesh file `{file}` is too large ({size / 2**20:.0f} MiB; at most {MAX_BYTES // 2**20} MiB)"
        )
    return path


def load_mesh(file: str, folder: Path) -> MeshFile:
    """Read a mesh file of a case; all its pieces become one mesh.

    Args:
        file: Path inside the case's folder.
        folder: The case's folder.

    Raises:
        AssetError: if it cannot be used.
    """
    path = mesh_path(file, folder)
    stat = path.stat()
    try:
        return _read(path, folder.resolve(), stat.st_mtime_ns, stat.st_size)
    except AssetError as error:
        raise AssetError(f"mesh file `{file}` {error}") from None


def load_paint(file: str, folder: Path) -> list[MeshPaint]:
    """Read what a mesh file of a case looks like, a part for each of its materials.

    Raises:
        AssetError: if it cannot be used.
    """
    path = mesh_path(file, folder)
    stat = path.stat()
    try:
        return _read_paint(path, folder.resolve(), stat.st_mtime_ns, stat.st_size)
    except AssetError as error:
        raise AssetError(f"mesh file `{file}` {error}") from None


def _open(path: Path, root: Path, **options: Any) -> Any:
    import trimesh

    try:
        with path.open("rb") as stream:
            return trimesh.load(
                stream, file_type=path.suffix[1:].lower(), process=False, resolver=_Resolver(path.parent, root), **options
            )  # fmt: skip
    except AssetError:
        raise
    except Exception as error:  # readers of foreign files fail in every way there is
        raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error


def _upright(vectors: "np.ndarray", path: Path) -> "np.ndarray":
    """Turn glTF's y, which points up, to z."""
    import numpy as np

    if path.suffix.lower() not in (".glb", ".gltf"):
        return vectors
    return np.stack([vectors[:, 0], -vectors[:, 2], vectors[:, 1]], axis=1)


@lru_cache(maxsize=64)
def _read_paint(path: Path, root: Path, _mtime: int, _size: int) -> list[MeshPaint]:
    import numpy as np
    import trimesh

    scene = _open(path, root, force="scene")
    parts = []
    for mesh in scene.dump():
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            continue
        uvs, picture, rgba = _material(mesh)
        if uvs is None and len(mesh.faces) <= MAX_SMOOTHED:
            mesh = trimesh.graph.smooth_shade(mesh, angle=SMOOTH)
        normals = np.asarray(mesh.vertex_normals, float)
        vertices, normals = _upright(np.asarray(mesh.vertices, float), path), _upright(normals, path)
        parts.append(MeshPaint(vertices, np.asarray(mesh.faces, np.int64), normals, uvs, picture, rgba))
    return parts


def _material(mesh: Any) -> "tuple[np.ndarray | None, bytes | None, tuple[float, float, float, float] | None]":
    """Return texture coordinates, picture and colour of a mesh, as far as it has them."""
    import numpy as np

    visual = mesh.visual
    if not getattr(visual, "defined", False):
        return None, None, None
    if visual.kind != "texture":
        rgba = np.asarray(visual.main_color, float) / 255
        return None, None, _rgba(rgba)
    material = visual.material
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    uvs = None if visual.uv is None else np.asarray(visual.uv, float)
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
        picture.thumbnail((MAX_PICTURE, MAX_PICTURE))
        stream = BytesIO()
        picture.save(stream, "PNG")
    except Exception as error:  # damaged pictures fail in every way there is
        raise AssetError(f"has a picture that cannot be read ({type(error).__name__}: {str(error)[:80]})") from error
    return stream.getvalue()


@lru_cache(maxsize=64)
def _read(path: Path, root: Path, _mtime: int, _size: int) -> MeshFile:
    import numpy as np
    import trimesh

    loaded = _open(path, root, force="mesh", skip_materials=True)
    try:
        vertices, faces = _upright(np.asarray(loaded.vertices, float), path), np.asarray(loaded.faces, np.int64)
    except Exception as error:  # a point cloud, a path or a scene has neither
        raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error
    if len(faces) == 0 or not np.isfinite(vertices).all():
        raise AssetError("has no triangles" if len(faces) == 0 else "has vertices that are not finite")
    if len(faces) > MAX_FACES:
        raise AssetError(f"has too many triangles ({len(faces)}; at most {MAX_FACES})")
    mesh = trimesh.Trimesh(vertices, faces, process=True)
    try:
        hull = mesh.convex_hull
    except Exception as error:
        raise AssetError("is flat: a body needs thickness") from error
    closed = bool(mesh.is_volume)
    volume = float(mesh.volume if closed else hull.volume)
    return MeshFile(vertices, faces, np.asarray(hull.vertices), np.asarray(hull.faces), volume, closed,
                    (np.asarray(mesh.vertices), np.asarray(mesh.faces)))


class _Resolver(Mapping[str, bytes]):
    """Gives a mesh file the files that it refers to, as long as they are in the case's folder."""

    def __init__(self, parent: Path, root: Path) -> None:
        self.parent, self.root = parent, root

    def __getitem__(self, name: str) -> bytes:
        path = (self.parent / name).resolve()
        if not path.is_relative_to(self.root) or not path.is_file() or path.stat().st_size > MAX_BYTES:
            raise AssetError(f"refers to `{name}`, which is not in the case's folder")
        return path.read_bytes()

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return True
