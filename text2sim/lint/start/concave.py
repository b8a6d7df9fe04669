"""Overlap of meshes that collide by their surface, or by convex pieces that only the engine computes."""

from functools import lru_cache
from typing import Any

from text2sim.compiler.shapes.boxes import sides
from text2sim.compiler.shapes.meshfile import MeshFile
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Vec, frame_apply, quat_conjugate, quat_rotate, vector_minus
from text2sim.lint.parts import StandingPart

MAX_ROUGHNESS = 0.05
"""Share of a mesh's size by which the engine's convex pieces may protrude from its surface: its CoACD uses a threshold
of 0.1 of half of that."""
BISECTION_STEPS = 14
"""Bisection steps for an exit length."""


def inside(a: StandingPart, b: StandingPart, step: Vec = (0.0, 0.0, 0.0)) -> bool:
    """Return whether two pieces, one of them such a mesh, overlap when `a` is moved by `step` [m].

    Args:
        a: A piece.
        b: Another piece.
        step: Displacement of `a` [m].
    """
    import fcl

    x, y, z = a.pos
    pos = (x + step[0], y + step[1], z + step[2])
    if fcl.collide(_object(a, pos), _object(b, b.pos), fcl.CollisionRequest(), fcl.CollisionResult()):
        return True
    # If the surfaces do not cross, one piece may still be entirely inside the other.
    return _encloses(a, pos, _point(b, b.pos)) or _encloses(b, b.pos, _point(a, pos))


def exit_length(a: StandingPart, b: StandingPart, direction: Vec) -> float:
    """Return a distance [m] along a direction after which two overlapping pieces no longer overlap.

    Args:
        a: The piece that moves.
        b: The piece that it overlaps.
        direction: Direction of the motion, a unit vector.
    """
    far = sum((q - p) * d for p, q, d in zip(a.solid.center, b.solid.center, direction, strict=True))
    low, high = 0.0, far + a.solid.ball + b.solid.ball
    for _ in range(BISECTION_STEPS):
        middle = (low + high) / 2
        x, y, z = direction
        low, high = (middle, high) if inside(a, b, (middle * x, middle * y, middle * z)) else (low, middle)
    return high


def roughness(*parts: StandingPart) -> float:
    """Return how far [m] the engine's convex pieces may protrude from the surfaces of these parts."""
    rough = [part for part in parts if part.piece.collision == "decompose"]
    return MAX_ROUGHNESS * max((max(sides(part.box)) for part in rough), default=0.0)


def _object(part: StandingPart, pos: Vec) -> Any:
    import fcl
    import numpy as np

    piece = part.piece
    geometry = _convex(piece) if part.mesh is None else _surface(part.mesh, piece.size[0])
    return fcl.CollisionObject(
        geometry, fcl.Transform(np.array(part.turn), np.array(frame_apply(pos, part.quat, piece.pos)))
    )


def _convex(piece: Piece) -> Any:
    import fcl
    import numpy as np

    if piece.kind in ("hull", "mesh"):
        faces = np.array([[3, *face] for face in piece.faces])
        return fcl.Convex(np.array(piece.vertices), len(faces), faces.ravel())
    kinds = {
        "box": fcl.Box, "sphere": fcl.Sphere, "cylinder": fcl.Cylinder, "capsule": fcl.Capsule,
        "ellipsoid": fcl.Ellipsoid,
    }  # fmt: skip
    return kinds[piece.kind](*piece.size)


@lru_cache(maxsize=16)
def _surface(mesh: MeshFile, scale: float) -> Any:
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices * scale, mesh.faces)
    model.endModel()
    return model


def _point(part: StandingPart, pos: Vec) -> Vec:
    """Return a point of a piece at `pos`; the centre of a mesh may be in its hole."""
    own = part.piece.vertices[0] if part.piece.vertices else (0.0, 0.0, 0.0)
    return frame_apply(pos, part.quat, frame_apply(part.piece.pos, part.piece.quat, own))


def _encloses(part: StandingPart, pos: Vec, point: Vec) -> bool:
    """Return whether a point is inside a mesh, by its solid angle (van Oosterom and Strackee 1983)."""
    import numpy as np

    if part.mesh is None or not part.mesh.closed:
        return False
    at, back = frame_apply(pos, part.quat, part.piece.pos), quat_conjugate(part.turn)
    local = quat_rotate(back, vector_minus(point, at))
    corners = part.mesh.vertices * part.piece.size[0] - local
    a, b, c = (corners[part.mesh.faces[:, k]] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    over = np.einsum("ij,ij->i", a, np.cross(b, c))
    angle = 2 * np.arctan2(over, la * lb * lc + ab * lc + bc * la + ca * lb)
    return abs(float(np.sum(angle))) > 2 * np.pi
