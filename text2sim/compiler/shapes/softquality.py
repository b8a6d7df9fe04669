"""What is wrong with a surface that is to become a soft body: holes, folds, sides turned inside out, thin parts."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from text2sim.compiler.shapes.softmesh import SoftMesh

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

RAYS = 2_000
"""Places at which the thickness is measured."""
THIN_PART = 0.02
"""This part of the surface may be thinner than what counts as the thinnest: every edge and tip is thin."""


@dataclass(frozen=True)
class Faults:
    """What was found."""

    open_edges: int
    """Edges with one triangle: the border of holes, or of a cloth."""
    crowded_edges: int
    """Edges with more than two triangles."""
    turned_edges: int
    """Edges whose two triangles look to opposite sides."""
    flat: int
    """Triangles without area."""
    loose: int
    """Connected parts."""
    volume: float
    """Volume [m3] inside; negative if the surface is inside out."""
    thickness: float | None
    """Thickness [m] of the thinnest parts (all but a fiftieth of the surface is thicker); None if it is open."""

    @property
    def closed(self) -> bool:
        """Whether it encloses a volume: no border, no folds, outside out."""
        return not (self.open_edges or self.crowded_edges or self.turned_edges) and self.volume > 0


def signed_volume(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    """Return the volume [m3] that a closed surface encloses; negative if it is inside out."""
    import numpy as np

    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("nk,nk->", a, np.cross(b, c)) / 6)


@lru_cache(maxsize=64)
def surface_faults(mesh: SoftMesh, *, thin: bool = True) -> Faults:
    """Look for what is wrong with a surface.

    Args:
        mesh: The surface.
        thin: Whether its thickness is measured, by rays.
    """
    import numpy as np
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    count = len(vertices)
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    keys, index, number = np.unique(low * count + high, return_inverse=True, return_counts=True)
    # Neighbours that agree go along their edge in opposite ways.
    ways = np.bincount(index.reshape(-1), weights=np.where(ends[:, 0] < ends[:, 1], 1, -1), minlength=len(keys))
    a, b, c = vertices[faces].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    links = coo_matrix((np.ones(len(low)), (low, high)), shape=(count, count))
    used = np.unique(faces)
    _, labels = connected_components(links, directed=False)
    open_edges, crowded = int((number == 1).sum()), int((number > 2).sum())
    volume = signed_volume(vertices, faces)
    whole = not open_edges and not crowded and volume > 0
    return Faults(
        open_edges=open_edges,
        crowded_edges=crowded,
        turned_edges=int(((number == 2) & (ways != 0)).sum()),
        flat=int((areas <= 1e-12 * max(float(areas.max(initial=0.0)), 1e-300)).sum()),
        loose=len(np.unique(labels[used])),
        volume=volume,
        thickness=_thickness(vertices, faces, areas) if thin and whole else None,
    )


def _thickness(vertices: "np.ndarray", faces: "np.ndarray", areas: "np.ndarray") -> float:
    """How far it is to the other side, straight into the solid from the middles of triangles."""
    import numpy as np
    import trimesh

    # Each triangle stands for its area: equal steps along the sum of all areas.
    run = np.cumsum(areas)
    chosen = np.unique(np.searchsorted(run, (np.arange(RAYS) + 0.5) / RAYS * run[-1]))
    a, b, c = vertices[faces[chosen]].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    size = float(np.ptp(vertices, axis=0).max())
    starts = (a + b + c) / 3 - normals * (1e-5 * size)
    solid = trimesh.Trimesh(vertices, faces, process=False)
    hits, rays, _ = solid.ray.intersects_location(starts, -normals, multiple_hits=False)
    if len(hits) == 0:
        return 0.0
    lengths = np.linalg.norm(hits - starts[rays], axis=1) + 1e-5 * size
    weights = areas[chosen][rays]
    order = np.argsort(lengths)
    share = np.cumsum(weights[order]) / weights.sum()
    return float(lengths[order][np.searchsorted(share, THIN_PART)])
