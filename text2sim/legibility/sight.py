"""Sight of a camera: what it sees of each thing, and what it would see of it if nothing else were there.

A rasteriser makes pixels of all triangles at once. Each pixel shows the nearest; a thing is hidden at those that it
would cover alone and where something else is seen. So one pass tells how much of every thing is hidden, and by what.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from text2sim.drawing.raster import Raster
from text2sim.drawing.view import PictureView

Array = NDArray[Any]

SPECK_PIXELS = 0.25
"""Pixels that something counts for which is seen, but lies between the middles of pixels."""
MIN_PIXELS = 4
"""A thing that would cover fewer is too small for saying what part of it is hidden."""
RING_WIDTH = 3
"""Pixels around a thing that it is compared with."""


class Things(NamedTuple):
    """What there is to be seen at a moment."""

    triangles: Array
    """[m], shape (n, 3, 3)"""
    owner: Array
    """Index of the thing that each triangle is of, shape (n,)"""
    solid: NDArray[np.bool_]
    """Whether each triangle hides what is behind it, shape (n,): a drum may have a front of glass"""
    number: int
    """How many things there are, m."""
    culled: NDArray[np.bool_] | None = None
    """Triangles that are seen from outside only, shape (n,); none if left out."""


class Measures(NamedTuple):
    """How well a thing is seen in a picture."""

    share: float
    """Part of the picture that it fills."""
    hidden: float | None
    """Part of what the picture would show of it that others hide; None if that is too small to tell."""
    inside: float
    """Part of its points that are in the picture, hidden or not."""
    edge: float | None
    """Distance from the edge of the picture, in heights of it; None if it is not seen."""
    contrast: float | None
    """Distance in colour from what is around it, 0 to 1; None if that is not known."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What a camera sees.

    Attributes:
        seen: Pixels at which each thing is seen, shape (m,).
        alone: Pixels at which it would be seen if nothing else were there, shape (m,).
        inside: Part of its points that are in the picture, shape (m,).
    """

    view: PictureView
    front: Array
    """Solid thing at each pixel, row by row, -1 for none, shape (h w,)."""
    pixels: Array
    """Pixels that things cover, seen or not, and"""
    things: Array
    """which thing that is: each pair once."""
    visible: NDArray[np.bool_]
    """Whether that thing is seen there."""
    seen: Array
    alone: Array
    inside: Array

    @property
    def size(self) -> int:
        """Pixels of the picture."""
        return self.view.width * self.view.height

    @cached_property
    def hidden(self) -> Array:
        """Part of each thing that others hide, shape (m,)."""
        return np.clip(1 - self.seen / np.maximum(self.alone, 1e-9), 0, 1) * (self.alone > 0)

    def mask(self, thing: int) -> NDArray[np.bool_]:
        """Return where a thing is seen, shape (h, w)."""
        found = np.zeros(self.size, bool)
        found[self.pixels[self.visible & (self.things == thing)]] = True
        return found.reshape(self.view.height, self.view.width)

    def hiders(self, thing: int) -> Iterator[tuple[int, float]]:
        """Yield what hides a thing, the most first, with the part of the thing that it hides."""
        pixels = self.pixels[~self.visible & (self.things == thing)]
        counts = np.bincount(self.front[pixels] + 1)[1:]
        for other in np.argsort(-counts, kind="stable").tolist():
            if counts[other]:
                yield other, float(counts[other] / self.alone[thing])

    def measures(self, picture: Array | None = None) -> list[Measures]:
        """Return how well each thing is seen.

        Args:
            picture: Colours 0 to 1, shape (h, w, 3), for contrast.
        """
        edges = self._edges()
        return [
            Measures(
                float(self.seen[k] / self.size), float(self.hidden[k]) if self.alone[k] >= MIN_PIXELS else None,
                float(self.inside[k]),
                float(edges[k]) if np.isfinite(edges[k]) else None,
                None if picture is None else contrast(picture, self.mask(k)),
            )
            for k in range(len(self.seen))
        ]  # fmt: skip

    def _edges(self) -> Array:
        """Distance of each thing from the edge of the picture [heights], infinite if it is not seen."""
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
    inside = _specks(things, view, nearness, seen, alone)
    return Sight(view, front, pixels, owners, visible, seen, alone, inside)


def _specks(things: Things, view: PictureView, nearness: Array, seen: Array, alone: Array) -> Array:
    """Count what lies between pixels, in place; return which part of each thing's points is in the picture."""
    count = things.number
    points, owner = things.triangles.reshape(-1, 3), np.repeat(things.owner, 3)
    pixels, depth = view.pixels(points), -view.local(points)[:, 2]
    with np.errstate(invalid="ignore"):
        within = ((pixels >= 0) & (pixels < (view.width, view.height))).all(axis=1) & (depth > view.near)
    column, row = np.floor(pixels[within]).astype(int).T
    ahead = 1.0 / depth[within] >= nearness[row * view.width + column] * (1 - 1e-3)
    there, shown = (np.bincount(rows, minlength=count) for rows in (owner[within], owner[within][ahead]))
    tiny = (alone == 0) & (there > 0)
    alone[tiny] = SPECK_PIXELS
    seen[(seen == 0) & (shown > 0)] = SPECK_PIXELS
    return there / np.maximum(np.bincount(owner, minlength=count), 1)


def contrast(picture: Array, mask: NDArray[np.bool_]) -> float | None:
    """Return the distance in colour between what a mask shows and a ring around it, 0 to 1.

    Args:
        picture: Colours 0 to 1, shape (h, w, 3).
        mask: Shape (h, w).

    Returns:
        The distance; None if the mask is empty, or nothing is around it.
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
    """Return a mask with what is at most some pixels away from it, along rows and columns in turn."""
    for _ in range(pixels):
        found = mask.copy()
        found[1:] |= mask[:-1]
        found[:-1] |= mask[1:]
        found[:, 1:] |= mask[:, :-1]
        found[:, :-1] |= mask[:, 1:]
        mask = found
    return mask
