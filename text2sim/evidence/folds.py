"""Folds and self-penetration of cloth."""

import numpy as np

from text2sim.assets.surface import triangle_areas
from text2sim.evidence.deformation import DeformationError, triangles
from text2sim.recording.deformables import RecordedDeformable, frame_spans
from text2sim.recording.states import Array

MAX_CELLS = 4_000_000
"""Most cells of the picture of a frame: a cloth that has flown apart has no silhouette to measure."""
MAX_CELLS_TOGETHER = 50_000_000
"""With no more cells over several frames than this, drawing them is fastest."""
NEIGHBOUR_SPACINGS = 2.0
"""Points of a cloth are neighbours if they start within this many spacings of each other."""
IN_TREES = 2_000_000
"""Most points over all frames among which neighbours are sought; longer runs are sampled at even steps."""


def folded_area(body: RecordedDeformable, axis: int) -> Array:
    """Return the area [m2] of a cloth that is hidden behind other parts of it, seen along an axis, shape (F,).

    The triangles of its surface are drawn into a grid whose cells are as long as an edge. A cell that n layers cover
    counts n - 1 times: a towel folded in half hides half of its area, a sheet that hangs or lies flat none. Exact to
    about a cell along the outline of the fold. NaN where the cloth has flown apart.

    Raises:
        DeformationError: if the body has no surface.
    """
    faces, points = triangles(body)
    if not len(points):
        return np.zeros(0)
    cell = float(
        np.sqrt(2 * triangle_areas(points[0].astype(float)[faces]).mean())
    )  # leg of a right triangle of mean area
    plane = [k for k in range(3) if k != axis]
    found = [
        _count_hidden_cells(points[span][..., plane].astype(float) / cell, faces)
        for span in frame_spans(points, 2 * len(faces))
    ]
    return np.concatenate(found) * cell**2


def _count_hidden_cells(points: Array, faces: Array) -> Array:
    """Return the number of hidden cells in each frame, shape (F,), for points (F, n, 2) in units of cells."""
    frames = len(points)
    low = np.floor(points.min(axis=1))
    size = np.ceil(points.max(axis=1)) - low + 1
    sound = np.isfinite(size).all(axis=1) & (size.prod(axis=1) < MAX_CELLS)
    # The grid is rotated against points that form a grid themselves, so that no cell centre lies on a shared edge.
    points = np.where(sound[:, None, None], points - low[:, None], 0.0) + np.array([0.5 + 0.0137, 0.5 + 0.0071])
    corners = [[points[:, faces[:, k], axis].astype(np.float32).ravel() for k in range(3)] for axis in range(2)]
    begin = [np.ceil(np.minimum(np.minimum(a, b), c)).astype(np.int32) for a, b, c in corners]
    end = [np.floor(np.maximum(np.maximum(a, b), c)).astype(np.int32) for a, b, c in corners]
    wide, high = (np.maximum(last - first + 1, 0) for first, last in zip(begin, end, strict=True))
    some = np.flatnonzero(wide * high)
    count = (wide * high)[some]
    owner = np.repeat(some, count)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    across = high[owner]
    x, y = begin[0][owner] + number // across, begin[1][owner] + number % across
    covered = _covers([[side[owner] - at for side in sides] for sides, at in zip(corners, (x, y), strict=True)])
    frame = owner[covered] // len(faces)
    columns, rows = (int(np.where(sound, size[:, axis], 0).max(initial=0)) + 2 for axis in range(2))
    cell = (frame * columns + x[covered]) * rows + y[covered]
    if frames * columns * rows > MAX_CELLS_TOGETHER:
        seen = np.bincount(np.unique(cell) // (columns * rows), minlength=frames)
    else:
        picture = np.zeros((frames, columns * rows), bool)
        picture.ravel()[cell] = True
        seen = picture.sum(axis=1)
    return np.where(sound, np.bincount(frame, minlength=frames) - seen, np.nan)


def _covers(corners: list[list[Array]]) -> Array:
    """Return whether each triangle covers its point, shape (n,); corners are relative to it, by axis and number."""
    (ax, bx, cx), (ay, by, cy) = corners
    ab, bc, ca = ax * by - ay * bx, bx * cy - by * cx, cx * ay - cy * ax
    return ((ab > 0) & (bc > 0) & (ca > 0)) | ((ab < 0) & (bc < 0) & (ca < 0))


def self_penetration(body: RecordedDeformable, thickness: float) -> Array:
    """Return the depth [m] by which non-adjacent points of a cloth come closer than its thickness, shape (F,).

    The deepest overlap of two balls of that diameter about points that started more than two spacings apart, else 0.
    Ipc cloth is much thinner than its point spacing, so overlap between its points goes unseen. In long runs of large
    cloths every k-th frame and the last are evaluated, and the others interpolated.

    Args:
        body: The cloth.
        thickness: Thickness of the cloth [m]; for pbd the spacing of its particles.

    Raises:
        DeformationError: if the body is not a cloth.
    """
    from scipy.spatial import KDTree

    if body.kind != "cloth":
        raise DeformationError(f"{body.body} is {body.kind}, not cloth")
    points, start = body.points, body.rest
    chosen = sampled_frames(len(points), body.count)
    depth = np.full(len(chosen), np.nan)
    for row, frame in enumerate(chosen):
        x = points[frame].astype(float)
        if not np.isfinite(x).all():
            continue
        tree = KDTree(x, balanced_tree=False, compact_nodes=False)
        pairs = tree.query_pairs(thickness * (1 - 1e-6), output_type="ndarray")
        away = np.linalg.norm(start[pairs[:, 0]] - start[pairs[:, 1]], axis=1)
        pairs = pairs[away > NEIGHBOUR_SPACINGS * body.spacing]
        near = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
        depth[row] = thickness - near.min(initial=thickness)
    return np.interp(np.arange(len(points)), chosen, depth) if len(chosen) else np.zeros(0)


def sampled_frames(frames: int, points: int) -> Array:
    """Return the indices of the frames to evaluate: all, or evenly fewer for many points, always including the last."""
    step = max(1, int(np.ceil(frames * points / IN_TREES)))
    chosen = np.arange(0, frames, step)
    return np.append(chosen, frames - 1) if frames and chosen[-1] != frames - 1 else chosen
