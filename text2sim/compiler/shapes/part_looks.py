"""Looks of the parts of a deformable body: which part gives each triangle of its surface its look."""

from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.rotation import quat_of, quat_to_rows
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

    from text2sim.compiler.shapes.softmesh import SoftMesh

SAMPLE_SPACING = 0.5
"""Distance of the samples of parts, in edges of the surface."""


def part_looks(shape: Compound | Sculpt, mesh: "SoftMesh", folder: Path, edge: float) -> Callable[[], bytes]:
    """Return a function that makes an .npz file with the part whose look each triangle has.

    It holds `centers` (f, 3) [m] of triangles, and their `parts` (f,). A check does not call it: its imports alone take
    a quarter of a second.

    Parts are numbered in the shape's order; -1 stands for the body itself. Whoever draws the surface finds its
    triangles by their centers, since solvers may number them differently.

    Args:
        shape: The shape, some parts of which have a look of their own.
        mesh: Its surface.
        folder: The case's folder.
        edge: Length of the surface's edges [m].

    Raises:
        AssetError: if the surface of a part cannot be made.
    """
    import numpy as np

    samples, parts = zip(*_samples(shape, folder, SAMPLE_SPACING * edge), strict=True)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    owners = np.concatenate([np.full(len(some), part) for some, part in zip(samples, parts, strict=True)])

    def make() -> bytes:
        from scipy.spatial import KDTree

        _, nearest = KDTree(np.concatenate(samples)).query(centers)
        file = BytesIO()
        np.savez(file, centers=centers.astype(np.float32), parts=owners[nearest].astype(np.int16))
        return file.getvalue()

    return make


def _samples(shape: Compound | Sculpt, folder: Path, step: float) -> "Iterator[tuple[np.ndarray, int]]":
    """Yield points on the surface of each part (n, 3) [m], and the part's number, or -1 if it has no look."""
    import numpy as np

    from text2sim.compiler.shapes.remesh import split_long_edges
    from text2sim.compiler.shapes.sculpting import sculpted
    from text2sim.compiler.shapes.softmesh import soft_surface

    names = list(shape.parts)
    if isinstance(shape, Sculpt):
        for drawn in sculpted(shape).visuals():
            vertices, faces, _ = split_long_edges(np.asarray(drawn.vertices, float), np.asarray(drawn.faces), step)
            yield vertices[faces].mean(axis=1), -1 if drawn.part is None else names.index(drawn.part)
        return
    for name, part in shape.solids.items():
        mesh = soft_surface(part.shape, folder, step, coarsen=False)
        turn = np.array(quat_to_rows(quat_of(part.pose))).T
        centers = mesh.vertices[mesh.faces].mean(axis=1) @ turn + np.array(part.pose.pos)
        yield centers, -1 if part.look is None else names.index(name)
