"""Distant lamps with shadow maps that are made by the rasteriser.

Soft lamps and the sky consist of several of them: what only a few of them reach is in partial shadow.
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
"""Part of the light that glass blocks, in addition to its opacity."""


@dataclass(frozen=True)
class ParallelLight:
    """Parallel light."""

    direction: tuple[float, float, float]
    """Unit vector towards the lamp."""
    color: tuple[float, float, float]
    """Light that a white surface reflects if it faces the lamp; linear."""
    glossy: bool = False
    """Whether smooth surfaces have highlights of it."""


class ShadowMap:
    """Depth map of a scene from a lamp."""

    def __init__(
        self,
        triangles: np.ndarray,
        culled: np.ndarray,
        lamp: ParallelLight,
        bounds: tuple[np.ndarray, np.ndarray],
        size: int,
    ) -> None:
        """Draw the scene from the lamp.

        Args:
            triangles: (n, 3, 3) float [m]: triangles that cast shadows.
            culled: (n,) bool: triangles that are only visible from outside.
            lamp: The lamp.
            bounds: Lower and upper bounds (3,) [m] of what casts shadows.
            size: Side of the map [pixels].
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
        # With an empty margin, so that points beside the map are lit.
        self._flat = np.pad(self.raster.nearness, 1).ravel()

    def reached(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return which part (n,) of the lamp's light reaches points, from 0 to 1.

        Args:
            points: (3, n) float32 [m].
            normals: (3, n) or (3, 1) float32: normals of their surfaces, for an offset that avoids self-shadowing.
        """
        raster = self.raster
        view, axes = raster.view, raster.view.axes.astype(np.float32)
        shift = axes @ normals
        shift *= np.float32(self.texel) * (1.8 - 1.2 * np.abs(shift[2]))
        local = axes @ points - (axes @ view.origin.astype(np.float32))[:, None] + shift
        scale = 0.75 / raster.span
        nearness = local[2] * np.float32(scale) + np.float32(0.25 + (0.5 * self.texel - raster.lowest) * scale)
        # The map is zero where nothing is drawn: clamped, all points there are lit.
        np.maximum(nearness, 0.0, out=nearness)
        # Coordinates in the map with its margin, in pixels with centres at integers.
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
        found = self._is_lit(spot, nearness) * ((1 - x) * (1 - y))
        found += self._is_lit(spot + np.int32(1), nearness) * (x * (1 - y))
        found += self._is_lit(spot + np.int32(side), nearness) * ((1 - x) * y)
        found += self._is_lit(spot + np.int32(side + 1), nearness) * (x * y)
        return found

    def _is_lit(self, spot: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        return self._flat.take(spot, mode="clip") <= nearness


@dataclass(frozen=True, eq=False)
class Light:
    """Lamps and their shadow maps, for all pictures of a stage."""

    lamps: Sequence[ParallelLight]
    ambient: float
    """Ambient light."""
    maps: Sequence[ShadowMap | None] = ()
    """A map for each lamp, None if nothing blocks it; empty if nothing casts shadows."""


def light_up(
    props: Stage, lamps: Sequence[ParallelLight], ambient: float, bounds: tuple[np.ndarray, np.ndarray], size: int = 512
) -> Light:
    """Make the shadow maps of lamps.

    Args:
        props: The stage.
        lamps: The lamps.
        ambient: Ambient light.
        bounds: Lower and upper bounds (3,) [m] of the space in which things cast shadows.
        size: Side of a glossy lamp's shadow map [pixels]; that of the others, for soft shadows, is a quarter.
    """
    low, high = bounds
    triangles = props.triangles
    near = ~props.grounds & ((triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)).all(axis=1)
    opacity = np.array([prop.opacity for prop in props])[props.owner]
    maps: list[ShadowMap | None] = []
    for number, lamp in enumerate(lamps):
        # Transparent props block only some of the lamps.
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
    """Return a lamp that covers a small part of the sky.

    Args:
        direction: Direction to its centre.
        color: Total light.
        count: Number of lamps that it consists of.
        spread: Half its width [rad].
    """
    axes = look(direction, (0.0, 0.0, 0.0))
    lamps = []
    for k in range(count):
        radius, angle = spread * sqrt((k + 0.5) / count) if count > 1 else 0.0, GOLDEN * k
        towards = axes[2] + radius * (cos(angle) * axes[0] + sin(angle) * axes[1])
        lamps.append(_lamp(towards, np.asarray(color) / count, glossy=True))
    return lamps


def sky(count: int, top: Sequence[float], rim: Sequence[float]) -> list[ParallelLight]:
    """Return lamps all over the sky, most of them near the zenith.

    Args:
        count: Number of lamps.
        top: Light on a horizontal surface if all of the sky were like its zenith.
        rim: Light on a horizontal surface if all of the sky were like its horizon.
    """
    lamps = []
    for k in range(count):
        # Evenly by the cosine, so that all lamps contribute the same light to a horizontal surface.
        up = sqrt(1 - (k + 0.5) / count)
        out, angle = sqrt(1 - up * up), GOLDEN * k
        color = (np.asarray(top) * up + np.asarray(rim) * (1 - up)) / count / max(up, 0.2)
        lamps.append(_lamp(np.array((out * cos(angle), out * sin(angle), up)), color))
    return lamps


def _lamp(direction: np.ndarray, color: np.ndarray, *, glossy: bool = False) -> ParallelLight:
    x, y, z = (direction / np.linalg.norm(direction)).tolist()
    red, green, blue = color.tolist()
    return ParallelLight((x, y, z), (red, green, blue), glossy)
