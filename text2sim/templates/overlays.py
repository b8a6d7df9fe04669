"""Overlays of a film: title, time, playback speed, measured values, replay marks, and the first picture in a corner."""

from typing import Any

import numpy as np

TITLE = 3.0
"""Time for which the title is shown [s of film]."""
FADE = 0.5
"""Last part of that time, in which the title fades out [s of film]."""
INSET = 0.24
"""Width of the inset, as a fraction of the picture's width."""


class Overlay:
    """Draws overlays into the pictures of a film.

    Args:
        film: Constants of `render.py`.
        values: Function of the simulated time [s] that returns rows of text, such as `height 0.52 m`; None if there are
            no measured values yet.
    """

    def __init__(self, film: dict, values: Any = None):
        self._overlay, self._fps = film["overlay"], film["fps"]
        self._values = values
        self._first: np.ndarray | None = None

    def draw(self, image: np.ndarray, frame: Any) -> np.ndarray:
        """Return a picture with its overlays, shape (height, width, 3), uint8.

        Args:
            image: The picture, of the same shape; the first call gets the first picture of the film.
            frame: One of `cadence.frames`.
        """
        wanted = self._overlay
        pace = _pace(frame, told=wanted["time"] or wanted.get("pace", False))
        if not (wanted["title"] or wanted["time"] or wanted["inset"] or (wanted["values"] and self._values) or pace):
            return image
        from PIL import Image, ImageDraw, ImageFont

        if self._first is None:
            self._first = image
        height, width = image.shape[:2]
        unit = max(height / 36, 9.0)
        edge = round(1.4 * unit)
        picture = Image.fromarray(image)
        if wanted["inset"] and frame.k:
            small = Image.fromarray(self._first)
            small = small.resize((round(INSET * width), round(INSET * height)), Image.Resampling.LANCZOS)
            picture.paste(small, (edge, edge))
            ImageDraw.Draw(picture).rectangle(
                (edge - 1, edge - 1, edge + small.width, edge + small.height),
                outline="white",
                width=max(1, height // 480),
            )
        layer = Image.new("RGBA", picture.size, (0, 0, 0, 0))
        pen = ImageDraw.Draw(layer)
        if wanted["title"] and (opacity := self._title_opacity(frame)) > 0:
            font = ImageFont.load_default(size=1.9 * unit)
            _write(pen, (edge, height - edge), _fitting(wanted["title"], font, width - 2 * edge), font, "ls", opacity)
        time = f"t = {frame.t:.2f} s" if wanted["time"] else ""
        rows = [row] if (row := "   ".join(filter(None, (time, pace)))) else []
        rows += self._values(frame.t) if wanted["values"] and self._values else []
        font = ImageFont.load_default(size=1.25 * unit)
        for number, row in enumerate(rows):
            _write(pen, (width - edge, edge + round(1.7 * unit * number)), row, font, "ra", 1.0)
        return np.asarray(Image.alpha_composite(picture.convert("RGBA"), layer).convert("RGB"))

    def _title_opacity(self, frame: Any) -> float:
        """Opacity of the title, 0 to 1."""
        return float(np.clip((TITLE - frame.k / self._fps) / FADE, 0.0, 1.0))


def _fitting(text: str, font: Any, width: float) -> str:
    """Shorten a text to a width [pixels]."""
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "…") > width:
        text = text[:-1]
    return text.rstrip() + "…"


def _pace(frame: Any, *, told: bool) -> str:
    """Return the text for playback speed and replay. Replays are always marked: none may look like a second event.

    Args:
        frame: The picture.
        told: Whether to show the speed outside replays.
    """
    speed = f"{frame.speed:.2g} x" if told and abs(frame.speed - 1) > 1e-6 else ""
    if not frame.again:
        return speed
    return f"replay   {frame.speed:.2g} x" if abs(frame.speed - 1) > 1e-6 else "replay"


def _write(pen: Any, at: tuple[float, float], text: str, font: Any, anchor: str, opacity: float) -> None:
    """Write a row in white with a dark shadow, which is legible on any background."""
    away = max(1, round(font.size / 16))
    for x, y, ink in ((away, away, (16, 18, 20, round(170 * opacity))), (0, 0, (255, 255, 255, round(250 * opacity)))):
        pen.text((at[0] + x, at[1] + y), text, font=font, anchor=anchor, fill=ink)
