"""Smooth surfaces to draw for shapes that touch by pieces, so that films show no staves."""

import hashlib
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.assets.answer_cache import cached_answer
from text2sim.compiler.shapes.hulls import hull_of
from text2sim.compiler.shapes.rings import Point, profile_corners
from text2sim.compiler.shapes.rotation import Quaternion, Vec, quat_to_rows
from text2sim.spec_schema.models.faceted import Faceted
from text2sim.spec_schema.models.shapes import (
    Box,
    Capsule,
    Cone,
    Cup,
    Cylinder,
    Ellipsoid,
    Funnel,
    Sphere,
    Stream,
    Torus,
    Tube,
)

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

SIDES = 64
BAR_SIDES = 32


@dataclass(frozen=True, eq=False)
class VisualMesh:
    """A closed surface in the body's frame; on sharp edges, vertices occur twice, each with its own normal."""

    vertices: "np.ndarray"
    """(n, 3) float [m]."""
    faces: "np.ndarray"
    """(m, 3) int, counterclockwise from outside"""
    normals: "np.ndarray"
    """(n, 3) float, unit length."""
    part: str | None = None
    """Of a compound: name of the part."""
    uvs: "np.ndarray | None" = None
    """(n, 2) float: place of each vertex in the picture."""
    picture: bytes | None = None
    """A .png that is drawn on it."""
    rgba: tuple[float, float, float, float] | None = None
    """Its own colour."""

    @cached_property
    def digest(self) -> str:
        """Hash of the surface to a tenth of a micrometre: equal surfaces share one file."""
        import numpy as np

        content = hashlib.sha256()
        with np.errstate(invalid="ignore"):  # the lint reports sizes that are not finite
            content.update((np.round(self.vertices * 1e7).astype("<i8")).tobytes())
        content.update(self.faces.astype("<i4").tobytes())
        if self.uvs is not None:
            content.update((np.round(self.uvs * 1e6).astype("<i8")).tobytes())
        return content.hexdigest()

    def at(self, pos: Vec, quat: Quaternion, part: str | None) -> "VisualMesh":
        """Return the surface in the frame around (`pos`, `quat`).

        Args:
            pos: Origin of the surface's present frame in the other one [m].
            quat: Orientation of that frame (w, x, y, z).
            part: Name of the part of the body that it becomes.
        """
        import numpy as np

        turn = np.array(quat_to_rows(quat)).T
        return replace(self, vertices=self.vertices @ turn + np.array(pos), normals=self.normals @ turn, part=part)

    def obj(self) -> str:
        """Return the surface as the text of an .obj file, with its normals."""
        import numpy as np

        lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in (self.vertices + 0.0).tolist()]
        lines += [f"vn {x:.5f} {y:.5f} {z:.5f}" for x, y, z in (np.round(self.normals, 5) + 0.0).tolist()]
        if self.uvs is None:
            lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in (self.faces + 1).tolist()]
        else:
            lines += [f"vt {u:.6g} {v:.6g}" for u, v in (self.uvs + 0.0).tolist()]
            lines += [f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}" for a, b, c in (self.faces + 1).tolist()]
        return "\n".join(lines) + "\n"


class LazyMesh(VisualMesh):
    """A surface that is made when its points are first read: a check only needs its digest.

    Args:
        make: Makes it.
        key: All that it depends on.
        part: Of a compound: name of the part.
    """

    key: str

    def __init__(self, make: Callable[[], VisualMesh], key: str, part: str | None = None) -> None:
        # The dataclass is frozen.
        self.__dict__.update(key=key, part=part, _make=make)

    @cached_property
    def _made(self) -> VisualMesh:
        return self.__dict__["_make"]()

    def __getattr__(self, name: str) -> Any:
        if name not in ("vertices", "faces", "normals"):
            raise AttributeError(name)
        return getattr(self._made, name)

    def at(self, pos: Vec, quat: Quaternion, part: str | None) -> VisualMesh:
        """Return the surface in the frame around (`pos`, `quat`).

        Args:
            pos: Origin of the surface's present frame in the other one [m].
            quat: Orientation of that frame (w, x, y, z).
            part: Name of the part of the body that it becomes.
        """
        return LazyMesh(lambda: self._made.at(pos, quat, part), f"{self.key} at {pos} {quat}", part)


def learn_digests(meshes: Iterable[VisualMesh]) -> None:
    """Give surfaces that are not yet made their digests from the cache, if it has them."""
    lazy = [mesh for mesh in meshes if isinstance(mesh, LazyMesh) and "digest" not in mesh.__dict__]
    if not lazy:
        return
    question = (b"surfaces", Path(__file__).read_bytes(), *(mesh.key.encode() for mesh in lazy))
    found = cached_answer(question, lambda: [mesh.digest for mesh in lazy])
    for mesh, digest in zip(lazy, found, strict=True):
        mesh.__dict__["digest"] = digest


Drawn = Box | Cylinder | Cone | Faceted | Torus | Tube | Cup | Funnel
"""Shapes with edges, which the engine would shade as if they were smooth."""


