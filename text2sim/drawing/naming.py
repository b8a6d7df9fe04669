"""Labels of bodies in a panel."""

import numpy as np

from text2sim.drawing.canvas import INK, Canvas, Color, text_width
from text2sim.drawing.labels import PlacedLabel, place_labels
from text2sim.drawing.panel import Panel
from text2sim.drawing.picture import Picture
from text2sim.drawing.prop import Stage

LABEL_HEIGHT = 19.0
"""Height of a label [pixels]."""
MAX_LABELS = 14


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
