"""Sculpted shapes for the rest of the compiler, kept in memory and in the user's cache."""

from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.answer_cache import cached_answer
from text2sim.compiler.memory import Memory
from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.distance_field import field_of
from text2sim.compiler.shapes.hulls import outward_hull
from text2sim.compiler.shapes.meshfile import MeshFile, obj_text
from text2sim.compiler.shapes.piece import Piece, hull_piece
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.models.sculpts import Sculpt

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

DIGEST_PREFIX = "sculpt:"
"""Prefix of the digest of a shape that a piece names as its file."""
_KNOWN: "Memory[Sculpted]" = Memory(64)
_BY_DIGEST: "dict[str, Sculpted]" = {}


@dataclass(frozen=True, eq=False)
class Sculpted:
    """The mesh of a sculpted shape, with its convex pieces."""

    vertices: "np.ndarray"
    """(n, 3) float [m]"""
    faces: "np.ndarray"
    """(m, 3) int, counterclockwise from outside"""
    normals: "np.ndarray"
    """(n, 3) float, unit length"""
    looks: "np.ndarray"
    """(m,) int: number of the part that gives a triangle its look; -1, the body"""
    hulls: "list[tuple[np.ndarray, np.ndarray]]"
    """For each convex piece: corners (k, 3) float [m], and triangles (l, 3) int, counterclockwise from outside"""
    names: tuple[str, ...]
    """Names of the parts."""

    @cached_property
    def digest(self) -> str:
        """Hash of the surface."""
        return sha256(self.vertices.tobytes() + self.faces.tobytes()).hexdigest()

    @cached_property
    def mesh(self) -> MeshFile:
        """The surface as if it had been read from a file, in metres."""
        corners, net = outward_hull(self.vertices)
        return MeshFile(self.vertices, self.faces, self.vertices[corners], net, volume=self.volume, closed=True)

    @cached_property
    def volume(self) -> float:
        """Enclosed volume [m3]."""
        return self._moments[0]

    @cached_property
    def center(self) -> Vec:
        """Centre of volume [m]."""
        return self._moments[1]

    @cached_property
    def inertia(self) -> tuple[float, float, float, float, float, float]:
        """Inertia [m5] about the centre, for a density of 1: xx, yy, zz, xy, xz, yz."""
        return self._moments[2]

    @cached_property
    def _moments(self) -> tuple[float, Vec, tuple[float, float, float, float, float, float]]:
        """Volume, centre and inertia, by tetrahedra from the middle of the bounds to every triangle (Mirtich, 1996)."""
        import numpy as np

        middle = (self.vertices.min(0) + self.vertices.max(0)) / 2
        corners = (self.vertices - middle)[self.faces]
        six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
        volume = float(six.sum() / 6)
        total = corners.sum(axis=1)
        center = (six[:, None] * total).sum(0) / 24 / volume
        # Second moment of a tetrahedron with corners 0, a, b, c: V/20 (aa + bb + cc + ss), with s = a + b + c.
        second = np.einsum("i,ija,ijb->ab", six, corners, corners) + np.einsum("i,ia,ib->ab", six, total, total)
        second = second / 120 - volume * np.outer(center, center)
        tensor = np.eye(3) * np.trace(second) - second
        x, y, z = (center + middle).tolist()
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = tensor.tolist()
        return volume, (x, y, z), (xx, yy, zz, xy, xz, yz)

    def obj(self) -> str:
        """Return the surface as the text of an .obj file."""
        return obj_text(self.vertices, self.faces)

    def visuals(self) -> list[VisualMesh]:
        """Return the surface to draw: a mesh for each look, with the name of a part that has it."""
        import numpy as np

        found = []
        for look in np.unique(self.looks).tolist():
            used, net = np.unique(self.faces[self.looks == look], return_inverse=True)
            name = self.names[look] if look >= 0 else None
            found.append(VisualMesh(self.vertices[used], net.reshape(-1, 3), self.normals[used], part=name))
        return found


def sculpted(shape: Sculpt) -> Sculpted:
    """Return the mesh of a shape.

    Raises:
        AssetError: if it cannot be made within the limits, or is in several pieces.
    """
    key = shape.model_dump_json(exclude_defaults=True)
    return _KNOWN.recall(key, lambda: _recalled(shape, key))


def sculpted_obj(file: str) -> str:
    """Return the .obj text of the surface that a piece names as its file."""
    return _BY_DIGEST[file.removeprefix(DIGEST_PREFIX)].obj()


def piece_mesh(piece: Piece, folder: Path) -> MeshFile:
    """Return the surface that a piece names as its file: of a sculpted shape, or of a file in the case's folder.

    Raises:
        AssetError: if the file cannot be read.
    """
    file = str(piece.file)
    if file.startswith(DIGEST_PREFIX):
        return _BY_DIGEST[file.removeprefix(DIGEST_PREFIX)].mesh
    return load_mesh(file, folder)


def pieces_of(shape: Sculpt) -> list[Piece]:
    """Return the convex pieces with which a shape touches others; for `decompose` and `exact`, one mesh.

    Raises:
        AssetError: if it cannot be made, or cannot touch exactly.
    """
    sculpture = sculpted(shape)
    if shape.collision in ("decompose", "exact"):
        return [whole_piece(sculpture, shape.collision)]
    return [hull_piece(corners, net) for corners, net in sculpture.hulls]


def whole_piece(sculpture: Sculpted, collision: str) -> Piece:
    """Return a sculpted shape as one mesh.

    Args:
        sculpture: The shape.
        collision: How it touches: `decompose` or `exact`.

    Raises:
        AssetError: if it cannot touch exactly.
    """
    if len(sculpture.hulls) == 1:
        corners, net = sculpture.hulls[0]
    else:
        used, net = outward_hull(sculpture.vertices)
        corners = sculpture.vertices[used]
    field = field_of(sculpture.vertices, sculpture.faces, None) if collision == "exact" else None
    return replace(
        hull_piece(corners, net), kind="mesh", size=(1.0,), file=DIGEST_PREFIX + sculpture.digest,
        enclosed=sculpture.volume, collision=collision, field=field,
    )  # fmt: skip


def _recalled(shape: Sculpt, key: str) -> Sculpted:
    here = Path(__file__).parent
    sources = (here / name for name in ("distances.py", "levelset.py", "convex.py", "hulls.py"))
    question = (b"sculpt with hulls", key.encode(), *(path.read_bytes() for path in sources))

    def ask() -> dict[str, Any]:
        from text2sim.compiler.shapes.levelset import sculpt_mesh

        made = sculpt_mesh(shape)
        arrays = {name: getattr(made, name) for name in ("vertices", "faces", "normals", "looks")}
        hulls = [(points, outward_hull(points)) for points in made.pieces]
        return arrays | {"hulls": [(points[corners], net) for points, (corners, net) in hulls]}

    made = Sculpted(**cached_answer(question, ask), names=tuple(shape.parts))
    _BY_DIGEST[made.digest] = made
    return made
