"""Geometry of recordings: corners and reach of recorded shapes, and regions of space."""

import json
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.recording.chunks import DAMAGED
from text2sim.recording.states import Array, RunStates
from text2sim.recording.vectors import rotate, rotate_back
from text2sim.spec_schema.models.base import AXES, Axis
from text2sim.spec_schema.models.scene import Domain
from text2sim.spec_schema.models.space import BoxRegion, Region, SphereRegion

MESH_FILE = re.compile(r"\w{1,128}\.npz\Z")
MAX_CORNERS = 64
"""Meshes with more corners than this are reduced to their convex hulls, which have the same extent."""


class Geometry:
    """The recorded shapes of a run."""

    def __init__(self, folder: Path, index: dict[int, list[dict[str, Any]]]) -> None:
        self._folder = folder
        self._index = index
        self._corners = cache(self._read_corners)
        self.corners = cache(self._link_corners)
        """Corners (n, 3) of the shapes of a link [m], in the link's frame; empty if it has no shape."""

    @classmethod
    def load(cls, run_dir: Path) -> "Geometry":
        """Open the shapes of a run; missing ones have no corners."""
        folder = run_dir / "geometry"
        try:
            data = json.loads((folder / "index.json").read_text("utf-8"))
            index = {int(link): [{**row} for row in rows] for link, rows in data.items()}
        except (OSError, ValueError, TypeError, AttributeError, RecursionError):
            index = {}
        return cls(folder, index)

    def _link_corners(self, link: int) -> Array:
        parts = [np.zeros((0, 3))]
        for row in self._index.get(link, ()):
            quat = np.asarray(row.get("quat", (1, 0, 0, 0)), dtype=float)
            parts.append(
                rotate(quat, self._corners(str(row["mesh"]))) + np.asarray(row.get("pos", (0, 0, 0)), dtype=float)
            )
        return np.concatenate(parts)

    def _read_corners(self, mesh: str) -> Array:
        if not MESH_FILE.match(mesh):  # a name becomes a path
            return np.zeros((0, 3))
        try:
            with np.load(self._folder / mesh, allow_pickle=False) as data:
                vertices = np.asarray(data["vertices"], dtype=float).reshape(-1, 3)
        except DAMAGED:
            return np.zeros((0, 3))
        return _hull(np.unique(vertices[np.isfinite(vertices).all(axis=1)], axis=0))


def _hull(vertices: Array) -> Array:
    if len(vertices) <= MAX_CORNERS:
        return vertices
    from scipy.spatial import ConvexHull, QhullError  # slow to import, and rarely needed

    try:
        return vertices[ConvexHull(vertices).vertices]
    except QhullError:  # a flat mesh has no volume
        return vertices


def reach_along(
    states: RunStates, geometry: Geometry, links: Sequence[int], axis: str, frame: int | None
) -> tuple[Array, Array]:
    """Return the lowest and highest coordinate (F,) [m] of links along an axis, from their corners.

    The coordinate of a corner c of a link at p with rotation R is p.a + c.(R^T a), so one product of the corners with
    the turned axis is enough for a link.

    Args:
        states: The recorded states.
        geometry: Corners of links.
        links: Numbers of the links.
        axis: `x`, `y` or `z`.
        frame: Number of the link whose axis and origin are used; those of the world if None.
    """
    low, high = np.full(states.frames, np.inf), np.full(states.frames, -np.inf)
    origin, direction = axis_in(states, axis, frame)
    for link in links:
        corners = geometry.corners(int(link))
        if not len(corners):
            continue
        along = rotate_back(states.quat[:, link].astype(float), direction)
        base = ((states.pos[:, link] - origin) * direction).sum(axis=-1)
        # In blocks, for long runs of detailed meshes.
        block = max(1, 2_000_000 // len(corners))
        for first in range(0, states.frames, block):
            span = slice(first, first + block)
            reached = along[span] @ corners.T
            low[span] = np.minimum(low[span], base[span] + reached.min(axis=1))
            high[span] = np.maximum(high[span], base[span] + reached.max(axis=1))
    nothing = ~np.isfinite(low) | ~np.isfinite(high)
    low[nothing] = high[nothing] = np.nan
    return low, high


def axis_in(states: RunStates, axis: str, frame: int | None) -> tuple[Array, Array]:
    """Return the origin [m] and direction, in the world, of an axis of a link, (F, 3) each; of the world's, (3,).

    Args:
        states: The recorded states.
        axis: `x`, `y` or `z`.
        frame: Number of the link; the world if None.
    """
    if frame is None:
        return np.zeros(3), np.array(AXES[axis])
    turned = rotate(states.quat[:, frame].astype(float), np.array(AXES[axis]))
    return states.pos[:, frame].astype(float), turned


def unit_vector(axis: Axis) -> Array:
    """Return the unit vector of an axis of the language."""
    vector = np.array(AXES[axis] if isinstance(axis, str) else axis, dtype=float)
    return vector / np.linalg.norm(vector)


def depth_inside(region: Region | Domain, points: Array) -> Array:
    """Return how deep points (..., 3) lie inside a region [m]; negative outside, zero on its surface.

    Continuous in the points, so that the time of a passage can be interpolated between frames.
    """
    if isinstance(region, Domain | BoxRegion):
        return np.minimum(points - np.array(region.min), np.array(region.max) - points).min(axis=-1)
    offset = points - np.array(region.center)
    if isinstance(region, SphereRegion):
        return region.radius - np.linalg.norm(offset, axis=-1)
    along = offset @ unit_vector(region.axis)
    radial = np.linalg.norm(offset - along[..., None] * unit_vector(region.axis), axis=-1)
    return np.minimum(region.radius - radial, region.height / 2 - np.abs(along))
