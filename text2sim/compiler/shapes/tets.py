"""Tetrahedra of a solid, cut as the engine cuts them: how many there will be, and how good the worst one is."""

import math
from contextlib import chdir
from dataclasses import dataclass
from functools import lru_cache
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.softmesh import SoftMesh
from text2sim.spec_schema.errors import AssetError

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

MIN_RATIO, MIN_DIHEDRAL = 1.1, 10
"""The engine's bounds for tetgen: radius of the sphere around a tetrahedron over its shortest edge, and the smallest
angle [deg] between two of its faces. Both are aims: at sharp edges of the body they are not reached."""
REGULAR = 1 / (6 * math.sqrt(2))
"""Volume of a regular tetrahedron of edge 1."""
MAX_TETS = 2_000_000


def tet_options(edge: float) -> dict[str, Any]:
    """Return the options of a morph that let the engine cut a body into tetrahedra with edges of about `edge` [m].

    The surface has such edges already (`soft_surface`), and stays as it is: so all tetrahedra together become better
    than where tetgen divides it, too. Most are smaller than the largest that is allowed; their edges are, in the
    mean, 0.8 to 1 of the wanted one.
    """
    return {"maxvolume": float(f"{REGULAR * edge**3:.4g}"), "nobisect": True}


@dataclass(frozen=True, eq=False)
class Tets:
    """Tetrahedra, and how good they are."""

    vertices: "np.ndarray"
    """(n, 3) float64 [m]; those of the surface come first, in their order"""
    tets: "np.ndarray"
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
    import numpy as np
    import tetgen

    from text2sim.compiler.shapes.softquality import signed_volume

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


def _split(vertices: "np.ndarray", tets: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
    """Divide tetrahedra with all corners on the surface in four, as the engine does: sap's contact needs an inside."""
    import numpy as np

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


def quality(vertices: "np.ndarray", tets: "np.ndarray") -> "tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]":
    """Return radius ratio, smallest angle between faces [rad], shortest edge [m] and volume [m3] of tetrahedra.

    The radius of the inner sphere is 3 V / A, with the area A of all faces. That of the outer one is
    sqrt(s (s - a) (s - b) (s - c)) / (6 V), with a, b, c the products of opposite edges and s half their sum.
    """
    import numpy as np

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
