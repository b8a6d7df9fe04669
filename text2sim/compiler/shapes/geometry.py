"""Geometry of shapes: their convex pieces, their drawn surface, volume and exact bounds."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from text2sim.compiler.shapes.casemesh import load_mesh, load_paint
from text2sim.compiler.shapes.hulls import MANY_VERTICES
from text2sim.compiler.shapes.piece import Piece, cone_piece, outer_polygon_radius, ring_pieces, wall_pieces
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    Quaternion,
    Rows,
    Vec,
    frame_apply,
    quat_of,
    quat_rotate,
    quat_to_rows,
)
from text2sim.compiler.shapes.sagging import sheet_pieces, sheet_reach
from text2sim.compiler.shapes.surface import Drawn, VisualMesh, surface
from text2sim.spec_schema.models.bodies import Articulated, Chain, Driven, Net, Ragdoll, Rigid, Rope
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound, Cone, Cup, Ellipsoid, Funnel, Mesh, Sheet, Sketch, Text, Tube

__all__ = [
    "Bounds",
    "InnerFloor",
    "Piece",
    "TreeExtents",
    "VisualMesh",
    "body_extents",
    "extents",
    "inner_floor",
    "pieces",
    "points",
    "visual_mesh",
    "volume",
]

Bounds = tuple[Vec, Vec]
"""Lowest and highest corner [m] of an upright box."""

TreeExtents = Callable[[Any, Quaternion, Path], Bounds]
"""Bounds of a body that is a tree of links, about its origin, turned by a quaternion."""


_MEMORY = 4096
_KNOWN: dict[Any, tuple[Piece, ...]] = {}
"""Pieces of shapes: copies, and bodies that are alike, share them, and what was worked out of them."""
_DRAWN: dict[Any, VisualMesh] = {}
"""The same of drawn surfaces."""


def pieces(shape: Any, folder: Path) -> list[Piece]:
    """Return the convex pieces with which a shape touches others, in the body's frame.

    Hollow shapes become staves (see `piece.wall_pieces`), a ring capsules, a cone a pyramid; a mesh stays
    one piece, which the engine makes convex. Equal shapes have the same pieces.

    Args:
        shape: Any shape but a plane.
        folder: The case's folder, for meshes.

    Raises:
        AssetError: if a mesh file cannot be used.
    """
    key = key_of(shape, folder)
    found = _KNOWN.get(key)
    if found is None:
        if len(_KNOWN) >= _MEMORY:
            _KNOWN.clear()
        found = _KNOWN[key] = tuple(_pieces(shape, folder))
    return list(found)


def key_of(shape: Any, folder: Path) -> Any:
    """Return what two shapes with the same pieces have in common; files are known by their content.

    Raises:
        AssetError: if a file cannot be used.
    """
    if isinstance(shape, Compound):
        parts = (part.shape for part in shape.parts.values())
        return (shape.model_dump_json(exclude_defaults=True), *(_content(part, folder) for part in parts))
    if isinstance(shape, Sculpt):
        return shape.model_dump_json(exclude_defaults=True)
    return (*vars(shape).values(), _content(shape, folder))


def _content(shape: Any, folder: Path) -> Any:
    """What was read from a shape's file; equal only to itself."""
    if isinstance(shape, Mesh):
        return load_mesh(shape.file, folder)
    if isinstance(shape, Text | Sketch):
        from text2sim.compiler.shapes.glyphs import glyph_parts

        return glyph_parts(shape, folder)[0]
    return None


