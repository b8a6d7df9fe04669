"""Placement of labels: near their things, on free background if possible, without overlaps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from text2sim.drawing.canvas import Box

GRID_STEP = 8
"""Grid of candidate positions [pixels]."""
COVERING_COST = 150.0
"""Cost of a label that covers other things completely, as a distance [pixels]."""
SMALL_AREA = 16_000
"""Area of a thing [pixels] below which covering it costs more."""
SAMPLES = 48
GAP = 3.0


@dataclass(frozen=True)
class PlacedLabel:
    """A label at its position."""

    text: str
    box: Box
    target: tuple[float, float]
    """Point of the labelled thing [pixels]."""
    key: str


def place_labels(
    wanted: list[tuple[str, str, float]],
    seen: np.ndarray,
    keys: list[str],
    height: float,
    blocked: np.ndarray,
    taken: Sequence[Box] = (),
) -> list[PlacedLabel]:
    """Find positions for labels.

    Args:
        wanted: Key, text and width [pixels] of each.
        seen: (h, w) int: index of the key that each pixel shows, -1 for none.
        keys: The keys.
        height: Height of a label [pixels].
        blocked: (h, w) bool: pixels of lines, which labels should not cover.
        taken: Boxes of other texts.
    """
    rows, columns = seen.shape
    # Covering small things costs more.
    areas = np.bincount(seen[seen >= 0], minlength=len(keys))
    worth = np.append(np.clip(np.sqrt(SMALL_AREA / np.maximum(areas, 1)), 1.0, 4.0), 0.0)
    busy = np.maximum(worth[seen], _grown((seen >= 0) | blocked))
    filled = np.zeros((rows + 1, columns + 1))
    filled[1:, 1:] = busy.cumsum(axis=0).cumsum(axis=1)
    spots = {key: np.argwhere(seen == keys.index(key))[:, ::-1] for key, _, _ in wanted}
    placed: list[PlacedLabel] = []
    # Small things come first, because they have few good positions.
    for key, text, width in sorted(wanted, key=lambda row: len(spots[row[0]])):
        points = spots[key]
        if len(points):
            points = points[:: len(points) // SAMPLES + 1].astype(np.float32) + np.float32(0.5)
            label = _best_label(key, text, width, height, points, filled, placed, taken)
            if label is not None:
                placed.append(label)
    return placed


def _best_label(
    key: str,
    text: str,
    width: float,
    height: float,
    points: np.ndarray,
    filled: np.ndarray,
    placed: list[PlacedLabel],
    taken: Sequence[Box],
) -> PlacedLabel | None:
    rows, columns = filled.shape[0] - 1, filled.shape[1] - 1
    across = np.arange(4, columns - width - 4, GRID_STEP, dtype=np.float32)
    down = np.arange(4, rows - height - 4, GRID_STEP, dtype=np.float32)
    if not len(across) or not len(down):
        return None
    left, top = (grid.ravel() for grid in np.meshgrid(across, down))
    free = np.ones(len(left), bool)
    for x0, y0, x1, y1 in [*taken, *(other.box for other in placed)]:
        free &= (left > x1 + GAP) | (left + width < x0 - GAP) | (top > y1 + GAP) | (top + height < y0 - GAP)
    left, top = left[free], top[free]
    if not len(left):
        return None
    x0, y0 = left.astype(int), top.astype(int)
    x1, y1 = x0 + int(width), y0 + int(height)
    covered = filled[y1, x1] - filled[y0, x1] - filled[y1, x0] + filled[y0, x0]
    covered = covered / max(width * height, 1.0)
    # Distance between the nearest points of thing and label.
    dx = np.maximum(np.maximum(left[:, None] - points[:, 0], points[:, 0] - left[:, None] - width), 0.0)
    dy = np.maximum(np.maximum(top[:, None] - points[:, 1], points[:, 1] - top[:, None] - height), 0.0)
    away = np.hypot(dx, dy)
    nearest = away.argmin(axis=1)
    distance = away[np.arange(len(left)), nearest]
    middle = points.mean(axis=0)
    aside = np.hypot(left + width / 2 - middle[0], top + height / 2 - middle[1])
    cost = np.maximum(distance, 8.0) + COVERING_COST * covered + 0.15 * aside
    for other in placed:
        cost += 60.0 * _crossing(left + width / 2, top + height / 2, points[nearest], other)
    best = int(cost.argmin())
    x, y = points[nearest[best]].tolist()
    box = (float(left[best]), float(top[best]), float(left[best] + width), float(top[best] + height))
    return PlacedLabel(text, box, (x, y), key)


def _crossing(x: np.ndarray, y: np.ndarray, ends: np.ndarray, other: PlacedLabel) -> np.ndarray:
    """Whether lines from (x, y) to `ends` cross the line of another label."""
    ox, oy = (other.box[0] + other.box[2]) / 2, (other.box[1] + other.box[3]) / 2
    tx, ty = other.target

    def side(px: np.ndarray, py: np.ndarray, ax, ay, bx, by) -> np.ndarray:
        return np.sign((bx - ax) * (py - ay) - (by - ay) * (px - ax))

    ex, ey = ends[:, 0], ends[:, 1]
    apart = side(x, y, ox, oy, tx, ty) * side(ex, ey, ox, oy, tx, ty) < 0
    split = side(np.full_like(x, ox, float), np.full_like(x, oy, float), x, y, ex, ey)
    return apart & (split * side(np.full_like(x, tx, float), np.full_like(x, ty, float), x, y, ex, ey) < 0)


def _grown(mask: np.ndarray) -> np.ndarray:
    """A mask grown by three pixels."""
    grown = mask.copy()
    for shift in (1, 2, 3):
        grown[shift:] |= mask[:-shift]
        grown[:-shift] |= mask[shift:]
    wide = grown.copy()
    for shift in (1, 2, 3):
        wide[:, shift:] |= grown[:, :-shift]
        wide[:, :-shift] |= grown[:, shift:]
    return wide
