"""Mesh files of a case: read, checked and limited."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from text2sim.assets.engine_files import asset_folder
from text2sim.assets.foreign_files import NamedFiles, check_disguise, check_gltf, check_obj, named_errors
from text2sim.compiler.shapes.hulls import hull_of
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np


SUFFIXES = (".obj", ".stl", ".ply", ".glb", ".gltf")
MAX_BYTES = 64 * 1024 * 1024
MAX_FACES = 200_000
"""Most triangles of a mesh that MuJoCo reads."""
MAX_COORDINATE = 1e9
"""In the file's unit: a kilometre in micrometres. With larger ones, areas and volumes lose precision."""
MISSING_VERTICES = "has triangles with vertices that are not in the file"


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A triangle mesh in its file's unit, with its convex hull."""

    vertices: "np.ndarray"
    """(n, 3) float, every corner once"""
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
    flat: bool = False
    """Whether it lies in a plane, as a cloth may; its hull is a little thicker."""

    def obj(self) -> str:
        """Return the surface as the text of an .obj file."""
        return obj_text(self.vertices, self.faces)


def obj_text(vertices: "np.ndarray", faces: "np.ndarray") -> str:
    """Return a surface of vertices (n, 3) [m] and triangles (m, 3) as the text of an .obj file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in (vertices + 0.0).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join(lines) + "\n"


def mesh_path(file: str, folder: Path) -> tuple[Path, Path]:
    """Return the path of a mesh of a case, and the folder that it and all that it refers to must lie in.

    Raises:
        AssetError: if it leaves that folder, does not exist, is too large or of a kind that is not read.
    """
    return case_path(file, folder, "mesh", SUFFIXES, MAX_BYTES)


def case_path(file: str, folder: Path, what: str, suffixes: tuple[str, ...], max_bytes: int) -> tuple[Path, Path]:
    """Return the path of a file that a case names, and the folder that it and all that it refers to must lie in.

    Args:
        file: Path inside the case's folder, or `genesis:` and a path inside the engine's assets.
        folder: The case's folder.
        what: What the file is, for messages.
        suffixes: What it may end in.
        max_bytes: How many bytes it may have.

    Raises:
        AssetError: if it leaves that folder, does not exist, is too large or of a kind that is not read.
    """
    with errors_about(f"{what} file `{file[:80]}`"):
        source = asset_folder(folder, file)
    root = source.root
    try:
        path = (root / source.file).resolve()
        path.is_file()
    except (OSError, RuntimeError, ValueError) as error:  # the name is too long, or links form a circle
        raise AssetError(f"{what} file `{file[:80]}` cannot be read ({type(error).__name__})") from None
    if not path.is_relative_to(root):
        raise AssetError(f"{what} file `{file}` is outside {source.name}")
    if path.suffix.lower() not in suffixes:
        raise AssetError(f"{what} file `{file}` must end in one of {', '.join(suffixes)}")
    if not path.is_file():
        raise AssetError(f"{what} file `{file}` does not exist in {source.name}")
    size = path.stat().st_size
    if size > max_bytes:
        raise AssetError(
            f"{what} file `{file}` is too large ({size / 2**20:.0f} MiB; at most {max_bytes // 2**20} MiB)"
        )
    return path, root


@contextmanager
def errors_about(file: str) -> Iterator[None]:
    """Put the name of a file before what is wrong with it.

    Raises:
        AssetError: in place of one without that name.
    """
    try:
        yield
    except AssetError as error:
        raise AssetError(f"{file} {error}") from None


def open_mesh(path: Path, root: Path, **options: Any) -> Any:
    """Read a file with trimesh; everything that it refers to must lie in the folder `root`.

    Args:
        path: The file.
        root: Folder that everything it refers to must lie in.
        **options: Options of `trimesh.load`.

    Raises:
        AssetError: if it cannot be read.
    """
    import trimesh

    if not trimesh.util.log.handlers:
        trimesh.util.log.addHandler(logging.NullHandler())  # errors say what is wrong with a file
    suffix = path.suffix.lower()
    with named_errors(), path.open("rb") as stream:
        check_disguise(stream.read(1024))
        stream.seek(0)
        if suffix in (".glb", ".gltf"):
            check_gltf(stream.read(), suffix, beside=True)
            stream.seek(0)
        if suffix == ".obj":
            check_obj(stream.read())
            stream.seek(0)
        try:
            return trimesh.load(
                stream, file_type=suffix[1:], process=False, resolver=_Resolver(path.parent, root), **options
            )
        except IndexError:
            raise AssetError(MISSING_VERTICES) from None


def turn_upright(vectors: "np.ndarray", path: PurePath) -> "np.ndarray":
    """Return vectors of a file, (n, 3), with z up: in glTF y points up."""
    import numpy as np

    if path.suffix.lower() not in (".glb", ".gltf"):
        return vectors
    return np.stack([vectors[:, 0], -vectors[:, 2], vectors[:, 1]], axis=1)


def read_mesh(path: Path, root: Path) -> MeshFile:
    """Read a mesh without limits of time and memory; see `casemesh`.

    Raises:
        AssetError: if it cannot be used.
    """
    if path.suffix.lower() == ".obj" and (faces := path.read_bytes().count(b"\nf")) > MAX_FACES:
        raise AssetError(f"has too many triangles ({faces}; at most {MAX_FACES})")
    loaded = open_mesh(path, root, force="mesh", skip_materials=True)
    with named_errors():
        return _check_mesh(loaded, path)


def _check_mesh(loaded: Any, path: Path) -> MeshFile:
    import numpy as np
    import trimesh

    # A point cloud, a path or a scene has neither.
    vertices, faces = turn_upright(np.asarray(loaded.vertices, float), path), np.asarray(loaded.faces, np.int64)
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise AssetError(MISSING_VERTICES)
    if len(faces) == 0 or not np.isfinite(vertices).all():
        raise AssetError("has no triangles" if len(faces) == 0 else "has vertices that are not finite")
    if len(faces) > MAX_FACES:
        raise AssetError(f"has too many triangles ({len(faces)}; at most {MAX_FACES})")
    if (largest := float(np.abs(vertices).max())) > MAX_COORDINATE:
        raise AssetError(f"has a coordinate of {largest:.3g}; at most {MAX_COORDINATE:g} is possible")
    mesh = trimesh.Trimesh(vertices, faces, process=True)
    hull, flat = hull_of(np.asarray(mesh.vertices))
    closed = not flat and bool(mesh.is_volume)
    volume = float(mesh.volume if closed else hull.volume)
    arrays = [np.asarray(array) for array in (mesh.vertices, mesh.faces, hull.vertices, hull.faces)]
    return MeshFile(arrays[0], arrays[1], arrays[2], arrays[3], volume, closed, flat)


class _Resolver(NamedFiles):
    """Gives a mesh file the files that it refers to, as long as they are in the case's folder."""

    def __init__(self, parent: Path, root: Path) -> None:
        self.parent, self.root = parent, root

    def __getitem__(self, name: str) -> bytes:
        path = (self.parent / name).resolve()
        if not path.is_relative_to(self.root) or not path.is_file() or path.stat().st_size > MAX_BYTES:
            raise AssetError(f"refers to `{name}`, which is not in the case's folder")
        return path.read_bytes()
