"""Labels of bodies in a panel, and places for them where they cover little."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageFilter

from text2sim.drawing.canvas import INK, Box, Canvas, Color, text_width
from text2sim.drawing.panel import Panel
from text2sim.drawing.picture import Picture
from text2sim.drawing.prop import Stage

GRID_STEP = 8
"""Grid of candidate positions [pixels]."""
COVERING_COST = 150.0
"""Cost of a label that covers other things completely, as a distance [pixels]."""
SMALL_AREA = 16_000
"""Area of a thing [pixels] below which covering it costs more."""
SAMPLES = 48
GAP = 3.0
LABEL_HEIGHT = 19.0
"""Height of a label [pixels]."""
MAX_LABELS = 14


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
    return np.asarray(Image.fromarray(mask.astype(np.uint8)).filter(ImageFilter.MaxFilter(7)), bool)


def draw_labels(
    canvas: Canvas, panel: Panel, picture: Picture, props: Stage, texts: dict[str, str]
) -> list[PlacedLabel]:
    """Label the visible bodies of a panel; return the labels.

    Args:
        canvas: The page.
        panel: The panel.
        picture: The picture of the panel.
        props: The stage of the picture.
        texts: Texts of labels by body; other bodies have none.
    """
    names = list(texts)
    body_of = np.array([names.index(prop.body) if prop.body in texts else -1 for prop in props] + [-1])
    seen, through = body_of[picture.owner], body_of[picture.glazed]
    counts = np.bincount(seen[seen >= 0], minlength=len(names))
    # A glass body is labelled at its transparent pixels if it has no opaque ones.
    unseen = np.append(counts == 0, False)[through]
    seen = np.where(unseen, through, seen)
    counts = np.bincount(seen[seen >= 0], minlength=len(names))
    most = [k for k in np.argsort(-counts, kind="stable").tolist() if counts[k]][:MAX_LABELS]
    wanted = [(names[k], texts[names[k]], text_width(texts[names[k]], 13) + 28.0) for k in sorted(most)]
    taken = [(x0 - panel.left, y0 - panel.upper, x1 - panel.left, y1 - panel.upper) for x0, y0, x1, y1 in panel.notes]
    labels = place_labels(wanted, seen, names, LABEL_HEIGHT, panel.blocked, taken)
    x, y = panel.left, panel.upper
    for label in labels:
        box = label.box
        end = (x + label.target[0], y + label.target[1])
        near = (min(max(end[0], x + box[0]), x + box[2]), min(max(end[1], y + box[1]), y + box[3]))
        if abs(near[0] - end[0]) + abs(near[1] - end[1]) > 3:
            canvas.line([near, end], (255, 255, 255, 190), 3)
            canvas.line([near, end], INK, 1)
            canvas.ring(end, 1.6, INK, 1, fill=INK)
    for label in labels:
        left, upper, right, lower = (v + o for v, o in zip(label.box, (x, y, x, y), strict=True))
        canvas.box((left, upper, right, lower), (255, 255, 255, 235), (176, 182, 190), radius=4)
        swatches = _swatches(props, label.key)
        for k, color in enumerate(swatches):
            wide = 10 / len(swatches)
            canvas.box((left + 5 + k * wide, upper + 5, left + 5 + (k + 1) * wide, upper + 14), color)
        canvas.box((left + 5, upper + 5, left + 15, upper + 14), None, (90, 96, 104))
        canvas.text((left + 20, (upper + lower) / 2), label.text, 13, INK, anchor="lm")
    return labels


def _swatches(props: Stage, body: str) -> list[Color]:
    """Up to four clearly different colours of a body."""
    found: list[Color] = []
    for prop in props:
        red, green, blue = (int(255 * c) for c in prop.rgb)
        if prop.body == body and all(abs(red - r) + abs(green - g) + abs(blue - b) > 90 for r, g, b, *_ in found):
            found.append((red, green, blue))
            if len(found) == 4:
                break
    return found
