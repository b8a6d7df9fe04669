"""`repeat: {kind: glyphs}`: one copy for each letter of a text or piece of a sketch, where it stands in it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.compiler.placing.place_error import PatternError
from text2sim.compiler.shapes.rotation import IDENTITY, quat_rotate
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.spec_schema.models.shapes import Sketch, Text

WRONG_SHAPE = "has one copy for each letter of a text or piece of a sketch; this is neither"
WITH_PART = "the copies are the parts; leave out `part`"


def letter_rows(model: Any, folder: Path) -> list[tuple[int, int]]:
    """Return the row and column of every copy of a body or static whose copies are letters or pieces.

    Raises:
        PatternError: if its shape has none.
        AssetError: if its font or picture cannot be used.
    """
    from text2sim.compiler.shapes.glyphs import glyph_parts

    shape = getattr(model, "shape", None)
    if not isinstance(shape, Text | Sketch):
        raise PatternError(f"glyphs {WRONG_SHAPE}", "repeat")
    if shape.part is not None:
        raise PatternError(WITH_PART, "shape", "part")
    return [(glyph.row, glyph.column) for glyph in glyph_parts(shape, folder)]


def lettered(spots: Sequence[CopySpot], folder: Path) -> list[CopySpot]:
    """Return the copies, each with its own part of the shape, where that part stands.

    Raises:
        PatternError: if a copy's shape has not as many parts as there are copies.
        AssetError: if its font or picture cannot be used.
    """
    from text2sim.compiler.shapes.glyphs import glyph_parts

    found = []
    for index, spot in enumerate(spots):
        shape = spot.shape
        if not isinstance(shape, Text | Sketch):
            raise PatternError(f"glyphs {WRONG_SHAPE}", "repeat")
        parts = glyph_parts(shape, folder)
        if len(parts) != len(spots):
            raise PatternError(f"copy {index}: its text has {len(parts)} letters, that of copy 0 {len(spots)}", "shape")
        x, z = parts[index].offset
        a, b, c = (x, 0.0, z) if spot.quat == IDENTITY else quat_rotate(spot.quat, (x, 0.0, z))
        pos = (spot.pos[0] + a, spot.pos[1] + b, spot.pos[2] + c)
        own = shape.model_copy(update={"part": index})
        found.append(spot._replace(pos=pos, shape=own, model=spot.model.model_copy(update={"shape": own})))
    return found