def _pieces(shape: Any, folder: Path) -> list[Piece]:
    kind = shape.kind
    if kind == "box":
        return [Piece("box", size=shape.size)]
    if kind == "sphere":
        return [Piece("sphere", size=(shape.radius,))]
    if kind == "cylinder":
        return [Piece("cylinder", size=(shape.radius, shape.height))]
    if kind == "capsule":
        return [Piece("capsule", size=(shape.radius, shape.length))]
    if kind == "ellipsoid":
        return [Piece("ellipsoid", size=shape.radii)]
    if kind == "cone":
        return [cone_piece(shape.radius, shape.height)]
    if kind == "torus":
        return ring_pieces(shape.radius, shape.bar_radius, shape.segments)
    if kind == "mesh":
        return [_mesh_piece(shape, folder)]
    if isinstance(shape, Text | Sketch):
        from text2sim.compiler.shapes.flatforms import prisms

        return prisms(shape, folder)
    if isinstance(shape, Sculpt):
        from text2sim.compiler.shapes.sculpting import pieces_of

        return pieces_of(shape)
    if isinstance(shape, Sheet):
        return sheet_pieces(shape)
    if kind == "compound":
        return [
            piece.at(part.pose.pos, quat_of(part.pose), name)
            for name, part in shape.solids.items()
            for piece in pieces(part.shape, folder)
        ]
    if kind == "plane":
        raise ValueError("a plane has no pieces")
    bottom, top = _wall(shape)
    half = shape.height / 2
    if kind == "cup":
        staves = wall_pieces(bottom, top, shape.thickness - half, half, shape.segments)
        floor = Piece("cylinder", pos=(0.0, 0.0, shape.thickness / 2 - half), size=(shape.radius, shape.thickness))
        return [floor, *staves]
    return wall_pieces(bottom, top, -half, half, shape.segments)


