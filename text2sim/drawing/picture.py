"""Pictures of a stage: which triangle is seen where, then light on what is seen.

A picture is rasterised with twice as many pixels each way. A pixel that shows one triangle is lit once, one that shows
several is lit four times: edges are smooth at little more than the price of a single pixel.
"""

from dataclasses import dataclass

import numpy as np

from text2sim.drawing.lighting import Light
from text2sim.drawing.prop import Stage
from text2sim.drawing.raster import Raster
from text2sim.drawing.surfaces import GLOSS, Spots, decoded, dot, encoded, linear, lit, unit_columns
from text2sim.drawing.view import PictureView

Rgb = tuple[float, float, float]

STEEP = 6.0
"""Change of depth from pixel to pixel, in pixels, that is drawn as a line in a parallel view."""
LAYERS = 8
"""Most surfaces one sees through at a pixel."""


@dataclass(frozen=True)
class Style:
    """How a picture looks."""

    background: Rgb
    """sRGB"""
    outline: float = 0.0
    """How dark the line between two things is, from 0 to 1."""
    planes: bool = True
    """Whether grounds are drawn."""
    grid: float = 0.0
    """Distance [m] of the lines on a ground, of which those at whole metres, or at tens, are strong; 0 for none."""
    haze: float = 0.0
    """Distance [m] at which a ground has faded into the background by two thirds; 0 for never."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture, and what is seen in it."""

    pixels: np.ndarray
    """(height, width, 3) float32, sRGB in 0..1"""
    coverage: np.ndarray
    """(height, width) float32: how much of a pixel is not background"""
    owner: np.ndarray
    """(height, width) int32: number of the prop that is seen, -1 for none"""
    glazed: np.ndarray
    """(height, width) int32: number of the prop that one sees through first, -1 for none"""


def paint(props: Stage, view: PictureView, light: Light, style: Style) -> Picture:
    """Draw a stage as a camera sees it.

    Args:
        props: What is drawn.
        view: The camera.
        light: What lights it.
        style: How it looks.
    """
    return _Painter(props, view, light, style).paint()


