"""The surface of convex pieces, as triangles and as points spread over these."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Quaternion, Vec, quat_to_rows
from text2sim.compiler.shapes.surface import bands, rings

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

SIDES = 64
RINGS = 32
POINTS_ALONG = 24
"""About how many points lie along the longest side of a body."""

_BOX = (
    (0, 3, 2), (0, 1, 3), (4, 7, 5), (4, 6, 7), (0, 5, 1), (0, 4, 5),
    (2, 7, 6), (2, 3, 7), (0, 6, 4), (0, 2, 6), (1, 7, 3), (1, 5, 7),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SurfaceSkin:
    """A surface in its body's frame."""

    triangles: "np.ndarray"
    """(n, 3, 3) float [m]"""

    @cached_property
    def bounds(self) -> "tuple[np.ndarray, np.ndarray]":
        """Lowest and highest corner [m]."""
        corners = self.triangles.reshape(-1, 3)
        return corners.min(0), corners.max(0)

    @cached_property
    def samples(self) -> "tuple[np.ndarray, np.ndarray]":
        """Points (k, 3) [m] of all triangles, corners included, and the area [m2] that each stands for."""
        import numpy as np

        from text2sim.assets.surface import triangle_areas

        low, high = self.bounds
        spacing = float((high - low).max()) / POINTS_ALONG
        sides = np.linalg.norm(self.triangles - np.roll(self.triangles, 1, axis=1), axis=2).max(1)
        steps = np.maximum(np.ceil(sides / spacing - 1e-9), 1).astype(int)
        areas = triangle_areas(self.triangles)
        points, weights = [], []
        for n in np.unique(steps):
            chosen = steps == n
            mix = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
            points.append(np.einsum("kc,tcx->tkx", mix, self.triangles[chosen]).reshape(-1, 3))
            weights.append(np.repeat(areas[chosen] / len(mix), len(mix)))
        return np.concatenate(points), np.concatenate(weights)

    def nearest(self, point: Vec) -> "tuple[np.ndarray, float]":
        """Return the point [m] of the surface that is nearest to another, and its distance [m]."""
        import numpy as np

        found = _nearest_points(self.triangles, np.array(point, float))
        apart = np.linalg.norm(found - point, axis=1)
        best = int(apart.argmin())
        return found[best], float(apart[best])


def skin_of(pieces: Iterable[tuple[Piece, Vec, Quaternion]]) -> SurfaceSkin:
    """Return the surface of pieces, each with the pose [m] of its frame in the body's."""
    import numpy as np

    found = []
    for piece, pos, quat in pieces:
        own = np.array(quat_to_rows(piece.quat)).T, np.array(piece.pos)
        outer = np.array(quat_to_rows(quat)).T, np.array(pos)
        found.append((_triangles(piece) @ own[0] + own[1]) @ outer[0] + outer[1])
    return SurfaceSkin(np.concatenate(found))


def _triangles(piece: Piece) -> "np.ndarray":
    """Return triangles (n, 3, 3) [m] of a piece in its own frame."""
    import numpy as np

    size = piece.size
    if piece.kind in ("hull", "mesh"):
        return np.array(piece.vertices)[np.array(piece.faces)]
    if piece.kind == "box":
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2
        return corners[np.array(_BOX)]
    if piece.kind == "cylinder":
        half = size[1] / 2
        return _revolved([(0.0, -half), (size[0], -half), (size[0], half), (0.0, half)])
    angles = [math.pi * k / RINGS - math.pi / 2 for k in range(RINGS + 1)]
    half = size[1] / 2 if piece.kind == "capsule" else 0.0
    radius = 1.0 if piece.kind == "ellipsoid" else size[0]
    profile = [(radius * math.cos(a), radius * math.sin(a) + math.copysign(half, a)) for a in angles]
    if half:
        profile.insert(RINGS // 2, (radius, -half))
    profile[0], profile[-1] = (0.0, profile[0][1]), (0.0, profile[-1][1])
    return _revolved(profile) * (np.array(size) if piece.kind == "ellipsoid" else 1.0)


def _revolved(profile: list[tuple[float, float]]) -> "np.ndarray":
    """Return triangles of a profile (radius, height) turned about z."""
    return bands(rings(profile, SIDES), [r for r, _ in profile])


def _nearest_points(triangles: "np.ndarray", p: "np.ndarray") -> "np.ndarray":
    """Return the point of every triangle that is nearest to `p`: inside it, or on one of its sides."""
    import numpy as np

    a, b, c = (triangles[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    flat = p - normal * (np.einsum("ij,ij->i", p - a, normal) / square)[:, None]
    best, far = flat.copy(), np.zeros(len(flat))
    inside = np.ones(len(flat), bool)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, flat - u), normal) >= 0
    far[~inside] = np.inf
    far[inside] = np.linalg.norm(flat[inside] - p, axis=1)
    for u, v in ((a, b), (b, c), (c, a)):
        edge = v - u
        t = np.einsum("ij,ij->i", p - u, edge) / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
        on = u + np.clip(t, 0.0, 1.0)[:, None] * edge
        apart = np.linalg.norm(on - p, axis=1)
        nearer = apart < far
        best[nearer], far[nearer] = on[nearer], apart[nearer]
    return best
