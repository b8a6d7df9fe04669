"""Folds along lines of a cloth: how often it bends one way, and then the other."""

import numpy as np

from text2sim.assets.surface import triangle_areas, unit_rows
from text2sim.evidence.deformation import DeformationError, triangles
from text2sim.evidence.swings import turning_points
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate_back

LINES = 15
"""Number of cuts."""
LEAST_BEND = np.radians(30)
"""Smallest angle [rad] of a bend: jitter of the points by a tenth of a cell makes less."""
MIN_SAMPLES = 4
"""Fewest points of a line that can bend both ways."""


def folds_of_lines(body: RecordedDeformable, axis: int) -> Array:
    """Return the number of folds of each line of a cloth, shape (F, L).

    Planes at right angles to an axis of its frame cut the cloth as it was at the start. The lines, sampled a cell
    apart, move with the triangles that they cross. With unit tangents t_k and the unit normal n of the cloth between
    two of them, the line bends by 2 asin((t_k+1 - t_k) . n / 2), which is its normal curvature times the step. The sum
    of these is the slope of the line; m turning points between slopes that differ by `LEAST_BEND` are (m + 1) // 2
    folds.

    Args:
        body: The cloth.
        axis: 0, 1 or 2.

    Raises:
        DeformationError: if it has no surface, or no line that could bend.
    """
    from scipy.sparse import csr_matrix, vstack

    faces, points = triangles(body)
    if not len(points):
        return np.zeros((0, 1))
    start = points[0].astype(float)
    if body.pose is not None:
        start = rotate_back(np.array(body.pose[3:]), start - np.array(body.pose[:3]))
    cell = float(np.sqrt(2 * triangle_areas(start[faces]).mean()))  # leg of a right triangle of mean area
    low, high = start[:, axis].min(), start[:, axis].max()
    levels = low + (np.arange(LINES) + 0.5) / LINES * (high - low) if high - low > cell else ()
    lines = [line for level in levels for line in _cut(start, faces, start[:, axis] - level, cell)]
    if not lines:
        raise DeformationError(f"{body.body} has no lines across {'xyz'[axis]} of at least {MIN_SAMPLES} cells")
    ends = np.cumsum([line.shape[0] for line in lines])[:-1]
    samples = vstack(lines, format="csr")
    corners = (np.ones(faces.size), (faces.ravel(), np.repeat(np.arange(len(faces)), 3)))
    normals_at = samples @ csr_matrix(corners, shape=(len(start), len(faces)))
    counts = np.full((len(points), len(lines)), np.nan)
    for frame, moved in enumerate(points):
        x = moved.astype(float)
        if np.isfinite(x).all():
            a, b, c = (x[faces[:, k]] for k in range(3))
            both = np.hstack([samples @ x, normals_at @ np.cross(b - a, c - a)])
            counts[frame] = [_count(row[:, :3], row[:, 3:]) for row in np.split(both, ends)]
    return counts


def _count(line: Array, normals: Array) -> int:
    """Return the number of folds of a line (n, 3) with normals (n, 3) of any length."""
    tangents = unit_rows(np.diff(line, axis=0))
    bends = (np.diff(tangents, axis=0) * unit_rows(normals[1:-1])).sum(axis=1)
    slopes = np.concatenate([[0.0], np.cumsum(2.0 * np.arcsin(np.clip(bends / 2.0, -1.0, 1.0)))])
    return (len(turning_points(slopes, LEAST_BEND)) + 1) // 2


def _cut(start: Array, faces: Array, height: Array, step: float) -> list:
    """Cut triangles where a height of their points (p,) is zero; return a sparse matrix (n, p) for each line.

    It gives n places along the line, a `step` [m] apart at the start, from the points.
    """
    from scipy.sparse import csr_matrix

    above = height > 0
    crossed = faces[(above[faces].any(axis=1)) & ~(above[faces].all(axis=1))]
    sides = np.sort(crossed[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    sides = sides[above[sides[:, 0]] != above[sides[:, 1]]]  # two for each triangle, one after the other
    ends, node = np.unique(sides, axis=0, return_inverse=True)
    part = height[ends[:, 0]] / (height[ends[:, 0]] - height[ends[:, 1]])
    weights = csr_matrix(
        (np.stack([1 - part, part], 1).ravel(), ends.ravel(), np.arange(0, 2 * len(ends) + 1, 2)),
        shape=(len(ends), len(start)),
    )
    lines = []
    for chain in _chains(node.reshape(-1, 2)):
        along = weights[chain]
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(along @ start, axis=0), axis=1))])
        count = int(length[-1] / step) + 1
        if count < MIN_SAMPLES:
            continue
        at = np.linspace(0.0, length[-1], count)
        first = np.clip(np.searchsorted(length, at, side="right") - 1, 0, len(length) - 2)
        share = (at - length[first]) / np.maximum(length[first + 1] - length[first], 1e-30)
        rows = np.repeat(np.arange(count), 2)
        between = (np.stack([1 - share, share], 1).ravel(), (rows, np.stack([first, first + 1], 1).ravel()))
        lines.append(csr_matrix(between, shape=(count, len(length))) @ along)
    return lines


def _chains(pairs: Array) -> list[list[int]]:
    """Join pairs of nodes (n, 2), each in one pair or in two, into chains; closed ones end where they began."""
    beside: dict[int, list[int]] = {}
    for one, other in pairs.tolist():
        beside.setdefault(one, []).append(other)
        beside.setdefault(other, []).append(one)
    chains, left = [], dict.fromkeys(sorted(beside, key=lambda node: len(beside[node])))  # open ends first
    while left:
        chain = [next(iter(left))]
        while chain[-1] in left:
            del left[chain[-1]]
            onward = [node for node in beside[chain[-1]] if node in left]
            chain += onward[:1]
        if len(chain) > 2 and chain[0] in beside[chain[-1]]:
            chain.append(chain[0])
        chains.append(chain)
    return chains
