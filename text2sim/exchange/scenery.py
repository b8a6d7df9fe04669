"""Scenery of a recorded run for export: links with meshes and deformable bodies over time."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from text2sim.exchange.materials import ExportMaterial, material_of
from text2sim.recording.chunks import DAMAGED
from text2sim.recording.film_record import FilmRecord, SoftPart, WornMesh, read_recording
from text2sim.rendering.meshes import RenderMesh, read_mesh
from text2sim.spec_schema.errors import RunError
from text2sim.templates.shading import Shell

Array = NDArray[np.floating]
Indices = NDArray[np.integer]


@dataclass(frozen=True)
class SceneryPiece:
    """A mesh of a link."""

    mesh: Path
    pos: tuple[float, ...]
    """Position in the link's frame [m]."""
    quat: tuple[float, ...]
    """Orientation in the link's frame (w, x, y, z)."""
    material: ExportMaterial


@dataclass(frozen=True)
class SceneryLink:
    """A rigid link."""

    row: int
    """Index of its poses."""
    body: str
    """Copy of a body that it belongs to, such as `brick[3]`."""
    name: str
    fixed: bool
    """Whether it is fixed to the world."""
    mass: float
    """Mass [kg]."""
    com: tuple[float, ...]
    """Centre of mass in its frame [m]."""
    pieces: list[SceneryPiece]


class Figure:
    """A deformable body.

    Attributes:
        body: The copy.
        kind: soft, cloth, granular, liquid or snow.
        faces: Triangles, shape (f, 3); None for particles.
        uvs: Texture coordinates of the vertices, shape (n, 2), or None.
        spacing: Distance of neighbouring particles [m].
        material: Its material.
    """

    def __init__(self, part: SoftPart, recording: FilmRecord):
        assert recording.states.soft is not None
        self.body, self.kind, self.spacing = part.body, part.kind, float(part.row["spacing"])
        self._soft = recording.states.soft
        surface = part.row["surface"]
        self._name, columns = ("soft_points", part.row["points"]) if surface is None else ("soft_surface", surface)
        self._columns = slice(*columns)
        with np.load(part.geometry) as file:
            arrays = dict(file)
        self.faces: Indices | None = None
        self.uvs: Array | None = None
        self._shell: Shell | None = None
        if "faces" in arrays:
            rest = self._places(0)
            self._shell = Shell(rest, arrays["faces"])
            self.faces = self._shell.faces
            uvs = arrays.get("uvs")
            if uvs is not None and len(uvs) == len(rest):
                self.uvs = uvs[self._shell.sources].astype(np.float32)
        self.material = material_of(part.look, two_sided=part.kind == "cloth", has_uvs=self.uvs is not None)

    @property
    def size(self) -> int:
        """Number of vertices or particles."""
        return self._columns.stop - self._columns.start if self._shell is None else len(self._shell.sources)

    def points(self, frame: int) -> Array:
        """Return its vertices or particles in a recorded frame [m], shape (n, 3)."""
        places = self._places(frame)
        return places if self._shell is None else places[self._shell.sources]

    def normals(self, frame: int) -> Array:
        """Return a unit normal for each vertex in a recorded frame, shape (n, 3)."""
        assert self._shell is not None
        return self._shell.normals(self._places(frame))

    def _places(self, frame: int) -> Array:
        return np.nan_to_num(self._soft.at(self._name, (frame, frame, 0.0))[self._columns].astype(np.float32))


