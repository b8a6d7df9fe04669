"""Light on surfaces: lamps far away, each with a map of what it reaches, made by the same rasteriser.

A soft lamp is several of them side by side, and so is the sky: what few of them reach lies in the shade.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin, sqrt

import numpy as np

from text2sim.drawing.prop import Stage
from text2sim.drawing.raster import Raster
from text2sim.drawing.view import look, parallel

GOLDEN = pi * (3 - sqrt(5))
GLASS_SHADE = 0.15
"""Part of the light that glass keeps away, besides its opacity."""


@dataclass(frozen=True)
class ParallelLight:
    """Parallel light."""

    direction: tuple[float, float, float]
    """Unit vector towards it."""
    color: tuple[float, float, float]
    """Light that a surface sends back that faces it and is white; linear."""
    glossy: bool = False
    """Whether it is seen in smooth surfaces."""


class ShadowMap:
    """What a lamp reaches first."""

    def __init__(
        self,
        triangles: np.ndarray,
        culled: np.ndarray,
        lamp: ParallelLight,
        bounds: tuple[np.ndarray, np.ndarray],
        size: int,
    ) -> None:
        """Draw the scene as the lamp sees it.

        Args:
            triangles: (n, 3, 3) float [m]: what throws shadows.
            culled: (n,) bool: seen from outside only.
            lamp: The lamp.
            bounds: Lowest and highest corner (3,) [m] of what may throw shadows.
            size: Pixels of the map's side.
        """
        axes = look(lamp.direction, (0.0, 0.0, 0.0))
        low, high = bounds
        corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
        flat = corners @ axes[:2].T
        width = float(np.ptp(flat, axis=0).max()) * 1.02 + 1e-9
        center = (flat.min(axis=0) + flat.max(axis=0)) / 2 @ axes[:2]
        self.texel = width / size
        view = parallel(axes, center.tolist(), size / width, (size, size))
        self.raster = Raster(triangles, view, culled)
        self.raster.draw()
        # With a margin, so that what falls beside the map finds nothing in its way.
        self._flat = np.pad(self.raster.nearness, 1).ravel()

    def reached(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return how much (n,) of the lamp points see, from 0 to 1.

        Args:
            points: (3, n) float32 [m]
            normals: (3, n) or (3, 1) float32: of their surfaces, so that a surface throws no shadow on itself.
        """
        raster = self.raster
        view, axes = raster.view, raster.view.axes.astype(np.float32)
        shift = axes @ normals
        shift *= np.float32(self.texel) * (1.8 - 1.2 * np.abs(shift[2]))
        local = axes @ points - (axes @ view.origin.astype(np.float32))[:, None] + shift
        scale = 0.75 / raster.span
        nearness = local[2] * np.float32(scale) + np.float32(0.25 + (0.5 * self.texel - raster.lowest) * scale)
        # Nothing is drawn where the map has zero, and nothing lies behind that.
        np.maximum(nearness, 0.0, out=nearness)
        # In the map with its margin, as numbers of pixels whose centres are whole.
        last = np.float32(view.width + 0.999)
        x = local[0] * np.float32(view.focal) + np.float32(0.5 * view.width + 0.5)
        y = np.float32(0.5 * view.height + 0.5) - local[1] * np.float32(view.focal)
        np.clip(x, 0.0, last, out=x)
        np.clip(y, 0.0, last, out=y)
        column, row = x.astype(np.int32), y.astype(np.int32)
        x -= column
        y -= row
        side = view.width + 2
        spot = row * np.int32(side) + column
        found = self._open(spot, nearness) * ((1 - x) * (1 - y))
        found += self._open(spot + np.int32(1), nearness) * (x * (1 - y))
        found += self._open(spot + np.int32(side), nearness) * ((1 - x) * y)
        found += self._open(spot + np.int32(side + 1), nearness) * (x * y)
        return found

    def _open(self, spot: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        return self._flat.take(spot, mode="clip") <= nearness


@dataclass(frozen=True, eq=False)
class Light:
    """Lamps, and what each of them reaches: the same for all pictures of a stage."""

    lamps: Sequence[ParallelLight]
    ambient: float
    """Light that reaches everything."""
    maps: Sequence[ShadowMap | None] = ()
    """One for each lamp, None where nothing is in its way; empty if nothing throws shadows."""


def light_up(
    props: Stage, lamps: Sequence[ParallelLight], ambient: float, bounds: tuple[np.ndarray, np.ndarray], size: int = 512
) -> Light:
    """Find what lamps reach.

    Args:
        props: What there is.
        lamps: What shines on it.
        ambient: Light that reaches everything.
        bounds: Corners (3,) [m] of the space in which things throw shadows.
        size: Pixels of the side of a glossy lamp's shadow map; the others, which are there for soft shade, have a
            quarter as many.
    """
    low, high = bounds
    triangles = props.triangles
    near = ~np.array([prop.plane for prop in props], bool)[props.owner]
    near &= ((triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)).all(axis=1)
    opacity = np.array([prop.opacity for prop in props])[props.owner]
    maps: list[ShadowMap | None] = []
    for number, lamp in enumerate(lamps):
        # What is clear is in the way of some lamps only.
        alike = [k for k, other in enumerate(lamps) if other.glossy == lamp.glossy]
        needed = (alike.index(number) + 0.5) / len(alike)
        chosen = np.flatnonzero(near & (opacity + GLASS_SHADE * (opacity > 0) >= needed))
        if not len(chosen):
            maps.append(None)
            continue
        side = size if lamp.glossy else size // 4
        maps.append(ShadowMap(triangles[chosen], props.culled[chosen], lamp, bounds, side))
    return Light(lamps, ambient, maps)


def soft_lamp(direction: Sequence[float], color: Sequence[float], count: int, spread: float) -> list[ParallelLight]:
    """Return a lamp that fills a small part of the sky.

    Args:
        direction: Towards its middle.
        color: Of all of it.
        count: How many lamps it is made of.
        spread: Half its width [rad].
    """
    axes = look(direction, (0.0, 0.0, 0.0))
    lamps = []
    for k in range(count):
        radius, angle = spread * sqrt((k + 0.5) / count) if count > 1 else 0.0, GOLDEN * k
        way = axes[2] + radius * (cos(angle) * axes[0] + sin(angle) * axes[1])
        lamps.append(_lamp(way, np.asarray(color) / count, glossy=True))
    return lamps


def sky(count: int, top: Sequence[float], rim: Sequence[float]) -> list[ParallelLight]:
    """Return light from all over the sky, more of it from above.

    Args:
        count: How many lamps it is made of.
        top: Colour of all light that reaches a surface that faces up, if it came from above.
        rim: The same, if it came from the horizon.
    """
    lamps = []
    for k in range(count):
        # Evenly by the cosine, so that all lamps give a level surface the same light.
        up = sqrt(1 - (k + 0.5) / count)
        out, angle = sqrt(1 - up * up), GOLDEN * k
        color = (np.asarray(top) * up + np.asarray(rim) * (1 - up)) / count / max(up, 0.2)
        lamps.append(_lamp(np.array((out * cos(angle), out * sin(angle), up)), color))
    return lamps


def _lamp(way: np.ndarray, color: np.ndarray, *, glossy: bool = False) -> ParallelLight:
    x, y, z = (way / np.linalg.norm(way)).tolist()
    red, green, blue = color.tolist()
    return ParallelLight((x, y, z), (red, green, blue), glossy)
