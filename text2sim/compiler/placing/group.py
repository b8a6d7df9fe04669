"""Copies that are placed together, or that others are placed on."""

import math
from collections.abc import Iterable

from text2sim.compiler.shapes.boxes import Bounds, middle
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    Z_AXIS,
    Quaternion,
    Vec,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    quat_to_rows,
    vector_unit,
)
from text2sim.compiler.shapes.sizes import MAX_PIECES, CopySpot, SizeError, Sizes
from text2sim.compiler.shapes.skin import skin_of
from text2sim.compiler.shapes.solid import Solid

EXACT_SHAPES = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh")
"""Shapes that touch exactly where their bounds are; others touch by flat pieces, which lie within."""


class PlacedGroup:
    """One body, or several copies: their bounds, and their pieces where they are."""

    def __init__(self, spots: Iterable[CopySpot], sizes: Sizes) -> None:
        self.sizes = sizes
        self.members: list[CopySpot] = []
        self.planes: list[CopySpot] = []
        for spot in spots:
            plane = spot.shape is not None and spot.shape.kind == "plane"
            (self.planes if plane else self.members).append(spot)
        self._bounds: Bounds | None = None
        self._solids: list[Solid] | None = None

    def bounds(self, frame: Quaternion | None = None) -> Bounds:
        """Return the bounds [m] of all copies but planes, along the axes of the world or of `frame`."""
        if frame is None and self._bounds is not None:
            return self._bounds
        low, high = [math.inf] * 3, [-math.inf] * 3
        back = None if frame is None or frame == IDENTITY else quat_conjugate(frame)
        for spot in self.members:
            pos, quat = spot.pos, spot.quat
            if back is not None:
                pos, quat = quat_rotate(back, pos), quat_multiply(back, quat)
            a, b = self.sizes.of(spot, quat)
            for k in range(3):
                low[k], high[k] = min(low[k], pos[k] + a[k]), max(high[k], pos[k] + b[k])
        found = (low[0], low[1], low[2]), (high[0], high[1], high[2])
        if frame is None:
            self._bounds = found
        return found

    def lowest(self, axis: Vec) -> float:
        """Return the lowest coordinate [m] along a unit vector at which a copy can touch something."""
        return min(self._lowest(spot, axis) for spot in self.members)

    def _lowest(self, spot: CopySpot, axis: Vec) -> float:
        kind = None if spot.shape is None else spot.shape.kind
        upright = axis == Z_AXIS and not (spot.quat[1] or spot.quat[2])
        if upright and kind not in (None, "compound", "sculpt"):
            bottom = self.sizes.of(spot)[0][2]
        elif kind in EXACT_SHAPES:
            back = quat_conjugate(quat_between(Z_AXIS, axis))
            bottom = self.sizes.of(spot, quat_multiply(back, spot.quat))[0][2]
        else:
            bottom = self.sizes.lowest(spot, axis)
        return bottom + axis[0] * spot.pos[0] + axis[1] * spot.pos[1] + axis[2] * spot.pos[2]

    def middle(self) -> Vec:
        """Return the middle [m] of the bounds; of a group of planes, the first one's origin."""
        if not self.members:
            return self.planes[0].pos
        return middle(self.bounds())

    def frame(self) -> Quaternion:
        """Return the orientation that all copies share; that of the world if they do not."""
        turns = {spot.quat for spot in self.members}
        return turns.pop() if len(turns) == 1 else IDENTITY

    def upward(self, x: float, y: float) -> Vec:
        """Return the normal of the flat face that is on top at a place [m].

        Of a plane it is the plane's; of what is round there, or not there, that of its uppermost side: along an axis of
        the frame that copies share.
        """
        if self.planes:
            return quat_rotate(self.planes[0].quat, Z_AXIS)
        found = None
        if any(spot.shape is None or spot.shape.kind not in EXACT_SHAPES[:-1] for spot in self.members):
            found = self._face_at(x, y)
        if found is not None:
            return found
        axes = [
            quat_rotate(self.frame(), [sign * (k == i) for i in range(3)]) for k in range(3) for sign in (1.0, -1.0)
        ]
        return max(axes, key=lambda axis: axis[2])

    def _face_at(self, x: float, y: float) -> Vec | None:
        """Return the normal of the face that a drop falls on; None where there is none, or it is part of a curve."""
        import numpy as np

        found, top = None, -math.inf
        for spot in self.members:
            turn = np.array(quat_to_rows(spot.quat)).T
            for row in self.sizes.pieces(spot):
                corners = skin_of([row]).triangles @ turn + spot.pos
                sides = np.roll(corners, -1, axis=1) - corners
                normals = np.cross(sides[:, 0], sides[:, 1])
                # Seen from above, the drop lies to the left of every side; on a side, it is on both faces.
                left = (sides[..., 0] * (y - corners[..., 1]) - sides[..., 1] * (x - corners[..., 0])).min(1)
                up = normals[:, 2]
                hit = (up > 1e-9 * np.linalg.norm(normals, axis=1)) & (left >= -1e-9 * up)
                for normal, corner in zip(normals[hit], corners[hit, 0], strict=True):
                    height = corner[2] - ((x, y) - corner[:2]) @ normal[:2] / normal[2]
                    if height > top + 1e-9:
                        flat = row[0].kind in ("box", "hull", "mesh")
                        found, top = vector_unit(normal.tolist()) if flat else None, float(height)
        return found

    def solids(self) -> list[Solid]:
        """Return the convex pieces of all copies but planes.

        Raises:
            SizeError: if there are more than any scene can have.
        """
        if self._solids is None:
            found: list[Solid] = []
            for spot in self.members:
                found += self.sizes.solids(spot)
                if len(found) > MAX_PIECES:
                    raise SizeError(f"with this, the scene has more than {MAX_PIECES:,} convex pieces, too many")
            self._solids = found
        return self._solids
