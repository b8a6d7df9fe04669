"""Bodies of points whose every number is known, and what a case says of such bodies."""

import numpy as np

SOFT = {"kind": "soft", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}
CLOTH = {"kind": "cloth", "shape": {"kind": "sheet", "size": [1.0, 1.0]}}
CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
SIX = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
"""Tetrahedra of a cube, by its corners in the order of `CORNERS`."""


def lattice(n, step):
    """Points of a cubic lattice about the origin, (n^3, 3)."""
    axis = (np.arange(n) - (n - 1) / 2) * step
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)


def tets(n):
    """Tetrahedra that fill the lattice, (t, 4)."""
    index = np.arange(n**3).reshape(n, n, n)
    cell = [index[i : n - 1 + i, j : n - 1 + j, k : n - 1 + k].ravel() for i, j, k in CORNERS]
    return np.concatenate([np.stack([cell[c] for c in row], 1) for row in SIX])


def sheet(nx, ny, step):
    """Points of a sheet in the plane z = 0 about the origin, (nx ny, 3), and triangles that span them."""
    x, y = (np.arange(nx) - (nx - 1) / 2) * step, (np.arange(ny) - (ny - 1) / 2) * step
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((nx, ny))], -1).reshape(-1, 3)
    i = np.arange(nx * ny).reshape(nx, ny)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def deformed(points, gradient):
    """Points of a body that is deformed evenly over time: gradients (F, 3, 3) make (F, n, 3) of points (n, 3)."""
    return np.einsum("fij,nj->fni", gradient, points)


def turns(angle):
    """Rotation matrices (F, 3, 3) about an axis askew."""
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    angle = np.atleast_1d(angle)[:, None, None]
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def sphere(radius, rings=24):
    """Vertices and outward triangles of a sphere, with a seam along which vertices stand twice."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    points = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1)
    points[:, -1] = points[:, 0]
    i = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return radius * points.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
