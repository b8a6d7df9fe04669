"""Panels of a layout: parallel views with axes in metres."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, floor, log10

import numpy as np

from text2sim.assets.surface import scaled_normals
from text2sim.drawing.canvas import FAINT, INK, Box, Canvas, Color, clipped, text_width
from text2sim.drawing.picture import Picture
from text2sim.drawing.prop import Stage
from text2sim.drawing.view import PictureView, parallel

AXES: dict[str, np.ndarray] = {
    "top": np.array([(1.0, 0, 0), (0, 1, 0), (0, 0, 1)]),
    "front": np.array([(1.0, 0, 0), (0, 0, 1), (0, -1, 0)]),
    "side": np.array([(0.0, 1, 0), (0, 0, 1), (1, 0, 0)]),
}
"""Right, up and back of each view: from above, from -y, from +x."""
NAMES = {"top": "xy", "front": "xz", "side": "yz"}
MARGIN = 0.08
"""Margin on each side, as a part of the panel."""


@dataclass
class Panel:
    """A parallel view at a position on the page."""

    name: str
    """top, front or side."""
    view: PictureView
    left: int
    upper: int
    blocked: np.ndarray = field(init=False)
    """(height, width) bool: pixels of lines."""
    notes: list[Box] = field(default_factory=list)
    """Boxes of texts on the page."""

    def __post_init__(self) -> None:
        """Start without lines."""
        self.blocked = np.zeros((self.view.height, self.view.width), bool)

    @property
    def box(self) -> Box:
        """Its box on the page."""
        return (self.left, self.upper, self.left + self.view.width, self.upper + self.view.height)

    def at(self, point: Sequence[float]) -> tuple[float, float]:
        """Return the position on the page of a point [m] of the world."""
        x, y = self.view.pixels(point)
        return (self.left + float(x), self.upper + float(y))

    def block(self, a: Sequence[float], b: Sequence[float]) -> None:
        """Mark the pixels of a line on the page."""
        part = clipped(a, b, self.box)
        if part is None:
            return
        (x0, y0), (x1, y1) = part
        count = int(max(abs(x1 - x0), abs(y1 - y0))) + 2
        x = np.clip(np.linspace(x0, x1, count) - self.left, 0, self.view.width - 1).astype(int)
        y = np.clip(np.linspace(y0, y1, count) - self.upper, 0, self.view.height - 1).astype(int)
        self.blocked[y, x] = True

    def write(self, canvas: Canvas, place: tuple[float, float], text: str, color: Color, *, bold: bool = False) -> None:
        """Write a short text, moved up or down if other texts are in the way.

        Args:
            canvas: The page.
            place: Upper left corner of the text [pixels].
            text: The text.
            color: Its colour.
            bold: Whether it is bold.
        """
        width, height = text_width(text, 12, bold), 15.0
        x = min(max(place[0], self.left + 5), self.box[2] - width - 5)
        y, box = place[1], (x, place[1], x, place[1])
        for number in range(9):
            away = (number + 1) // 2 * (17 if number % 2 else -17)
            y = min(max(place[1] + away, self.upper + 4), self.box[3] - 19)
            box = (x - 3, y - 1, x + width + 3, y + height)
            if not any(_overlap(box, other) for other in self.notes):
                break
        canvas.box(box, fill=(255, 255, 255, 215), radius=3)
        canvas.text((x, y), text, 12, color, bold=bold)
        self.notes.append(box)

    def span(self, axis: int) -> tuple[float, float]:
        """Return the lowest and highest coordinate [m] of the view along axis 0 (right) or 1 (up)."""
        middle = float(self.view.axes[axis] @ self.view.origin)
        half = (self.view.width, self.view.height)[axis] / 2 / self.view.focal
        return middle - half, middle + half


def fitted(name: str, bounds: tuple[np.ndarray, np.ndarray], box: tuple[int, int, int, int]) -> Panel:
    """Return a panel that shows everything within bounds.

    Args:
        name: Name of the panel: `top`, `front` or `side`.
        bounds: Lower and upper bounds, each (3,) [m].
        box: Left, upper, right and lower edge on the page [pixels].
    """
    axes, (low, high) = AXES[name], bounds
    width, height = box[2] - box[0], box[3] - box[1]
    size = np.maximum(np.abs(axes[:2] @ (high - low)), 1e-6)
    scale = (1 - 2 * MARGIN) * min(width / size[0], height / size[1])
    view = parallel(axes, ((low + high) / 2).tolist(), float(scale), (width, height))
    return Panel(name, view, box[0], box[1])


def nice_step(span: float, max_steps: int) -> float:
    """Return the smallest step of 1, 2, 5, 10, … that divides a span into at most this many parts."""
    power = 10.0 ** floor(log10(max(span, 1e-12) / max_steps))
    return next(power * k for k in (1, 2, 5, 10, 20) if span / (power * k) <= max_steps)


def ticks(low: float, high: float, max_steps: int) -> list[float]:
    """Return round numbers in an interval.

    Args:
        low: Lower end.
        high: Upper end.
        max_steps: Largest number of steps.
    """
    step = nice_step(high - low, max_steps)
    return [k * step for k in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]


def ground(panel: Panel, pixels: np.ndarray, props: Stage) -> np.ndarray:
    """Return the background (height, width, 3) of a panel: white, tinted where there is a ground, with grid lines.

    Args:
        panel: The panel.
        pixels: Its picture, shape (height, width, …).
        props: The stage.
    """
    height, width = pixels.shape[:2]
    back = np.full((height, width, 3), 1.0, np.float32)
    for prop in props:
        if prop.plane and abs(float(_normal(prop.triangles) @ panel.view.axes[2])) > 0.9:
            low, high = _flat_bounds(panel, prop.triangles)
            x0, y0 = np.clip(np.ceil(low - 0.5), 0, (width, height)).astype(int)
            x1, y1 = np.clip(np.ceil(high - 0.5), 0, (width, height)).astype(int)
            back[y0:y1, x0:x1] = 0.86 + 0.14 * np.array(prop.rgb)
    for axis, length in ((0, width), (1, height)):
        low, high = panel.span(axis)
        for value in ticks(low, high, _tick_count(length)):
            part = (value - low) / (high - low)
            place = min(int((part if axis == 0 else 1 - part) * length), length - 1)
            strong = 0.88 if abs(value) < 1e-9 else 0.955
            if axis == 0:
                back[:, place] *= strong
            else:
                back[place] *= strong
    return back


def composed(picture: Picture, back: np.ndarray) -> np.ndarray:
    """Return a picture with a white background on another background."""
    return picture.pixels + (1.0 - picture.coverage[:, :, None]) * (back - 1.0)


def draw_frame(canvas: Canvas, panel: Panel, title: str) -> None:
    """Draw axes with ticks and the title.

    Args:
        canvas: The page.
        panel: The panel.
        title: Its title.
    """
    left, upper, right, lower = panel.box
    canvas.box((left - 0.5, upper - 0.5, right + 0.5, lower + 0.5), outline=(150, 156, 164))
    for axis, length in ((0, right - left), (1, lower - upper)):
        low, high = panel.span(axis)
        for value in ticks(low, high, _tick_count(length)):
            part = (value - low) / (high - low)
            text = f"{value:.6g}".replace("-", "−") if abs(value) > 1e-12 else "0"
            if axis == 0:
                x = left + part * (right - left)
                canvas.line([(x, lower), (x, lower + 4)], FAINT)
                canvas.text((x, lower + 6), text, 12, FAINT, anchor="ma")
            else:
                y = lower - part * (lower - upper)
                canvas.line([(left - 4, y), (left, y)], FAINT)
                canvas.text((left - 7, y), text, 12, FAINT, anchor="rm")
    across, up = NAMES[panel.name]
    canvas.text((right, lower + 21), f"{across} [m]", 12, INK, anchor="ra")
    canvas.text((left - 42, upper - 7), f"{up} [m]", 12, INK, anchor="ls")
    canvas.text((left + 20, upper - 7), title, 14, INK, bold=True, anchor="ls")
    panel.notes.append(_scale_box(panel))


def _scale_length(panel: Panel) -> float:
    """Length [m] of the scale bar."""
    return nice_step(panel.view.width / panel.view.focal, 8)


def _scale_box(panel: Panel) -> Box:
    _, _, right, lower = panel.box
    return (right - 20 - _scale_length(panel) * panel.view.focal, lower - 34, right - 4, lower - 4)


def draw_scale(canvas: Canvas, panel: Panel) -> None:
    """Draw the scale bar, for which `draw_frame` has reserved space."""
    metres, box = _scale_length(panel), _scale_box(panel)
    text = f"{metres:g} m" if metres >= 1 else f"{metres * 100:g} cm" if metres >= 0.01 else f"{metres * 1000:g} mm"
    x0, x1, y = box[0] + 8, box[2] - 8, box[3] - 8
    canvas.box(box, fill=(255, 255, 255, 225), radius=4)
    canvas.line([(x0, y), (x1, y)], INK, 2)
    for x in (x0, x1):
        canvas.line([(x, y - 4), (x, y + 4)], INK, 1.5)
    canvas.text(((x0 + x1) / 2, y - 5), text, 12, INK, anchor="ms")


def draw_ground_lines(canvas: Canvas, panel: Panel, props: Stage) -> None:
    """Draw every ground that is seen edge-on, hatched below.

    Args:
        canvas: The page.
        panel: The panel.
        props: The stage.
    """
    for prop in (prop for prop in props if prop.plane):
        normal = panel.view.axes @ _normal(prop.triangles)
        if abs(normal[2]) > 0.2:
            continue
        low, high = _flat_bounds(panel, prop.triangles)
        ends = [panel.at(corner) for corner in prop.triangles.reshape(-1, 3).tolist()]
        a = min(ends, key=lambda p: p[0] * abs(normal[1]) + p[1] * abs(normal[0]))
        b = max(ends, key=lambda p: p[0] * abs(normal[1]) + p[1] * abs(normal[0]))
        part = clipped(a, b, panel.box)
        if part is None:
            continue
        (x0, y0), (x1, y1) = part
        color = tuple(int(150 * c) for c in prop.rgb)
        canvas.line([(x0, y0), (x1, y1)], color, 2)  # type: ignore[arg-type]
        panel.block((x0, y0), (x1, y1))
        length = max(abs(x1 - x0), abs(y1 - y0))
        for k in range(int(length / 12) + 1):
            x, y = x0 + (x1 - x0) * k * 12 / max(length, 1), y0 + (y1 - y0) * k * 12 / max(length, 1)
            end = (x - 8 * normal[0] - 5 * normal[1], y + 8 * normal[1] - 5 * abs(normal[0]))
            canvas.line([(x, y), end], (*color, 130), 1, clip=panel.box)  # type: ignore[arg-type]


def _tick_count(length: float) -> int:
    """Number of ticks that fit on a length [pixels]."""
    return max(int(length / 62), 2)


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _normal(triangles: np.ndarray) -> np.ndarray:
    normal = scaled_normals(triangles[:1])[0]
    return normal / np.linalg.norm(normal)


def _flat_bounds(panel: Panel, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    pixels = panel.view.pixels(triangles.reshape(-1, 3))
    return pixels.min(axis=0), pixels.max(axis=0)
