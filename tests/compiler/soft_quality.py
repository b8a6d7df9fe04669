"""What a test of soft bodies looks for: faults of their surfaces, and the tetrahedra that the engine will cut them into."""

from contextlib import chdir
from dataclasses import dataclass
from functools import lru_cache
from tempfile import TemporaryDirectory

import numpy as np

from text2sim.compiler.shapes.softmesh import SoftMesh, tet_options
from text2sim.spec_schema.errors import AssetError

MIN_RATIO, MIN_DIHEDRAL = 1.1, 10
"""The engine's bounds for tetgen: radius of the sphere around a tetrahedron over its shortest edge, and the smallest
angle [deg] between two of its faces."""
MAX_TETS = 2_000_000
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


def signed_volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the volume [m3] that a closed surface encloses; negative if it is inside out."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("nk,nk->", a, np.cross(b, c)) / 6)


@lru_cache(maxsize=64)
def surface_faults(mesh: SoftMesh, *, thin: bool = True) -> Faults:
    """Look for what is wrong with a surface.

    Args:
        mesh: The surface.
        thin: Whether its thickness is measured, by rays.
    """
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


def _thickness(vertices: np.ndarray, faces: np.ndarray, areas: np.ndarray) -> float:
    """How far it is to the other side, straight into the solid from the middles of triangles."""
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


@dataclass(frozen=True, eq=False)
class Tets:
    """Tetrahedra, and how good they are."""

    vertices: np.ndarray
    """(n, 3) float64 [m]; those of the surface come first, in their order"""
    tets: np.ndarray
    """(m, 4) int32"""
    worst: float
    """Radius ratio of the worst: three times the inner radius over the outer, 1 if regular and 0 if flat."""
    mean: float
    """Mean radius ratio."""
    sharpest_deg: float
    """Smallest angle [deg] between two faces of a tetrahedron."""
    shortest: float
    """Shortest edge [m]: it bounds the time step of an explicit solver."""
    smallest: float
    """Volume [m3] of the smallest."""

    @property
    def count(self) -> int:
        """How many."""
        return len(self.tets)


def tetrahedralise(mesh: SoftMesh, edge: float) -> Tets:
    """Cut a closed surface into tetrahedra, with the switches that the engine gives tetgen for `tet_options`.

    Args:
        mesh: The surface.
        edge: Wanted length [m] of their edges.

    Raises:
        AssetError: if tetgen cannot, which it can not where a surface cuts through itself, or if there are too many.
    """
    return _cut(mesh, float(edge))


@lru_cache(maxsize=16)
def _cut(mesh: SoftMesh, edge: float) -> Tets:
    import tetgen

    options = tet_options(edge)
    expected = signed_volume(mesh.vertices, mesh.faces) / options["maxvolume"]
    if expected > MAX_TETS:
        raise AssetError(
            f"with elements of {edge:g} m it would have more than {expected:,.0f} tetrahedra; at most {MAX_TETS:,} "
            f"are possible: take a larger `cell`"
        )
    switches = f"pq{MIN_RATIO}/{MIN_DIHEDRAL}a{options['maxvolume']}YQ"  # Q: quiet
    try:
        made = tetgen.TetGen(np.array(mesh.vertices), np.array(mesh.faces, np.int32))
        with TemporaryDirectory() as folder, chdir(folder):  # it leaves files about what it skipped where it stands
            vertices, tets, *_ = made.tetrahedralize(switches=switches)
    except Exception as error:  # what tetgen raises is a RuntimeError with few words
        raise AssetError(
            f"cannot be cut into tetrahedra ({str(error)[:120]}): its surface must be closed and not cut through itself"
        ) from error
    if len(tets) == 0:
        raise AssetError("cannot be cut into tetrahedra: its surface must be closed and not cut through itself")
    vertices, tets = _split(np.asarray(vertices, float), np.asarray(tets, np.int32))
    ratios, angles, lengths, volumes = quality(vertices, tets)
    return Tets(
        vertices,
        tets,
        float(ratios.min()),
        float(ratios.mean()),
        float(np.degrees(angles.min())),
        float(lengths.min()),
        float(volumes.min()),
    )


def _split(vertices: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Divide tetrahedra with all corners on the surface in four, as the engine does: sap's contact needs an inside."""
    faces = np.sort(tets[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    unique, counts = np.unique(faces, axis=0, return_counts=True)
    outer = np.zeros(len(vertices), bool)
    outer[unique[counts == 1]] = True
    bad = outer[tets].all(axis=1)
    if not bad.any():
        return vertices, tets
    added = vertices[tets[bad]].mean(axis=1)
    fifth = np.arange(len(added)) + len(vertices)
    a, b, c, d = tets[bad].T
    pieces = [(a, b, c, fifth), (a, b, fifth, d), (a, fifth, c, d), (fifth, b, c, d)]
    new = np.stack([np.stack(piece, axis=1) for piece in pieces], axis=1).reshape(-1, 4)
    return np.concatenate([vertices, added]), np.concatenate([tets[~bad], new]).astype(np.int32)


def quality(vertices: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return radius ratio, smallest angle between faces [rad], shortest edge [m] and volume [m3] of tetrahedra.

    The radius of the inner sphere is 3 V / A, with the area A of all faces. That of the outer one is
    sqrt(s (s - a) (s - b) (s - c)) / (6 V), with a, b, c the products of opposite edges and s half their sum.
    """
    corners = vertices[tets]
    p = [corners[:, k] for k in range(4)]
    edges = {(i, j): p[j] - p[i] for i in range(4) for j in range(i + 1, 4)}
    long = {key: np.linalg.norm(edge, axis=1) for key, edge in edges.items()}
    volumes = np.einsum("nk,nk->n", edges[0, 1], np.cross(edges[0, 2], edges[0, 3])) / 6
    normals = []
    for k in range(4):
        a, b, c = (q for q in range(4) if q != k)
        normal = np.cross(p[b] - p[a], p[c] - p[a])
        inward = np.einsum("nk,nk->n", normal, p[k] - p[a]) > 0
        normals.append(np.where(inward[:, None], -normal, normal))
    areas = [np.linalg.norm(normal, axis=1) / 2 for normal in normals]
    inner = 3 * np.abs(volumes) / np.maximum(sum(areas), 1e-300)
    a, b, c = long[0, 1] * long[2, 3], long[0, 2] * long[1, 3], long[0, 3] * long[1, 2]
    s = (a + b + c) / 2
    outer = np.sqrt(np.maximum(s * (s - a) * (s - b) * (s - c), 0)) / np.maximum(6 * np.abs(volumes), 1e-300)
    angles = np.full(len(tets), np.pi)
    for i in range(4):
        for j in range(i + 1, 4):
            size = np.maximum(4 * areas[i] * areas[j], 1e-300)
            cosine = -np.einsum("nk,nk->n", normals[i], normals[j]) / size
            angles = np.minimum(angles, np.arccos(np.clip(cosine, -1, 1)))
    shortest = np.min(np.stack(list(long.values())), axis=0)
    return 3 * inner / np.maximum(outer, 1e-300), angles, shortest, np.abs(volumes)
