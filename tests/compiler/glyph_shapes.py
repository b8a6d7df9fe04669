"""Texts and sketches to test with, and what is measured of their forms."""

from pathlib import Path

import cv2
import numpy as np

from text2sim.compiler.shapes.extrude import polygons_of
from text2sim.spec_schema.models.shapes import Sketch, Text

HERE = Path(".")


def stroke_width(form) -> float:
    """Return the width [m] of the thinnest strokes of a form: where a wider brush would not reach a tenth of it.

    Mean widths hide thin parts, and least ones are those of every pointed end.
    """
    low_x, low_z, high_x, high_z = form.bounds
    low, high = 0.0, min(high_x - low_x, high_z - low_z)
    for _ in range(12):
        width = (low + high) / 2
        brushed = form.buffer(-width / 2, join_style="mitre").buffer(width / 2 * (1 + 1e-9), join_style="mitre")
        low, high = (width, high) if brushed.intersection(form).area >= 0.9 * form.area else (low, width)
    return low


def text(words, **more):
    return Text(kind="text", text=words, height=0.3, depth=0.1, **more)


def sketch(file="sketch.png", **more):
    return Sketch(kind="sketch", file=file, height=more.pop("height", 1.0), depth=0.1, **more)


def holes(form):
    return sum(len(part.interiors) for part in polygons_of(form))


def draw(path, *strokes, size=(400, 300), pen=24, paper=250, ink=20):
    """Strokes are lists of points; a single point is a dot, three numbers a circle."""
    picture = np.full((size[1], size[0]), paper, np.uint8)
    for points in strokes:
        if isinstance(points, tuple):
            cv2.circle(picture, points[:2], points[2], ink, pen, cv2.LINE_AA)
        else:
            cv2.polylines(picture, [np.array(points, np.int32)], False, ink, pen, cv2.LINE_AA)
    cv2.imwrite(str(path), picture)
