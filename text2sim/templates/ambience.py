"""Effects that the rasteriser lacks, from the depth buffer: ambient occlusion, and grounds that fade at their edge."""

from typing import Any

import numpy as np

if __package__:
    from .viewpoints import basis  # noqa: TID252
else:  # in a program, where it lies beside this module
    from viewpoints import basis

SHADE = 0.5
"""Largest share of the light that ambient occlusion takes away."""
REACHES = (0.01, 0.02, 0.04)
"""Distances in the picture at which depths are compared, in picture heights."""
DIRECTIONS = ((0, 1), (1, 0), (1, 1), (1, -1))
FAINT, STEEP = 0.08, 1.4
"""Range of curvature that is shaded: below it a surface is flat, above it one body hides another far behind it."""
FADES = 0.35
"""Distance from the middle of a ground at which it begins to fade, as a fraction of half its side."""


def shaded(image: np.ndarray, depth: np.ndarray, fov: float) -> np.ndarray:
    """Return a picture, uint8, darkened in concave places, such as between a body and the ground it stands on.

    The inverse depth is linear over a plane, so its second differences measure how surfaces bend.

    Args:
        image: Shape (height, width, 3).
        depth: Depth along the axis of the camera [m], shape (height, width); 0 or not finite for the background.
        fov: Vertical field of view [deg].
    """
    near = np.where(np.isfinite(depth) & (depth > 0), 1.0 / np.maximum(depth, 1e-6), 0.0)[::2, ::2].astype(np.float32)
    there, total = np.maximum(near, 1e-9), np.zeros_like(near)
    for reach in REACHES:
        step = max(1, round(reach * len(near)))
        wide = np.pad(near, step, mode="reflect", reflect_type="odd")
        size = 2 * np.tan(np.radians(fov) / 2) * step / len(near)
        for down, right in DIRECTIONS:
            ahead, back = (_moved(wide, step, sign * down, sign * right) for sign in (1, -1))
            bend = ((ahead + back) / 2 - near) / (there * size * np.hypot(down, right))
            total += np.clip(bend - FAINT, 0.0, 1.0) * np.clip(2 - bend / STEEP, 0.0, 1.0)
    total *= near > 0
    dark = _blurred(total / (len(REACHES) * len(DIRECTIONS)), max(1, round(REACHES[0] * len(near))))
    dark = np.clip(2.5 * dark, 0.0, 1.0).repeat(2, axis=0).repeat(2, axis=1)[: image.shape[0], : image.shape[1], None]
    return (image * (1 - np.float32(SHADE) * dark)).astype(np.uint8)


def faded(image: np.ndarray, depth: np.ndarray, view: Any, grounds: list, background: tuple) -> np.ndarray:
    """Return a picture, uint8, in which grounds fade into the background before their edge.

    Args:
        image: Shape (height, width, 3).
        depth: Depth along the axis of the camera [m], shape (height, width).
        view: View of the camera, see `cameras.View`.
        grounds: Centre, shape (3,), and half the side of each ground [m].
        background: Colour of the background, 0 to 1.
    """
    tall, wide = depth.shape
    unit = 2 * np.tan(np.radians(view.fov) / 2) / tall
    across = unit * (np.arange(wide, dtype=np.float32) + 0.5 - wide / 2)
    upward = -unit * (np.arange(tall, dtype=np.float32) + 0.5 - tall / 2)[:, None]
    frame = zip(view.pos, *basis(view.pos, view.look_at, view.up), strict=True)
    places = [float(pos) + depth * (across * r + (upward * u + a)) for pos, r, u, a in frame]
    for (x, y, z), half in grounds:
        on = np.abs(places[2] - z) < unit * depth + 1e-4 * half  # a depth may belong to any place within the pixel
        share = np.clip((np.hypot(places[0] - x, places[1] - y) / half - FADES) / (0.95 - FADES), 0.0, 1.0)
        share = (on * share * share * (3 - 2 * share))[..., None].astype(np.float32)
        image = (image + share * (255 * np.asarray(background, np.float32) - image)).astype(np.uint8)
    return image


def _moved(padded: np.ndarray, by: int, down: int, right: int) -> np.ndarray:
    """The inner part of a padded array, shifted by `by` pixels down and right, times -1, 0 or 1 each."""
    tall, wide = padded.shape[0] - 2 * by, padded.shape[1] - 2 * by
    return padded[by + by * down : by + by * down + tall, by + by * right : by + by * right + wide]


def _blurred(values: np.ndarray, by: int) -> np.ndarray:
    """The mean over a square of `2 by + 1` places a side."""
    for _ in range(2):
        sums = np.cumsum(np.pad(values, ((by + 1, by), (0, 0)), mode="edge"), axis=0)
        values = ((sums[2 * by + 1 :] - sums[: -2 * by - 1]) / (2 * by + 1)).T
    return values
