"""Coloured transparent bodies as filters of what is behind them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.finishes import SHADE
from text2sim.rendering.renderer import mitsuba

Array = NDArray[np.floating]

LAYERS = 8
"""Largest number of surfaces in a row that filter: both sides of four panes."""
SLANT = 3.0
"""Largest length of the way through a skin, in thicknesses: its outline is darker, which shows its form."""
WITHIN = (0.25, 0.75)
"""Places in a pixel, along both sides, at which rays are cast."""


def passed(scene: Any, sensor: Any, depth: Array) -> Array:
    """Return the fraction of the light that passes through the transparent bodies of a picture, shape (h, w, 3).

    Args:
        scene: The transparent bodies. The attribute `SHADE` of a face is the fraction that it lets through.
        sensor: The camera.
        depth: Distance of the first opaque surface [m], 0 where there is none, shape (h, w).
    """
    import drjit as dr

    mi = mitsuba()
    tall, wide = depth.shape
    behind = np.where(depth > 0, depth, np.inf).astype(np.float32).ravel()
    if mi.variant().startswith("scalar"):
        rows = [
            _through(scene, sensor, ((k % wide + 0.5) / wide, (k // wide + 0.5) / tall), float(far))
            for k, far in enumerate(behind)
        ]
        return np.array(rows).reshape(tall, wide, 3)
    number = dr.arange(mi.UInt32, tall * wide)
    column, row, far = mi.Float(number % wide), mi.Float(number // wide), mi.Float(behind)
    casts = [_through(scene, sensor, ((column + x) / wide, (row + y) / tall), far) for x in WITHIN for y in WITHIN]
    return np.mean(casts, axis=0).T.reshape(tall, wide, 3)


def _through(scene: Any, sensor: Any, at: tuple[Any, Any], left: Any) -> Array:
    """Return the fraction that passes at places of the picture, shape (3,) or (3, n).

    Args:
        scene: The transparent bodies.
        sensor: The camera.
        at: Places in the picture, 0 to 1 across and down.
        left: Distance of the first opaque surface [m].
    """
    import drjit as dr

    mi = mitsuba()
    ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(*at), mi.Point2f(0.5))
    through, active = mi.Color3f(1.0), left > 0
    for _ in range(LAYERS):
        hit = scene.ray_intersect(ray, active)
        left = left - hit.t
        active &= hit.is_valid() & (left > 0)
        if isinstance(active, bool) and not active:
            break
        path_length = dr.minimum(1 / dr.maximum(dr.abs(hit.wi.z), 1e-3), SLANT)
        tint = hit.shape.eval_attribute_3(SHADE, hit, active)
        through = dr.select(active, through * dr.power(tint, path_length), through)
        ray = hit.spawn_ray(ray.d)
    return np.array(through)
