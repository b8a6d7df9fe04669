"""Colours in which a case draws a body, or a part or link of it."""

from typing import Any


def drawn_colors(copy: Any, part: str | None) -> list[tuple[float, ...]]:
    """Return the colours (sRGB, 0 to 1) of a copy, or of one of its parts or links.

    Args:
        copy: A resolved copy of a body.
        part: Name of a part of its shape, or of a link; None for all of it.

    Returns:
        The colours; empty if a file defines them.

    Raises:
        ValueError: There is no such part or link.
    """
    from text2sim.compiler.looks import looks_of, rgba_of

    model = copy.model
    looks = list(looks_of(model))
    if part is not None:
        looks = _looks_of_part(model, part, copy.body)
    elif len(looks) > 1 and looks[0].color is None:
        looks = looks[1:]  # the copy has no look of its own
    kinds = {getattr(model, "kind", ""), getattr(getattr(model, "shape", None), "kind", "")}
    if looks[0].color is None and ("mesh" in kinds or getattr(model, "file", None) is not None):
        return []
    return [rgba_of(look, copy)[:3] for look in looks]


def _looks_of_part(model: Any, part: str, body: str) -> list[Any]:
    """Return the looks of the pieces of a part or link; a piece without one takes the part's, or else the body's."""
    named = {
        **(getattr(getattr(model, "shape", None), "parts", None) or {}),
        **(getattr(model, "links", None) or {}),
    }
    if part not in named:
        raise ValueError(f"`{body}` has no part `{part}` with a look of its own")
    look = named[part].look or model.look
    pieces = getattr(getattr(named[part], "shape", None), "parts", None) or {}
    return [piece.look or look for piece in pieces.values()] or [look]
