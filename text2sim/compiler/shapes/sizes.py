"""Bounds and pieces of bodies and statics, computed once for each orientation."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.shapes.boxes import Bounds, middle, sides
from text2sim.compiler.shapes.extents import TreeExtents, body_extents, extents
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec, frame_apply, quat_multiply
from text2sim.compiler.shapes.solid import Solid, solids

MAX_PIECES = 20_000
"""Most convex pieces of a scene. The engine keeps a table of all pairs of them, 1.6 GB for so many."""

TreePieces = Callable[[Any, Path], list[tuple[Piece, Vec, Quaternion]]]
"""Pieces of a body that is a tree of links, each with the pose [m] of its link in the body's frame."""


class CopySpot(NamedTuple):
    """Where one copy of a body or static is."""

    pos: Vec
    """[m]"""
    quat: Quaternion
    shape: Any
    """None for a tree of links."""
    model: Any


class SizeError(ValueError):
    """Something has no size, or too many pieces, where its size is needed."""


class Sizes:
    """Gives bounds [m] and pieces, and remembers them."""

    def __init__(
        self, folder: Path, tree_extents: TreeExtents | None = None, tree_pieces: TreePieces | None = None
    ) -> None:
        self.folder = folder
        self._tree_extents, self._tree_pieces = tree_extents, tree_pieces
        self._bounds: dict[tuple[ObjectKey, Quaternion], Bounds] = {}
        self._lowest: dict[tuple[ObjectKey, Quaternion, Vec], float] = {}
        self._trees: dict[ObjectKey, list[tuple[Piece, Vec, Quaternion]]] = {}

    def of(self, spot: CopySpot, quat: Quaternion | None = None) -> Bounds:
        """Return the bounds [m] about the copy's origin, turned by its orientation (or by `quat`).

        Raises:
            SizeError: for a plane, and for a tree of links if `tree_extents` is missing.
            AssetError: if a mesh file cannot be used.
        """
        quat = spot.quat if quat is None else quat
        key = (_key_of(spot), quat)
        found = self._bounds.get(key)
        if found is None:
            try:
                if spot.shape is None:
                    found = body_extents(spot.model, quat, self.folder, self._tree_extents)
                else:
                    found = extents(spot.shape, quat, self.folder)
            except ValueError as error:
                raise SizeError(str(error)) from None
            self._bounds[key] = found
        return found

    def lowest(self, spot: CopySpot, axis: Vec) -> float:
        """Return the lowest coordinate [m] of a copy's pieces along a unit vector, about the copy's origin."""
        key = (_key_of(spot), spot.quat, axis)
        found = self._lowest.get(key)
        if found is None:
            at_origin = self.solids(spot._replace(pos=ORIGIN))
            found = self._lowest[key] = min(solid.span(axis)[0] for solid in at_origin)
        return found

    def pieces(self, spot: CopySpot) -> list[tuple[Piece, Vec, Quaternion]]:
        """Return the convex pieces of a copy, each with the pose [m] of its frame in the copy's frame.

        Without `tree_pieces`, a tree of links counts as its bounds.
        """
        if spot.shape is not None:
            return [(piece, ORIGIN, IDENTITY) for piece in pieces(spot.shape, self.folder)]
        key = _key_of(spot)
        if key not in self._trees:
            if self._tree_pieces is not None:
                self._trees[key] = self._tree_pieces(spot.model, self.folder)
            else:
                box = self.of(spot, IDENTITY)
                self._trees[key] = [(Piece("box", size=sides(box)), middle(box), IDENTITY)]
        return self._trees[key]

    def solids(self, spot: CopySpot) -> list[Solid]:
        """Return the convex pieces of a copy where it is."""
        if spot.shape is not None:
            return solids(pieces(spot.shape, self.folder), spot.pos, spot.quat)
        return [
            Solid(piece, frame_apply(spot.pos, spot.quat, pos), quat_multiply(spot.quat, quat))
            for piece, pos, quat in self.pieces(spot)
        ]


def _key_of(spot: CopySpot) -> ObjectKey:
    return ObjectKey(spot.model if spot.shape is None else spot.shape)
