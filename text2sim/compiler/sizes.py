"""Bounds of bodies and statics, worked out once for each orientation."""

from pathlib import Path
from typing import Any, NamedTuple

from text2sim.compiler.geometry import Bounds, TreeExtents, body_extents, extents
from text2sim.compiler.rotation import Quaternion, Vec


class Spot(NamedTuple):
    """Where one copy of a body or static is."""

    pos: Vec
    """[m]"""
    quat: Quaternion
    shape: Any
    """None for a tree of links."""
    model: Any


class SizeError(ValueError):
    """Something whose size is needed has none."""


class Sizes:
    """Gives bounds [m], and remembers them."""

    def __init__(self, folder: Path, tree_extents: TreeExtents | None = None) -> None:
        self.folder = folder
        self._tree_extents = tree_extents
        # The object is kept beside its bounds, so that its id stays its own.
        self._known: dict[tuple[int, Quaternion], tuple[Any, Bounds]] = {}

    def of(self, spot: Spot, quat: Quaternion | None = None) -> Bounds:
        """Return the bounds [m] about the copy's origin, turned by its orientation (or by `quat`).

        Raises:
            SizeError: for a plane, and for a tree of links that nobody can measure.
            AssetError: if a mesh file cannot be used.
        """
        thing = spot.model if spot.shape is None else spot.shape
        quat = spot.quat if quat is None else quat
        key = (id(thing), quat)
        found = self._known.get(key)
        if found is None:
            try:
                if spot.shape is None:
                    bounds = body_extents(spot.model, quat, self.folder, self._tree_extents)
                else:
                    bounds = extents(spot.shape, quat, self.folder)
            except ValueError as error:
                raise SizeError(str(error)) from None
            found = self._known[key] = (thing, bounds)
        return found[1]
