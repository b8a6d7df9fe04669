"""Convex hulls of points; flat points get a thin hull, and very many are reduced to the outermost ones."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from text2sim.assets.answer_cache import cached_answer
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.base import Vec3

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

MANY_VERTICES = 20_000
"""With more vertices, only the outermost ones are used."""
FLATNESS = 1e-6
"""Thickness over length below which points count as flat."""


def hull_of(points: "np.ndarray") -> tuple[Any, bool]:
    """Return the convex hull of points as a mesh of trimesh, and whether they are flat.

    The hull of flat points is a little thicker than they are.

    Raises:
        AssetError: if they lie on a line.
    """
    import numpy as np
    import trimesh

    if len(points) > MANY_VERTICES:
        points = _outermost(points)
    size = np.ptp(points, axis=0)
    try:
        if size.min() > FLATNESS * size.max():
            return trimesh.Trimesh(points, process=False).convex_hull, False
    except Exception:  # flat, but along no axis
        pass
    middle = points.mean(axis=0)
    _, lengths, axes = np.linalg.svd(points - middle, full_matrices=False)
    if lengths[1] <= FLATNESS * lengths[0]:
        raise AssetError("has no area")
    across = axes[2]
    half = across * (FLATNESS * float(size.max()) / 2)
    try:
        return trimesh.Trimesh(np.concatenate([points - half, points + half]), process=False).convex_hull, True
    except Exception as error:
        raise AssetError("has no area") from error


def outward_hull(points: "np.ndarray", options: str | None = None) -> "tuple[np.ndarray, np.ndarray]":
    """Return which points are corners of their convex hull (k,), and the triangles between these corners (m, 3).

    Triangles are counterclockwise from outside. Qhull, whose options these are, raises `QhullError` for flat points.
    """
    import numpy as np
    from scipy.spatial import ConvexHull

    from text2sim.assets.surface import scaled_normals

    hull = ConvexHull(points, qhull_options=options)
    faces = hull.simplices.astype(np.int64)
    inward = np.einsum("ij,ij->i", scaled_normals(hull.points[faces]), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    corners, faces = np.unique(faces, return_inverse=True)
    return corners, faces.reshape(-1, 3)


def corners_and_sides(points: Sequence[Vec3]) -> "tuple[np.ndarray, np.ndarray]":
    """Return the convex hull of listed points [m]: vertices (n, 3) and triangles (m, 3).

    Raises:
        AssetError: if they lie on a line.
    """
    import numpy as np

    array = np.array(points)

    def make() -> "tuple[np.ndarray, np.ndarray]":
        hull, _ = hull_of(array)
        return np.asarray(hull.vertices), np.asarray(hull.faces)

    vertices, faces = cached_answer((b"hull", array.tobytes()), make)
    return vertices, faces


def _outermost(points: "np.ndarray") -> "np.ndarray":
    """Return the farthest of many points in each of some six thousand directions from their middle.

    Their hull is that of all points to a thousandth of the size, in a tenth of the time.
    """
    import numpy as np

    away = points - (points.min(axis=0) + points.max(axis=0)) / 2
    axis = np.abs(away).argmax(axis=1)
    row = np.arange(len(points))
    main = away[row, axis]
    others = away[row[:, None], np.stack([(axis + 1) % 3, (axis + 2) % 3], axis=1)]
    cells = np.floor(16 * (others / np.maximum(np.abs(main), 1e-300)[:, None] + 1)).astype(int).clip(0, 31)
    bucket = ((axis * 2 + (main > 0)) * 32 + cells[:, 0]) * 32 + cells[:, 1]
    order = np.lexsort((-(away**2).sum(axis=1), bucket))
    first = np.unique(bucket[order], return_index=True)[1]
    return points[np.union1d(order[first], np.concatenate([points.argmin(axis=0), points.argmax(axis=0)]))]
