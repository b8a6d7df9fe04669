"""Standing cameras of a film: their backgrounds, and what of each frame differs from them."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from text2sim.rendering.background import (
    Background,
    Mask,
    Probe,
    background_samples,
    changed,
    coarse_size,
    probe,
    references,
)
from text2sim.rendering.scene import FilmStage, sensor
from text2sim.rendering.trace import SEED, Quality, Surfaces, trace
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

MAX_BACKGROUNDS = 12
"""Largest number of backgrounds that are kept; each takes about 100 MB at 1280x720."""
SHARES = 5
"""Number of pictures of a film from which the share that differs is estimated."""


class StandingCameras:
    """Backgrounds of the frames of a film.

    Args:
        stage: Returns the stage.
        cameras: The cameras.
        size: Width and height of the pictures [pixels].
        how: Sampling quality of the pictures.
        gain: Factor that maps a lit white sheet to 1.
    """

    def __init__(
        self, stage: Callable[[], FilmStage], cameras: Cameras, size: tuple[int, int], how: Quality, gain: float
    ):
        self._stage, self._cameras, self._size, self._how, self._gain = stage, cameras, size, how, gain
        self.references: dict[Frame, Frame] = {}
        """The frame whose moment is the background of each frame that has one."""
        self._backgrounds: dict[tuple[Frame, int], Background | None] = {}

    def add(self, drawn: Iterable[Frame]) -> None:
        """Find the backgrounds of the frames that are drawn, in order."""
        self.references |= references(drawn, self._cameras, self._how.samples)

    def behind(self, frame: Frame, samples: int) -> tuple[Background, Mask] | None:
        """Return the background of a frame, and the pixels (h, w) that differ from it; None if it has none.

        Args:
            frame: The frame.
            samples: Its samples per pixel.
        """
        reference = self.references.get(frame)
        background = None if reference is None else self._background(reference, samples)
        return None if background is None else (background, self._changed(frame, background.probe))

    def share(self, drawn: Iterable[Frame]) -> float:
        """Return the share of the picture that differs from the background in some frames; 1 if they have none."""
        still = [frame for frame in dict.fromkeys(drawn) if frame in self.references]
        shares = []
        for k in np.unique(np.linspace(0, len(still) - 1, SHARES).round().astype(int)) if still else ():
            reference = self.references[still[k]]
            if self._stage().at(reference.t, gloss=False, metals=False).liquids is not None:
                return 1.0
            shares.append(float(self._changed(still[k], self._probe(reference)).mean()))
        return float(np.mean(shares)) if shares else 1.0

    def _background(self, frame: Frame, samples: int) -> Background | None:
        """Return what the camera of a frame sees at its time; None with clear liquids."""
        if (frame, samples) in self._backgrounds:
            return self._backgrounds[frame, samples]
        if len(self._backgrounds) >= MAX_BACKGROUNDS:
            del self._backgrounds[next(iter(self._backgrounds))]
        alike = next((found for (one, _), found in self._backgrounds.items() if one == frame and found), None)
        moment, found = self._stage().at(frame.t, gloss=False), None
        if moment.liquids is None:
            seen = [(moment, sensor(self._cameras.view(frame.camera, frame.t, frame.part), self._size))]

            def traced(count: int) -> Surfaces:
                surfaces = trace(seen, replace(self._how, samples=count), self._gain).surfaces
                assert surfaces is not None, "without liquids"
                return surfaces

            noisy = traced(samples).noisy
            if alike is not None:
                found = replace(alike, noisy=noisy)
            else:
                many = traced(background_samples(self._how.samples))
                found = Background(many.smooth, noisy, many.alpha, many.guides, self._probe(frame))
        self._backgrounds[frame, samples] = found
        return found

    def _changed(self, frame: Frame, before: Probe) -> Mask:
        """Return the pixels of a frame that differ from its background, at any of its moments."""
        moments = frame.moments(self._how.blur)
        return np.logical_or.reduce([changed(self._probe(frame, *one), before, self._gain) for one in moments])

    def _probe(self, frame: Frame, t: float | None = None, part: float = 0.0) -> Probe:
        """Return the probe of a frame at one of its moments; without one, in its middle."""
        t, part = (frame.t, frame.part) if t is None else (t, part)
        view = self._cameras.view(frame.camera, t, part)
        sensors = sensor(view, self._size), sensor(view, coarse_size(self._size))
        return probe(self._stage().at(t, gloss=False, metals=False).solid, *sensors, self._how.depth, SEED)
