"""A fragment of a shape that was cut: a shape that no case can name, only `repeat: {kind: fragments}` makes."""

from typing import Any, Literal

from text2sim.compiler.shapes.piece import Piece, hull_piece
from text2sim.compiler.shapes.rotation import Vec
from text2sim.spec_schema.models.base import Model


class Fragment(Model):
    """A piece of a shape, about the centre of its volume."""

    kind: Literal["fragment"] = "fragment"
    solid: Any
    """Its surface and its convex pieces: a `Sculpted`."""
    volume: float
    """Its part of the volume [m3] of the shape as described."""
    place: Vec
    """Its centre in the frame of the whole [m]."""
    bounds: tuple[Vec, Vec]
    """Lowest and highest corner of the whole in its frame [m]."""


def fragment_pieces(fragment: Fragment) -> list[Piece]:
    """Return the convex pieces with which a fragment touches others."""
    return [hull_piece(corners, net) for corners, net in fragment.solid.hulls]
