"""Normals of a mesh that keeps its edges: recorded ones are means over all faces at a corner, round a box as well."""

import numpy as np

SHARP = np.cos(np.radians(35.0))
"""Faces that meet at more than this angle meet at an edge."""


def corners(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which vertex each corner of each face is, and its normal.

    Args:
        vertices: [m], shape (V, 3).
        faces: Indices of vertices, shape (F, 3).
        normals: Of the vertices, shape (V, 3), or (0, 3).

    Returns:
        Vertices (3 F,) and unit normals (3 F, 3), corner by corner.
    """
    vertex = faces.ravel()
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    size = np.linalg.norm(across, axis=1, keepdims=True)
    flat = np.repeat(across / np.maximum(size, 1e-30), 3, axis=0)
    if len(normals) == len(vertices):
        smooth = normals[vertex].copy()
        edged = (smooth * flat).sum(axis=1) < SHARP
    else:
        smooth, edged = flat.copy(), np.ones(len(vertex), bool)
    if edged.any():
        smooth[edged] = _within_edges(vertex, flat, np.repeat(across, 3, axis=0))[edged]
    return vertex, smooth


def _within_edges(vertex: np.ndarray, flat: np.ndarray, weighted: np.ndarray) -> np.ndarray:
    """Mean at each corner over the faces at its vertex that lie nearly as its own does, shape (3 F, 3)."""
    order = np.argsort(vertex, kind="stable")
    count = np.bincount(vertex)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    # All pairs (corner, corner) at the same vertex.
    own = np.repeat(np.arange(len(vertex)), count[vertex])
    within = np.arange(len(own)) - np.repeat(np.cumsum(count[vertex]) - count[vertex], count[vertex])
    other = order[np.repeat(first[vertex], count[vertex]) + within]
    alike = (flat[own] * flat[other]).sum(axis=1) >= SHARP
    total = np.zeros_like(flat)
    np.add.at(total, own[alike], weighted[other[alike]])
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
