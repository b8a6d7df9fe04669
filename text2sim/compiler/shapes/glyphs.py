"""Letters of texts and pieces of sketches: each with its place, and all together, as outlines of extrusions are."""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from shapely import MultiPolygon, Polygon, unary_union
from shapely.affinity import affine_transform, translate

from text2sim.compiler.shapes.lettering import Letter, areas, letters
from text2sim.compiler.shapes.outlines import outlined
from text2sim.compiler.shapes.sketching import Stroke, strokes
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.shapes import Extrusion, FlatShape, Sketch, Text


@dataclass(frozen=True, eq=False)
class Glyph:
    """A letter of a text, or a connected piece of a sketch."""

    form: Polygon | MultiPolygon
    """In x and z [m], about the middle of its own bounds."""
    offset: tuple[float, float]
    """Where that middle is in the whole [m], x and z."""
    row: int
    """From the top."""
    column: int
    """In its row, from the left."""


def glyph_parts(shape: Text | Sketch, folder: Path) -> list[Glyph]:
    """Return all letters of a text, blanks left out, or all pieces of a sketch, in reading order.

    The `part` of the shape is ignored.

    Raises:
        AssetError: if the font or picture cannot be used, or there is nothing in it.
    """
    found = letters(shape.text, shape.font, folder) if isinstance(shape, Text) else strokes(shape.file, folder)
    return list(_scaled(tuple(found), shape.height))


@lru_cache(maxsize=256)
def _scaled(found: tuple[Letter | Stroke, ...], height: float) -> tuple[Glyph, ...]:
    bounds = [letter.form.bounds for letter in found]
    x = (min(b[0] for b in bounds) + max(b[2] for b in bounds)) / 2
    z = (min(b[1] for b in bounds) + max(b[3] for b in bounds)) / 2
    glyphs = []
    for letter, (x0, z0, x1, z1) in zip(found, bounds, strict=True):
        u, v = (x0 + x1) / 2, (z0 + z1) / 2
        form = affine_transform(letter.form, [height, 0, 0, height, -u * height, -v * height])
        glyphs.append(Glyph(form, ((u - x) * height, (v - z) * height), letter.row, letter.column))
    return tuple(glyphs)


def chosen(shape: Text | Sketch, folder: Path) -> list[Glyph]:
    """Return the letters or pieces that a shape means: all, or its one `part`, about its own middle.

    Raises:
        AssetError: if there is no such part, or the font or picture cannot be used.
    """
    found = glyph_parts(shape, folder)
    if shape.part is None:
        return found
    if shape.part >= len(found):
        what = "letter" if shape.kind == "text" else "piece"
        count = f"{len(found)} {what}s, 0 to {len(found) - 1}" if len(found) > 1 else f"one {what}, 0"
        raise AssetError(f"the {shape.kind} has {count}; there is no part {shape.part}")
    return [replace(found[shape.part], offset=(0.0, 0.0))]


def whole(shape: FlatShape, folder: Path) -> Polygon | MultiPolygon:
    """Return what a shape covers in x and z [m], about its frame's origin.

    Raises:
        AssetError: if there is no such part, or the font, picture or outline cannot be used.
    """
    if isinstance(shape, Extrusion):
        return outlined(shape)
    return _together(tuple(chosen(shape, folder)))


@lru_cache(maxsize=256)
def _together(glyphs: tuple[Glyph, ...]) -> Polygon | MultiPolygon:
    forms = [translate(glyph.form, *glyph.offset) if any(glyph.offset) else glyph.form for glyph in glyphs]
    return forms[0] if len(forms) == 1 else areas(unary_union(forms))
