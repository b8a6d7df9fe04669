"""Exact bounds of shapes and bodies, from their support functions: how far they reach along a direction."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from text2sim.compiler.shapes.boxes import Bounds
from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.hulls import MANY_VERTICES
from text2sim.compiler.shapes.piece import outer_polygon_radius, piece_reach, wall_radii
from text2sim.compiler.shapes.revolved import revolved_reach
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Quaternion,
    Vec,
    quat_conjugate,
    quat_of,
    quat_rotate,
    quat_to_rows,
    vector_dot,
)
from text2sim.compiler.shapes.sagging import SHEET_THICKNESS, sheet_reach
from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.spec_schema.models.bodies import Articulated, Driven, Rigid
from text2sim.spec_schema.models.faceted import Faceted
from text2sim.spec_schema.models.placed import Linked
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.shapes import (
    Compound,
    Cone,
    Cup,
    FlatShape,
    Funnel,
    Mesh,
    Tube,
)
from text2sim.spec_schema.models.sheets import Sleeve

TreeExtents = Callable[[Any, Quaternion, Path], Bounds]
"""Bounds of a body that is a tree of links, about its origin, turned by a quaternion."""


# The reach of a shape along a direction u of its own frame: the largest u.x over its points x [m].


def _reach_ring(radius: float, height: float, u: Vec) -> float:
    return radius * math.hypot(u[0], u[1]) + height * u[2]


def _reach_piece(shape: Any, u: Vec, folder: Path) -> float:
    return piece_reach(pieces(shape, folder)[0], u)


def _reach_cone(shape: Cone, u: Vec, folder: Path) -> float:
    half = shape.height / 2
    return max(_reach_ring(shape.radius, -half, u), _reach_ring(shape.top_radius, half, u))


def _reach_sleeve(shape: Sleeve, u: Vec, folder: Path) -> float:
    half = shape.height / 2
    low, high = (r + SHEET_THICKNESS / 2 for r in shape.radii)
    return max(_reach_ring(low, -half, u), _reach_ring(high, half, u))


def _reach_wall(shape: Tube | Cup | Funnel, u: Vec, folder: Path) -> float:
    half = shape.height / 2
    (low_in, low), (high_in, high) = wall_radii(shape)
    low, high = (
        outer_polygon_radius(low, low_in, shape.segments),
        outer_polygon_radius(high, high_in, shape.segments),
    )
    return max(_reach_ring(low, -half, u), _reach_ring(high, half, u))


def _reach_mesh(shape: Mesh, u: Vec, folder: Path) -> float:
    mesh = load_mesh(shape.file, folder)
    # The hull of many vertices is a little smaller than they are.
    corners = mesh.vertices if len(mesh.vertices) > MANY_VERTICES else mesh.hull_vertices
    return shape.scale * float((corners @ u).max())


def _reach_flat(shape: FlatShape, u: Vec, folder: Path) -> float:
    from text2sim.compiler.shapes.flatforms import reach

    return reach(shape, u, folder)


def _reach_points(shape: Faceted, u: Vec, folder: Path) -> float:
    return max(x * u[0] + y * u[1] + z * u[2] for x, y, z in shape.points)


def _reach_compound(shape: Compound, u: Vec, folder: Path) -> float:
    best = -math.inf
    for part in shape.solids.values():
        own = quat_rotate(quat_conjugate(quat_of(part.pose)), u)
        best = max(best, vector_dot(part.pose.pos, u) + _REACH[part.shape.kind](part.shape, own, folder))
    return best


def _reach_ribbon(shape: Any, u: Vec, folder: Path) -> float:
    from text2sim.compiler.shapes.ribbons import ribbon_reach

    return ribbon_reach(shape, u)


_REACH: dict[str, Callable[[Any, Vec, Path], float]] = {
    "box": _reach_piece,
    "sphere": _reach_piece,
    "stream": lambda shape, u, folder: shape.radius,  # its mouth, whatever its direction
    "cylinder": _reach_piece,
    "capsule": _reach_piece,
    "polyhedron": _reach_points,
    "rock": _reach_points,
    "ellipsoid": _reach_piece,
    "cone": _reach_cone,
    "torus": lambda shape, u, folder: shape.bar_radius + _reach_ring(shape.radius, 0.0, u),
    "tube": _reach_wall,
    "cup": _reach_wall,
    "funnel": _reach_wall,
    "mesh": _reach_mesh,
    "text": _reach_flat,
    "sketch": _reach_flat,
    "extrusion": _reach_flat,
    "sculpt": lambda shape, u, folder: float((sculpted(shape).vertices @ u).max()),
    "fragment": lambda shape, u, folder: float((shape.solid.vertices @ u).max()),
    "disc": lambda shape, u, folder: _reach_ring(shape.radius, SHEET_THICKNESS / 2, (u[0], u[1], abs(u[2]))),
    "sleeve": _reach_sleeve,
    "revolve": lambda shape, u, folder: revolved_reach(shape, u),
    "ribbon": _reach_ribbon,
    "sheet": lambda shape, u, folder: sheet_reach(shape, u),
    "compound": _reach_compound,
}
_SYMMETRIC = {"box", "sphere", "stream", "disc", "cylinder", "capsule", "ellipsoid", "torus", "tube", "cup"}


def extents(shape: Any, quat: Quaternion, folder: Path) -> Bounds:
    """Return the exact bounds [m] of a shape about its body's origin, turned by `quat`.

    Args:
        shape: The shape.
        quat: Orientation of the body (w, x, y, z).
        folder: Folder of the case, for files of shapes.

    Raises:
        AssetError: if a mesh file cannot be used.
        ValueError: for a plane, which has no end.
    """
    kind = shape.kind
    if kind == "plane":
        raise ValueError("a plane has no end")
    reach = _REACH[kind]
    rows = (X_AXIS, Y_AXIS, Z_AXIS) if quat == IDENTITY else quat_to_rows(quat)
    x, y, z = (reach(shape, row, folder) for row in rows)
    if kind in _SYMMETRIC:
        return (-x, -y, -z), (x, y, z)
    lx, ly, lz = (-reach(shape, (-row[0], -row[1], -row[2]), folder) for row in rows)
    return (lx, ly, lz), (x, y, z)


def body_extents(body: Any, quat: Quaternion, folder: Path, tree_extents: TreeExtents | None = None) -> Bounds:
    """Return the bounds [m] of a body or static about its origin, turned by `quat`.

    Args:
        body: The validated model.
        quat: Orientation of the body.
        folder: The case's folder.
        tree_extents: Gives the bounds of chains, ropes, nets, ragdolls and articulated bodies.

    Raises:
        ValueError: for a plane, or where `tree_extents` is needed and missing.
    """
    if isinstance(body, Static | Rigid | Driven):
        return extents(body.shape, quat, folder)
    if tree_extents is None or not isinstance(body, Articulated | Linked):
        raise ValueError(f"the size of a body of kind {body.kind} is not known")
    return tree_extents(body, quat, folder)
