"""Patterns whose copies are the parts of a shape: letters of a text, pieces of a sketch, fragments."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.compiler.placing.fragmenting import fragmented, fragments_of
from text2sim.compiler.placing.lettering import letter_rows, lettered
from text2sim.compiler.placing.place_error import PatternError
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.spec_schema.errors import AssetError, Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.repeat import Divided, Fragments, Glyphs


def part_rows(model: Any, folder: Path) -> list[tuple[int, int]]:
    """Return the row and column of every copy of a body or static whose copies are parts; of others, nothing.

    Raises:
        PatternError: if its shape has no such parts.
        AssetError: if a file of its shape cannot be used.
    """
    if isinstance(model.repeat, Glyphs):
        return letter_rows(model, folder)
    if isinstance(model.repeat, Fragments):
        return [(0, column) for column in range(len(fragments_of(model, folder)))]
    return []


def part_counts(loaded: LoadedCase) -> tuple[dict[str, int], list[Problem]]:
    """Count the copies of bodies and statics whose copies are parts, and say what is wrong there."""
    counts: dict[str, int] = {}
    problems: list[Problem] = []
    for root, models in ((("scene", "statics"), loaded.case.scene.statics), (("bodies",), loaded.case.bodies)):
        for name, model in models.items():
            if not isinstance(model.repeat, Divided):
                continue
            try:
                counts[name] = len(part_rows(model, loaded.folder))
            except PatternError as error:
                problems.append(loaded.problem((*root, name, *error.where), str(error), rule="placement"))
            except AssetError as error:
                problems.append(loaded.problem((*root, name, "shape"), str(error), rule="asset"))
    return counts, problems


def divided(repeat: Divided, spots: Sequence[CopySpot], folder: Path) -> list[CopySpot]:
    """Return the copies, each with its own part of the shape, where that part is in the whole.

    Args:
        repeat: The pattern.
        spots: The copies, each at its body's own position and orientation.
        folder: The case's folder.

    Raises:
        PatternError: if a copy's shape has not as many parts as there are copies.
        AssetError: if a file of the shape cannot be used.
    """
    return lettered(spots, folder) if isinstance(repeat, Glyphs) else fragmented(spots, folder)
