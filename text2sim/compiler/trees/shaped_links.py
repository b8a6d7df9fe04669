"""Links with a shape: pieces with their densities, and a surface with its colours."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from text2sim.compiler.looks import rgba_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.inertials import Inertial
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.compiler.trees.tree import TreeGeom, TreeLink, TreeVisual
from text2sim.spec_schema.models.materials import DENSITY, Look, Material
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.models.shapes import Compound, Part


def shaped_link(shape: Any, material: Material, look: Look, copy: Copy, name: str, folder: Path) -> TreeLink:
    """Return a link without joints, at the origin.

    Args:
        shape: The shape.
        material: Its material; a part may have its own density.
        look: Its look; a part may have its own.
        copy: The copy that the link belongs to, as palettes give each copy its colour.
        name: Of the link.
        folder: The case's folder.

    Raises:
        AssetError: if a file of the shape cannot be used.
    """
    geoms = geoms_of(shape, material, look, copy, folder)
    link = TreeLink(name, geoms=geoms, inertia=_inertia(shape, geoms))
    visuals = geometry.visual_mesh(shape, folder)
    if not look.visible:
        return replace(link, geoms=tuple(_hide(g) for g in geoms))
    parts: dict[Any, Any] = shape.parts if isinstance(shape, Compound | Sculpt) else {}
    hidden = {name for name, part in parts.items() if part.look is not None and not part.look.visible}
    geoms = tuple(_hide(g) if g.piece.part in hidden else g for g in geoms)
    if not visuals:
        return replace(link, geoms=geoms)
    drawn = tuple(
        _own_colored_surface(mesh, (parts[mesh.part].look if mesh.part in parts else None) or look, copy)
        for mesh in visuals
        if mesh.part not in hidden
    )
    meshed = {mesh.part for mesh in visuals} | ({None} if isinstance(shape, Sculpt) else set())
    shown = tuple(_hide(g) if g.piece.part in meshed else g for g in geoms)
    return replace(link, geoms=shown, visuals=drawn)


def geoms_of(shape: Any, material: Material, look: Look, copy: Copy, folder: Path) -> tuple[TreeGeom, ...]:
    """Return the convex pieces of a shape with density [kg/m3], friction and colour; see `shaped_link`.

    Args:
        shape: The shape.
        material: Its material.
        look: Its look.
        copy: The copy that the shape belongs to.
        folder: The case's folder.

    Raises:
        AssetError: if a file of the shape cannot be used.
    """
    parts = shape.parts if isinstance(shape, Compound) else {}
    pieces = geometry.pieces(shape, folder)
    densities = _densities(shape, pieces, material, folder)
    found = []
    for piece in pieces:
        part = parts.get(piece.part) if piece.part else None
        own = (part.look if part is not None else None) or look
        density = densities[piece.part, piece.kind]
        found.append(TreeGeom(piece, density, material.friction, rgba_of(own, copy), own, torques=material.torques))
    return tuple(found)


def _densities(
    shape: Any, pieces: list[Piece], material: Material, folder: Path
) -> dict[tuple[str | None, str], float]:
    """Return the density [kg/m3] of pieces by part (None for a shape without parts) and kind.

    The capsules of a ring overlap, and staves lack a little of a round wall: their density makes up for it, so that
    the whole weighs what the shape does. For a mesh, the volume is that of its pieces.
    """
    compound = isinstance(shape, Compound)
    parts: dict[Any, Part] = shape.solids if compound else {None: Part.model_construct(shape=shape)}
    densities, total = {}, 0.0
    for name, part in parts.items():
        made: dict[str, float] = {}
        for piece in pieces:
            if piece.part == name:
                made[piece.kind] = made.get(piece.kind, 0.0) + piece.volume()
        meant = sum(made.values()) if part.shape.kind == "mesh" else geometry.volume(part.shape, folder)
        own = part.density or material.density or DENSITY
        exact = made.pop("cylinder", 0.0)  # the floor of a cup has its true volume
        densities[name, "cylinder"] = own
        densities |= {(name, kind): own * (meant - exact) / sum(made.values()) for kind in made}
        total += own * meant
    if material.mass is None:
        return densities
    return {key: density * material.mass / total for key, density in densities.items()}


def _inertia(shape: Any, geoms: tuple[TreeGeom, ...]) -> Inertial | None:
    """Return the inertia of a sculpt or fragment from its surface, which its pieces do not fill exactly.

    Their masses add up to its mass.
    """
    if not isinstance(shape, Sculpt | Fragment):
        return None
    sculpture = sculpted(shape) if isinstance(shape, Sculpt) else shape.solid
    mass = sum(geom.density * geom.piece.volume() for geom in geoms)
    xx, yy, zz, xy, xz, yz = (moment * mass / sculpture.volume for moment in sculpture.inertia)
    return Inertial(mass, sculpture.center, (xx, yy, zz, xy, xz, yz))


def _own_colored_surface(mesh: VisualMesh, look: Look, copy: Copy) -> TreeVisual:
    """Return a surface in its own colours, if it has any and the case gives none."""
    if look.color is None and (mesh.picture is not None or mesh.rgba is not None):
        return TreeVisual(mesh, mesh.rgba)
    plain = mesh if mesh.picture is None and mesh.uvs is None else replace(mesh, picture=None, uvs=None)
    return TreeVisual(plain, rgba_of(look, copy), look)


def _hide(geom: TreeGeom) -> TreeGeom:
    return replace(geom, drawn=False)
