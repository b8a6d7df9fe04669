"""Mass, centre of mass and inertia of convex pieces, as the engine computes them from shape and density.

Inertias are symmetric tensors (xx, yy, zz, xy, xz, yz) [kg m2]. The formulas are those of solid bodies (Beer and
Johnston, Vector Mechanics for Engineers, appendix); a hull is the sum of the tetrahedra between its faces and the
origin (Blow and Binstock 2004, "How to find the inertia tensor of a 3D solid body").
"""

from collections.abc import Iterable
from dataclasses import dataclass

from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec, frame_apply, quat_to_rows

Tensor = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass, centre of mass and inertia in some frame."""

    mass: float
    """[kg]"""
    center: Vec
    """[m]"""
    inertia: Tensor
    """About the centre, along the frame's axes [kg m2]."""

    def at(self, pos: Vec, quat: Quaternion) -> "Inertial":
        """Return it in the frame around (`pos`, `quat`)."""
        return Inertial(self.mass, frame_apply(pos, quat, self.center), _rotate_tensor(self.inertia, quat))

    def about(self, anchor: Vec, axis: Vec) -> float:
        """Return the moment of inertia [kg m2] about the line through `anchor` along the unit vector `axis`."""
        x, y, z = axis
        xx, yy, zz, xy, xz, yz = self.inertia
        own = xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z)
        arm = (self.center[0] - anchor[0], self.center[1] - anchor[1], self.center[2] - anchor[2])
        along = arm[0] * x + arm[1] * y + arm[2] * z
        return own + self.mass * (arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2 - along**2)


_NONE: Tensor = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NOTHING = Inertial(0.0, ORIGIN, _NONE)


def combined_inertial(inertials: Iterable[Inertial]) -> Inertial:
    """Return several inertials of one frame as one."""
    inertials = list(inertials)
    if len(inertials) == 1:
        return inertials[0]
    mass = sum(inertial.mass for inertial in inertials)
    if mass <= 0.0:
        return NOTHING
    center = tuple(sum(inertial.mass * inertial.center[k] for inertial in inertials) / mass for k in range(3))
    total = [0.0] * 6
    for inertial in inertials:
        x, y, z = (inertial.center[k] - center[k] for k in range(3))
        shift = (y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)
        total = [t + i + inertial.mass * s for t, i, s in zip(total, inertial.inertia, shift, strict=True)]
    return Inertial(mass, center, tuple(total))  # type: ignore[arg-type]


def piece_inertial(piece: Piece, density: float) -> Inertial:
    """Return the inertial of a piece of a density [kg/m3], in the frame of its body."""
    mass = density * piece.volume()
    if piece.kind in ("hull", "mesh"):
        return _hull(piece, mass).at(piece.pos, piece.quat)
    return Inertial(mass, ORIGIN, _solid(piece, mass)).at(piece.pos, piece.quat)


def _solid(piece: Piece, mass: float) -> Tensor:
    size = piece.size
    if piece.kind == "box":
        a, b, c = (side * side / 12 for side in size)
    elif piece.kind == "sphere":
        a = b = c = size[0] ** 2 / 5
    elif piece.kind == "ellipsoid":
        a, b, c = (half * half / 5 for half in size)
    elif piece.kind == "cylinder":
        a = b = size[0] ** 2 / 4
        c = size[1] ** 2 / 12
    elif piece.kind == "capsule":  # a cylinder and two half balls
        radius, length = size
        bar, ball = radius**2 * length, 4 / 3 * radius**3
        a = b = (bar * radius**2 / 4 + ball * radius**2 / 5) / (bar + ball)
        # The centre of a half ball is 3/8 r from its flat side.
        offset = length / 2
        c = bar * length**2 / 12 + ball * (radius**2 / 5 + offset**2 + 0.75 * radius * offset)
        c /= bar + ball
    else:
        raise TypeError(f"the inertia of a piece of kind {piece.kind} is not known")
    return (mass * (b + c), mass * (a + c), mass * (a + b), 0.0, 0.0, 0.0)


def _hull(piece: Piece, mass: float) -> Inertial:
    """Return the inertial of a polyhedron, from moments of the tetrahedra between its faces and the origin."""
    volume = 0.0
    first, second = [0.0] * 3, [0.0] * 6  # of x, y, z; of xx, yy, zz, xy, xz, yz
    for i, j, k in piece.faces:
        a, b, c = piece.vertices[i], piece.vertices[j], piece.vertices[k]
        six = (
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        volume += six / 6
        s = (a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2])
        for axis in range(3):
            first[axis] += six * s[axis] / 24
        for slot, (p, q) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
            second[slot] += six / 120 * (s[p] * s[q] + a[p] * a[q] + b[p] * b[q] + c[p] * c[q])
    if volume <= 0.0:
        return Inertial(mass, ORIGIN, _NONE)
    x, y, z = center = (first[0] / volume, first[1] / volume, first[2] / volume)
    means = [moment / volume for moment in second]
    xx, yy, zz = means[0] - x * x, means[1] - y * y, means[2] - z * z
    xy, xz, yz = means[3] - x * y, means[4] - x * z, means[5] - y * z
    moments = (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)
    return Inertial(mass, center, tuple(mass * moment for moment in moments))  # type: ignore[arg-type]


def _rotate_tensor(inertia: Tensor, quat: Quaternion) -> Tensor:
    """Return R I R^T."""
    if quat == IDENTITY or not any(inertia):
        return inertia
    xx, yy, zz, xy, xz, yz = inertia
    full = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    rows = quat_to_rows(quat)
    half = [[sum(row[m] * full[m][n] for m in range(3)) for n in range(3)] for row in rows]

    def entry(p: int, q: int) -> float:
        return sum(half[p][n] * rows[q][n] for n in range(3))

    return (entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))
