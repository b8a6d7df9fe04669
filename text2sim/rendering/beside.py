"""Film of two runs side by side, synchronised by film time."""

from itertools import zip_longest
from pathlib import Path

import numpy as np

from text2sim.rendering.film import ENCODER, Filming, Reel
from text2sim.templates.video import Video

GAP = 4
"""Gap between the two films [pixels]."""


def beside(films: tuple[Filming, Filming], reels: tuple[Reel, Reel], captions: tuple[str, str], name: str) -> Path:
    """Combine two rendered films; the shorter one holds its last frame.

    Args:
        films: Left and right, with the same size and frame rate.
        reels: One of each.
        captions: Caption of each.
        name: Stem of the file in the left one's folder.

    Raises:
        RunError: If frames are missing.
    """
    one, two = (film.pictures(reel, film.rendered(reel)) for film, reel in zip(films, reels, strict=True))
    left = films[0]
    target, (width, height) = left.folder / f"{name}.mp4", left.size
    crf, preset = ENCODER.get(left.quality, ENCODER["final"])
    video = Video(target, (2 * width + GAP, height), left.fps, crf=crf, preset=preset)
    shown = [np.zeros((height, width, 3), np.uint8)] * 2
    for pictures in zip_longest(one, two):
        for k, picture in enumerate(pictures):
            if picture is not None:
                shown[k] = captioned(picture, captions[k])
        video.write(np.hstack([shown[0], np.full((height, GAP, 3), 255, np.uint8), shown[1]]))
    video.close()
    return target


def captioned(image: np.ndarray, text: str) -> np.ndarray:
    """Return a picture (h, w, 3) with a caption centred at its lower edge."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = image.shape[:2]
    picture = Image.fromarray(image)
    size = max(height / 24, 11.0)
    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(size=size)
    while len(text) > 1 and pen.textlength(text, font=font) > width - size:
        text = f"{text[:-2]}…"
    at = (width / 2, height - 0.4 * size)
    pen.text(at, text, font=font, anchor="mb", fill="white", stroke_width=max(1, height // 360), stroke_fill="#202428")
    return np.asarray(picture)