def _wall(shape: Tube | Cup | Funnel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Inner and outer radius [m] of a round wall at its bottom and top."""
    if isinstance(shape, Tube):
        return (shape.inner_radius, shape.outer_radius), (shape.inner_radius, shape.outer_radius)
    if isinstance(shape, Cup):
        return (shape.radius - shape.thickness, shape.radius), (shape.radius - shape.thickness, shape.radius)
    low, high = shape.bottom_radius, shape.top_radius
    return (low, low + shape.thickness), (high, high + shape.thickness)


def _mesh_piece(shape: Mesh, folder: Path) -> Piece:
    mesh, scale = load_mesh(shape.file, folder), shape.scale
    corners = tuple((x * scale, y * scale, z * scale) for x, y, z in mesh.hull_vertices.tolist())
    faces = tuple((a, b, c) for a, b, c in mesh.hull_faces.tolist())
    enclosed = mesh.volume * scale**3 if mesh.closed else 0.0
    return Piece(
        "mesh", size=(scale,), vertices=corners, faces=faces, file=shape.file, enclosed=enclosed,
        decompose=shape.collision == "decompose",
    )  # fmt: skip


def visual_mesh(shape: Any, folder: Path) -> list[VisualMesh] | None:
    """Return the surfaces to draw instead of the pieces, or None where every piece draws itself.

    Of a compound only the parts that need one have a surface; it carries the part's name. A mesh has one for
    each of its materials, a sculpt one for each look, with the name of a part that has it.

    Raises:
        AssetError: if a mesh file cannot be used.
    """
    if isinstance(shape, Compound):
        found = [
            mesh.at(part.pose.pos, quat_of(part.pose), name)
            for name, part in shape.parts.items()
            for mesh in visual_mesh(part.shape, folder) or ([surface(part.shape)] if part.decor else ())
        ]
        return found or None
    if isinstance(shape, Mesh):
        return [
            VisualMesh(
                paint.vertices * shape.scale,
                paint.faces,
                paint.normals,
                uvs=paint.uvs,
                picture=paint.picture,
                rgba=paint.rgba,
            )  # fmt: skip
            for paint in load_paint(shape.file, folder)
        ]
    if isinstance(shape, Sculpt):
        from text2sim.compiler.shapes.sculpting import sculpted

        return sculpted(shape).visuals()
    if not isinstance(shape, Drawn | Text | Sketch):
        return None
    key = key_of(shape, folder)
    if key not in _DRAWN:
        if len(_DRAWN) >= _MEMORY:
            _DRAWN.clear()
        if isinstance(shape, Drawn):
            _DRAWN[key] = surface(shape)
        else:
            from text2sim.compiler.shapes.flatforms import flat_surface

            _DRAWN[key] = flat_surface(shape, folder)
    return [_DRAWN[key]]


def volume(shape: Any, folder: Path) -> float:
    """Return the volume [m3] of the shape as described (its pieces may differ a little: `Piece.volume`).

    Parts of a compound that overlap count twice; a mesh that is not closed counts as its
    convex hull.
    """
    kind = shape.kind
    if kind == "compound":
        return sum(volume(part.shape, folder) for part in shape.solids.values())
    if kind == "mesh":
        return load_mesh(shape.file, folder).volume * shape.scale**3
    if kind == "cone":
        return math.pi * shape.radius**2 * shape.height / 3
    if kind == "torus":
        return 2 * math.pi**2 * shape.radius * shape.bar_radius**2
    if kind == "tube":
        return math.pi * (shape.outer_radius**2 - shape.inner_radius**2) * shape.height
    if kind == "cup":
        inner = shape.radius - shape.thickness
        return math.pi * (shape.radius**2 * shape.height - inner**2 * (shape.height - shape.thickness))
    if kind == "funnel":
        # The integral of pi ((r + t)^2 - r^2) over the height, r growing evenly.
        t = shape.thickness
        return math.pi * shape.height * t * (shape.top_radius + shape.bottom_radius + t)
    if isinstance(shape, Text | Sketch):
        from text2sim.compiler.shapes.glyphs import whole

        return whole(shape, folder).area * shape.depth
    if isinstance(shape, Sculpt):
        from text2sim.compiler.shapes.sculpting import sculpted

        return sculpted(shape).volume
    if kind == "plane":
        raise ValueError("a plane has no volume")
    return pieces(shape, folder)[0].volume()


# The reach of a shape along a direction u of its own frame: the largest u.x over its points x [m].


def _reach_ring(radius: float, height: float, u: Vec) -> float:
    return radius * math.hypot(u[0], u[1]) + height * u[2]


def _reach_box(shape: Any, u: Vec, folder: Path) -> float:
    x, y, z = shape.size
    return (x * abs(u[0]) + y * abs(u[1]) + z * abs(u[2])) / 2


def _reach_ellipsoid(shape: Ellipsoid, u: Vec, folder: Path) -> float:
    return math.hypot(*(r * c for r, c in zip(shape.radii, u, strict=True)))


def _reach_cone(shape: Cone, u: Vec, folder: Path) -> float:
    half = shape.height / 2
    return max(_reach_ring(shape.radius, -half, u), half * u[2])


def _reach_wall(shape: Tube | Cup | Funnel, u: Vec, folder: Path) -> float:
    half = shape.height / 2
    (low_in, low), (high_in, high) = _wall(shape)
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


def _reach_flat(shape: Text | Sketch, u: Vec, folder: Path) -> float:
    from text2sim.compiler.shapes.flatforms import reach

    return reach(shape, u, folder)


def _reach_sculpt(shape: Sculpt, u: Vec, folder: Path) -> float:
    from text2sim.compiler.shapes.sculpting import sculpted

    return float((sculpted(shape).vertices @ u).max())


def _reach_sheet(shape: Sheet, u: Vec, folder: Path) -> float:
    return sheet_reach(shape, u)


def _reach_compound(shape: Compound, u: Vec, folder: Path) -> float:
    best = -math.inf
    for part in shape.solids.values():
        w, x, y, z = quat_of(part.pose)
        p = part.pose.pos
        away = p[0] * u[0] + p[1] * u[1] + p[2] * u[2]
        best = max(best, away + _REACH[part.shape.kind](part.shape, quat_rotate((w, -x, -y, -z), u), folder))
    return best


_REACH: dict[str, Callable[[Any, Vec, Path], float]] = {
    "box": _reach_box,
    "sphere": lambda shape, u, folder: shape.radius,
    "cylinder": lambda shape, u, folder: _reach_ring(shape.radius, shape.height / 2, (u[0], u[1], abs(u[2]))),
    "capsule": lambda shape, u, folder: shape.radius + shape.length / 2 * abs(u[2]),
    "ellipsoid": _reach_ellipsoid,
    "cone": _reach_cone,
    "torus": lambda shape, u, folder: shape.bar_radius + _reach_ring(shape.radius, 0.0, u),
    "tube": _reach_wall,
    "cup": _reach_wall,
    "funnel": _reach_wall,
    "mesh": _reach_mesh,
    "text": _reach_flat,
    "sketch": _reach_flat,
    "sculpt": _reach_sculpt,
    "sheet": _reach_sheet,
    "compound": _reach_compound,
}
_SYMMETRIC = {"box", "sphere", "cylinder", "capsule", "ellipsoid", "torus", "tube", "cup"}


def extents(shape: Any, quat: Quaternion, folder: Path) -> Bounds:
    """Return the exact bounds [m] of a shape about its body's origin, turned by `quat`.

    Raises:
        AssetError: if a mesh file cannot be used.
        ValueError: for a plane, which has no end.
    """
    kind = shape.kind
    if kind == "plane":
        raise ValueError("a plane has no end")
    reach = _REACH[kind]
    rows: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) if quat == IDENTITY else quat_to_rows(quat)
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
    if tree_extents is None or not isinstance(body, Articulated | Chain | Rope | Net | Ragdoll):
        raise ValueError(f"the size of a body of kind {body.kind} is not known")
    return tree_extents(body, quat, folder)


def points(shape: Any, folder: Path) -> list[Vec]:
    """Return points [m] in the body's frame whose convex hull is the shape, to within 3 % of its round parts.

    They serve for framing pictures; for bounds `extents` is exact.
    """
    found: list[Vec] = []
    for piece in pieces(shape, folder):
        found += (frame_apply(piece.pos, piece.quat, p) for p in _piece_points(piece))
    return found


def _piece_points(piece: Piece) -> list[Vec]:
    size = piece.size
    if piece.kind in ("hull", "mesh"):
        return list(piece.vertices)
    if piece.kind == "box":
        x, y, z = (s / 2 for s in size)
        return [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    ring = [(math.cos(math.pi * k / 8), math.sin(math.pi * k / 8)) for k in range(16)]
    if piece.kind == "cylinder":
        return [(size[0] * c, size[0] * s, z) for c, s in ring for z in (-size[1] / 2, size[1] / 2)]
    latitudes = [(math.cos(math.pi * k / 16), math.sin(math.pi * k / 16)) for k in range(-8, 9)]
    ball = [(c * a, s * a, b) for a, b in latitudes for c, s in ring]
    rx, ry, rz = size if piece.kind == "ellipsoid" else (size[0],) * 3
    half = size[1] / 2 if piece.kind == "capsule" else 0.0
    return [(rx * x, ry * y, rz * z + math.copysign(half, z)) for x, y, z in ball]


class InnerFloor(NamedTuple):
    """The bottom of a hollow, in the body's frame."""

    height: float
    """Height [m] of the floor; of an open shape, of its lower end."""
    radius: float
    """Radius [m] of the free circle at the floor."""
    center: tuple[float, float]
    """x and y [m] of the circle's centre."""


def inner_floor(shape: Any) -> InnerFloor | None:
    """Return the lowest inner floor of a cup, tube or funnel (in a compound, an upright one), or None."""
    if isinstance(shape, Compound):
        floors = []
        for part in shape.solids.values():
            floor, upright = (
                inner_floor(part.shape),
                quat_rotate(quat_of(part.pose), (0.0, 0.0, 1.0))[2] > 1 - 1e-9,
            )
            if floor is not None and upright:
                x, y, z = part.pose.pos
                floors.append(InnerFloor(z + floor.height, floor.radius, (x + floor.center[0], y + floor.center[1])))
        return min(floors, default=None)
    if not isinstance(shape, Tube | Cup | Funnel):
        return None
    floor = shape.thickness if isinstance(shape, Cup) else 0.0
    return InnerFloor(floor - shape.height / 2, _wall(shape)[0][0], (0.0, 0.0))
