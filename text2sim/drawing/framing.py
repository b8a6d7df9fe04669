"""What a picture has to show: everything that moves, and what stands near it."""

from collections.abc import Sequence

import numpy as np

from text2sim.drawing.prop import Prop

AROUND = 0.6
"""How far beyond what moves statics are shown, as a part of its size."""
LARGE = 2.0
"""A static that is larger than this many times what moves is shown only in part,"""
RIM = 0.15
"""as far as this beyond it, as a part of its size."""


def subject_bounds(props: Sequence[Prop]) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (3,) [m] of an upright box around what a picture has to show.

    That is all bodies, and statics: whole where they are not much larger than all of these together, and else as far
    as they are near. A ground without end does not count.
    """
    solid = [prop for prop in props if not prop.plane and prop.opacity > 0.0]
    bodies = [prop for prop in solid if not prop.static] or solid
    low, high = box_of(bodies)
    size = max(float((high - low).max()), 1e-6)
    around, rim = ((low - part * size, high + part * size) for part in (AROUND, RIM))
    for prop in (prop for prop in solid if prop.static):
        first, last = box_of([prop])
        if (last - first).max() > LARGE * size:
            first, last = np.maximum(first, rim[0]), np.minimum(last, rim[1])
        elif (first > around[1]).any() or (last < around[0]).any():
            continue
        if (first < last).all():
            low, high = np.minimum(low, first), np.maximum(high, last)
    return low, high


def box_of(props: Sequence[Prop]) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (3,) [m] of an upright box around props; around the origin if there are none."""
    props = [prop for prop in props if len(prop.triangles)]
    if not props:
        return np.array((-1.0, -1.0, -1.0)), np.array((1.0, 1.0, 1.0))
    lows = [prop.triangles.reshape(-1, 3).min(axis=0) for prop in props]
    highs = [prop.triangles.reshape(-1, 3).max(axis=0) for prop in props]
    return np.min(lows, axis=0), np.max(highs, axis=0)
