"""Recorded deformable bodies, which are points, not links: soft bodies, cloth, grains, liquids, snow."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.recording.chunks import DAMAGED, Array, Chunks, read_arrays
from text2sim.recording.vectors import rotate_back

ARRAYS = ("rest", "masses", "tets", "edges", "point_faces", "faces", "uvs")
"""Arrays that `geometry/soft_<index>.npz` may hold."""
IN_HAND = 500_000
"""Most points, over several frames, that are computed at once."""


@dataclass(frozen=True, eq=False)
class RecordedDeformable:
    """One recorded copy of a deformable body."""

    index: int
    """Its place among the deformable bodies."""
    body: str
    """Name of the copy: `curtain`, `letter[3]`."""
    kind: str
    """soft, cloth, granular, liquid or snow."""
    solver: str
    """mpm, pbd, fem or ipc."""
    spacing: float
    """Distance [m] of its particles, cell of its grid, or length of its edges, depending on the solver."""
    mass: float
    """[kg]"""
    points_at: tuple[int, int]
    """Its columns of `soft_points`, from and to (not included)."""
    surface_at: tuple[int, int] | None
    """Its columns of `soft_surface`; None without a surface of its own."""
    pose: tuple[float, ...] | None = None
    """Where its frame was placed: position [m] and quaternion (w, x, y, z); None in recordings without it."""
    domain: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    """Corners [m] of the domain of its solver; None if that is unbounded."""
    geometry: dict[str, Array] | None = None
    """Arrays that do not change: rest (p, 3), masses (p,), tets (t, 4), edges (e, 2) and point_faces (g, 3) of points,
    faces (f, 3), uvs (s, 2)."""
    chunks: Chunks = Chunks(())
    step: int = 1
    """Recorded frames from one frame of it to the next."""

    @property
    def count(self) -> int:
        """Number of its points."""
        return self.points_at[1] - self.points_at[0]

    @property
    def points(self) -> Array:
        """Its points [m], world, shape (F, p, 3); read from disk each time."""
        return self.chunks.columns("soft_points", *self.points_at)[:: self.step]

    @property
    def seen(self) -> Array:
        """What is drawn of it [m], shape (F, n, 3): vertices of its surface, or points. Read from disk each time."""
        if self.surface_at is None:
            return self.points
        return self.chunks.columns("soft_surface", *self.surface_at)[:: self.step]

    @property
    def torn(self) -> Array | None:
        """Whether each of its points has torn, shape (F, p); None if no body of the recording has a tear strength."""
        torn = self.chunks.columns("soft_torn", *self.points_at)[:: self.step]
        return torn > 0 if len(torn) == len(self.points) and torn.ndim == 2 else None

    @cached_property
    def rest(self) -> Array:
        """Its points at the start [m], world, shape (p, 3)."""
        if self.geometry and "rest" in self.geometry:
            return self.geometry["rest"].astype(float)
        points = self.points
        return points[0].astype(float) if len(points) else np.zeros((self.count, 3))

    @cached_property
    def own(self) -> Array:
        """Its points at the start [m] in the frame of its body, shape (p, 3).

        Without a recorded pose, the body is taken to be upright, with its frame in its middle.
        """
        if self.pose is None:
            return self.rest - (self.rest.min(axis=0) + self.rest.max(axis=0)) / 2
        return rotate_back(np.array(self.pose[3:]), self.rest - np.array(self.pose[:3]))

    @cached_property
    def masses(self) -> Array:
        """Masses of the points [kg], shape (p,)."""
        if self.geometry and "masses" in self.geometry:
            return self.geometry["masses"].astype(float)
        return np.full(self.count, self.mass / self.count)

    @cached_property
    def shares(self) -> Array:
        """Fraction of the mass of each point, shape (p,)."""
        return self.masses / self.masses.sum()

    @property
    def tets(self) -> Array | None:
        """Tetrahedra, indices of points, shape (t, 4); None if it has none."""
        return (self.geometry or {}).get("tets")

    @property
    def edges(self) -> Array | None:
        """Threads of a cloth, pairs of points, shape (e, 2); None if they were not recorded."""
        return (self.geometry or {}).get("edges")

    @property
    def faces(self) -> Array | None:
        """Triangles of its surface, shape (f, 3): indices of `seen`."""
        return (self.geometry or {}).get("faces")

    @cached_property
    def net(self) -> tuple[Array, bool] | None:
        """Triangles (f, 3) of it, and whether they index its points; otherwise they index `seen`. None without any.

        Triangles of its points are preferred, since what is drawn only follows them.
        """
        own = (self.geometry or {}).get("point_faces")
        if own is not None:
            return own, True
        return None if self.faces is None else (self.faces, self.surface_at is None)

    @cached_property
    def center(self) -> Array:
        """Centre of mass [m], world, shape (F, 3): the mean of the points, weighted by mass."""
        points = self.points
        parts = [self.shares @ points[span].astype(float) for span in frame_spans(points)]
        return np.concatenate(parts) if parts else np.zeros((0, 3))

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest coordinates of its points [m], world, both (F, 3)."""
        points = self.points
        return points.min(axis=1).astype(float), points.max(axis=1).astype(float)

    def thinned(self, max_points: int, frames: int) -> "RecordedDeformable":
        """Return the body at evenly chosen frames, from the first on, with `max_points` points in all."""
        return replace(self, step=max(1, int(np.ceil(frames * self.count / max_points))))

    def recorded_in(self, chunks: Chunks) -> "RecordedDeformable":
        """Return the body with its recording."""
        return replace(self, chunks=chunks)


