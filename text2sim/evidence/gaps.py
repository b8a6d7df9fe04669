"""Gaps between deformable bodies and others, and penetration depths.

A body is sampled at its particles, or at vertices and the midpoints of triangles and edges. Exact distances are
computed for few points only: bounding boxes of groups of neighbours rule out the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from text2sim.evidence.rigid_shapes import world_frames
from text2sim.evidence.solids import LinkSolid
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array, RunStates

if TYPE_CHECKING:
    from scipy.spatial import KDTree

MAX_POINTS_AT_ONCE = 200_000
"""Largest number of points whose distances to a solid are computed at once."""
MAX_GROUP_SIZE = 24
"""Most points in a group of neighbours."""
ROUNDING_ERROR = 1e-5
"""Rounding error of a bound in single precision [m]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points of a body over time, in groups of neighbours."""

    points: Array
    """(F, n, 3) [m], world; those of a group follow each other."""
    starts: Array
    """First point of each group, (G,)."""
    low: Array
    """Lowest corner of each group's box [m], (F, G, 3)."""
    high: Array
    """Highest corner, (F, G, 3)."""
    step: int = 1
    """Recorded frames from one frame of the cloud to the next."""

    @classmethod
    def of(cls, body: RecordedDeformable) -> "Cloud":
        """Sample a body; a mesh also gets points on its edges and triangles."""
        points = body.points
        if body.solver in ("fem", "ipc") and body.faces is not None:
            faces, corners = body.faces, body.seen
            sides, used = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0), np.unique(faces)
            middles = [corners[:, faces].mean(axis=2), corners[:, sides].mean(axis=2)]
            points = np.concatenate((corners[:, used], *middles), axis=1)
        if not len(points):
            return cls(points, np.zeros(1, np.int64), points[:, :1], points[:, :1], body.step)
        order, starts = _groups(points[0])
        points = np.ascontiguousarray(points[:, order])
        low = np.minimum.reduceat(points, starts, axis=1)
        return cls(points, starts, low, np.maximum.reduceat(points, starts, axis=1), body.step)

    @property
    def size(self) -> int:
        """Number of points."""
        return self.points.shape[1]

    def members(self, frames: Array, groups: Array) -> tuple[Array, Array]:
        """Return (frame, point) for all points of groups, given by frame and group number."""
        ends = np.append(self.starts[1:], self.size)
        count = (ends - self.starts)[groups]
        first = np.repeat(self.starts[groups] - (np.cumsum(count) - count), count)
        return np.repeat(frames, count), first + np.arange(count.sum())


def _groups(points: Array) -> tuple[Array, Array]:
    """Sort points (n, 3) so that neighbours are adjacent; return the order, and where groups begin."""
    points = np.where(np.isfinite(points).all(axis=1, keepdims=True), points, 0.0)
    stack, found = [np.arange(len(points))], []
    while stack:
        rows = stack.pop()
        if len(rows) <= MAX_GROUP_SIZE:
            found.append(rows)
            continue
        # Bisect across the longest side.
        own = points[rows]
        order = np.argsort(own[:, np.ptp(own, axis=0).argmax()], kind="stable")
        half = len(rows) // 2
        stack += [rows[order[:half]], rows[order[half:]]]
    sizes = [len(rows) for rows in found]
    return np.concatenate(found), np.cumsum([0, *sizes[:-1]])


@dataclass
class Nearest:
    """The smallest distance so far in each frame."""

    value: Array
    """[m], (F,); negative inside. The given limit where nothing is nearer."""
    pos: Array
    """The point of the body [m], world, (F, 3); NaN where nothing is nearer than the limit."""
    of: Array
    """Number of the solid, (F,); -1 where nothing is nearer than the limit."""

    @classmethod
    def within(cls, frames: int, limit: float | Array) -> "Nearest":
        """Return an empty result; distances beyond the limit [m] are ignored."""
        return cls(np.full(frames, limit, float), np.full((frames, 3), np.nan), np.full(frames, -1))

    def add(self, frames: Array, values: Array, points: Array, of: int) -> None:
        """Keep, in each frame, the smallest of these distances.

        Args:
            frames: Frames of the distances, shape (n,), increasing.
            values: Distances, shape (n,) [m]; nan where there is none.
            points: Points of the body, world, shape (n, 3) [m].
            of: Number of the solid.
        """
        if not len(frames):
            return
        values = np.where(np.isnan(values), np.inf, values)
        begins = np.flatnonzero(np.diff(frames, prepend=-1))
        best = np.minimum.reduceat(values, begins)
        owner = np.repeat(np.arange(len(begins)), np.diff(np.append(begins, len(frames))))
        rows = np.flatnonzero(values == best[owner])
        rows = rows[np.diff(owner[rows], prepend=-1) > 0]  # the first of equals
        rows = rows[values[rows] < self.value[frames[rows]]]
        at = frames[rows]
        self.value[at], self.pos[at], self.of[at] = values[rows], points[rows], of


