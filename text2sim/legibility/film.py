"""Legibility of bodies in the pictures of a film, measured on recorded states."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from text2sim.legibility.recorded import Recorded
from text2sim.legibility.sight import Measures, Sight, Things
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras, project

if TYPE_CHECKING:
    from text2sim.recording.film_record import FilmRecord

Array = NDArray[Any]
Row = dict[str, Any]
"""Of a picture: frame, camera, t, span of all bodies together, and bodies with their measures by name."""
Painted = Callable[[Frame, tuple[int, int]], Array | None]
"""Returns a picture of a film in this size, colours 0 to 1, shape (h, w, 3); None if there is none."""

SAMPLED_PICTURES = 15
"""Pictures of a film that are looked at: every second one is also one that the preview keeps."""
PICTURE_WIDTH = 192
"""Of the pictures that are looked at [pixels]; shares do not depend on it."""
MAX_TIME_OFFSET = 0.1
"""How far [s of film] a picture may be from the moment that it is to show."""
DIGITS = 5


class Watcher:
    """Looks at pictures of a film.

    Args:
        recording: Of the run.
        painted: Where finished pictures come from, for contrast; that of plain colours if left out.
    """

    def __init__(self, recording: "FilmRecord", painted: Painted | None = None):
        self.recording, self._painted = recording, painted
        self.recorded = Recorded(recording)
        self.cameras = Cameras(recording.film, recording.states)
        wide, tall = recording.film["resolution"]
        self.size = (PICTURE_WIDTH, max(2, round(PICTURE_WIDTH * tall / wide)))

    @property
    def moving(self) -> list[str]:
        """Bodies: all that is no static."""
        return [name for name in self.recorded.names if name not in self.recorded.statics]

    def sight(self, frame: Frame) -> Sight:
        """Return what is seen in a picture."""
        return self.recorded.sight(frame.t, self.cameras.view(frame.camera, frame.t, frame.part), self.size)

    def measures(self, frame: Frame, sight: Sight | None = None) -> dict[str, Measures]:
        """Return how well each thing is seen in a picture, by its name."""
        sight = self.sight(frame) if sight is None else sight
        if self._painted is None:
            picture = self.recorded.flat_picture(sight, self.recording.film["background"])
        else:
            picture = self._painted(frame, self.size)
        return dict(zip(self.recorded.names, sight.measures(picture), strict=True))

    def row(self, frame: Frame, after: Frame | None = None) -> Row:
        """Return the measures of a picture: of all that is in it, and of bodies that others hide in it.

        Args:
            frame: The picture.
            after: The next one, for motion.
        """
        sight = self.sight(frame)
        found, motion = self.measures(frame, sight), self._motion(frame, after)
        bodies = {
            name: {key: None if value is None else round(value, DIGITS) for key, value in measures._asdict().items()}
            | {"motion": None if motion is None or np.isnan(motion[k]) else round(float(motion[k]), DIGITS)}
            for k, (name, measures) in enumerate(found.items())
            if measures.share or measures.inside
        }
        span = round(self._span(sight), DIGITS)
        return {"frame": frame.k, "camera": frame.camera, "t": round(frame.t, 6), "span": span, "bodies": bodies}

    def moves_between(self, start: float, end: float) -> bool:
        """Whether bodies are elsewhere at one time [s] than at another, by a twentieth of the room that they take."""
        before, after = (self.recorded.things(t) for t in (start, end))
        chosen = np.array([name not in self.recorded.statics for name in self.recorded.names], bool)
        one, other = (things.triangles[chosen[things.owner], 0] for things in (before, after))
        if not len(one) or len(one) != len(other):
            return len(one) != len(other)
        return bool(np.linalg.norm(other - one, axis=1).max() > np.ptp(one, axis=0).max() / 20)

    def _span(self, sight: Sight) -> float:
        """Part of the picture's width or height, whichever is more, from end to end of all bodies that are seen."""
        moving = np.array([name not in self.recorded.statics for name in self.recorded.names], bool)
        pixels = sight.pixels[sight.visible & moving[sight.things]]
        if not len(pixels):
            return 0.0
        wide, tall = self.size
        return float(max((np.ptp(pixels % wide) + 1) / wide, (np.ptp(pixels // wide) + 1) / tall))

    def rows(self, frames: Sequence[Frame], samples: int = SAMPLED_PICTURES) -> list[Row]:
        """Return the measures of pictures spread evenly over a film."""
        return [
            self.row(frames[k], frames[k + 1] if k + 1 < len(frames) else None)
            for k in spread_numbers(len(frames), samples)
        ]

    def _motion(self, frame: Frame, after: Frame | None) -> Array | None:
        """Way of each thing's middle from a picture to the next [heights of it]; None across a cut.

        What spins in place goes nowhere. It is nan where the middle is behind the camera.
        """
        if after is None or after.camera != frame.camera:
            return None
        aspect, places = self.size[0] / self.size[1], []
        for one in (frame, after):
            view = self.cameras.view(one.camera, one.t, one.part)
            place = project(view, _middles(self.recorded.things(one.t)), aspect)
            places.append(np.where(place[:, 2:] > 0, place[:, :2], np.nan))
        return np.hypot(*((places[1] - places[0]) * (aspect / 2, 0.5)).T)


def _middles(things: Things) -> Array:
    """Middles of the surfaces of all things [m], shape (m, 3); nan for what has none."""
    corners = things.triangles
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rows = (
        np.bincount(things.owner, weights, things.number)
        for weights in (area, *(corners.mean(axis=1) * area[:, None]).T)
    )
    area, *sums = rows
    return np.stack(sums, axis=1) / np.where(area > 0, area, np.nan)[:, None]


def spread_numbers(count: int, samples: int) -> list[int]:
    """Return the numbers of at most some of `count` pictures, spread evenly from the first to the last."""
    return np.unique(np.linspace(0, count - 1, samples).round().astype(int)).tolist() if count else []


def nearest_frame(frames: Iterable[Frame], t: float) -> Frame | None:
    """Return the picture of a film that shows a time [s] best; None if none does."""
    best = min(frames, key=lambda frame: abs(frame.t - t), default=None)
    return best if best is not None and abs(best.t - t) <= MAX_TIME_OFFSET * best.speed else None


def read_picture(path: Path, size: tuple[int, int]) -> Array:
    """Return a picture in this size, colours 0 to 1, shape (h, w, 3)."""
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB").resize(size, Image.Resampling.BOX), float) / 255
