"""Rotations as unit quaternions (w, x, y, z), in plain floats, which are fast enough for thousands of poses.

A quaternion turns vectors of the body's frame into the world's: `world = quat_rotate(q, local)`. Products
apply the right factor first. Angles are radians, except in `quat_from_euler_deg`.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from text2sim.spec_schema.models.base import AXES, Pose
from text2sim.spec_schema.models.placement import Place

if TYPE_CHECKING:
    import numpy as np

Vec = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Rows = tuple[Vec, Vec, Vec]
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)
ORIGIN: Vec = (0.0, 0.0, 0.0)
X_AXIS: Vec = (1.0, 0.0, 0.0)
Y_AXIS: Vec = (0.0, 1.0, 0.0)
Z_AXIS: Vec = (0.0, 0.0, 1.0)

_TINY = 1e-12


def quat_normalize(q: Sequence[float]) -> Quaternion:
    """Return the unit quaternion along `q`.

    Raises:
        ValueError: if `q` has no direction.
    """
    w, x, y, z = q
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if norm < _TINY:
        raise ValueError("a quaternion must not be zero")
    return (w / norm, x / norm, y / norm, z / norm)


def quat_multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation that does `b`, then `a`."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def quat_conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse rotation."""
    return (q[0], -q[1], -q[2], -q[3])


def quat_to_rows(q: Quaternion) -> Rows:
    """Return the rotation matrix as three rows: `world[k] = dot(rows[k], local)`."""
    w, x, y, z = q
    xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z
    return (
        (1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)),
        (2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)),
        (2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)),
    )


def quats_to_matrices(quats: "np.ndarray") -> "np.ndarray":
    """Return the rotation matrices of quaternions, shape (n, 3, 3) for (n, 4)."""
    import numpy as np

    rows = quat_to_rows(tuple(np.moveaxis(np.asarray(quats, float), -1, 0)))
    return np.moveaxis(np.array(rows), -1, 0)


def quat_rotate(q: Quaternion, v: Sequence[float]) -> Vec:
    """Return the vector `v`, turned by `q`."""
    return rows_apply(quat_to_rows(q), v)


def rows_apply(rows: Rows, v: Sequence[float]) -> Vec:
    """Return a matrix, given as three rows, times the vector `v`."""
    a, b, c = rows
    x, y, z = v
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def quat_from_axis_angle(axis: Sequence[float], angle: float) -> Quaternion:
    """Return the rotation by `angle` [rad] about `axis`, right-handed."""
    x, y, z = vector_unit(axis)
    s = math.sin(angle / 2)
    return (math.cos(angle / 2), x * s, y * s, z * s)


def quat_from_yaw(angle: float) -> Quaternion:
    """Return the rotation by `angle` [rad] about z."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def quat_from_euler_deg(angles: Sequence[float]) -> Quaternion:
    """Return the rotation by three angles [deg] about the fixed x, then y, then z axis (extrinsic xyz)."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(math.radians(a) / 2), math.sin(math.radians(a) / 2)) for a in angles)
    return (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )


def quat_between(a: Sequence[float], b: Sequence[float]) -> Quaternion:
    """Return the smallest rotation that turns direction `a` into direction `b`."""
    a, b = vector_unit(a), vector_unit(b)
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    if dot < -1 + _TINY:
        # Half a turn about any axis across `a`; y is kept where possible so that the answer is stable.
        across = vector_cross(a, Y_AXIS if abs(a[1]) < 0.9 else X_AXIS)
        return quat_from_axis_angle(across, math.pi)
    c = vector_cross(a, b)
    return quat_normalize((1.0 + dot, c[0], c[1], c[2]))


def quat_of(where: Pose | Place) -> Quaternion:
    """Return the orientation that a pose or place gives; the identity if it gives none.

    Raises:
        ValueError: if it gives two, or a zero quaternion.
    """
    if where.quat is None:
        return IDENTITY if where.euler_deg is None else quat_from_euler_deg(where.euler_deg)
    if where.euler_deg is not None:
        raise ValueError("give either quat or euler_deg, not both")
    return quat_normalize(where.quat)


def vector_unit(v: str | Sequence[float]) -> Vec:
    """Return the unit vector along `v`, which may be the name of an axis.

    Raises:
        ValueError: if it has no direction.
    """
    x, y, z = AXES[v] if isinstance(v, str) else v
    norm = math.sqrt(x * x + y * y + z * z)
    if norm < _TINY:
        raise ValueError("a direction must not be zero")
    return (x / norm, y / norm, z / norm)


def vector_cross(a: Sequence[float], b: Sequence[float]) -> Vec:
    """Return the cross product `a x b`."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def vector_dot(a: Sequence[float], b: Sequence[float]) -> float:
    """Return the inner product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def vector_plus(a: Sequence[float], b: Sequence[float]) -> Vec:
    """Return the sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def vector_minus(a: Sequence[float], b: Sequence[float]) -> Vec:
    """Return the difference of two vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def vector_times(a: Sequence[float], factor: float) -> Vec:
    """Return a vector times a number."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def frame_apply(pos: Sequence[float], quat: Quaternion, point: Sequence[float]) -> Vec:
    """Return a point [m] of the frame at (`pos`, `quat`) in the frame around it.

    Args:
        pos: Origin of the frame [m].
        quat: Orientation of the frame (w, x, y, z).
        point: The point in the frame [m].
    """
    x, y, z = point if quat == IDENTITY else quat_rotate(quat, point)
    return (pos[0] + x, pos[1] + y, pos[2] + z)
