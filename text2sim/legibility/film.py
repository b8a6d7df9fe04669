"""Legibility of bodies in the pictures of a film, measured on recorded states."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import triangle_areas
from text2sim.legibility.recorded import Recorded
from text2sim.legibility.sight import Sight, Things
from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras, project

Array = NDArray[Any]
Row = dict[str, Any]
"""Measures of a picture: frame, camera, t, span of all bodies together, and the measures of each body by name."""
Painted = Callable[[Frame, tuple[int, int]], Array | None]
"""Returns a picture of a film in this size, colours 0 to 1, shape (h, w, 3); None if there is none."""

SAMPLED_PICTURES = 15
"""Pictures of a film that are measured; the preview keeps every second of them."""
PICTURE_WIDTH = 192
"""Width of these pictures [pixels]; shares do not depend on it."""
MAX_TIME_OFFSET = 0.1
"""Largest difference [s of film] between a moment and the picture that shows it."""
DIGITS = 5
"""Decimal places of measures."""


class Watcher:
    """Measures pictures of a film.

    Args:
        recording: The recorded run.
        painted: Source of finished pictures, for contrast; pictures have flat colours if it is left out.
        links: Whether each link is a thing of its own, with names such as `arm[1].hand`, instead of each body.
    """

    def __init__(self, recording: FilmRecord, painted: Painted | None = None, *, links: bool = False):
        if links:
            names = [row["link"] for row in recording.states.layout["links"]]
            parts = [replace(part, body=f"{part.body}.{names[part.link]}") for part in recording.parts]
            recording = replace(recording, parts=parts)
        self.recording, self._painted = recording, painted
        self.recorded = Recorded(recording, copies=links)
        self.cameras = Cameras(recording.film, recording.states)
        wide, tall = recording.film["resolution"]
        self.size = (PICTURE_WIDTH, max(2, round(PICTURE_WIDTH * tall / wide)))
        self.moves = np.array([name not in self.recorded.statics for name in self.recorded.names], bool)
        """Whether each thing is a body, not a static, shape (m,)."""

    @property
    def moving(self) -> list[str]:
        """Names of the bodies, without statics."""
        return list(compress(self.recorded.names, self.moves))

    def sight(self, frame: Frame) -> Sight:
        """Return what is visible in a picture."""
        return self.recorded.sight(frame.t, self.cameras.view(frame.camera, frame.t, frame.part), self.size)

    def row(self, frame: Frame, after: Frame | None = None) -> Row:
        """Return the measures of a picture, of all things in it, including those that others hide.

        Args:
            frame: The picture.
            after: The next picture, for motion.
        """
        sight = self.sight(frame)
        if self._painted is None:
            picture = self.recorded.flat_picture(sight, self.recording.film["background"])
        else:
            picture = self._painted(frame, self.size)
        motion = self._motion(frame, after)
        bodies = {
            name: {key: None if value is None else round(value, DIGITS) for key, value in measures._asdict().items()}
            | {"motion": None if motion is None or np.isnan(motion[k]) else round(float(motion[k]), DIGITS)}
            for k, (name, measures) in enumerate(zip(self.recorded.names, sight.measures(picture), strict=True))
            if measures.share or measures.inside
        }
        span = round(self._span(sight), DIGITS)
        return {"frame": frame.k, "camera": frame.camera, "t": round(frame.t, 6), "span": span, "bodies": bodies}

    def moves_between(self, start: float, end: float) -> bool:
        """Whether bodies move between two times [s], by more than a twentieth of the space that they take up."""
        before, after = (self.recorded.things(t) for t in (start, end))
        one, other = (things.triangles[self.moves[things.owner], 0] for things in (before, after))
        if not len(one) or len(one) != len(other):
            return len(one) != len(other)
        return bool(np.linalg.norm(other - one, axis=1).max() > np.ptp(one, axis=0).max() / 20)

    def _span(self, sight: Sight) -> float:
        """Part of the picture's width or height, the larger of both, that all visible bodies together span."""
        pixels = sight.pixels[sight.visible & self.moves[sight.things]]
        if not len(pixels):
            return 0.0
        wide, tall = self.size
        return float(max((np.ptp(pixels % wide) + 1) / wide, (np.ptp(pixels // wide) + 1) / tall))

    def rows(self, frames: Sequence[Frame], samples: int = SAMPLED_PICTURES) -> list[Row]:
        """Return the measures of at most `samples` pictures, evenly spread over a film."""
        return [
            self.row(frames[k], frames[k + 1] if k + 1 < len(frames) else None)
            for k in spread_numbers(len(frames), samples)
        ]

    def _motion(self, frame: Frame, after: Frame | None) -> Array | None:
        """Displacement of the centre of each thing to the next picture [heights of the picture]; None at a cut.

        A thing that spins in place does not move. It is nan for things whose centre is behind the camera.
        """
        if after is None or after.camera != frame.camera:
            return None
        aspect, places = self.size[0] / self.size[1], []
        for shown in (frame, after):
            view = self.cameras.view(shown.camera, shown.t, shown.part)
            place = project(view, _middles(self.recorded.things(shown.t)), aspect)
            places.append(np.where(place[:, 2:] > 0, place[:, :2], np.nan))
        return np.hypot(*((places[1] - places[0]) * (aspect / 2, 0.5)).T)


def _middles(things: Things) -> Array:
    """Centres of the surfaces of all things [m], shape (m, 3); nan for things without a surface."""
    corners = things.triangles
    area = triangle_areas(corners)
    rows = (
        np.bincount(things.owner, weights, things.number)
        for weights in (area, *(corners.mean(axis=1) * area[:, None]).T)
    )
    area, *sums = rows
    return np.stack(sums, axis=1) / np.where(area > 0, area, np.nan)[:, None]


def spread_numbers(count: int, samples: int) -> list[int]:
    """Return the indices of at most `samples` of `count` pictures, evenly spread from the first to the last."""
    return np.unique(np.linspace(0, count - 1, samples).round().astype(int)).tolist() if count else []


def nearest_frame(frames: Iterable[Frame], t: float) -> Frame | None:
    """Return the picture of a film nearest to a time [s]; None if none is within `MAX_TIME_OFFSET`."""
    best = min(frames, key=lambda frame: abs(frame.t - t), default=None)
    return best if best is not None and abs(best.t - t) <= MAX_TIME_OFFSET * best.speed else None


def read_picture(path: Path, size: tuple[int, int]) -> Array:
    """Return a picture file scaled to a width and height [pixels], colours 0 to 1, shape (h, w, 3)."""
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB").resize(size, Image.Resampling.BOX), float) / 255
