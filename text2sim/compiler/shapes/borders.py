"""Meshes cut along the borders between groups of parts that look different."""

import numpy as np

Array = np.ndarray
FAR = 1e30
"""Distance [m] of what does not count."""


def labels_of(away: Array, over: Array) -> Array:
    """Return the group of each vertex (n,): the last that paints or cuts there, else the nearest of the others.

    Args:
        away: Distances of the vertices from the groups [m], shape (g, n).
        over: Whether a group paints or cuts, shape (g,).
    """
    label = np.where(over[:, None], FAR, away).argmin(0)
    for k in np.flatnonzero(over):
        label[away[k] < 0] = k
    return label


def cut_edges(vertices: Array, faces: Array, label: Array, away: Array, over: Array) -> tuple[Array, Array]:
    """Add a vertex on each edge between two groups.

    Args:
        vertices: Vertices [m], shape (n, 3).
        faces: Triangles, shape (m, 3).
        label: Group of each vertex, shape (n,).
        away: Distances of the vertices from the groups [m], shape (g, n).
        over: Whether a group paints or cuts, shape (g,).

    Returns:
        All vertices, and the new one on the edge from each corner to the next, shape (m, 3); -1 on edges that stay.
    """
    following = np.roll(faces, -1, axis=1)
    mixed = label[faces] != label[following]
    keys = np.minimum(faces, following) * len(vertices) + np.maximum(faces, following)
    edges, edge_of = np.unique(keys[mixed], return_inverse=True)
    a, b = edges // len(vertices), edges % len(vertices)
    higher, lower = np.maximum(label[a], label[b]), np.minimum(label[a], label[b])
    # Parts that paint or cut end at their own surface; between joined parts, the border is half way.
    field_a = np.where(over[higher], away[higher, a], away[higher, a] - away[lower, a])
    field_b = np.where(over[higher], away[higher, b], away[higher, b] - away[lower, b])
    share = np.clip(field_a / np.where(field_a == field_b, 1.0, field_a - field_b), 0.1, 0.9)
    on_edge = np.full(faces.shape, -1)
    on_edge[mixed] = edge_of + len(vertices)
    return np.concatenate([vertices, vertices[a] + share[:, None] * (vertices[b] - vertices[a])]), on_edge


def retriangulated(points: Array, faces: Array, label: Array, on_edge: Array) -> tuple[Array, Array, Array]:
    """Divide triangles at the vertices on their edges; return vertices, the group of each triangle, triangles.

    Args:
        points: Vertices [m], shape (n, 3).
        faces: Triangles, shape (m, 3).
        label: Group of each corner of the triangles.
        on_edge: Vertex on the edge from each corner to the next, shape (m, 3); -1 on edges that stay.
    """
    mixed = on_edge >= 0
    whole = ~mixed.any(axis=1)
    found, labels = [faces[whole]], [label[faces[whole, 0]]]
    two = mixed.sum(axis=1) == 2
    # Turned so that the corner with a look of its own comes first: the edges at it are the mixed ones.
    turn = np.argmax(~mixed[two], axis=1)[:, None]
    order = (turn + 2 + np.arange(3)) % 3
    row = np.flatnonzero(two)[:, None]
    (p, q, r), (pq, _, rp) = faces[row, order].T, on_edge[row, order].T
    for corners, own in (((p, pq, rp), p), ((pq, q, r), q), ((pq, r, rp), q)):
        found.append(np.stack(corners, 1))
        labels.append(label[own])
    # With three groups, six triangles meet at the centre.
    three = mixed.sum(axis=1) == 3
    centre = len(points) + np.arange(int(three.sum()))
    points = np.concatenate([points, points[faces[three]].mean(axis=1)])
    for k in range(3):
        corner, after, before = faces[three, k], on_edge[three, k], on_edge[three, (k + 2) % 3]
        for corners in ((corner, after, centre), (corner, centre, before)):
            found.append(np.stack(corners, 1))
            labels.append(label[corner])
    return points, np.concatenate(labels), np.concatenate(found)