class _Painter:
    def __init__(self, props: Stage, view: PictureView, light: Light, style: Style) -> None:
        self.props, self.view, self.light, self.style = props, view, light, style
        self.fine = view.scaled(2)
        self.raster = Raster(props.triangles, self.fine, props.culled)
        self.albedo = linear(props.colors)
        self.gloss = np.array([GLOSS[prop.finish] for prop in props], np.float32).reshape(-1, 3)
        self.opacity = np.array([prop.opacity for prop in props], np.float32)
        self.plane = np.array([prop.plane for prop in props], bool)
        self.owners = np.append(props.owner, np.int32(-1))
        """Number of the prop by number of the triangle; the last is for nothing, number -1."""

    def paint(self) -> Picture:
        """Draw everything."""
        opaque = self.opacity >= 1.0
        usable = opaque if self.style.planes else opaque & ~self.plane
        self.raster.draw(np.flatnonzero(usable[self.props.owner]))
        h, w = self.view.height, self.view.width
        ids = self.raster.ids.reshape(h, 2, w, 2).transpose(0, 2, 1, 3).reshape(-1, 4)
        whole = (ids == ids[:, :1]).all(axis=1)
        light = np.empty((h * w, 3), np.float32)
        light[:] = decoded(self.style.background)
        seen = np.flatnonzero(whole & (ids[:, 0] >= 0))
        light[seen] = self.shade(ids[seen, 0], 2.0 * (seen % w) + 1.0, 2.0 * (seen // w) + 1.0)
        mixed = np.flatnonzero(~whole)
        parts = ids[mixed].ravel()
        x = (2.0 * (mixed % w)[:, None] + (0.5, 1.5, 0.5, 1.5)).ravel()
        y = (2.0 * (mixed // w)[:, None] + (0.5, 0.5, 1.5, 1.5)).ravel()
        colors = np.empty((len(parts), 3), np.float32)
        colors[:] = decoded(self.style.background)
        there = np.flatnonzero(parts >= 0)
        colors[there] = self.shade(parts[there], x[there], y[there])
        # Mixed as sRGB would be: edges of bright things against dark ones are smoother so.
        light[mixed] = decoded(encoded(colors).reshape(-1, 4, 3).mean(axis=1))
        coverage = (ids >= 0).mean(axis=1, dtype=np.float32)
        owner = self.owners[ids[:, 0]]
        glazed = np.full(h * w, -1, np.int32)
        if not opaque.all():
            self._glaze(light, coverage, glazed)
        if self.style.outline:
            light *= 1.0 - self.style.outline * self._edges(ids, mixed)[:, None]
        pixels = encoded(light).reshape(h, w, 3)
        return Picture(pixels, coverage.reshape(h, w), owner.reshape(h, w).astype(np.int32), glazed.reshape(h, w))

    # --- light on surfaces -------------------------------------------------------------------------------------

    def shade(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the light (n, 3) that comes from triangles at points of the picture [fine pixels]."""
        owner = self.props.owner[triangle]
        light = np.empty((len(triangle), 3), np.float32)
        grounds = self.plane[owner]
        for number in np.flatnonzero(np.bincount(owner[grounds])).tolist():
            mine = np.flatnonzero(owner == number)
            light[mine] = self._ground(triangle[mine], x[mine], y[mine]).T
        things = np.flatnonzero(~grounds)
        light[things] = self._thing(triangle[things], owner[things], x[things], y[things]).T
        return light

    def _thing(self, triangle: np.ndarray, owner: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        spots = self._spots(triangle, owner, x, y)
        return lit(spots, self.light.lamps, self.light.maps, self.light.ambient)

    def _spots(self, triangle: np.ndarray, owner: np.ndarray, x: np.ndarray, y: np.ndarray) -> Spots:
        start, way = self.fine.sight(x, y)
        shares, depth = self.raster.shares(triangle, x, y)
        corners = self.props.normals[triangle]
        normals = np.empty_like(shares)
        for axis in range(3):
            normals[axis] = (
                shares[0] * corners[:, 0, axis] + shares[1] * corners[:, 1, axis] + shares[2] * corners[:, 2, axis]
            )
        eye = np.broadcast_to(-way, shares.shape) / np.sqrt(dot(way, way))
        unit_columns(normals)
        normals *= np.where(dot(normals, eye) < 0, np.float32(-1), np.float32(1))
        return Spots(start + way * depth, normals, eye, self.albedo[triangle].T, self.gloss[owner].T)

    def _ground(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        start, way = self.fine.sight(x, y)
        _, depth = self.raster.shares(triangle, x, y)
        points = start + way * depth
        length = np.sqrt(dot(way, way))
        normal = self.props.normals[triangle[0], 0][:, None]
        slant = dot(normal, way) / length
        normal = -normal if slant[len(slant) // 2] > 0 else normal
        albedo = self.albedo[triangle].T
        if self.style.grid:
            albedo = albedo * self._grid(points, depth * length, np.abs(slant))
        spots = Spots(points, normal, way, albedo, np.zeros((3, 1), np.float32))
        light = lit(spots, self.light.lamps, self.light.maps, self.light.ambient)
        if self.style.haze:
            clear = np.exp(-((depth * length / np.float32(self.style.haze)) ** 2))
            light = light * clear + decoded(self.style.background)[:, None] * (1 - clear)
        return light

    def _grid(self, points: np.ndarray, away: np.ndarray, slant: np.ndarray) -> np.ndarray:
        """How much of its light a ground keeps."""
        step = np.float32(self.style.grid)
        pixel = (1.0 if self.view.parallel else away) / np.float32(self.view.focal)
        foot = pixel / np.maximum(slant, np.float32(0.05))
        kept = np.ones(points.shape[1], np.float32)
        for every, strength in ((step, 0.13), (np.float32(1.0) if step < 1 else 10 * step, 0.16)):
            fading = strength * np.clip(1.5 - 6 * foot / every, 0.0, 1.0)
            for axis in (0, 1):
                place = points[axis] / every
                off = np.abs(place - np.round(place)) * every
                kept *= 1.0 - fading * np.clip(1.2 - off / foot, 0.0, 1.0)
        return kept

    # --- what one sees through, and lines ----------------------------------------------------------------------

    def _glaze(self, light: np.ndarray, coverage: np.ndarray, glazed: np.ndarray) -> None:
        """Lay what is not opaque over the picture, from the back to the front."""
        clear = (self.opacity < 1.0) & (self.opacity > 0.0) & ~self.plane
        parts = list(self.raster.fragments(np.flatnonzero(clear[self.props.owner])))
        if not parts:
            return
        pixel, nearness, triangle = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        ahead = np.flatnonzero(nearness > self.raster.nearness.ravel()[pixel])
        if not len(ahead):
            return
        # From the back to the front at each fine pixel.
        order = ahead[np.lexsort((nearness[ahead], pixel[ahead]))]
        pixel, triangle, nearness = pixel[order], triangle[order], nearness[order]
        # On the edge between two triangles, both of them cover a pixel.
        twice = np.zeros(len(pixel), bool)
        twice[1:] = (pixel[1:] == pixel[:-1]) & (nearness[1:] <= nearness[:-1] * np.float32(1 + 1e-6))
        twice[1:] &= self.props.owner[triangle[1:]] == self.props.owner[triangle[:-1]]
        pixel, triangle = pixel[~twice], triangle[~twice]
        color, alpha, group = self._glass(pixel, triangle)
        starts = np.flatnonzero(np.diff(pixel, prepend=-1))
        counts = np.diff(starts, append=len(pixel))
        added, passed = np.zeros((len(starts), 3), np.float32), np.ones(len(starts), np.float32)
        for layer in range(min(int(counts.max()), LAYERS)):
            slot = np.flatnonzero(counts > layer)
            part = group[starts[slot] + layer]
            kept = 1 - alpha[part]
            added[slot] = added[slot] * kept[:, None] + alpha[part, None] * color[part]
            passed[slot] *= kept
        coarse = self._coarse(pixel[starts])
        share = np.bincount(coarse, 1 - passed, len(light)).astype(np.float32) / 4
        for channel in range(3):
            over = np.bincount(coarse, added[:, channel], len(light)).astype(np.float32) / 4
            light[:, channel] = light[:, channel] * (1 - share) + over
        np.maximum(coverage, share, out=coverage)
        glazed[coarse] = self.props.owner[triangle[starts + counts - 1]]

    def _coarse(self, pixel: np.ndarray) -> np.ndarray:
        return (pixel // self.fine.width // 2) * self.view.width + pixel % self.fine.width // 2

    def _glass(self, pixel: np.ndarray, triangle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return light (m, 3) and opacity (m,) of what one sees through, and which of them each fragment (n,) is.

        What one triangle covers of a pixel is lit once.
        """
        keys = self._coarse(pixel) * len(self.props.owner) + triangle
        _, first, group, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
        x = np.bincount(group, pixel % self.fine.width) / count + 0.5
        y = np.bincount(group, pixel // self.fine.width) / count + 0.5
        owner = self.props.owner[triangle[first]]
        spots = self._spots(triangle[first], owner, x, y)
        # Thin walls would only throw shadows on themselves.
        color = lit(spots, self.light.lamps, (), self.light.ambient).T
        # Glass is seen by what it mirrors, most of all where it is seen at a slant.
        slant = (1 - np.abs(dot(spots.normals, spots.eye))) ** 3
        mirrors = self.gloss[owner, 0] * (0.2 * color.mean(axis=1) + 0.45 * slant)
        return color, np.clip(self.opacity[owner] + mirrors, 0.0, 1.0).astype(np.float32), group

    def _edges(self, ids: np.ndarray, mixed: np.ndarray) -> np.ndarray:
        """How much of each pixel is a line between two things.

        Args:
            ids: (n, 4): triangles of each pixel.
            mixed: Pixels that show more than one.
        """
        h, w = self.view.height, self.view.width
        first = self.owners[ids[:, 0]].reshape(h, w)
        edge = np.zeros((h, w), np.float32)
        if self.view.parallel:
            self._add_steps(edge)
        edge[:, 1:][first[:, 1:] != first[:, :-1]] = 0.5
        edge[1:][first[1:] != first[:-1]] = 0.5
        inside = self.owners[ids[mixed]]
        edge.reshape(-1)[mixed[(inside != inside[:, :1]).any(axis=1)]] = 0.75
        return edge.ravel()

    def _add_steps(self, edge: np.ndarray) -> None:
        """Add lines where a thing lies much deeper in one pixel than in the next, as at the rim of a cup."""
        depth = self.raster.depth(self.raster.nearness[::2, ::2]).astype(np.float32)
        steep = np.float32(STEEP / self.view.focal)
        edge[:, 1:][np.abs(depth[:, 1:] - depth[:, :-1]) > steep] = 0.35
        edge[1:][np.abs(depth[1:] - depth[:-1]) > steep] = 0.35
