"""Painter of a stage: rasterises triangles, then shades the visible ones.

A picture is rasterised at double resolution. A pixel with one triangle is shaded once, one with several is shaded four
times: this gives smooth edges at little extra cost.
"""

from dataclasses import dataclass

import numpy as np

from text2sim.drawing.lighting import Light
from text2sim.drawing.prop import Stage
from text2sim.drawing.raster import Raster
from text2sim.drawing.surfaces import GLOSS, Spots, decoded, dot, encoded, linear, lit, unit_columns
from text2sim.drawing.view import PictureView

Rgb = tuple[float, float, float]

STEEP_CHANGE = 6.0
"""Change of depth between pixels, in pixels, above which a parallel view has a line."""
MAX_LAYERS = 8
"""Largest number of transparent surfaces at a pixel."""


@dataclass(frozen=True)
class Style:
    """Style of a picture."""

    background: Rgb
    """Colour of the background, sRGB."""
    outline: float = 0.0
    """Darkness of lines between things, from 0 to 1."""
    planes: bool = True
    """Whether grounds are drawn."""
    grid: float = 0.0
    """Distance [m] of grid lines on a ground, with strong lines at metres or at tens of it; 0 for none."""
    haze: float = 0.0
    """Distance [m] at which a ground fades into the background by 1 - 1/e; 0 for never."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture with its visible props."""

    pixels: np.ndarray
    """Colours, sRGB in 0..1, (height, width, 3) float32."""
    coverage: np.ndarray
    """Part of each pixel that is not background, (height, width) float32."""
    owner: np.ndarray
    """Index of the visible opaque prop, -1 for none, (height, width) int32."""
    glazed: np.ndarray
    """Index of the nearest transparent prop, -1 for none, (height, width) int32."""


