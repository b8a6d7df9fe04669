"""Rasteriser of triangles in numpy.

It uses the homogeneous form of Olano and Greer ("Triangle scan conversion using 2D homogeneous coordinates", 1997): the
inverse of the matrix of a triangle's projected corners gives three functions that are linear in the pixel and positive
inside. No triangle needs clipping, even if it crosses the plane of the eye. A fourth function cuts at the near plane.
All triangles are processed at once: split into rows of pixels, then into pixels. The nearest at each pixel is the
largest of numbers that combine nearness and index of the triangle.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from text2sim.drawing.view import PictureView

CHUNK_FRAGMENTS = 1 << 20
"""Fragments that are processed at a time: about 60 MB."""
TRIANGLE_MARGIN = 1e-6
"""Margin of a triangle [pixels], so that there are no gaps between neighbours."""


class Fragments(NamedTuple):
    """Pixels of triangles."""

    pixel: np.ndarray
    """Row times width, plus column, (n,) int."""
    nearness: np.ndarray
    """Nearness to the eye, positive, (n,) float32."""
    triangle: np.ndarray
    """Index of the triangle, (n,) int32."""


class Raster:
    """Projected triangles.

    Attributes:
        view: The camera.
        ids: (height, width) int32: the visible triangle of each pixel, -1 for none.
        nearness: (height, width) float32, positive: 1 / depth [1/m], or in parallel projection a linear measure of
            depth; 0 for background.
    """

    def __init__(self, triangles: np.ndarray, view: PictureView, culled: np.ndarray | None = None) -> None:
        """Prepare triangles.

        Args:
            triangles: (n, 3, 3) float [m], counterclockwise from outside.
            view: The camera.
            culled: (n,) bool: triangles that are only visible from outside; none if left out.
        """
        self.view = view
        corners = view.homogeneous(np.asarray(triangles, float))
        weights = np.empty_like(corners)
        for k in range(3):
            weights[:, k] = _cross(corners[:, (k + 1) % 3], corners[:, (k + 2) % 3])
        det = np.einsum("nk,nk->n", corners[:, 0], weights[:, 0])
        # Rows count downwards, so that triangles that are counterclockwise to the eye have negative determinants.
        usable = np.abs(det) > 1e-30
        if culled is not None:
            usable &= (det < 0) | ~culled
        self._weights = np.divide(weights, det[:, None, None], out=weights, where=usable[:, None, None])
        """(n, 3, 3): coefficients of x, y and 1 of each corner's weight, divided by depth."""
        self._deepness = self._nearness_of_corners(triangles)
        self._corners = corners
        self.chosen = np.flatnonzero(usable)
        self.ids = np.full((view.height, view.width), -1, np.int32)
        self.nearness = np.zeros((view.height, view.width), np.float32)

    def _nearness_of_corners(self, triangles: np.ndarray) -> np.ndarray:
        """Nearness at the corners, (n, 3), which is linear over the picture and increases towards the eye."""
        if not self.view.parallel:
            return np.ones(triangles.shape[:2])
        height = (triangles - self.view.origin) @ self.view.axes[2]
        self.lowest, highest = (float(height.min()), float(height.max())) if height.size else (0.0, 1.0)
        self.span = max(highest - self.lowest, 1e-9)
        return 0.25 + 0.75 * (height - self.lowest) / self.span

    def depth(self, nearness: np.ndarray) -> np.ndarray:
        """Return depths [m] in front of the eye; in parallel projection, in front of the view's origin."""
        if not self.view.parallel:
            return 1.0 / nearness
        return -(self.lowest + (nearness.astype(float) - 0.25) / 0.75 * self.span)

    def draw(self, triangles: np.ndarray | None = None) -> None:
        """Find the visible triangle of each pixel.

        Args:
            triangles: Indices of the triangles to draw; all if left out.
        """
        size = self.view.width * self.view.height
        best = np.zeros(size, np.uint64)
        for part in self.fragments(triangles):
            key = part.nearness.view(np.uint32).astype(np.uint64) << np.uint64(32)
            key |= part.triangle.view(np.uint32)
            np.maximum.at(best, part.pixel, key)
        shape = (self.view.height, self.view.width)
        seen = best > 0
        self.nearness = (best >> np.uint64(32)).astype(np.uint32).view(np.float32).reshape(shape)
        self.ids = np.where(seen, (best & np.uint64(0xFFFFFFFF)).astype(np.int64), -1).astype(np.int32).reshape(shape)

    def fragments(self, triangles: np.ndarray | None = None) -> Iterator[Fragments]:
        """Yield the pixels of triangles in chunks; see `draw`."""
        chosen = self.chosen
        if triangles is not None:
            wanted = np.zeros(len(self._corners), bool)
            wanted[triangles] = True
            chosen = chosen[wanted[chosen]]
        chosen, first, last = self._rows(chosen)
        counts = last - first + 1
        for part in _chunks(counts):
            yield from self._fragments(chosen[part], first[part], counts[part])

    def shares(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return barycentric coordinates (3, n) of points of the picture in triangles, and depths (n,) [m].

        Depths are measured from the eye along the view, in parallel projection from the view's origin.

        Args:
            triangle: Indices of triangles, shape (n,).
            x: Columns of the points, shape (n,) [pixels].
            y: Rows of the points, shape (n,) [pixels].
        """
        weights = self._weights[triangle].astype(np.float32)
        found = np.empty((3, len(triangle)), np.float32)
        for k in range(3):
            found[k] = weights[:, k, 0] * x + weights[:, k, 1] * y + weights[:, k, 2]
        total = found.sum(axis=0)
        if self.view.parallel:
            heights = self._deepness[triangle].astype(np.float32)
            depth = self.depth((found * heights.T).sum(axis=0))
        else:
            depth = 1.0 / np.maximum(total, 1e-9)
        np.maximum(found, 0.0, out=found)
        found /= np.maximum(found.sum(axis=0), 1e-30)
        return found, depth.astype(np.float32)

    def _rows(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The triangles in the picture, with the first and last row of each."""
        corners = self._corners[chosen]
        w = corners[:, :, 2]
        ahead = w > max(self.view.near * 0.1, 1e-12)
        whole = ahead.all(axis=1)
        divided = corners[:, :, :2] / np.where(ahead, w, 1.0)[:, :, None]
        low, high = divided.min(axis=1), divided.max(axis=1)
        low[~whole], high[~whole] = 0.0, (self.view.width, self.view.height)
        first = np.ceil(np.clip(low[:, 1], 0, self.view.height) - 0.5 - TRIANGLE_MARGIN).astype(np.int64)
        last = np.floor(np.clip(high[:, 1], 0, self.view.height) - 0.5 + TRIANGLE_MARGIN).astype(np.int64)
        np.maximum(first, 0, out=first)
        np.minimum(last, self.view.height - 1, out=last)
        seen = ahead.any(axis=1) & (last >= first) & (high[:, 0] > 0) & (low[:, 0] < self.view.width)
        return chosen[seen], first[seen], last[seen]

    def _fragments(self, chosen: np.ndarray, first: np.ndarray, counts: np.ndarray) -> Iterator[Fragments]:
        owner = np.repeat(np.arange(len(chosen)), counts)
        row = first[owner] + (np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts))
        weights = self._weights[chosen]
        near = np.einsum("nk,nkc->nc", self._deepness[chosen], weights)
        y = row + 0.5
        low, high = np.zeros(len(owner)), np.full(len(owner), float(self.view.width))
        edges = [weights[:, k] for k in range(3)]
        if not self.view.parallel:
            edges.append(np.array((0.0, 0.0, 1.0 / self.view.near)) - near)
        with np.errstate(divide="ignore", invalid="ignore"):
            for edge in edges:
                slope, rest = edge[owner, 0], edge[owner, 1] * y + edge[owner, 2]
                cut = -rest / slope
                low = np.where(slope > 0, np.maximum(low, cut), low)
                high = np.where(slope < 0, np.minimum(high, cut), high)
                high[(slope == 0) & (rest < 0)] = -1.0
        wide = self.view.width
        begin = np.ceil(np.clip(low, 0, wide + 1) - 0.5 - TRIANGLE_MARGIN).astype(np.int64)
        end = np.floor(np.clip(high, -1, wide) - 0.5 + TRIANGLE_MARGIN).astype(np.int64)
        np.maximum(begin, 0, out=begin)
        np.minimum(end, wide - 1, out=end)
        full = np.flatnonzero(end >= begin)
        owner, begin, widths, row = owner[full], begin[full], (end - begin + 1)[full], row[full]
        slope = near[owner, 0]
        at_zero = near[owner, 1] * (row + 0.5) + near[owner, 2] + 0.5 * slope
        for part in _chunks(widths):
            yield self._pixels(chosen[owner[part]], row[part], begin[part], widths[part], slope[part], at_zero[part])

    def _pixels(
        self,
        triangle: np.ndarray,
        row: np.ndarray,
        begin: np.ndarray,
        widths: np.ndarray,
        slope: np.ndarray,
        at_zero: np.ndarray,
    ) -> Fragments:
        """Split spans of rows into pixels."""
        ends = np.cumsum(widths)
        column = np.arange(int(ends[-1])) + np.repeat(begin - (ends - widths), widths)
        nearness = np.repeat(slope, widths) * column + np.repeat(at_zero, widths)
        return Fragments(
            np.repeat(row * self.view.width, widths) + column,
            np.maximum(nearness, 1e-12).astype(np.float32),
            np.repeat(triangle.astype(np.int32), widths),
        )


def _chunks(counts: np.ndarray) -> Iterator[slice]:
    """Yield slices of items whose counts (n,) sum to `CHUNK_FRAGMENTS` at most, or that are a single item."""
    ends = np.cumsum(counts)
    start, done = 0, 0
    while start < len(counts):
        stop = max(int(np.searchsorted(ends, done + CHUNK_FRAGMENTS, "right")), start + 1)
        yield slice(start, stop)
        start, done = stop, int(ends[stop - 1])


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products of rows; `np.cross` takes three times as long."""
    found = np.empty_like(a)
    found[:, 0] = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    found[:, 1] = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    found[:, 2] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return found