def frame_spans(points: Array, elements: int = 0) -> list[slice]:
    """Cut the frames of points (F, n, 3) into runs that are small enough to be computed at once.

    Args:
        points: The points.
        elements: Number of elements in one frame, if there are more than points.
    """
    length = max(1, IN_HAND // max(1, points.shape[1], elements))
    return [slice(first, first + length) for first in range(0, len(points), length)]


def read_deformables(
    run_dir: Path, layout: dict[str, Any]
) -> tuple[list[RecordedDeformable], dict[str, int], list[str]]:
    """Return the deformable bodies of a layout, the widths P, S and B of their arrays, and what could not be read.

    Raises:
        ValueError, TypeError, KeyError: if the layout does not describe them.
    """
    bodies, losses = [], []
    for index, row in enumerate(layout.get("deformables") or []):
        body = _row(index, row)
        path = run_dir / "geometry" / f"soft_{index}.npz"
        try:
            arrays = read_arrays(path, ARRAYS)
        except DAMAGED as error:
            arrays = {}
            losses.append(f"geometry/{path.name}: {'missing' if isinstance(error, OSError) else f'damaged ({error})'}")
        good, wrong = _checked(body, arrays)
        losses += [f"geometry/{path.name}: {reason}" for reason in wrong]
        bodies.append(replace(body, geometry=good))
    sizes = {
        "P": max((body.points_at[1] for body in bodies), default=0),
        "S": max((body.surface_at[1] for body in bodies if body.surface_at), default=0),
        "B": len(bodies),
    }
    return bodies, sizes, losses


def _row(index: int, row: dict[str, Any]) -> RecordedDeformable:
    spacing, mass = float(row["spacing"]), float(row["mass"])
    pose = None
    if row.get("pos") is not None and row.get("quat") is not None:
        pose = tuple(float(x) for x in (*row["pos"], *row["quat"]))
        if len(pose) != 7 or not np.isfinite(pose).all():
            raise ValueError(f"deformable {index} has no pose")
    domain = None
    if row.get("domain") is not None:
        low, high = (tuple(float(x) for x in corner) for corner in row["domain"])
        domain = (low, high)
        if len(low) != 3 or len(high) != 3:
            raise ValueError(f"deformable {index} has no domain")
    if not (0 < spacing < np.inf and 0 < mass < np.inf):
        raise ValueError(f"deformable {index} has spacing {spacing} and mass {mass}")
    surface = row.get("surface")
    return RecordedDeformable(
        index, str(row["body"]), str(row["kind"]), str(row["solver"]), spacing, mass,
        _span(row["points"]), None if surface is None else _span(surface), pose, domain,
    )  # fmt: skip


def _span(pair: Any) -> tuple[int, int]:
    first, last = (int(n) for n in pair)
    if not 0 <= first < last < 2**31:
        raise ValueError(f"no columns: {first} to {last}")
    return first, last


def _checked(body: RecordedDeformable, arrays: dict[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Return the arrays that fit the body, and what is wrong with the others."""
    faced = body.surface_at or body.points_at
    corners = faced[1] - faced[0]
    shapes: dict[str, tuple[tuple[int | None, ...], int]] = {
        "rest": ((body.count, 3), 0),
        "masses": ((body.count,), 0),
        "tets": ((None, 4), body.count),
        "edges": ((None, 2), body.count),
        "point_faces": ((None, 3), body.count),
        "faces": ((None, 3), corners),
        "uvs": ((corners, 2), 0),
    }
    good, wrong = {}, []
    for name, array in arrays.items():
        shape, limit = shapes[name]
        fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=True))
        if not fits or (limit and array.dtype.kind not in "iu"):
            wrong.append(f"{name} has shape {array.shape}")
        elif limit and array.size and not (0 <= array.min() and array.max() < limit):
            wrong.append(f"{name} names points that are not there")
        elif not limit and not np.isfinite(array).all():
            wrong.append(f"{name} has values that are not finite")
        elif name == "masses" and not (array.min() >= 0 and array.sum() > 0):
            wrong.append("masses are not positive")
        elif len(array):
            good[name] = array
    return good, wrong
