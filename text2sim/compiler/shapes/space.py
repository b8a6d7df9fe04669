"""Regions of space: whether points lie inside, and how to fill them."""

import math
from collections.abc import Sequence

from text2sim.compiler.shapes.boxes import middle, sides
from text2sim.compiler.shapes.rotation import (
    Z_AXIS,
    Rows,
    Vec,
    quat_between,
    quat_conjugate,
    quat_rotate,
    quat_to_rows,
    rows_apply,
    vector_times,
    vector_unit,
)
from text2sim.spec_schema.models.space import BoxRegion, CylinderRegion, SphereRegion


class SpaceError(ValueError):
    """A region that cannot be used."""


class Space:
    """A region in its own frame: about its middle, a cylinder's axis along z."""

    def __init__(self, region: BoxRegion | CylinderRegion | SphereRegion) -> None:
        self.kind = region.kind
        self._turn: Rows | None = None
        """Into the region's frame; None where it has the axes of the world."""
        if isinstance(region, BoxRegion):
            box = region.min, region.max
            self.middle, self.half, self.radius = middle(box), vector_times(sides(box), 0.5), 0.0
            self.volume = math.prod(sides(box))
            return
        r = self.radius = region.radius
        self.middle = region.center
        if isinstance(region, SphereRegion):
            self.half, self.volume = (r, r, r), 4 / 3 * math.pi * r**3
            return
        self.half, self.volume = (r, r, region.height / 2), math.pi * r * r * region.height
        try:
            axis = vector_unit(region.axis)
        except ValueError as error:
            raise SpaceError(f"axis: {error}") from None
        if axis != Z_AXIS:
            self._back = quat_between(Z_AXIS, axis)
            self._turn = quat_to_rows(quat_conjugate(self._back))

    def _local(self, v: Vec) -> Vec:
        return v if self._turn is None else rows_apply(self._turn, v)

    def _world(self, v: Vec) -> Vec:
        x, y, z = v if self._turn is None else quat_rotate(self._back, v)
        return (self.middle[0] + x, self.middle[1] + y, self.middle[2] + z)

    def sample(self, numbers: Vec, margin: float) -> Vec:
        """Return a point [m] of the region, `margin` [m] off its walls, from three numbers in 0..1."""
        a, b, c = numbers
        hx, hy, hz = (max(h - margin, 0.0) for h in self.half)
        if self.kind == "box":
            return self._world(((2 * a - 1) * hx, (2 * b - 1) * hy, (2 * c - 1) * hz))
        angle = 2 * math.pi * b
        if self.kind == "cylinder":
            r = hx * math.sqrt(a)
            return self._world((r * math.cos(angle), r * math.sin(angle), (2 * c - 1) * hz))
        r, z = hx * a ** (1 / 3), 2 * c - 1
        flat = math.sqrt(max(1 - z * z, 0.0))
        return self._world((r * flat * math.cos(angle), r * flat * math.sin(angle), r * z))

    def contains(self, p: Vec, points: Sequence[Vec], rounding: float) -> bool:
        """Return whether points [m] about `p`, thickened by `rounding` [m], are inside.

        Args:
            p: Origin that the points are given about [m].
            points: Points relative to `p` [m].
            rounding: Radius of a ball around each point [m].
        """
        x, y, z = self._local((p[0] - self.middle[0], p[1] - self.middle[1], p[2] - self.middle[2]))
        hx, hy, hz = (h - rounding for h in self.half)
        square = max(self.radius - rounding, 0.0) ** 2
        for point in points:
            a, b, c = self._local(point)
            a, b, c = a + x, b + y, c + z
            if self.kind == "box":
                if abs(a) > hx or abs(b) > hy or abs(c) > hz:
                    return False
            elif self.kind == "cylinder":
                if abs(c) > hz or a * a + b * b > square:
                    return False
            elif a * a + b * b + c * c > square:
                return False
        return True

    def lattice(self, cell: Vec, gap: float) -> list[Vec]:
        """Return the centres [m] of cells of a lattice that lie inside, apart from half the gap around each."""
        half = self.half
        if self._turn is not None:
            hx, hy, hz = (sum(abs(r[k]) * h for r, h in zip(self._turn, self.half, strict=True)) for k in range(3))
            half = (hx, hy, hz)
        steps = [max(int((2 * h + gap) / c + 1e-9), 0) for h, c in zip(half, cell, strict=True)]
        ex, ey, ez = ((c - gap) / 2 * (1 - 1e-9) for c in cell)
        corners = [(x, y, z) for x in (-ex, ex) for y in (-ey, ey) for z in (-ez, ez)]
        found = []
        mx, my, mz = self.middle
        for k in range(steps[2]):
            for j in range(steps[1]):
                for i in range(steps[0]):
                    p = (
                        mx + (i - (steps[0] - 1) / 2) * cell[0],
                        my + (j - (steps[1] - 1) / 2) * cell[1],
                        mz + (k - (steps[2] - 1) / 2) * cell[2],
                    )
                    if self.kind == "box" or self.contains(p, corners, 0.0):
                        found.append(p)
        return found