class Scenery:
    """Everything visible of a run, frame by frame.

    Args:
        folder: The run folder.
        every: Use every N-th recorded frame, and the last.
        detailed: Whether meshes get the rounded edges that films show.

    Raises:
        RunError: if nothing is recorded, or the recording is damaged.
    """

    def __init__(self, folder: Path, *, stride: int = 1, detailed: bool = True):
        self.recording = _read_confined(folder)
        self._meshes: dict[Path, RenderMesh] = {}
        self._detailed = detailed
        self._cut = {part.mesh for part in self.recording.parts if part.look.cut is not None}
        count = len(self.recording.states.time)
        if not count:
            raise RunError(f"{folder}: no frame was recorded")
        self.frames: Indices = np.unique([*range(0, count, stride), count - 1])
        """Indices of the frames."""
        self.times: Array = self.recording.states.time[self.frames].astype(float)
        """Times of the frames [s]."""
        self.poses: tuple[Array, Array] = self._poses()
        """Positions [m], shape (F, L, 3), and orientations (w, x, y, z), shape (F, L, 4), of the links' frames.

        Signs of successive orientations are such that interpolation takes the short way.
        """
        try:
            self.links = self._links()
            self.figures = [Figure(part, self.recording) for part in self.recording.soft if part.look.drawn]
        except DAMAGED as error:
            raise RunError(f"{folder}: its geometry is damaged ({error})") from error

    def mesh(self, path: Path) -> RenderMesh:
        """Return a mesh of a piece.

        Raises:
            RunError: if its file is damaged.
        """
        if path not in self._meshes:
            try:
                self._meshes[path] = read_mesh(path, rounded=self._detailed and path not in self._cut)
            except DAMAGED as error:
                raise RunError(f"{path}: its geometry is damaged ({error})") from error
        return self._meshes[path]

    def _poses(self) -> tuple[Array, Array]:
        poses = [self.recording.states.poses(float(t)) for t in self.times]
        pos, quat = np.array([row[0] for row in poses]), np.array([row[1] for row in poses])
        sound = np.isfinite(pos).all(axis=(1, 2)) & np.isfinite(quat).all(axis=(1, 2))
        if not sound.all():  # a run that diverged is exported up to that frame
            end = int(sound.argmin())
            if not end:
                raise RunError(f"{self.recording.folder}: no frame has finite poses")
            self.frames, self.times, pos, quat = self.frames[:end], self.times[:end], pos[:end], quat[:end]
        turned = (quat[1:] * quat[:-1]).sum(axis=-1) < 0
        quat[1:] *= np.cumprod(np.where(turned, -1.0, 1.0), axis=0)[..., None]
        return pos, quat

    def _links(self) -> list[SceneryLink]:
        pieces_by_link: dict[int, list[SceneryPiece]] = {}
        for part in self.recording.parts:
            if part.look.drawn:
                pieces_by_link.setdefault(part.link, []).append(self._piece(part))
        rows = self.recording.states.layout["links"]
        return [
            SceneryLink(
                k, row["body"], row["link"], bool(row["fixed"]), float(row["mass"]),
                tuple(float(x) for x in row.get("com", (0, 0, 0))), pieces_by_link.get(k, []),
            )
            for k, row in enumerate(rows)
        ]  # fmt: skip

    def _piece(self, part: WornMesh) -> SceneryPiece:
        has_uvs = part.look.picture is not None and self.mesh(part.mesh).uvs is not None
        material = material_of(part.look, two_sided=False, has_uvs=has_uvs)
        return SceneryPiece(part.mesh, part.pos, part.quat, material)


def keyframe_rows(values: Array) -> Indices:
    """Return the rows of a track (n, ...) that are needed to restore the others by linear interpolation."""
    if len(values) < 3:
        return np.arange(len(values))
    changed = (values[1:] != values[:-1]).reshape(len(values) - 1, -1).any(axis=1)
    needed = np.concatenate([[True], changed[:-1] | changed[1:], [True]])
    return np.flatnonzero(needed)


def _read_confined(folder: Path) -> FilmRecord:
    """Read an untrusted recording, none of whose files may be outside of its folder."""
    try:
        recording = read_recording(folder)
    except DAMAGED as error:
        raise RunError(f"{folder}: its states are damaged ({error})") from error
    root = folder.resolve()
    files = [*(part.mesh for part in recording.parts), *(part.geometry for part in recording.soft)]
    looks = [part.look for part in (*recording.parts, *recording.soft)]
    files += [look.picture for look in looks if look.picture is not None]
    for path in dict.fromkeys(files):
        if not path.resolve().is_relative_to(root):
            raise RunError(f"{folder}: names a file outside of it: {path}")
    return recording
