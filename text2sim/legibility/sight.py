"""Sight of a camera: the pixels at which each thing is visible, and those that it would cover alone.

A rasteriser turns all triangles into pixels at once. Each pixel shows the nearest thing. A thing is hidden at the
pixels that it would cover alone but where another thing is visible. So one pass finds which part of every thing is
hidden, and by what.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import triangle_areas
from text2sim.drawing.raster import Raster
from text2sim.drawing.view import PictureView

Array = NDArray[Any]

SPECK_PIXELS = 0.25
"""Number of pixels that a visible thing counts as if it lies between the centres of pixels."""
MIN_PIXELS = 4
"""Smallest number of pixels of a thing alone for which the hidden part can be measured."""
RING_WIDTH = 3
"""Width of the surroundings that a thing is compared with [pixels]."""

SIDE = 4
"""Number of parts that each side of a triangle is divided into, to find what part of it is in the picture."""
SLIVER = 1e-6
"""Area of a triangle without any, relative to the largest."""


class Things(NamedTuple):
    """Triangles of a scene at a moment."""

    triangles: Array
    """Corners [m], shape (n, 3, 3)."""
    owner: Array
    """Index of the thing of each triangle, shape (n,)."""
    solid: NDArray[np.bool_]
    """Whether each triangle hides what is behind it, shape (n,); parts of a thing may be of glass."""
    number: int
    """Number of things, m."""
    culled: NDArray[np.bool_] | None = None
    """Whether each triangle is only visible from outside, shape (n,); none is if left out."""


class Measures(NamedTuple):
    """Visibility of a thing in a picture."""

    share: float
    """Part of the picture that it fills."""
    hidden: float | None
    """Part of it that others hide, of what is in the picture; None if it is too small to measure."""
    inside: float
    """Part of its surface that is in the picture, hidden or not."""
    edge: float | None
    """Distance from the edge of the picture, in heights of the picture; None if it is not visible."""
    contrast: float | None
    """Distance in colour from its surroundings, 0 to 1; None if unknown."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What a camera sees."""

    view: PictureView
    front: Array
    """Nearest solid thing at each pixel, row by row, -1 for none, shape (h w,)."""
    pixels: Array
    """Pixels that things cover, visible or not; each pair of pixel and thing is listed once."""
    things: Array
    """The thing of each of these pairs."""
    visible: NDArray[np.bool_]
    """Whether this thing is visible at this pixel."""
    seen: Array
    """Number of pixels at which each thing is visible, shape (m,)."""
    alone: Array
    """Number of pixels at which it would be visible without the others, shape (m,)."""
    inside: Array
    """Part of the surface of each thing that is in the picture, whether anything hides it, shape (m,)."""

    @property
    def size(self) -> int:
        """Number of pixels of the picture."""
        return self.view.width * self.view.height

    @cached_property
    def hidden(self) -> Array:
        """Part of each thing that others hide, shape (m,)."""
        return np.clip(1 - self.seen / np.maximum(self.alone, 1e-9), 0, 1) * (self.alone > 0)

    def mask(self, thing: int) -> NDArray[np.bool_]:
        """Return the pixels at which a thing is visible as a mask, shape (h, w)."""
        found = np.zeros(self.size, bool)
        found[self.pixels[self.visible & (self.things == thing)]] = True
        return found.reshape(self.view.height, self.view.width)

    def hiders(self, thing: int) -> Iterator[tuple[int, float]]:
        """Yield the things that hide a thing, and the part of it that each hides, the largest part first."""
        pixels = self.pixels[~self.visible & (self.things == thing)]
        counts = np.bincount(self.front[pixels] + 1)[1:]
        for other in np.argsort(-counts, kind="stable").tolist():
            if counts[other]:
                yield other, float(counts[other] / self.alone[thing])

    def measures(self, picture: Array | None = None) -> list[Measures]:
        """Return the measures of each thing.

        Args:
            picture: Colours 0 to 1, shape (h, w, 3), for contrast.
        """
        edges = self._edges()
        return [
            Measures(
                share=float(self.seen[k] / self.size),
                hidden=float(self.hidden[k]) if self.alone[k] >= MIN_PIXELS else None,
                inside=float(self.inside[k]),
                edge=float(edges[k]) if np.isfinite(edges[k]) else None,
                contrast=None if picture is None else contrast(picture, self.mask(k)),
            )
            for k in range(len(self.seen))
        ]

    def _edges(self) -> Array:
        """Distance of each thing from the edge of the picture [heights]; infinite if it is not visible."""
        wide, tall = self.view.width, self.view.height
        pixels, things = self.pixels[self.visible], self.things[self.visible]
        row, column = pixels // wide, pixels % wide
        gaps = np.minimum(np.minimum(row, tall - 1 - row), np.minimum(column, wide - 1 - column)) / tall
        found = np.full(len(self.seen), np.inf)
        np.minimum.at(found, things, gaps)
        return found