def nearest_solid(
    cloud: Cloud, states: RunStates, solids: Sequence[tuple[int, LinkSolid]], limit: float | Array = np.inf
) -> Nearest:
    """Return the distance of a cloud to the nearest solid in each frame.

    Args:
        cloud: The points.
        states: The recording.
        solids: Solids with their links.
        limit: Distance [m] beyond which the exact value does not matter.
    """
    found = Nearest.within(len(cloud.points), limit)
    for number, (link, solid) in enumerate(solids):
        if len(cloud.points):
            pos, turn = world_frames(states, link, solid, cloud.step)
            bound = _bound(cloud, solid, pos, turn)
            first = bound.argmin(axis=1)
            frames = np.flatnonzero(bound.min(axis=1) < found.value)
            _measure(cloud, solid, pos, turn, frames, first[frames], found, number)
            bound[frames, first[frames]] = np.inf
            rest, groups = np.nonzero(bound < found.value[:, None])
            _measure(cloud, solid, pos, turn, rest, groups, found, number)
    return found


def _bound(cloud: Cloud, solid: LinkSolid, pos: Array, turn: Array) -> Array:
    """Return a lower bound of the signed distance [m] between each group of points and a solid, (F, G)."""
    if solid.kind == "plane":
        normal = turn[:, :, 2].astype(np.float32)[:, None]
        middle, half = (cloud.low + cloud.high) / 2, (cloud.high - cloud.low) / 2
        height = ((middle - pos[:, None]) * normal).sum(axis=2)
        return height - (half * np.abs(normal)).sum(axis=2) - ROUNDING_ERROR
    low, high = solid.bounds
    middle = pos + turn @ ((low + high) / 2)
    half = np.abs(turn) @ ((high - low) / 2)
    low, high = (middle - half)[:, None].astype(np.float32), (middle + half)[:, None].astype(np.float32)
    # Separation along an axis or, where boxes overlap, at most the depth of the solid's box.
    apart = np.maximum(low - cloud.high, cloud.low - high).max(axis=2)
    deep = -half.min(axis=1)[:, None]
    return np.where(apart > 0, apart, np.maximum(apart, deep)) - ROUNDING_ERROR


def _measure(
    cloud: Cloud, solid: LinkSolid, pos: Array, turn: Array, frames: Array, groups: Array, found: Nearest, number: int
) -> None:
    """Compute the distances of the groups that may be nearer than the nearest so far."""
    block = max(1, MAX_POINTS_AT_ONCE // MAX_GROUP_SIZE)
    for begin in range(0, len(frames), block):
        at, points = cloud.members(frames[begin : begin + block], groups[begin : begin + block])
        x = cloud.points[at, points].astype(float)
        own = np.einsum("nij,ni->nj", turn[at], x - pos[at])
        value, exact = solid.least(own)
        found.add(at[exact], value[exact], x[exact], number)
        inexact = np.flatnonzero(~exact & (value < found.value[at]))
        if len(inexact):
            # The seemingly nearest point of each frame first: it rules out most others.
            order = inexact[np.lexsort((value[inexact], at[inexact]))]
            first = order[np.diff(at[order], prepend=-1) > 0]
            found.add(at[first], solid.distance(own[first]), x[first], number)
            left = inexact[value[inexact] < found.value[at[inexact]]]
            left = np.setdiff1d(left, first, assume_unique=True)
            found.add(at[left], solid.distance(own[left]), x[left], number)


def nearest_cloud(cloud: Cloud, other: Cloud, limit: float | Array = np.inf) -> Nearest:
    """Return the distance between the points of two bodies in each frame; never negative.

    Args:
        cloud: Points of the one body.
        other: Points of the other.
        limit: Distance [m] beyond which nothing is searched; one for all frames, or shape (F,).
    """
    from scipy.spatial import KDTree

    found = Nearest.within(len(cloud.points), limit)
    if not len(cloud.points):
        return found
    low = np.fmin.reduce(other.low, axis=1, keepdims=True)
    high = np.fmax.reduce(other.high, axis=1, keepdims=True)
    apart = np.maximum(np.maximum(low - cloud.high, cloud.low - high), 0.0)
    # Groups with points that are not finite are left out.
    bound = np.nan_to_num(np.linalg.norm(apart, axis=2), nan=np.inf) - ROUNDING_ERROR
    for frame in np.flatnonzero(bound.min(axis=1) < limit).tolist():
        theirs = other.points[frame].astype(float)
        theirs = theirs[np.isfinite(theirs).all(axis=1)]
        if not len(theirs):
            continue
        tree = KDTree(theirs, balanced_tree=False, compact_nodes=False)
        # The seemingly nearest group first: it rules out most others.
        first = np.array([bound[frame].argmin()])
        _measure_to_tree(cloud, tree, frame, first, found)
        rest = np.setdiff1d(np.flatnonzero(bound[frame] < found.value[frame]), first)
        _measure_to_tree(cloud, tree, frame, rest, found)
    return found


def _measure_to_tree(cloud: Cloud, tree: "KDTree", frame: int, groups: Array, found: Nearest) -> None:
    """Compute the distances of groups of points to the points of a tree in one frame."""
    at, points = cloud.members(np.full(len(groups), frame), groups)
    x = cloud.points[at, points].astype(float)
    sound = np.isfinite(x).all(axis=1)
    x, at = x[sound], at[sound]
    if len(x):
        found.add(at, np.asarray(tree.query(x, distance_upper_bound=found.value[frame])[0]), x, 0)
