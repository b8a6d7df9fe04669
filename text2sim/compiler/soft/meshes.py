"""Meshes and pictures of deformable bodies as files of the program."""

from hashlib import sha256
from pathlib import Path
from typing import Any

from text2sim.compiler.digests import LOOKS_SUFFIX
from text2sim.compiler.files import Files
from text2sim.compiler.shapes.part_looks import part_looks
from text2sim.compiler.shapes.pictures import PREVIEW_SIDE, picture_path, thumbnail
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion
from text2sim.compiler.shapes.softmesh import SoftMesh, soft_surface, write_obj


class MeshFiles:
    """Collects meshes by their path in the program's folder; equal content is kept once.

    Args:
        folder: The case's folder.
        files: Files of the program, to which these are added.
    """

    def __init__(self, folder: Path, files: Files) -> None:
        self.folder, self.files = folder, files
        self._texts: dict[tuple[SoftMesh, Quaternion], bytes] = {}
        self._parted: dict[str, tuple[Any, float, bool]] = {}

    def write(self, body: str, shape: Any, edge: float, quat: Quaternion = IDENTITY, *, coarsen: bool = True) -> str:
        """Put the surface of a body into the program, turned by `quat`, and return its path.

        Args:
            body: Name of the body, which names the file.
            shape: Shape of the body.
            edge: Wanted length of the edges of triangles [m].
            quat: Orientation (w, x, y, z) that is applied to the surface.
            coarsen: Whether a finer surface is made coarser.

        Raises:
            AssetError: if its file cannot be used, or there would be too many triangles.
        """
        mesh = soft_surface(shape, self.folder, edge, coarsen=coarsen)
        if (mesh, quat) not in self._texts:  # copies share meshes
            self._texts[mesh, quat] = write_obj(mesh, quat)
        content = self._texts[mesh, quat]
        path = f"models/{body}.obj"
        if self.files.get(path, content) != content:
            path = f"models/{body}_{sha256(content).hexdigest()[:8]}.obj"
        self.files[path] = content
        return path

    def part_looks(self, body: str, shape: Any, edge: float, *, coarsen: bool) -> str:
        """Put the regions of a body's parts into the program, and return their path.

        Args:
            body: Name of the body, which names the file.
            shape: Its compound or sculpted shape.
            edge: Wanted length of the edges of triangles [m].
            coarsen: Whether a finer surface is made coarser.

        Raises:
            AssetError: if the surface cannot be made.
        """
        made_of = (shape, edge, coarsen)
        path = f"models/{body}{LOOKS_SUFFIX}"
        if self._parted.setdefault(path, made_of) != made_of:
            path = f"models/{body}_{sha256(repr(made_of).encode()).hexdigest()[:8]}{LOOKS_SUFFIX}"
        if path not in self.files:
            mesh = soft_surface(shape, self.folder, edge, coarsen=coarsen)
            self.files.later(path, part_looks(shape, mesh, self.folder, edge))
        return path

    def picture(self, file: str) -> str:
        """Put a picture of the case into the program and return its path.

        Raises:
            AssetError: if there is no such picture in the case's folder, or it cannot be read.
        """
        thumbnail(file, self.folder, PREVIEW_SIDE)  # reports a picture that cannot be read now, before the engine does
        source = picture_path(file, self.folder)
        content = source.read_bytes()
        path = f"models/{source.stem}_{sha256(content).hexdigest()[:8]}{source.suffix.lower()}"
        self.files[path] = content
        return path