def paint(props: Stage, view: PictureView, light: Light, style: Style) -> Picture:
    """Draw a stage from a camera.

    Args:
        props: The stage.
        view: The camera.
        light: The light.
        style: The style.
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
        """Index of the prop of each triangle; the last is for background, triangle -1."""

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
        drawn = np.flatnonzero(parts >= 0)
        colors[drawn] = self.shade(parts[drawn], x[drawn], y[drawn])
        # Averaged in sRGB, which gives smoother edges between bright and dark things.
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

    # --- shading -----------------------------------------------------------------------------------------------

    def shade(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the light (n, 3) from triangles at points of the picture [fine pixels]."""
        owner = self.props.owner[triangle]
        light = np.empty((len(triangle), 3), np.float32)
        grounds = self.plane[owner]
        for number in np.flatnonzero(np.bincount(owner[grounds])).tolist():
            own = np.flatnonzero(owner == number)
            light[own] = self._ground(triangle[own], x[own], y[own]).T
        things = np.flatnonzero(~grounds)
        spots = self._spots(triangle[things], owner[things], x[things], y[things])
        light[things] = lit(spots, self.light.lamps, self.light.maps, self.light.ambient).T
        return light

    def _spots(self, triangle: np.ndarray, owner: np.ndarray, x: np.ndarray, y: np.ndarray) -> Spots:
        start, ray = self.fine.sight(x, y)
        shares, depth = self.raster.shares(triangle, x, y)
        corners = self.props.normals[triangle]
        normals = np.empty_like(shares)
        for axis in range(3):
            normals[axis] = (
                shares[0] * corners[:, 0, axis] + shares[1] * corners[:, 1, axis] + shares[2] * corners[:, 2, axis]
            )
        eye = np.broadcast_to(-ray, shares.shape) / np.sqrt(dot(ray, ray))
        unit_columns(normals)
        normals *= np.where(dot(normals, eye) < 0, np.float32(-1), np.float32(1))
        return Spots(start + ray * depth, normals, eye, self.albedo[triangle].T, self.gloss[owner].T)

    def _ground(self, triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        start, ray = self.fine.sight(x, y)
        _, depth = self.raster.shares(triangle, x, y)
        points = start + ray * depth
        length = np.sqrt(dot(ray, ray))
        normal = self.props.normals[triangle[0], 0][:, None]
        slant = dot(normal, ray) / length
        normal = -normal if slant[len(slant) // 2] > 0 else normal
        albedo = self.albedo[triangle].T
        if self.style.grid:
            albedo = albedo * self._grid(points, depth * length, np.abs(slant))
        spots = Spots(points, normal, ray, albedo, np.zeros((3, 1), np.float32))
        light = lit(spots, self.light.lamps, self.light.maps, self.light.ambient)
        if self.style.haze:
            clear = np.exp(-((depth * length / np.float32(self.style.haze)) ** 2))
            light = light * clear + decoded(self.style.background)[:, None] * (1 - clear)
        return light

    def _grid(self, points: np.ndarray, away: np.ndarray, slant: np.ndarray) -> np.ndarray:
        """Factor of the grid lines on the light of a ground."""
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

    # --- transparent surfaces and lines ------------------------------------------------------------------------

    def _glaze(self, light: np.ndarray, coverage: np.ndarray, glazed: np.ndarray) -> None:
        """Blend transparent surfaces over the picture, from back to front."""
        clear = (self.opacity < 1.0) & (self.opacity > 0.0) & ~self.plane
        parts = list(self.raster.fragments(np.flatnonzero(clear[self.props.owner])))
        if not parts:
            return
        pixel, nearness, triangle = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        ahead = np.flatnonzero(nearness > self.raster.nearness.ravel()[pixel])
        if not len(ahead):
            return
        # From back to front at each fine pixel.
        order = ahead[np.lexsort((nearness[ahead], pixel[ahead]))]
        pixel, triangle, nearness = pixel[order], triangle[order], nearness[order]
        # Both triangles at an edge may cover the same pixel.
        twice = np.zeros(len(pixel), bool)
        twice[1:] = (pixel[1:] == pixel[:-1]) & (nearness[1:] <= nearness[:-1] * np.float32(1 + 1e-6))
        twice[1:] &= self.props.owner[triangle[1:]] == self.props.owner[triangle[:-1]]
        pixel, triangle = pixel[~twice], triangle[~twice]
        color, alpha, group = self._glass(pixel, triangle)
        starts = np.flatnonzero(np.diff(pixel, prepend=-1))
        counts = np.diff(starts, append=len(pixel))
        added, passed = np.zeros((len(starts), 3), np.float32), np.ones(len(starts), np.float32)
        for layer in range(min(int(counts.max()), MAX_LAYERS)):
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
        """Light (m, 3) and opacity (m,) of transparent surfaces, and the index into them of each fragment (n,).

        Each triangle is shaded once per pixel.
        """
        keys = self._coarse(pixel) * len(self.props.owner) + triangle
        _, first, group, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
        x = np.bincount(group, pixel % self.fine.width) / count + 0.5
        y = np.bincount(group, pixel // self.fine.width) / count + 0.5
        owner = self.props.owner[triangle[first]]
        spots = self._spots(triangle[first], owner, x, y)
        # Without shadows: thin walls would only shadow themselves.
        color = lit(spots, self.light.lamps, (), self.light.ambient).T
        # Glass is visible by its reflections, most of all at grazing angles.
        slant = (1 - np.abs(dot(spots.normals, spots.eye))) ** 3
        mirrors = self.gloss[owner, 0] * (0.2 * color.mean(axis=1) + 0.45 * slant)
        return color, np.clip(self.opacity[owner] + mirrors, 0.0, 1.0).astype(np.float32), group

    def _edges(self, ids: np.ndarray, mixed: np.ndarray) -> np.ndarray:
        """Strength of lines between things at each pixel.

        Args:
            ids: (n, 4): triangles of each pixel.
            mixed: Pixels with more than one triangle.
        """
        h, w = self.view.height, self.view.width
        first = self.owners[ids[:, 0]].reshape(h, w)
        edge = np.zeros((h, w), np.float32)
        if self.view.parallel:  # lines where depth jumps, as at the rim of a cup
            depth = self.raster.depth(self.raster.nearness[::2, ::2]).astype(np.float32)
            steep = np.float32(STEEP_CHANGE / self.view.focal)
            edge[:, 1:][np.abs(depth[:, 1:] - depth[:, :-1]) > steep] = 0.35
            edge[1:][np.abs(depth[1:] - depth[:-1]) > steep] = 0.35
        edge[:, 1:][first[:, 1:] != first[:, :-1]] = 0.5
        edge[1:][first[1:] != first[:-1]] = 0.5
        inside = self.owners[ids[mixed]]
        edge.reshape(-1)[mixed[(inside != inside[:, :1]).any(axis=1)]] = 0.75
        return edge.ravel()
