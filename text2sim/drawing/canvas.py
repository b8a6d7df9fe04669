"""Antialiased lines and text on a picture, drawn at double size and scaled down."""

import importlib.util
from collections.abc import Sequence
from functools import cache
from math import atan2, ceil, cos, hypot, isfinite, sin
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

Point = Sequence[float]
Color = tuple[int, int, int] | tuple[int, int, int, int]
Box = tuple[float, float, float, float]
"""Left, upper, right and lower edge [pixels]."""

FINE = 2
INK: Color = (38, 44, 52)
FAINT: Color = (120, 128, 138)


@cache
def font(size: float, bold: bool = False) -> Any:
    """Return a font: DejaVu, which matplotlib includes and which supports most languages, or Pillow's default."""
    found = importlib.util.find_spec("matplotlib")
    if found is not None and found.origin is not None:
        name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
        path = Path(found.origin).parent / "mpl-data" / "fonts" / "ttf" / name
        if path.is_file():
            return ImageFont.truetype(str(path), size * FINE)
    return ImageFont.load_default(size * FINE)


class Canvas:
    """A picture to draw on; all lengths are pixels of the finished picture."""

    def __init__(self, pixels: np.ndarray) -> None:
        """Start with a picture (height, width, 3), float in 0..1."""
        coarse = (np.clip(pixels, 0.0, 1.0) * 255 + 0.5).astype(np.uint8)
        height, width = coarse.shape[:2]
        self.image = Image.fromarray(coarse).resize((width * FINE, height * FINE), Image.Resampling.NEAREST)
        self._draw = ImageDraw.Draw(self.image, "RGBA")

    def finished(self) -> Image.Image:
        """Return the picture."""
        return self.image.reduce(FINE)

    def line(
        self,
        points: Sequence[Point],
        color: Color,
        width: float = 1.0,
        dashes: Sequence[float] = (),
        clip: Box | None = None,
    ) -> None:
        """Draw a polyline.

        Args:
            points: Vertices [pixels].
            color: Colour of the line.
            width: Width of the line [pixels].
            dashes: Lengths of dashes and gaps [pixels]; none for a solid line.
            clip: Box outside of which nothing is drawn [pixels].
        """
        for a, b in zip(points, points[1:], strict=False):
            part = clipped(a, b, clip) if clip is not None else (a, b)
            if part is None:
                continue
            for start, end in _dashed(*part, dashes) if dashes else [part]:
                self._draw.line([_fine(start), _fine(end)], fill=color, width=max(round(width * FINE), 1))

    def polygon(self, points: Sequence[Point], fill: Color) -> None:
        """Fill a polygon."""
        self._draw.polygon([_fine(p) for p in points], fill=fill)

    def box(self, box: Box, fill: Color | None = None, outline: Color | None = None, radius: float = 0.0) -> None:
        """Draw a rectangle.

        Args:
            box: Left, upper, right and lower edge [pixels].
            fill: Colour of the inside; not filled if None.
            outline: Colour of the outline; none if None.
            radius: Radius of the corners [pixels].
        """
        corners = tuple(value * FINE for value in box)
        self._draw.rounded_rectangle(corners, radius * FINE, fill=fill, outline=outline, width=FINE)

    def ring(self, center: Point, radius: float, color: Color, width: float = 1.5, fill: Color | None = None) -> None:
        """Draw a circle.

        Args:
            center: Centre [pixels].
            radius: Radius [pixels].
            color: Colour of the line.
            width: Width of the line [pixels].
            fill: Colour of the inside; not filled if None.
        """
        x, y = _fine(center)
        r = radius * FINE
        self._draw.ellipse((x - r, y - r, x + r, y + r), fill=fill, outline=color, width=round(width * FINE))

    def arrow(self, start: Point, end: Point, color: Color, width: float = 2.5, both: bool = False) -> None:
        """Draw an arrow with a white outline, so that it is visible on any background.

        Args:
            start: Its start [pixels].
            end: Its tip [pixels].
            color: Colour of the arrow.
            width: Width of the line [pixels].
            both: Whether both ends have heads.
        """
        length = hypot(end[0] - start[0], end[1] - start[1])
        if length < 1e-6:
            return
        head = min(5.0 * width, 0.5 * length + 4.0)
        ux, uy = (end[0] - start[0]) / length, (end[1] - start[1]) / length
        neck = (end[0] - 0.8 * head * ux, end[1] - 0.8 * head * uy)
        tail = (start[0] + 0.8 * head * ux, start[1] + 0.8 * head * uy) if both else start
        for more, ink in ((2.0, (255, 255, 255, 210)), (0.0, color)):
            self.line([tail, neck], ink, width + more)
            self._head(end, (ux, uy), head + more, ink)
            if both:
                self._head(start, (-ux, -uy), head + more, ink)

    def turn(self, center: Point, radius: float, color: Color, sign: int) -> None:
        """Draw a circular arrow over three quarters of a circle.

        Args:
            center: Centre of the circle [pixels].
            radius: Its radius [pixels].
            color: Its colour.
            sign: 1 for counterclockwise, -1 for clockwise.
        """
        angles = [0.1 * k for k in range(48)]
        points = [(center[0] + radius * cos(a), center[1] - sign * radius * sin(a)) for a in angles]
        ahead = (-sin(angles[-1]), -sign * cos(angles[-1]))
        for more, ink in ((2.0, (255, 255, 255, 210)), (0.0, color)):
            self.line(points, ink, 1.6 + more)
            self._head((points[-1][0] + 5 * ahead[0], points[-1][1] + 5 * ahead[1]), ahead, 7 + more, ink)

    def _head(self, tip: Point, direction: Point, size: float, color: Color) -> None:
        angle = atan2(direction[1], direction[0])
        back = [(tip[0] - size * cos(angle + a), tip[1] - size * sin(angle + a)) for a in (-0.4, 0.4)]
        self.polygon([tip, *back], color)

    def text(
        self, place: Point, text: str, size: float = 14, color: Color = INK, bold: bool = False, anchor: str = "la"
    ) -> None:
        """Write a line of text.

        Args:
            place: Position of the anchor [pixels].
            text: The line.
            size: Size of the font [pixels].
            color: Its colour.
            bold: Whether it is bold.
            anchor: Anchor of the text, as in Pillow: `la` is its upper left corner.
        """
        self._draw.text(_fine(place), text, fill=color, font=font(size, bold), anchor=anchor)


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return the length [pixels] of a line of text.

    Args:
        text: The line.
        size: Size of the font [pixels].
        bold: Whether it is bold.
    """
    return font(size, bold).getlength(text) / FINE


def shortened(text: str, width: float, size: float) -> str:
    """Return a text that is cut to fit.

    Args:
        text: The text; each run of whitespace becomes a blank.
        width: Available width [pixels].
        size: Size of the font [pixels].
    """
    text = " ".join(text.split())
    if text_width(text, size) <= width:
        return text
    low, high = 0, len(text)
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if text_width(text[:middle] + "…", size) <= width else (low, middle - 1)
    return text[:low].rstrip() + "…"


def clipped(a: Point, b: Point, box: Box) -> tuple[Point, Point] | None:
    """Return the part of a line inside a box, None if there is none (Liang and Barsky).

    Args:
        a: One end of the line.
        b: Its other end.
        box: Left, upper, right and lower edge.
    """
    if not all(map(isfinite, (*a, *b))):
        return None
    first, last = 0.0, 1.0
    for axis in (0, 1):
        start, length = a[axis], b[axis] - a[axis]
        low, high = box[axis] - start, box[axis + 2] - start
        if abs(length) < 1e-12:
            if low > 0 or high < 0:
                return None
            continue
        enter, leave = sorted((low / length, high / length))
        first, last = max(first, enter), min(last, leave)
    if first > last:
        return None
    return _point_between(a, b, first), _point_between(a, b, last)


def _point_between(a: Point, b: Point, part: float) -> tuple[float, float]:
    return (a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]))


def _fine(point: Point) -> tuple[float, float]:
    return (point[0] * FINE, point[1] * FINE)


def _dashed(a: Point, b: Point, dashes: Sequence[float]) -> list[tuple[Point, Point]]:
    length = hypot(b[0] - a[0], b[1] - a[1])
    whole = sum(dashes)
    if length < 1e-9 or length > 1e5:
        return []
    parts, at = [], 0.0
    for k in range(len(dashes) * ceil(length / whole)):
        end = min(at + dashes[k % len(dashes)], length)
        if k % 2 == 0 and end > at:
            parts.append((_point_between(a, b, at / length), _point_between(a, b, end / length)))
        at = end
    return parts
