"""Views of pictures: projection of points of the world, perspective or parallel."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians, tan

import numpy as np

TINY = 1e-9


@dataclass(frozen=True, eq=False)
class PictureView:
    """A camera and its picture. Pixels count from the upper left corner; the centre of the first is (0.5, 0.5)."""

    origin: np.ndarray
    """The eye; in parallel projection, a point at the centre of the picture [m], (3,) float."""
    axes: np.ndarray
    """Rows are the unit vectors right, up and back (towards the eye) of the picture, (3, 3) float."""
    focal: float
    """Focal length [pixels]; in parallel projection, pixels per metre."""
    width: int
    height: int
    near: float = 0.0
    """Distance of the near plane [m]; 0 means parallel projection."""

    @property
    def parallel(self) -> bool:
        """Whether lines of sight are parallel."""
        return self.near == 0.0

    def scaled(self, factor: int) -> "PictureView":
        """Return the same picture with more pixels."""
        return replace(self, focal=self.focal * factor, width=self.width * factor, height=self.height * factor)

    def local(self, points: np.ndarray) -> np.ndarray:
        """Return points (…, 3) of the world in the camera's frame: right, up and back [m]."""
        return (points - self.origin) @ self.axes.T

    def homogeneous(self, points: np.ndarray) -> np.ndarray:
        """Return (x w, y w, w) for points (…, 3) of the world: pixels times depth, and depth [m].

        In parallel projection w is 1.
        """
        local = self.local(points)
        found = np.empty_like(local)
        w = 1.0 if self.parallel else -local[..., 2]
        found[..., 0] = self.focal * local[..., 0] + 0.5 * self.width * w
        found[..., 1] = 0.5 * self.height * w - self.focal * local[..., 1]
        found[..., 2] = w
        return found

    def pixels(self, points: np.ndarray | Sequence[float]) -> np.ndarray:
        """Return pixels (…, 2) of points (…, 3) of the world; nan for points behind the eye."""
        found = self.homogeneous(np.asarray(points, float))
        w = np.where(found[..., 2:] > TINY, found[..., 2:], np.nan)
        return found[..., :2] / w

    def sight(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return origins and directions, (3, n) float32, of the rays through pixels.

        Directions have a depth of one metre. Rays of a parallel view start in the plane of its origin.
        """
        right = ((x - 0.5 * self.width) / self.focal).astype(np.float32)
        up = ((0.5 * self.height - y) / self.focal).astype(np.float32)
        axes, origin = self.axes.astype(np.float32), self.origin.astype(np.float32)[:, None]
        across = axes[0][:, None] * right + axes[1][:, None] * up
        if self.parallel:
            return across + origin, -axes[2][:, None]
        return origin, across - axes[2][:, None]


def look(pos: Sequence[float], target: Sequence[float], up: Sequence[float] = (0.0, 0.0, 1.0)) -> np.ndarray:
    """Return the axes of a camera as in the engine.

    If it looks straight up or down, +y is up, as in the language; if it looks at itself, it looks along -y.

    Args:
        pos: Position of the camera [m].
        target: Point that it looks at [m].
        up: Up direction.
    """
    back = np.asarray(pos, float) - np.asarray(target, float)
    length = float(np.linalg.norm(back))
    back = back / length if length > TINY else np.array((0.0, 1.0, 0.0))
    right = np.cross(np.asarray(up, float), back)
    if np.linalg.norm(right) < TINY:
        right = np.cross((0.0, 1.0, 0.0), back)
        if np.linalg.norm(right) < TINY:
            right = np.array((1.0, 0.0, 0.0))
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def perspective(
    pos: Sequence[float],
    target: Sequence[float],
    up: Sequence[float],
    fov_deg: float,
    size: tuple[int, int],
    near: float = 0.01,
) -> PictureView:
    """Return a perspective view.

    Args:
        pos: Position of the camera [m].
        target: Point that it looks at [m].
        up: Up direction.
        fov_deg: Vertical field of view [deg].
        size: Width and height [pixels].
        near: Distance of the near plane [m].
    """
    focal = 0.5 * size[1] / tan(radians(fov_deg) / 2)
    return PictureView(np.asarray(pos, float), look(pos, target, up), focal, *size, near=near)


def parallel(axes: np.ndarray, center: Sequence[float], scale: float, size: tuple[int, int]) -> PictureView:
    """Return a parallel view.

    Args:
        axes: Rows right, up and back.
        center: Point [m] at the centre of the picture.
        scale: Pixels per metre.
        size: Width and height [pixels].
    """
    return PictureView(np.asarray(center, float), np.asarray(axes, float), scale, *size)
