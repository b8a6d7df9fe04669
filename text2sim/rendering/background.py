"""Still backgrounds: what few samples and the denoiser smear is added back where nothing moves.

All pictures have the same seed. Where no path meets anything that moves, the samples of a picture equal those of
another moment exactly, and so does the error that remains after denoising. This error is known at one moment of each
standing camera, which is traced with few samples and with many: a control variate,
https://en.wikipedia.org/wiki/Control_variates. Nothing of that moment shows through: what is added is the difference
of two pictures of it.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

Array = NDArray[np.floating]

BACKGROUND_SAMPLES = 36
"""Samples per pixel of the moment that others are compared with."""
WORTH = 2
"""Least samples of all pictures of a standing camera, as a multiple of BACKGROUND_SAMPLES, for which it is traced."""
AROUND, MARGIN = 4.0, 2.0
"""Standard deviations of the weights by which pixels are averaged, and of the margin around what moves [pixels]."""
DIFFERENT = 0.1
"""Relative difference in brightness, as a root of radiance, from which nothing is added."""


@dataclass(frozen=True)
class Sampled:
    """A picture of surfaces before and after denoising, of one or several moments."""

    noisy: Array
    """Radiance, shape (h, w, 3)."""
    smooth: Array
    """Radiance denoised, shape (h, w, 3)."""
    first: Array
    """Albedo, normal, depth and coverage of what is hit first, shape (h, w, 8)."""


@dataclass(frozen=True)
class Background:
    """What a standing camera sees at one moment."""

    noisy: Array
    """Brightness with as many samples as the pictures, and the same seeds, shape (h, w)."""
    smooth: Array
    """The same denoised, shape (h, w)."""
    first: Array
    """What is hit first, as in `Sampled`, shape (h, w, 8)."""
    error: Array
    """Radiance that the denoised picture lacks, shape (h, w, 3)."""
    noise: Array
    """Variance of the samples' brightness around each pixel, shape (h, w)."""


def background(few: Sampled, many: Array) -> Background:
    """Return the background from the same moment with few samples, and with many, denoised (h, w, 3)."""
    noisy = _brightness(few.noisy)
    noise = _averaged((_brightness(many) - noisy) ** 2)
    return Background(noisy, _brightness(few.smooth), few.first, many - few.smooth, noise)


def sharpened(picture: Sampled, behind: Background) -> Array:
    """Return the denoised radiance (h, w, 3) of a picture, with what it lacks where it shows the background.

    The share that is added is the correlation of the samples, which is 1 where they are equal, and 0 where the light
    has changed so much that they have nothing in common.
    """
    moved = maximum_filter((picture.first != behind.first).any(axis=-1), 5).astype(np.float32)
    away = 1 - np.clip(2 * gaussian_filter(moved, MARGIN), 0, 1)
    change = _brightness(picture.noisy) - behind.noisy
    varied = _averaged(change**2) - _averaged(change) ** 2
    # The variance of the difference of two equally noisy pictures is 2 (1 - correlation) times that of each.
    alike = np.clip(1 - varied / np.maximum(2 * behind.noise, 1e-12), 0, 1)
    before, now = behind.smooth, _brightness(picture.smooth)
    # What has the colour of a neighbour that moves, since it was denoised, has another error.
    alike *= np.clip(1 - np.abs(now - before) / np.maximum(DIFFERENT * np.maximum(now, before), 1e-9), 0, 1)
    return np.maximum(picture.smooth + (away * alike)[..., None] * behind.error, 0)


def references(pictures: Iterable[Frame], cameras: Cameras, samples: int) -> dict[Frame, Frame]:
    """Return the middle picture of all that a standing camera sees, for each picture for which it is worth tracing.

    Args:
        pictures: The pictures that are traced, in order.
        cameras: Their cameras.
        samples: Samples per pixel.
    """
    if 2 * samples > BACKGROUND_SAMPLES:
        return {}
    seen = defaultdict[bytes, list[Frame]](list)
    for frame in dict.fromkeys(pictures):
        views = [np.hstack(cameras.view(frame.camera, t, part)).tobytes() for t, part in frame.moments(2)]
        if len(set(views)) == 1:
            seen[views[0]].append(frame)
    worth = [some for some in seen.values() if len(some) * samples >= WORTH * BACKGROUND_SAMPLES]
    return {frame: some[len(some) // 2] for some in worth for frame in some}


def _brightness(radiance: Array) -> Array:
    return np.sqrt(np.maximum(radiance.mean(axis=-1), 0))  # single bright samples count less


def _averaged(values: Array) -> Array:
    return gaussian_filter(values, AROUND)
