"""Deformation of bodies: volume, stretch, strain, inverted tetrahedra."""

from collections.abc import Callable
from typing import Any

import numpy as np

from text2sim.recording.deformables import RecordedDeformable, frame_spans
from text2sim.recording.states import Array

NEIGHBOURS = (20, 40, 80)
"""Nearest points that give the deformation around a particle; more where these lie nearly in a plane."""
FLATNESS = 1e-2
"""Neighbours lie in a plane if their spread across it is less than this part of that along it (squared)."""


class DeformationError(ValueError):
    """Error: a body lacks what a quantity needs, such as an interior or edges."""


def stretches(body: RecordedDeformable) -> Array:
    """Return the length of every edge over its length in the first frame, shape (F, e).

    Edges are the threads of a cloth as its solver has them, or the sides of the triangles of the surface.

    Raises:
        DeformationError: if the body has neither.
    """
    if body.edges is not None:
        pairs, points = body.edges, body.points
    else:
        faces, points = triangles(body)
        pairs = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    if len(points):
        pairs = pairs[(points[0, pairs[:, 0]] != points[0, pairs[:, 1]]).any(axis=1)]
    ratio = np.empty((len(points), len(pairs)), np.float32)
    for span in frame_spans(points, len(pairs)):
        x = np.ascontiguousarray(points[span].transpose(2, 0, 1))
        ratio[span] = np.sqrt(sum((side[:, pairs[:, 1]] - side[:, pairs[:, 0]]) ** 2 for side in x))
    return ratio / ratio[:1]


def triangles(body: RecordedDeformable) -> tuple[Array, Array]:
    """Return the triangles of a body (f, 3), and the points (F, n, 3) that they index.

    Raises:
        DeformationError: if it has none.
    """
    if body.net is None:
        raise DeformationError(f"{body.body} is {body.kind}: it has no surface, only particles")
    faces, own = body.net
    return faces, body.points if own else body.seen


def volumes(body: RecordedDeformable) -> Array:
    """Return the volume [m3] of a body, shape (F,): of its tetrahedra, or inside its closed surface.

    V = sum of a.(b x c) / 6 over outward triangles (a, b, c: corners about the middle), which is the divergence theorem
    for the field x / 3, or, without a surface, over tetrahedra (a, b, c: edges from a corner).

    Raises:
        DeformationError: if it has neither.
    """
    if body.faces is None and body.tets is not None:
        return sum_over_tets(body, lambda volume, start: (volume.T * np.sign(start)).sum(axis=1, dtype=float))
    if body.faces is None:
        raise DeformationError(f"{body.body} is {body.kind}: it has no surface, only particles")
    seen, faces = body.seen, body.faces
    if not len(seen):
        return np.zeros(0)
    if not closed(seen[0].astype(float), faces):
        raise DeformationError(f"the surface of {body.body} is not closed: it has no inside")

    parts = []
    for span in frame_spans(seen, len(faces)):
        x = seen[span] - seen[span].mean(axis=1, keepdims=True)  # centred, to keep precision
        corners = np.ascontiguousarray(x.transpose(2, 1, 0))
        parts.append(_triple(*(corners[:, faces[:, k]] for k in range(3))).sum(axis=0, dtype=float) / 6)
    return np.abs(np.concatenate(parts))


def inverted(body: RecordedDeformable) -> Array | None:
    """Return the fraction of the initial volume whose tetrahedra are inverted, shape (F,).

    None if the body has no tetrahedra.
    """
    if body.tets is None:
        return None

    def turned(volume: Array, start: Array) -> Array:
        return (np.abs(start) / np.abs(start).sum()) @ (volume * np.sign(start)[:, None] < 0)

    return sum_over_tets(body, turned)


