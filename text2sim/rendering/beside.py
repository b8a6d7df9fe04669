"""A film of two runs side by side, picture by picture at the same second of film."""

from itertools import zip_longest
from pathlib import Path

import numpy as np

from text2sim.rendering.film import ENCODER, Filming, Reel
from text2sim.templates.video import Video

GAP = 4
"""Between the two [pixels]."""


def beside(left: Filming, right: Filming, reels: tuple[Reel, Reel]) -> Path:
    """Make a film of two that are rendered already; the shorter one waits at its last picture.

    Args:
        left: Where the film is put.
        right: Films in the same size.
        reels: One of each.

    Returns:
        The file, `<quality>_beside_<run>.mp4` in the folder of the left one.

    Raises:
        RunError: if pictures are missing.
    """
    one, two = (film.pictures(reel, film.rendered(reel)) for film, reel in zip((left, right), reels, strict=True))
    names = captions(left.recording.folder.name, right.recording.folder.name)
    target = left.folder / f"{left.quality}_beside_{right.recording.folder.name}.mp4"
    width, height = left.size
    crf, preset = ENCODER.get(left.quality, ENCODER["final"])
    video = Video(target, (2 * width + GAP, height), left.recording.film["fps"], crf=crf, preset=preset)
    shown = [np.zeros((height, width, 3), np.uint8)] * 2
    for pictures in zip_longest(one, two):
        for k, picture in enumerate(pictures):
            if picture is not None:
                shown[k] = captioned(picture, names[k])
        video.write(np.hstack([shown[0], np.full((height, GAP, 3), 255, np.uint8), shown[1]]))
    video.close()
    return target


def captions(left: str, right: str) -> tuple[str, str]:
    """Return what two runs are called: their cases and variants, or their whole names where those are the same."""
    short = left.rpartition("-")[0] or left, right.rpartition("-")[0] or right
    return (left, right) if short[0] == short[1] else short


def captioned(image: np.ndarray, text: str) -> np.ndarray:
    """Return a picture (h, w, 3) with a name in the middle of its lower edge."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = image.shape[:2]
    picture = Image.fromarray(image)
    size = max(height / 24, 11.0)
    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(size=size)
    at = (width / 2, height - 0.4 * size)
    pen.text(at, text, font=font, anchor="mb", fill="white", stroke_width=max(1, height // 360), stroke_fill="#202428")
    return np.asarray(picture)