def look(things: Things, view: PictureView) -> Sight:
    """Return what a camera sees of things."""
    count = things.number
    raster = Raster(things.triangles, view, things.culled)
    best = np.zeros(view.width * view.height, np.uint64)
    pairs = [np.zeros(0, np.int64)]
    for part in raster.fragments():
        owner = things.owner[part.triangle].astype(np.int64)
        pairs.append(np.unique(part.pixel * count + owner))
        front = things.solid[part.triangle]
        key = part.nearness[front].view(np.uint32).astype(np.uint64) << np.uint64(32)
        np.maximum.at(best, part.pixel[front], key | owner[front].astype(np.uint64))
    front = np.where(best > 0, (best & np.uint64(0xFFFFFFFF)).astype(np.int64), -1)
    nearness = (best >> np.uint64(32)).astype(np.uint32).view(np.float32)
    clear = [np.zeros(0, np.int64)]
    glass = np.flatnonzero(~things.solid)
    for part in raster.fragments(glass) if len(glass) else ():
        ahead = part.nearness > nearness[part.pixel]
        clear.append(np.unique(part.pixel[ahead] * count + things.owner[part.triangle[ahead]]))
    covered = np.unique(np.concatenate(pairs))
    pixels, owners = np.divmod(covered, max(count, 1))
    visible = (front[pixels] == owners) | np.isin(covered, np.concatenate(clear))
    seen, alone = (np.bincount(rows, minlength=count).astype(float) for rows in (owners[visible], owners))
    _count_specks(things, view, nearness, seen, alone)
    return Sight(view, front, pixels, owners, visible, seen, alone, _inside(things, view))


def _inside(things: Things, view: PictureView) -> Array:
    """Return the part of the surface of each thing that is within the picture."""
    points = np.einsum("pk,tkc->tpc", _samples(SIDE), things.triangles)
    within = _within(view, points.reshape(-1, 3)).reshape(points.shape[:2]).mean(axis=1)
    area = triangle_areas(things.triangles)
    area += SLIVER * area.max(initial=1.0)  # of what has no area at all, the points count
    found, whole = (np.bincount(things.owner, weights, things.number) for weights in (within * area, area))
    return found / np.maximum(whole, 1e-300)


def _samples(side: int) -> Array:
    """Return the corners of a triangle and the middles of equal parts of it, as weights of its corners, shape (n, 3).

    With the corners, only what is wholly in the picture counts as such.
    """
    rows = [(i, j, side - 1 - i - j) for i in range(side) for j in range(side - i)]
    upright = [(i + 1 / 3, j + 1 / 3, k + 1 / 3) for i, j, k in rows]
    turned = [(i + 2 / 3, j + 2 / 3, k - 1 / 3) for i, j, k in rows if k > 0]
    return np.concatenate([np.eye(3), np.array([*upright, *turned]) / side])


def _within(view: PictureView, points: Array) -> NDArray[np.bool_]:
    """Return which points (n, 3) [m] are in the picture, hidden or not."""
    pixels, depth = view.pixels(points), -view.local(points)[:, 2]
    with np.errstate(invalid="ignore"):
        return ((pixels >= 0) & (pixels < (view.width, view.height))).all(axis=1) & (depth > view.near)


def _count_specks(things: Things, view: PictureView, nearness: Array, seen: Array, alone: Array) -> None:
    """Count things between the centres of pixels in `seen` and `alone`."""
    count = things.number
    points, owner = things.triangles.reshape(-1, 3), np.repeat(things.owner, 3)
    within = _within(view, points)
    points, owner = points[within], owner[within]
    column, row = np.floor(view.pixels(points)).astype(int).T
    ahead = 1.0 / -view.local(points)[:, 2] >= nearness[row * view.width + column] * (1 - 1e-3)
    there, shown = (np.bincount(rows, minlength=count) for rows in (owner, owner[ahead]))
    tiny = (alone == 0) & (there > 0)
    alone[tiny] = SPECK_PIXELS
    seen[(seen == 0) & (shown > 0)] = SPECK_PIXELS


def contrast(picture: Array, mask: NDArray[np.bool_]) -> float | None:
    """Return the distance in mean colour between the pixels of a mask and a ring around them, 0 to 1.

    Args:
        picture: Colours 0 to 1, shape (h, w, 3).
        mask: The pixels, shape (h, w).

    Returns:
        The distance; None if mask or ring are empty.
    """
    if not mask.any():
        return None
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = np.s_[
        max(rows[0] - RING_WIDTH, 0) : rows[-1] + RING_WIDTH + 1,
        max(columns[0] - RING_WIDTH, 0) : columns[-1] + RING_WIDTH + 1,
    ]
    inner = mask[box]
    around = _grown(inner, RING_WIDTH) & ~inner
    if not around.any():
        return None
    colors = picture[box]
    return float(np.linalg.norm(colors[inner].mean(axis=0) - colors[around].mean(axis=0)) / np.sqrt(3))


def _grown(mask: NDArray[np.bool_], pixels: int) -> NDArray[np.bool_]:
    """A mask grown by a number of pixels along rows and columns, not along diagonals."""
    for _ in range(pixels):
        found = mask.copy()
        found[1:] |= mask[:-1]
        found[:-1] |= mask[1:]
        found[:, 1:] |= mask[:, :-1]
        found[:, :-1] |= mask[:, 1:]
        mask = found
    return mask
