"""Frames of a film for judges: evenly spaced ones and those after scene changes, at full resolution."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.agents.models.exchange import MAX_IMAGE, Image
from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.legibility.film import spread_numbers
from text2sim.spec_schema.errors import RunError

EVEN_FRAMES, MAX_CHANGE_FRAMES = 10, 6
"""Number of evenly spaced frames, and largest number of frames after scene changes."""
MAX_FRAMES = 20_000
"""Largest number of frames that are read."""
MAX_PIXELS = 4096 * 2304
"""Largest frame that is read [pixels]."""
MIN_CUT_DIFFERENCE = 0.12
"""Smallest mean difference of consecutive grey thumbnails (0 to 1) at a scene change."""
MIN_CUT_RATIO = 5.0
"""Smallest ratio of this difference to the film's median, since fast motion is not a scene change."""
THUMBNAIL_SIZE = (64, 36)
"""Width and height of these thumbnails [pixels]."""


@dataclass(frozen=True)
class FilmFrames:
    """Frames of a film that are shown to a judge."""

    images: tuple[Image, ...]
    """`frame_01.png` and so on."""
    times: tuple[float, ...]
    """Their times in the film [s]."""
    duration: float
    """Duration of the film [s]."""
    size: tuple[int, int]
    """Width and height [pixels]."""

    def listed(self) -> str:
        """Return one line with the time of each frame."""
        return ", ".join(f"frame {k}: {t:.2f} s" for k, t in enumerate(self.times, 1))


def film_frames(film: Path) -> FilmFrames:
    """Return frames of a film for a judge.

    Raises:
        RunError: If it cannot be decoded.
    """
    times, greys, size = _scan(film)
    chosen = sorted({*spread_numbers(len(times), EVEN_FRAMES), *_changes(greys)})
    images = [_image(f"frame_{number:02}", picture) for number, picture in enumerate(_pictures(film, chosen), 1)]
    if len(images) != len(chosen):
        raise RunError(
            f"the film decodes differently each time: {len(images)} of {len(chosen)} frames were found again"
        )
    return FilmFrames(tuple(images), tuple(times[k] for k in chosen), _length(times), size)


def length_of(film: Path) -> float:
    """Return the length of a film [s].

    Raises:
        RunError: If it cannot be decoded.
    """
    return _length(_scan(film)[0])


def pictures_at(film: Path, times: list[float]) -> list[Any]:
    """Return the frames of a film nearest to given times [s]; the last one for times beyond its end.

    Raises:
        RunError: If it cannot be decoded.
    """
    own, _, _ = _scan(film)
    nearest = [int(np.abs(np.array(own) - time).argmin()) for time in times]
    found = dict(zip(sorted(set(nearest)), _pictures(film, sorted(set(nearest))), strict=True))
    return [found[k] for k in nearest]


def _scan(film: Path) -> tuple[list[float], Any, tuple[int, int]]:
    """Times [s] of all frames, thumbnails of them in grey (n, 36, 64), and the size of the first."""
    import av
    import av.error

    times, greys, size = [], [], (0, 0)
    try:
        with av.open(str(film)) as video:
            if not video.streams.video:
                raise RunError("the film has no frames")
            for k, frame in zip(range(MAX_FRAMES), video.decode(video=0)):  # noqa: B905
                size = size if k else (frame.width, frame.height)
                if frame.width * frame.height > MAX_PIXELS:
                    raise RunError(f"the film's frames are larger than {MAX_PIXELS:,} pixels")
                times.append(float(frame.time) if frame.time is not None else k / 25)
                greys.append(frame.reformat(*THUMBNAIL_SIZE, format="gray").to_ndarray().astype(np.float32) / 255)
    except (OSError, ValueError, av.error.FFmpegError) as error:
        raise RunError(
            f"the film does not decode: {getattr(error, 'strerror', None) or type(error).__name__}"
        ) from None
    if not times:
        raise RunError("the film has no frames")
    return times, np.stack(greys), size


def _length(times: list[float]) -> float:
    """Length of a film [s]; the last frame lasts as long as the others on average."""
    return times[-1] + (times[-1] - times[0]) / max(1, len(times) - 1)


def _changes(greys: Any) -> list[int]:
    """Indices of the first frames after the strongest scene changes."""
    if len(greys) < 3:
        return []
    steps = np.abs(np.diff(greys, axis=0)).mean(axis=(1, 2))
    cuts = np.flatnonzero((steps > MIN_CUT_DIFFERENCE) & (steps > MIN_CUT_RATIO * np.median(steps)))
    strongest = sorted(cuts, key=lambda k: -steps[k])[:MAX_CHANGE_FRAMES]
    return [int(k) + 1 for k in strongest]


def _pictures(film: Path, chosen: list[int]) -> Iterator[Any]:
    """Yield the frames with these indices."""
    import av

    wanted = set(chosen)
    with av.open(str(film)) as video:
        for k, frame in zip(range(max(wanted) + 1), video.decode(video=0)):  # noqa: B905
            if k in wanted:
                yield frame.to_image()


def _image(name: str, picture: Any) -> Image:
    """A frame as PNG, or as JPEG if the PNG is too large to send."""
    content = picture_bytes(picture, "png")
    if len(content) <= MAX_IMAGE:
        return Image(f"{name}.png", "image/png", content)
    return Image(f"{name}.jpg", "image/jpeg", picture_bytes(picture, "jpeg", quality=92))
