"""Curvature of a cloth, from the angles between its triangles."""

import numpy as np

from text2sim.evidence.deformation import DeformationError, triangles
from text2sim.recording.deformables import RecordedDeformable, frame_spans
from text2sim.recording.states import Array


def curvatures(body: RecordedDeformable) -> tuple[Array, Array]:
    """Return the integral of |k1| + |k2| over a cloth [m] and its area [m2], without its border, each of shape (F,).

    k1 and k2 are the principal curvatures. About a vertex, sum(angle length e e^T) / 2 over its edges is the tensor of
    curvature times its area (Cohen-Steiner and Morvan 2003; e: unit vector along the edge, angle: between the
    normals of the two triangles). Only two of its three eigenvalues are not zero, so the sum of their magnitudes
    follows from its trace and its norm: |a| + |b| = max(|a + b|, |a - b|), and (a - b)^2 = 2 (a^2 + b^2) - (a + b)^2.

    Raises:
        DeformationError: if the body has no surface.
    """
    faces, points = triangles(body)
    pairs, wings = _hinges(faces)
    if not len(pairs):
        raise DeformationError(f"{body.body} has no two triangles side by side")
    inner = np.ones(points.shape[1], bool)
    inner[_border(faces)] = False
    total, area = np.zeros(len(points)), np.zeros(len(points))
    for span in frame_spans(points, 2 * len(faces)):
        x = points[span].transpose(1, 0, 2).astype(float)  # (p, F, 3)
        a, b, c = (x[faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        sizes = np.linalg.norm(normals, axis=-1)
        edges = x[pairs[:, 1]] - x[pairs[:, 0]]
        lengths = np.maximum(np.linalg.norm(edges, axis=-1), 1e-30)
        first, second = normals[wings[:, 0]], normals[wings[:, 1]]
        sine = (np.cross(first, second) * edges).sum(axis=-1) / lengths
        angle = np.arctan2(sine, (first * second).sum(axis=-1))
        bent = (angle / (2.0 * lengths))[..., None, None] * edges[..., :, None] * edges[..., None, :]
        tensors, shares = np.zeros((*x.shape, 3)), np.zeros(x.shape[:2])
        for k in range(2):
            np.add.at(tensors, pairs[:, k], bent)
        for k in range(3):
            np.add.at(shares, faces[:, k], sizes / 6.0)
        trace = np.einsum("nfii->nf", tensors)
        apart = 2.0 * (tensors**2).sum(axis=(2, 3)) - trace**2
        bends = np.maximum(np.abs(trace), np.sqrt(np.maximum(apart, 0.0)))
        total[span], area[span] = bends[inner].sum(axis=0), shares[inner].sum(axis=0)
    return total, area


def _hinges(faces: Array) -> tuple[Array, Array]:
    """Return the edges shared by two triangles (e, 2), directed as in the first, and both triangles (e, 2)."""
    sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort(np.sort(sides, axis=1).T[::-1])
    ends = np.sort(sides[order], axis=1)
    twice = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    return sides[order[twice]], np.stack([owner[order[twice]], owner[order[twice + 1]]], axis=1)


def _border(faces: Array) -> Array:
    """Return the indices of the points on boundary edges."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends, times = np.unique(sides, axis=0, return_counts=True)
    return np.unique(ends[times == 1])
