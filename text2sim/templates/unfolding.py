"""Unfolded surfaces: a pattern lies on each face of a box, and runs around a solid of revolution."""

from dataclasses import dataclass

import numpy as np

ROUND = 0.2
"""Largest tangential component of a normal about z on a solid of revolution."""
SLOW = 0.01
"""How much of a pattern is on the round ends of a capsule of a strand: two links show the same where they overlap."""
CAP = 0.9
"""z component of a face's normal above which the face belongs to an end of a solid of revolution."""


@dataclass(frozen=True)
class Sheet:
    """A flat piece of an unfolded body: a face of a box, or the side or an end of a solid of revolution."""

    name: str
    """`+x`, `-x`, ... of a box; `side`, `top` and `bottom` of a solid of revolution."""
    width: float
    height: float
    """Width and height are in m."""


@dataclass(frozen=True)
class Unfolded:
    """An unfolded mesh."""

    vertices: np.ndarray
    """Index of the vertex of the mesh behind each unfolded vertex, shape (n,)."""
    faces: np.ndarray
    """Triangles as indices of unfolded vertices, shape (f, 3)."""
    sheet: np.ndarray
    """Index of the sheet of each unfolded vertex, shape (n,)."""
    uvs: np.ndarray
    """Position from the lower left corner of the sheet [m], shape (n, 2)."""
    sheets: list[Sheet]


def is_round(vertices: np.ndarray, normals: np.ndarray) -> bool:
    """Whether a mesh is a solid of revolution about z; vertices [m] and their normals have shape (n, 3)."""
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    x, y, _ = np.ptp(vertices, axis=0)
    out = radius > 0.05 * radius.max()
    angles = np.unique(np.round(np.arctan2(vertices[out, 1], vertices[out, 0]), 3))
    if abs(x - y) > 0.03 * max(x, y) or len(angles) < 12:
        return False
    along = (normals[out, 1] * vertices[out, 0] - normals[out, 0] * vertices[out, 1]) / radius[out]
    return bool(np.abs(along).max() < ROUND)


def unfold(
    vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, *, upright: bool, strand: bool = False
) -> Unfolded:
    """Unfold a mesh.

    Args:
        vertices: Vertices [m], shape (n, 3).
        faces: Triangles, shape (f, 3).
        normals: Normals of the vertices, shape (n, 3).
        upright: Whether z is up on the sides of a box; otherwise its longest extent is up.
        strand: Whether it is a capsule along z about the origin whose round ends lie in its neighbours: it has a side
            only, whose height is counted from the origin.
    """
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    looks = np.cross(b - a, c - a)
    looks /= np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), 1e-30)
    if is_round(vertices, normals):
        sheet, uvs, sheets = _turned(vertices, faces, looks, strand)
    else:
        sheet, uvs, sheets = _boxed(vertices, faces, looks, upright)
    rows = np.column_stack([faces.ravel(), np.repeat(sheet, 3), np.round(uvs.reshape(-1, 2) * 1e6).astype(np.int64)])
    own, first, index = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return Unfolded(own[:, 0], index.reshape(-1, 3), own[:, 1], uvs.reshape(-1, 2)[first], sheets)


def _boxed(vertices, faces, looks, upright):
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    axis = np.abs(looks).argmax(axis=1)
    side = np.take_along_axis(looks, axis[:, None], axis=1)[:, 0] < 0
    sheet, uvs, sheets = 2 * axis + side, np.zeros((*faces.shape, 2)), []
    for number in range(6):
        k, sign = number // 2, 1.0 - 2.0 * (number % 2)
        normal, up = sign * np.eye(3)[k], np.eye(3)[2 if k < 2 else 1]
        if k == 2:
            up = sign * up
        if not upright and k != (longest := int(size.argmax())):
            up = np.eye(3)[longest]
        right = np.cross(up, normal)
        mine = sheet == number
        for axis, column in ((right, 0), (up, 1)):
            corner = np.where(axis < 0, low + size, low)
            uvs[mine, :, column] = (vertices[faces[mine]] - corner) @ axis
        sheets.append(Sheet("+-"[number % 2] + "xyz"[k], float(np.abs(right) @ size), float(np.abs(up) @ size)))
    return sheet, uvs, sheets


def _turned(vertices, faces, looks, strand):
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    r, low, tall = radius.max(), vertices[:, 2].min(), np.ptp(vertices[:, 2])
    away = vertices - (0, 0, low + tall / 2)
    # The corners of a cylinder are on a ball, too, but its ends do not look away from the middle.
    outward = (looks * away[faces].mean(axis=1)).sum(axis=1)
    is_ball = np.ptp(np.linalg.norm(away, axis=1)) < 0.02 * r and outward.min() > 0.8 * r
    turn = np.arctan2(vertices[:, 1], vertices[:, 0])[faces] % (2 * np.pi)
    pole = radius[faces] < 1e-4 * r
    highest = np.where(pole, -1.0, turn).max(axis=1, keepdims=True)
    turn = np.where(highest - turn > np.pi, turn + 2 * np.pi, turn)
    weight = (~pole).sum(axis=1, keepdims=True)
    middle = np.where(pole, 0.0, turn).sum(axis=1, keepdims=True) / np.maximum(weight, 1)
    turn = np.where(pole, middle, turn)
    if is_ball:
        up = r * (np.arcsin(np.clip((vertices[:, 2] - low - tall / 2) / r, -1, 1)) + np.pi / 2)
        height = np.pi * r
    elif strand:
        straight = np.clip(vertices[:, 2], r - tall / 2, tall / 2 - r)
        up, height = straight + SLOW * (vertices[:, 2] - straight), tall
    else:
        up, height = vertices[:, 2] - low, tall
    uvs = np.stack([turn * r, up[faces]], axis=-1)
    sheet = np.zeros(len(faces), int)
    plain = is_ball or strand
    if not plain:
        sheet[looks[:, 2] > CAP], sheet[looks[:, 2] < -CAP] = 1, 2
        flat = vertices[:, :2] + r
        uvs[sheet == 1] = flat[faces[sheet == 1]]
        uvs[sheet == 2] = (flat * (-1, 1) + (2 * r, 0))[faces[sheet == 2]]
    sheets = [Sheet("side", 2 * np.pi * r, height), Sheet("top", 2 * r, 2 * r), Sheet("bottom", 2 * r, 2 * r)]
    return sheet, uvs, sheets[: 1 if plain else 3]
