"""Framing of a picture: moving bodies and the statics near them."""

from collections.abc import Iterable

import numpy as np

from text2sim.drawing.prop import Prop

MAX_SUBJECT_DISTANCE = 3.0
"""Distance below which a static belongs to the subject, in sizes of the larger of static and subject."""
LARGE_STATIC, LARGE_LEVEL_STATIC = 40.0, 2.0
"""Size of a static, in sizes of the subject, above which it is shown in part: any static, and one that is flat."""
FLATNESS = 0.15
"""Height of a static over its length below which it is flat."""
STATIC_RIM = 0.15
"""Part of the subject's size by which large statics are shown beyond it."""


def subject_bounds(props: Iterable[Prop]) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds, each (3,) [m], of what a picture has to show.

    That is all bodies, and the statics near them or near such statics: ramps, bins and targets completely, even if
    only a marble moves, but a floor that is much larger than the rest only in part. Infinite grounds do not count.
    """
    solid = [prop for prop in props if not prop.plane and prop.opacity > 0.0]
    low, high = box_of([prop for prop in solid if not prop.static] or solid)
    waiting = [box_of([prop]) for prop in solid if prop.static]
    while True:
        size = max(float((high - low).max()), 1e-6)
        shown = [box for box in waiting if not _large(box, size) and _is_near(box, (low, high), size)]
        if not shown:
            break
        waiting = [box for box in waiting if not any(box is other for other in shown)]
        low = np.min([low, *(first for first, _ in shown)], axis=0)
        high = np.max([high, *(last for _, last in shown)], axis=0)
    rim = low - STATIC_RIM * size, high + STATIC_RIM * size
    for first, last in (box for box in waiting if _large(box, size)):
        first, last = np.maximum(first, rim[0]), np.minimum(last, rim[1])
        if (first < last).all():
            low, high = np.minimum(low, first), np.maximum(high, last)
    return low, high


def _large(box: tuple[np.ndarray, np.ndarray], size: float) -> bool:
    sides = box[1] - box[0]
    longest = float(sides.max())
    return longest > (LARGE_LEVEL_STATIC if sides[2] < FLATNESS * longest else LARGE_STATIC) * size


def _is_near(box: tuple[np.ndarray, np.ndarray], shown: tuple[np.ndarray, np.ndarray], size: float) -> bool:
    around = MAX_SUBJECT_DISTANCE * max(size, float((box[1] - box[0]).max()))
    return bool((box[0] < shown[1] + around).all() and (box[1] > shown[0] - around).all())


def box_of(props: Iterable[Prop]) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds, each (3,) [m], of props; a box around the origin if there are none."""
    props = [prop for prop in props if len(prop.triangles)]
    if not props:
        return np.array((-1.0, -1.0, -1.0)), np.array((1.0, 1.0, 1.0))
    lows = [prop.triangles.reshape(-1, 3).min(axis=0) for prop in props]
    highs = [prop.triangles.reshape(-1, 3).max(axis=0) for prop in props]
    return np.min(lows, axis=0), np.max(highs, axis=0)
