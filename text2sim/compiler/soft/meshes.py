"""Meshes of deformable bodies as files of the program."""

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, quat_to_rows
from text2sim.spec_schema.errors import AssetError

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, eq=False)
class SoftSurface:
    """Triangles of a body in its own frame, welded: no vertex stands twice in one place."""

    vertices: "np.ndarray"
    """(n, 3) float [m]"""
    faces: "np.ndarray"
    """(m, 3) int, counterclockwise from outside; of a sheet, from above"""
    uvs: "np.ndarray | None" = None
    """(n, 2) float"""


def soft_surface(shape: Any, folder: Path, edge: float) -> SoftSurface:
    """Return the surface of a shape in triangles whose edges are about `edge` [m] long.

    Raises:
        AssetError: if the shape has no such surface.
    """
    import numpy as np
    import trimesh

    if shape.kind == "sheet":
        nx, ny = (max(1, round(side / edge)) for side in shape.size)
        u, v = np.meshgrid(np.linspace(0, 1, nx + 1), np.linspace(0, 1, ny + 1), indexing="ij")
        uvs = np.stack([u.ravel(), v.ravel()], axis=1)
        flat = (uvs - 0.5) * shape.size
        a = (np.arange(nx)[:, None] * (ny + 1) + np.arange(ny)).ravel()
        b, c, d = a + ny + 1, a + ny + 2, a + 1
        faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        return SoftSurface(np.column_stack([flat, np.zeros(len(flat))]), faces, uvs)
    if shape.kind == "box":
        mesh = trimesh.creation.box(shape.size)
    elif shape.kind == "sphere":
        mesh = trimesh.creation.icosphere(subdivisions=1, radius=shape.radius)
        while mesh.edges_unique_length.mean() > edge:
            mesh = trimesh.creation.icosphere(
                subdivisions=int(np.log(len(mesh.faces) / 5) / np.log(4)), radius=shape.radius
            )
    elif shape.kind == "cylinder":
        mesh = trimesh.creation.cylinder(shape.radius, shape.height)
    else:
        raise AssetError(f"no surface for {shape.kind} yet")
    if shape.kind != "sphere":
        vertices, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, edge * 1.2)
        mesh = trimesh.Trimesh(vertices, faces, process=True)
    return SoftSurface(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def write_obj(surface: SoftSurface, quat: Quaternion = IDENTITY) -> bytes:
    """Return a surface as an .obj file, turned by `quat`."""
    import numpy as np

    vertices = surface.vertices if quat == IDENTITY else surface.vertices @ np.array(quat_to_rows(quat)).T
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in (np.round(vertices, 9) + 0.0).tolist()]
    if surface.uvs is None:
        lines += [f"f {a} {b} {c}" for a, b, c in (surface.faces + 1).tolist()]
    else:
        lines += [f"vt {u:.6g} {v:.6g}" for u, v in (surface.uvs + 0.0).tolist()]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (surface.faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


class MeshFiles:
    """Collects meshes by their path in the program's folder; the same content is kept once.

    Args:
        folder: The case's folder.
        files: Files of the program, to which these are added.
    """

    def __init__(self, folder: Path, files: dict[str, bytes]) -> None:
        self.folder, self.files = folder, files
        self._known: dict[Any, tuple[Any, SoftSurface]] = {}

    def surface(self, shape: Any, edge: float) -> SoftSurface:
        """Return the surface of a shape; copies that share a shape share it.

        Raises:
            AssetError: if the shape has no such surface.
        """
        key = (id(shape), edge)
        if key not in self._known:
            self._known[key] = shape, soft_surface(shape, self.folder, edge)
        return self._known[key][1]

    def write(self, body: str, shape: Any, edge: float, quat: Quaternion = IDENTITY) -> str:
        """Put the mesh of a body into the program, turned by `quat`, and return its path.

        Raises:
            AssetError: if the shape has no such surface.
        """
        content = write_obj(self.surface(shape, edge), quat)
        path = f"models/{body}.obj"
        if self.files.get(path, content) != content:
            path = f"models/{body}_{sha256(content).hexdigest()[:8]}.obj"
        self.files[path] = content
        return path

    def picture(self, file: str) -> str:
        """Put a picture of the case into the program and return its path.

        Raises:
            AssetError: if there is no such file.
        """
        source = self.folder / file
        try:
            content = source.read_bytes()
        except OSError as error:
            raise AssetError(f"the picture {file} cannot be read: {error.strerror}") from error
        path = f"models/{source.stem}_{sha256(content).hexdigest()[:8]}{source.suffix.lower()}"
        self.files[path] = content
        return path