def surface(shape: Any) -> VisualMesh:
    """Return the surface of a shape, smooth where it is round and sharp at its edges."""
    return LazyMesh(lambda: _surface(shape), repr(shape))


def _surface(shape: Any) -> VisualMesh:
    if isinstance(shape, Box):
        return _box(shape)
    if isinstance(shape, Sphere | Stream | Ellipsoid | Capsule):
        return _egg(shape)
    if isinstance(shape, Torus):
        return _ring(shape)
    if isinstance(shape, Faceted):
        return _facets(shape)
    return _lathe(profile_corners(shape))


def _box(box: Box) -> VisualMesh:
    import numpy as np

    vertices, normals, faces = [], [], []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (-1.0, 1.0):
            normal = side * np.eye(3)[axis]
            first = len(vertices)
            vertices += [normal + side * a * u + b * v for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            normals += [normal] * 4
            faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return VisualMesh(np.array(vertices) * np.array(box.size) / 2, np.array(faces), np.array(normals))


def _facets(shape: Faceted) -> VisualMesh:
    import numpy as np

    hull, _ = hull_of(np.array(shape.points))
    normals = np.repeat(hull.face_normals, 3, axis=0)
    return VisualMesh(hull.triangles.reshape(-1, 3), np.arange(3 * len(hull.faces)).reshape(-1, 3), normals)


def _egg(shape: Sphere | Stream | Ellipsoid | Capsule) -> VisualMesh:
    """Turn a half circle about z, and stretch it to an ellipsoid or capsule."""
    import numpy as np

    ball = _lathe([(math.sin(a), -math.cos(a)) for a in np.linspace(0, math.pi, BAR_SIDES + 1).tolist()])
    points = ball.vertices / np.linalg.norm(ball.vertices, axis=1, keepdims=True)
    if isinstance(shape, Capsule):
        away = np.sign(points[:, 2:]) * (0, 0, shape.length / 2)
        return replace(ball, vertices=shape.radius * points + away, normals=points)
    radii = np.array(shape.radii if isinstance(shape, Ellipsoid) else (shape.radius,) * 3)
    normals = points / radii
    return replace(ball, vertices=points * radii, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True))


def rings(rows: "np.ndarray | Sequence[Point]", sides: int) -> "np.ndarray":
    """Turn points of a profile, or its normals, about z.

    Args:
        rows: Radial and vertical component of each, shape (n, 2).
        sides: Number of points around each ring.

    Returns:
        Points, counterclockwise from above, shape (n, sides, 3).
    """
    import numpy as np

    angles = np.linspace(0, 2 * math.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    out, up = np.split(np.array(rows, float)[:, None], 2, axis=2)
    return np.concatenate([out * circle, np.repeat(up, sides, axis=1)], axis=2)


def bands(around: "np.ndarray", radii: Iterable[float]) -> "np.ndarray":
    """Return the triangles between each ring and the next; a ring without radius is a point.

    Args:
        around: What the rings are made of, points or their numbers, shape (n, sides, …).
        radii: Their radii, (n,).

    Returns:
        Corners, counterclockwise from outside if the rings go up on the outside, shape (m, 3, …).
    """
    import numpy as np

    found = []
    for (low, r_low), (high, r_high) in pairwise(zip(around, radii, strict=True)):
        low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
        found += [np.stack([low, low_next, high_next], axis=1)] if r_low > 0 else []
        found += [np.stack([low, high_next, high], axis=1)] if r_high > 0 else []
    return np.concatenate(found)


def _lathe(profile: list[Point]) -> VisualMesh:
    """Turn a profile (radius, height) about z, the solid on its left; smooth around z, sharp at corners."""
    import numpy as np

    ends, slopes = [], []
    for (r0, z0), (r1, z1) in pairwise(profile):
        length = math.hypot(r1 - r0, z1 - z0)
        ends += [(r0, z0), (r1, z1)]
        slopes += [((z1 - z0) / length, (r0 - r1) / length)] * 2
    pairs = np.arange(len(ends) * SIDES).reshape(-1, 2, SIDES)
    faces = [bands(pair, (a[0], b[0])) for pair, (a, b) in zip(pairs, pairwise(profile), strict=True)]
    return VisualMesh(rings(ends, SIDES).reshape(-1, 3), np.concatenate(faces), rings(slopes, SIDES).reshape(-1, 3))


def _ring(torus: Torus) -> VisualMesh:
    import numpy as np

    slopes = rings([(1.0, 0.0)], BAR_SIDES)[0, :, :2]
    bar = (torus.radius, 0.0) + torus.bar_radius * slopes
    vertices, normals = (rings(rows, SIDES).swapaxes(0, 1).reshape(-1, 3) for rows in (bar, slopes))
    a = np.arange(SIDES * BAR_SIDES).reshape(SIDES, BAR_SIDES)
    b, d = np.roll(a, -1, axis=0), np.roll(a, -1, axis=1)
    c = np.roll(b, -1, axis=1)
    faces = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    return VisualMesh(vertices, faces, normals)
