"""Report on a mesh: closedness, size, number of triangles, thickness of walls."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from text2sim.assets.surface import TriangleMesh

MAX_TRIANGLES = 200_000
"""Largest mesh in a case."""
MAX_SPECK = 0.02
"""Diagonal of a loose piece, as a part of that of the largest piece, below which it is a speck."""
THIN_WALL = 0.01
"""Thickness of a wall, as a part of the largest extent, below which it is thin."""
RAYS = 4000
MAX_SLIVER = 1e-3
"""Height of a triangle over its longest side, below which it is a sliver."""
MAX_PLAUSIBLE_EXTENT, MIN_PLAUSIBLE_EXTENT = 10.0, 0.01
"""Extents [m] beyond which a mesh is probably not in metres."""


@dataclass(frozen=True)
class MeshReport:
    """Properties of a mesh file."""

    file: str
    bytes: int
    vertices: int
    """Distinct positions; a file has several vertices for one on a seam."""
    triangles: int
    extent: tuple[float, float, float]
    """Extent [m], z up."""
    watertight: bool
    """Whether every edge has two triangles that face the same side."""
    winding: str
    """`outwards`, `inwards`, or `mixed`."""
    volume: float | None
    """Volume [m3]; None if it encloses none."""
    area: float
    """Area [m2]."""
    components: int
    """Connected pieces."""
    specks: int
    """Tiny pieces among them."""
    open_edges: int
    knots: int
    """Edges of more than two triangles."""
    slivers: int
    """Triangles that are nearly lines."""
    thickness: float | None
    """Thickness [m] that 95 % of the wall exceeds; None if it is not closed."""
    textured: bool
    problems: tuple[str, ...]
    """Problems that prevent its use, in words."""
    notes: tuple[str, ...]
    """Other remarks."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def report(surface: TriangleMesh, name: str, size: int, notes: tuple[str, ...] = ()) -> MeshReport:
    """Return a report on a surface.

    Args:
        surface: The surface.
        name: Name of its file.
        size: Bytes of its file.
        notes: Earlier remarks.
    """
    count, _ = surface.components
    volumes = surface.volumes()
    thickness = wall_thickness(surface) if surface.watertight else None
    x, y, z = (float(length) for length in surface.extent)
    winding = "mixed" if not surface.coherent else "inwards" if volumes.sum() < 0 else "outwards"
    return MeshReport(
        file=name,
        bytes=size,
        vertices=len(np.unique(surface.faces)),
        triangles=len(surface.faces),
        extent=(x, y, z),
        watertight=surface.watertight,
        winding=winding,
        volume=float(volumes.sum()) if surface.watertight and volumes.sum() > 0 else None,
        area=float(surface.areas().sum()),
        components=count,
        specks=_specks(surface),
        open_edges=surface.edge_counts[0],
        knots=surface.edge_counts[1],
        slivers=_slivers(surface),
        thickness=thickness,
        textured=any(paint.picture is not None for paint in surface.paints),
        problems=tuple(faults(surface)),
        notes=(*notes, *_remarks(surface, thickness)),
    )


def faults(surface: TriangleMesh) -> list[str]:
    """Return the problems that prevent using a surface as a body, in words."""
    found = []
    if surface.edge_counts[0]:
        found.append(f"is open: {surface.edge_counts[0]:,} edges have only one triangle")
    if surface.edge_counts[1]:
        found.append(f"more than two triangles meet on {surface.edge_counts[1]:,} edges")
    if not surface.coherent:
        found.append("its triangles do not agree on which side is outside")
    elif surface.watertight and surface.volumes().sum() <= 0:
        found.append("its triangles face inwards")
    if len(surface.faces) > MAX_TRIANGLES:
        found.append(f"has {len(surface.faces):,} triangles; a mesh in a case can have {MAX_TRIANGLES:,}")
    if surface.flat:
        found.append("is flat: it may be a cloth or a picture, but not a body")
    if specks := _specks(surface):
        found.append(f"has {specks:,} tiny loose pieces")
    return found


def _remarks(surface: TriangleMesh, thickness: float | None) -> list[str]:
    found, largest = [], float(surface.extent.max())
    if largest > MAX_PLAUSIBLE_EXTENT or largest < MIN_PLAUSIBLE_EXTENT:
        found.append(
            f"is {largest:.3g} m {'large' if largest > MAX_PLAUSIBLE_EXTENT else 'small'}; give its size if that is "
            "wrong"
        )
    if thickness is not None and thickness < THIN_WALL * largest:
        found.append(f"has thin walls: {thickness:.2g} m; a soft body of it needs finer cells than that")
    count, _ = surface.components
    if count > 1:
        found.append(f"has {count} separate pieces")
    return found


def _specks(surface: TriangleMesh) -> int:
    length = surface.diagonals_of_components()
    return int((length < MAX_SPECK * length.max()).sum())


def _slivers(surface: TriangleMesh) -> int:
    corners = surface.vertices[surface.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return int((2 * surface.areas() < MAX_SLIVER * longest**2).sum())


def wall_thickness(surface: TriangleMesh) -> float | None:
    """Return the thickness [m] that 95 % of a closed surface exceed; None if no ray hit a wall.

    Rays start inwards from points that are spread evenly over the surface.
    """
    import trimesh

    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    areas = surface.areas()
    steps = (np.arange(RAYS) + 0.5) / RAYS * areas.sum()
    chosen = np.minimum(np.searchsorted(np.cumsum(areas), steps), len(areas) - 1)
    rng = np.random.default_rng(0)
    weights = rng.dirichlet((1.0, 1.0, 1.0), RAYS)
    corners = surface.vertices[surface.faces[chosen]]
    places = (corners * weights[:, :, None]).sum(axis=1)
    inwards = -surface.area_vectors[chosen]
    length = np.linalg.norm(inwards, axis=1)
    good = length > 0
    places, inwards = places[good], inwards[good] / length[good][:, None]
    start = places + 1e-5 * surface.diagonal * inwards
    hits, rays, _ = mesh.ray.intersects_location(start, inwards, multiple_hits=False)
    if not len(rays):
        return None
    return float(np.percentile(np.linalg.norm(hits - places[rays], axis=1), 5))
