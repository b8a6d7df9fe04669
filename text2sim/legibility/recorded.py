"""Triangles of a recorded run at a moment; coarse ones, since they only serve to find what is visible."""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.compiler.looks import hides
from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.drawing.view import PictureView, perspective
from text2sim.legibility.sight import Sight, Things, look
from text2sim.recording.film_record import FilmRecord, WornMesh
from text2sim.spec_schema.names.selectors import body_of
from text2sim.templates.cameras import View as FilmView

Array = NDArray[Any]

STAGE_TRIANGLES = 60_000
"""Approximate number of triangles of rigid things."""
MAX_PARTICLES = 2_000
"""Approximate number of particles of a body that are drawn."""
PARTICLE_RADIUS = 0.7
"""Radius of a particle, as a part of the distance between neighbours."""
OCTAHEDRON = np.array([
    (a, b, c) for x in (1, -1) for y in (1, -1) for z in (1, -1)
    for a, b, c in [((x, 0, 0), (0, y, 0), (0, 0, z))]
], float)  # fmt: skip
"""Corners of the triangles of an octahedron, shape (8, 3, 3), not oriented."""


class Recorded:
    """The things of a recording: bodies and statics, all copies of each together.

    Args:
        recording: The recorded run.
        budget: Approximate number of triangles of rigid things.
        grains: Approximate number of particles of a body that are drawn, each enlarged to stand for its neighbours.
        copies: Whether each copy of a body is a thing of its own.

    Attributes:
        names: Names of the things.
        pieces: The meshes of links, then deformable bodies.
        thing_of_piece: Index of the thing that each piece belongs to, shape (p,).
        hiding: Whether each piece hides what is behind it, shape (p,).
        statics: Names of the things that never move.
        colors: Colour of each thing, sRGB from 0 to 1, shape (m, 3).
    """

    def __init__(
        self,
        recording: FilmRecord,
        budget: int = STAGE_TRIANGLES,
        grains: int = MAX_PARTICLES,
        *,
        copies: bool = False,
    ):
        self.recording, self._budget, self._grains = recording, budget, grains
        self._name = str if copies else body_of
        parts = [part for part in recording.parts if part.look.drawn]
        soft = [part for part in recording.soft if part.look.drawn]
        self.pieces = [*parts, *soft]
        self.names = list(dict.fromkeys(self._name(piece.body) for piece in self.pieces))
        self._index = {name: k for k, name in enumerate(self.names)}
        looks = {self._name(piece.body): piece.look for piece in reversed(self.pieces)}
        self.colors = np.array([looks[name].color for name in self.names], float).reshape(-1, 3)
        still = {self._name(body) for body in recording.statics}
        self.statics = frozenset(still - {self._name(b) for b in recording.bodies if b not in recording.statics})
        self._soft = soft
        self._local, self._links, self._piece = self._rigid(parts)
        self.thing_of_piece = np.array([self._index[self._name(piece.body)] for piece in self.pieces], int)
        self.hiding = np.array([hides(piece.look.opacity, piece.look.finish) for piece in self.pieces], bool)

    def things(self, t: float) -> Things:
        """Return all things at a simulated time [s]."""
        corners, piece, there = self.surfaces(t)
        piece = piece[there]
        return Things(corners[there], self.thing_of_piece[piece], self.hiding[piece], len(self.names))

    def surfaces(self, t: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return the triangles of all pieces at a simulated time [s]; their order is the same at all times.

        Returns:
            Corners [m], shape (n, 3, 3); index of the piece of each triangle, and whether it exists, both shape (n,).
        """
        states = self.recording.states
        pos, quat = states.poses(t)
        turn = quats_to_matrices(quat.astype(float))[self._links]
        triangles = [np.einsum("nij,nkj->nki", turn, self._local) + pos[self._links][:, None]]
        piece = [self._piece]
        first = len(self.pieces) - len(self._soft)
        for k, (part, faces) in enumerate(zip(self._soft, self._faces, strict=True), first):
            triangles.append(self._deformed(part, faces, t))
            piece.append(np.full(len(triangles[-1]), k))
        corners = np.concatenate(triangles)
        there: NDArray[np.bool_] = np.isfinite(corners).reshape(-1, 9).min(axis=1)
        there[: len(self._links)] &= ~states.gone(t)[self._links]
        return corners, np.concatenate(piece), there

    def sight(self, t: float, camera: FilmView, size: tuple[int, int]) -> Sight:
        """Return what a camera sees at a simulated time.

        Args:
            t: Time [s].
            camera: Pose of the camera at this time.
            size: Width and height of the picture [pixels].
        """
        return look(self.things(t), raster_view(camera, size))

    def flat_picture(self, sight: Sight, background: Any) -> Array:
        """Return what a camera sees as a picture with flat colours, 0 to 1, shape (h, w, 3)."""
        colors = np.concatenate([self.colors, np.asarray(background, float).reshape(1, 3)])
        return colors[sight.front].reshape(sight.view.height, sight.view.width, 3)

    def _rigid(self, parts: list[WornMesh]) -> tuple[Array, Array, Array]:
        """Triangles of all rigid parts in the frames of their links, and the link and the part of each triangle."""
        meshes: dict[Any, tuple[Array, Array]] = {}
        for mesh in dict.fromkeys(part.mesh for part in parts):
            with np.load(mesh) as arrays:
                meshes[mesh] = arrays["vertices"].astype(float), arrays["faces"].astype(int)
        whole = sum(len(meshes[part.mesh][1]) for part in parts)
        most = max(self._budget // max(len(parts), 1), 48) if whole > self._budget else whole
        read = {mesh: vertices[coarsened(vertices, faces, most)] for mesh, (vertices, faces) in meshes.items()}
        if not parts:
            return np.zeros((0, 3, 3)), np.zeros(0, int), np.zeros(0, int)
        turns = quats_to_matrices(np.array([part.quat for part in parts], float))
        local = [read[p.mesh] @ r.T + np.asarray(p.pos) for p, r in zip(parts, turns, strict=True)]
        sizes = [len(rows) for rows in local]
        links = np.repeat([part.link for part in parts], sizes)
        return np.concatenate(local), links, np.repeat(np.arange(len(parts)), sizes)

    @cached_property
    def _faces(self) -> list[Array | None]:
        """Triangles over the vertices of each deformable body; None for particles."""
        found: list[Array | None] = []
        for part in self._soft:
            with np.load(part.geometry) as arrays:
                faces = arrays["faces"].astype(int) if "faces" in arrays else None
            if faces is not None:
                most = max(self._budget // len(self._soft), 200)
                faces = coarsened(self._places(part, float(self.recording.states.time[0])), faces, most)
            found.append(faces)
        return found

    def _deformed(self, part: Any, faces: Array | None, t: float) -> Array:
        points = self._places(part, t)
        if faces is not None:
            return points[faces]
        step = -(-len(points) // self._grains)
        radius = PARTICLE_RADIUS * float(part.row["spacing"]) * step ** (1 / 3)
        return (points[::step, None, None] + radius * OCTAHEDRON).reshape(-1, 3, 3)

    def _places(self, part: Any, t: float) -> Array:
        """Positions of the vertices, or particles, of a deformable body [m], shape (n, 3)."""
        states = self.recording.states
        assert states.soft is not None
        name, columns = ("soft_points", "points") if part.row["surface"] is None else ("soft_surface", "surface")
        return states.soft.at(name, states.around(t))[slice(*part.row[columns])].astype(float)


def raster_view(camera: FilmView, size: tuple[int, int]) -> PictureView:
    """Return a camera of the film as a view of the rasteriser."""
    away = float(np.linalg.norm(np.subtract(camera.look_at, camera.pos)))
    near = max(away * 1e-3, 1e-4)
    return perspective(camera.pos, camera.look_at, camera.up, camera.fov, size, near=near)  # type: ignore[arg-type]


def coarsened(vertices: Array, faces: Array, max_triangles: int) -> Array:
    """Return fewer triangles over the same vertices, shape (g, 3): vertices that are near each other are merged.

    Args:
        vertices: Positions [m], shape (n, 3).
        faces: Triangles, shape (f, 3).
        max_triangles: Approximate number of triangles; fewer are returned unchanged.
    """
    if len(faces) <= max_triangles:
        return faces
    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    cells = max(int(np.sqrt(max_triangles / 4)), 2)
    while True:
        spot = np.floor((vertices - low) * (cells / max(size, 1e-30)) + 0.5).astype(np.int64)
        _, first, cell = np.unique(spot @ (1, 4096, 4096**2), return_index=True, return_inverse=True)
        corners = cell.reshape(-1)[faces]
        triple = np.sort(corners, axis=1)
        _, kept = np.unique(triple, axis=0, return_index=True)
        kept = kept[(np.diff(triple[kept], axis=1) > 0).all(axis=1)]
        if len(kept) <= 1.5 * max_triangles or cells <= 2:
            return first[corners[kept]]
        cells = max(int(cells * 0.7), 2)
