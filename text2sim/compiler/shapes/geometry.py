"""Geometry of shapes: their convex pieces, their drawn surface and volume."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from text2sim.compiler.memory import Memory
from text2sim.compiler.shapes.casemesh import load_mesh, load_paint
from text2sim.compiler.shapes.distance_field import field_of
from text2sim.compiler.shapes.fragment import Fragment, fragment_pieces
from text2sim.compiler.shapes.hulls import corners_and_sides
from text2sim.compiler.shapes.meshfile import errors_about
from text2sim.compiler.shapes.piece import Piece, cone_piece, hull_piece, ring_pieces, wall_pieces, wall_radii
from text2sim.compiler.shapes.rotation import Z_AXIS, quat_between, quat_of, quat_rotate, vector_times, vector_unit
from text2sim.compiler.shapes.sagging import disc_pieces, sheet_pieces, sleeve_pieces
from text2sim.compiler.shapes.sculpting import pieces_of, sculpted
from text2sim.compiler.shapes.surface import Drawn, VisualMesh, surface
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.base import content_of
from text2sim.spec_schema.models.faceted import Faceted
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import (
    Compound,
    Cup,
    Extrusion,
    FlatShape,
    Funnel,
    Mesh,
    Sketch,
    Stream,
    Text,
    Tube,
)
from text2sim.spec_schema.models.sheets import Disc, Revolve, Ribbon, Sheet, Sleeve

_PIECES: Memory[list[Piece]] = Memory(4096)
"""Pieces of shapes, so that copies and equal bodies share them and all that is derived from them."""
_SURFACES: Memory[VisualMesh] = Memory(4096)
"""Drawn surfaces, likewise."""


def pieces(shape: Any, folder: Path) -> list[Piece]:
    """Return the convex pieces with which a shape touches others, in the body's frame.

    Hollow shapes become staves (see `piece.wall_pieces`), a torus becomes capsules, a cone a pyramid; a mesh stays
    one piece, which the engine makes convex. Equal shapes have the same pieces.

    Args:
        shape: Any shape but a plane.
        folder: The case's folder, for meshes.

    Raises:
        AssetError: if a mesh file cannot be used.
    """
    return list(_PIECES.recall(key_of(shape, folder), lambda: _pieces(shape, folder)))


def key_of(shape: Any, folder: Path) -> Any:
    """Return a key that is equal for shapes with the same pieces; files count by their content.

    Raises:
        AssetError: if a file cannot be used.
    """
    if isinstance(shape, Compound):
        parts = (part.shape for part in shape.parts.values())
        return (content_of(shape), *(_content(part, folder) for part in parts))
    if isinstance(shape, Sculpt | Faceted | Revolve | Ribbon | Extrusion):
        return content_of(shape)
    return (*vars(shape).values(), _content(shape, folder))


def _content(shape: Any, folder: Path) -> Any:
    """Return what was read from the file of a shape, an object that is equal only to itself."""
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
    if isinstance(shape, Stream):
        return [_stream_piece(shape)]
    if kind == "cone":
        return [cone_piece(shape.radius, shape.height, shape.top_radius)]
    if isinstance(shape, Faceted):
        return [hull_piece(*corners_and_sides(shape.points))]
    if kind == "torus":
        return ring_pieces(shape.radius, shape.bar_radius, shape.segments)
    if kind == "mesh":
        return [_mesh_piece(shape, folder)]
    if isinstance(shape, FlatShape):
        from text2sim.compiler.shapes.flatforms import prisms

        return prisms(shape, folder)
    if isinstance(shape, Sculpt):
        return pieces_of(shape)
    if isinstance(shape, Fragment):
        return fragment_pieces(shape)
    if isinstance(shape, Sheet):
        return sheet_pieces(shape)
    if isinstance(shape, Disc):
        return disc_pieces(shape)
    if isinstance(shape, Sleeve):
        return sleeve_pieces(shape)
    if isinstance(shape, Revolve):
        from text2sim.compiler.shapes.revolved import revolved_pieces

        return revolved_pieces(shape)
    if isinstance(shape, Ribbon):
        from text2sim.compiler.shapes.ribbons import ribbon_pieces

        return ribbon_pieces(shape)
    if kind == "compound":
        return [
            piece.at(part.pose.pos, quat_of(part.pose), name)
            for name, part in shape.solids.items()
            for piece in pieces(part.shape, folder)
        ]
    if kind == "plane":
        raise ValueError("a plane has no pieces")
    if not isinstance(shape, Tube | Cup | Funnel):
        raise TypeError(f"the pieces of a shape of kind {kind} are not known")
    bottom, top = wall_radii(shape)
    half = shape.height / 2
    if isinstance(shape, Cup):
        staves = wall_pieces(bottom, top, shape.thickness - half, half, shape.segments)
        floor = Piece("cylinder", pos=(0.0, 0.0, shape.thickness / 2 - half), size=(shape.radius, shape.thickness))
        return [floor, *staves]
    return wall_pieces(bottom, top, -half, half, shape.segments)


def _stream_piece(stream: Stream) -> Piece:
    """Return what just comes out of a mouth, by half of its radius."""
    direction, long = vector_unit(stream.direction), stream.radius / 2
    turned = quat_between(Z_AXIS, direction)
    return Piece("cylinder", pos=vector_times(direction, long / 2), quat=turned, size=(stream.radius, long))


def _mesh_piece(shape: Mesh, folder: Path) -> Piece:
    mesh, scale = load_mesh(shape.file, folder), shape.scale
    corners = tuple((x * scale, y * scale, z * scale) for x, y, z in mesh.hull_vertices.tolist())
    faces = tuple((a, b, c) for a, b, c in mesh.hull_faces.tolist())
    enclosed = mesh.volume * scale**3 if mesh.closed else 0.0
    field = None
    if shape.collision == "exact":
        if not mesh.closed:
            raise AssetError(
                f"mesh file `{shape.file}` is open, or its triangles face different ways: without an inside it "
                "cannot have exact contact; close it, or use another `collision`"
            )
        with errors_about(f"mesh file `{shape.file}`"):
            field = field_of(mesh.vertices * scale, mesh.faces, shape.cell)
    return Piece(
        "mesh", size=(scale,), vertices=corners, faces=faces, file=shape.file, enclosed=enclosed,
        collision=shape.collision, field=field,
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
        return [replace(mesh, vertices=mesh.vertices * shape.scale) for mesh in load_paint(shape.file, folder)]
    if isinstance(shape, Sculpt):
        return sculpted(shape).visuals()
    if isinstance(shape, Fragment):
        return shape.solid.visuals()
    if isinstance(shape, Drawn):
        return [_SURFACES.recall(key_of(shape, folder), lambda: surface(shape))]
    if isinstance(shape, FlatShape):
        from text2sim.compiler.shapes.flatforms import flat_surface

        return [_SURFACES.recall(key_of(shape, folder), lambda: flat_surface(shape, folder))]
    return None


def volume(shape: Any, folder: Path) -> float:
    """Return the volume [m3] of the shape as described (its pieces may differ a little: `Piece.volume`).

    Parts of a compound that overlap count twice; a mesh that is not closed counts as its
    convex hull.

    Raises:
        AssetError: if a file of the shape cannot be used.
        ValueError: if the shape is a plane.
    """
    kind = shape.kind
    if kind == "compound":
        return sum(volume(part.shape, folder) for part in shape.solids.values())
    if kind == "mesh":
        return load_mesh(shape.file, folder).volume * shape.scale**3
    if isinstance(shape, Stream | Fragment):
        return shape.volume
    if kind == "cone":
        r, top = shape.radius, shape.top_radius
        return math.pi * (r * r + r * top + top * top) * shape.height / 3
    if kind == "torus":
        return 2 * math.pi**2 * shape.radius * shape.bar_radius**2
    if kind == "tube":
        return math.pi * (shape.outer_radius**2 - shape.inner_radius**2) * shape.height
    if kind == "cup":
        inner = shape.radius - shape.thickness
        return math.pi * (shape.radius**2 * shape.height - inner**2 * (shape.height - shape.thickness))
    if kind == "funnel":
        # The integral of pi ((r + t)^2 - r^2) over the height, with r linear in it.
        t = shape.thickness
        return math.pi * shape.height * t * (shape.top_radius + shape.bottom_radius + t)
    if isinstance(shape, FlatShape):
        from text2sim.compiler.shapes.glyphs import whole

        return whole(shape, folder).area * shape.depth
    if isinstance(shape, Sculpt):
        return sculpted(shape).volume
    if kind == "plane":
        raise ValueError("a plane has no volume")
    return pieces(shape, folder)[0].volume()


class InnerFloor(NamedTuple):
    """The bottom of a hollow, in the body's frame."""

    height: float
    """Height [m] of the floor, or of the lower end of an open shape."""
    radius: float
    """Radius [m] of the free circle at the floor."""
    center: tuple[float, float]
    """x and y [m] of the circle's centre."""


def inner_floor(shape: Any) -> InnerFloor | None:
    """Return the lowest inner floor of a cup, tube or funnel (in a compound, an upright one), or None."""
    if isinstance(shape, Compound):
        floors = []
        for part in shape.solids.values():
            floor = inner_floor(part.shape)
            if floor is not None and quat_rotate(quat_of(part.pose), Z_AXIS)[2] > 1 - 1e-9:
                x, y, z = part.pose.pos
                floors.append(InnerFloor(z + floor.height, floor.radius, (x + floor.center[0], y + floor.center[1])))
        return min(floors, default=None)
    if not isinstance(shape, Tube | Cup | Funnel):
        return None
    floor = shape.thickness if isinstance(shape, Cup) else 0.0
    return InnerFloor(floor - shape.height / 2, wall_radii(shape)[0][0], (0.0, 0.0))