def strains(body: RecordedDeformable) -> Array:
    """Return the equivalent strain of every tetrahedron or particle, shape (F, n).

    E = (F^T F - 1) / 2 (Green-Lagrange), E' its deviator, and e = sqrt(2/3 E':E') (von Mises): equal to the axial
    strain of a bar in small isochoric tension. F maps the initial edges of a tetrahedron to the current ones; for a
    particle it is the least-squares fit over its nearest initial neighbours.

    Raises:
        DeformationError: if the body has no volume elements.
    """
    if body.tets is None and body.kind == "cloth":
        raise DeformationError(f"{body.body} is cloth, which has no inside: measure its `stretch`")
    points = body.points
    gradient = tet_gradient(body.rest, body.tets) if body.tets is not None else particle_gradient(body.rest)
    if not gradient.shape[0]:
        raise DeformationError(f"the points of {body.body} are too few, or lie in a plane")
    found = np.empty((len(points), gradient.shape[0] // 3), np.float32)
    for span in frame_spans(points, gradient.shape[0] // 3):
        x = points[span].astype(np.float32)
        x = (x - x[:, :1]).transpose(1, 2, 0)  # centred, to keep precision
        # (3n, p) times (p, 3F): the derivatives of all frames in one product.
        f = gradient @ x.reshape(len(x), -1)
        found[span] = _equivalent(f.reshape(-1, 3, 3, x.shape[2])).T
    return found


def tet_gradient(rest: Array, tets: Array) -> Any:
    """Return the sparse matrix (3t, p) that maps points x to dx/dX: row 3 t + j is the derivative along X_j."""
    edge = np.stack([rest[tets[:, k]] - rest[tets[:, 0]] for k in (1, 2, 3)], axis=1)
    whole = np.abs(np.linalg.det(edge)) > 1e-18
    tets, inverse = tets[whole], np.linalg.inv(edge[whole])  # dX = E c, so c = E^-1 dX: (t, 3, 3), [t, j, k]
    weights = np.concatenate([-inverse.sum(axis=2, keepdims=True), inverse], axis=2)
    return _sparse(weights, tets, len(rest))


def particle_gradient(rest: Array) -> Any:
    """Return the sparse matrix (3n, p) that fits dx/dX around points to their neighbours, weighted by proximity.

    The least-squares solution of x_i - x = F (X_i - X) is F = (sum w dx dX^T) (sum w dX dX^T)^-1. Points whose
    neighbours are all coplanar are left out.
    """
    from scipy.sparse import csr_matrix, vstack
    from scipy.spatial import KDTree

    left, tree, parts = np.arange(len(rest)), KDTree(rest), []
    for wanted in NEIGHBOURS:
        if not len(left) or len(rest) < 5:
            break
        near = np.asarray(tree.query(rest[left], min(wanted, len(rest)))[1])[:, 1:]
        d = rest[near] - rest[left][:, None]
        size = (d * d).sum(axis=2)
        weight = np.exp(-size / np.maximum(size.mean(axis=1, keepdims=True), 1e-30))
        moment = np.einsum("nk,nki,nkj->nij", weight, d, d)
        spread = np.linalg.eigvalsh(moment)
        sound = spread[:, 0] > FLATNESS * np.maximum(spread[:, 2], 1e-30)
        w = np.einsum("nij,nkj,nk->nik", np.linalg.inv(moment[sound]), d[sound], weight[sound])
        weights = np.concatenate([-w.sum(axis=2, keepdims=True), w], axis=2)
        parts.append(_sparse(weights, np.concatenate([left[sound][:, None], near[sound]], axis=1), len(rest)))
        left = left[~sound]
    return vstack(parts, format="csr") if parts else csr_matrix((0, len(rest)))


def _sparse(weights: Array, columns: Array, width: int) -> Any:
    """Return weights (n, 3, k) of the points `columns` (n, k) as a sparse matrix (3n, width)."""
    from scipy.sparse import csr_matrix

    n, _, k = weights.shape
    wide = np.repeat(columns[:, None], 3, axis=1).ravel()
    return csr_matrix((weights.astype(np.float32).ravel(), wide, np.arange(0, 3 * n * k + 1, k)), shape=(3 * n, width))


def _equivalent(f: Array) -> Array:
    """Return the equivalent strain (n, F) of deformation gradients (n, j, i, F), derivatives of x_i along X_j."""

    def product(j: int, k: int) -> Array:
        return (f[:, j, 0] * f[:, k, 0] + f[:, j, 1] * f[:, k, 1] + f[:, j, 2] * f[:, k, 2]) / 2

    own = [product(k, k) for k in range(3)]  # E + 1/2
    mean = (own[0] + own[1] + own[2]) / 3
    square = (own[0] - mean) ** 2 + (own[1] - mean) ** 2 + (own[2] - mean) ** 2
    for j, k in ((0, 1), (0, 2), (1, 2)):
        square += 2 * product(j, k) ** 2
    return np.sqrt(2 / 3 * square)


def closed(points: Array, faces: Array) -> bool:
    """Return whether triangles enclose a volume: every edge belongs to two, once in each direction.

    Coincident points count as one: a surface has duplicates along texture seams.
    """
    size = max(float(np.ptp(points, axis=0).max()), 1e-9)
    _, same = np.unique(np.round(points / size * 1e6).astype(np.int64), axis=0, return_inverse=True)
    own = same.reshape(-1)[faces]
    own = own[(own[:, 0] != own[:, 1]) & (own[:, 1] != own[:, 2]) & (own[:, 2] != own[:, 0])]
    sides = own[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key = sides.min(axis=1) * (own.max(initial=0) + 1) + sides.max(axis=1)
    order = np.argsort(key, kind="stable")
    key, direction = key[order], np.where(sides[:, 0] < sides[:, 1], 1, -1)[order]
    begins = np.flatnonzero(np.diff(key, prepend=-1))
    return len(own) > 0 and not np.add.reduceat(direction, begins).any()


def sum_over_tets(body: RecordedDeformable, of: Callable[[Array, Array], Array]) -> Array:
    """Apply a function to the signed volumes [m3] of the tetrahedra, (t, F), and the initial ones, (t,)."""
    points, tets = body.points, body.tets
    assert tets is not None
    start = _tet_volumes(body.rest.T[..., None], tets)[:, 0]
    parts = []
    for span in frame_spans(points, len(tets)):
        x = points[span].astype(np.float32)
        x = np.ascontiguousarray((x - x[:, :1]).transpose(2, 1, 0))  # centred, to keep precision
        parts.append(of(_tet_volumes(x, tets), start))
    return np.concatenate(parts) if parts else np.zeros(0)


def _tet_volumes(x: Array, tets: Array) -> Array:
    """Return signed volumes [m3] of tetrahedra with corners among points (3, p, F), shape (t, F)."""
    first = x[:, tets[:, 0]]
    return _triple(*(x[:, tets[:, k]] - first for k in (1, 2, 3))) / 6


def _triple(u: Array, v: Array, w: Array) -> Array:
    """Return u . (v x w) of vectors (3, ...)."""
    (a, b, c), (d, e, f), (g, h, i) = u, v, w
    return a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
