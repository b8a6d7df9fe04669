"""Points of bodies that something acts on or looks at: regions of copies and links, at the start."""

from pathlib import Path
from typing import Any

from text2sim.compiler.memory import ObjectKey
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.regions import RegionError, region_middle
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec, frame_apply
from text2sim.compiler.shapes.skin import SurfaceSkin, skin_of
from text2sim.compiler.trees.tree import Tree, tree_links, tree_pieces
from text2sim.spec_schema.models.regions import BodyRegion

_Standing = list[tuple[Piece, Vec, Quaternion]]


class BodyPoints:
    """Points on copies and their links.

    Args:
        trees: Trees of links by name of the copy; copies that have none are primitives.
        folder: The case's folder.
    """

    def __init__(self, trees: dict[str, Tree], folder: Path) -> None:
        self.trees, self.folder = trees, folder
        # Copies share shapes, and controls share regions.
        self._skins: dict[ObjectKey, SurfaceSkin] = {}
        self._middles: dict[tuple[ObjectKey, ObjectKey], Vec] = {}

    def on_link(self, copy: Copy, part: str | None, point: Vec | BodyRegion | None) -> Vec | None:
        """Return a point [m] in the frame of a link.

        Args:
            copy: The copy.
            part: Name of the link; the first one if None.
            point: A point [m] in the frame of the link, or a region of it.

        Raises:
            RegionError: if nothing lies in the region.
        """
        if not isinstance(point, BodyRegion):
            return point
        tree = self.trees.get(copy.name)
        if tree is None:
            return self._middle(copy.shape, point, [(p, ORIGIN, IDENTITY) for p in pieces(copy.shape, self.folder)])
        link = next((link for link in tree.links() if part in (None, link.name)), tree.roots[0])
        return self._middle(link, point, [(geom.piece, ORIGIN, IDENTITY) for geom in link.geoms if geom.touches])

    def in_world(self, copy: Copy, part: str | None, region: BodyRegion | None) -> Vec:
        """Return where a copy, a link of it, or the middle of a region of either is at the start [m].

        Args:
            copy: The copy.
            part: Name of a link; the whole copy if None.
            region: The region; the origin of the copy or link if None.

        Raises:
            RegionError: if nothing lies in the region.
        """
        tree = self.trees.get(copy.name)
        if part is not None and tree is not None:
            standing = next(row for row in tree_links(tree, copy.pos, copy.quat) if row.link.name == part)
            pos, quat = standing.pos, standing.quat
            return pos if region is None else frame_apply(pos, quat, self.on_link(copy, part, region) or ORIGIN)
        if region is None:
            return copy.pos
        if copy.shape is not None and copy.shape.kind == "plane":
            raise RegionError(f"`{copy.body}` is a plane, and has neither sides nor corners")
        if tree is None:
            return frame_apply(copy.pos, copy.quat, self.on_link(copy, None, region) or ORIGIN)
        whole = [standing[:3] for standing in tree_pieces(tree)]
        return frame_apply(copy.pos, copy.quat, self._middle(tree, region, whole))

    def _middle(self, owner: Any, region: BodyRegion, standing: _Standing) -> Vec:
        whole, key = ObjectKey(owner), (ObjectKey(owner), ObjectKey(region))
        if key not in self._middles:
            if whole not in self._skins:
                if not standing:
                    raise RegionError("it has no surface to touch")
                self._skins[whole] = skin_of(standing)
            self._middles[key] = region_middle(region, self._skins[whole])
        return self._middles[key]
