"""Still backgrounds: of a standing camera's pictures only those pixels are traced that differ from one of its moments.

That moment is traced with many samples. What differs is found by comparing first hits at every pixel, and the light of
a coarse picture. All pictures have the same seed: where no path meets anything that has moved, samples are equal, so
few of them show where light has changed (common random numbers,
https://en.wikipedia.org/wiki/Variance_reduction#Common_random_numbers).
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_opening, find_objects, gaussian_filter, label, uniform_filter

from text2sim.rendering.partly import render
from text2sim.rendering.renderer import mitsuba
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

Array = NDArray[np.floating]
Mask = NDArray[np.bool_]

LEAST_SAMPLES, TIMES_SAMPLES = 36, 4
"""Samples per pixel of the moment that others are compared with: at least so many, and so many times theirs."""
MOST_SAMPLES = 36
"""Samples per pixel above which pictures have no background: of such there are few."""
WORTH = 1.5
"""Least samples of all pictures of a standing camera, as a multiple of the background's, for which it is traced."""
FINISHING_SAMPLES = 2
"""Samples per pixel that take as long as guides and denoising of a picture."""
GUIDES = "albedo:albedo,normal:sh_normal,depth:depth"
COARSE, LIGHT_SAMPLES = 4, 4
"""Pixels of a picture along a pixel of the coarse one, and samples per pixel of that."""
ALBEDO, NORMAL, DEPTH = 0.004, 0.02, 5e-4
"""Differences of first hits that nobody sees: of albedo, of the normal, and of the depth, relative to it."""
LIGHT, AROUND = 0.02, 1.5
"""Relative difference in light that nobody sees, and standard deviation of the weights by which it is averaged
[coarse pixels]."""
MOST_OF_ONE = 0.25
"""Largest relative difference of a single coarse pixel that counts."""
NARROWEST = 3
"""Width of the narrowest change in light that counts [coarse pixels]: two paths that differ make a narrower one."""
DARK = 0.03
"""Radiance, relative to a white sheet, that is added to what differences are relative to."""
MARGIN, COARSE_MARGIN = 4, 2
"""Pixels around what differs, and coarse pixels, that are traced as well."""
FADED = 7
"""Width of the band in which a traced part fades into the background [pixels]."""
CROP_MARGIN, MOST_CROPS = 24, 6
"""Pixels around a traced part that the denoiser sees, and largest number of parts that it is given one by one."""


@dataclass(frozen=True)
class Probe:
    """What tells whether a picture differs."""

    hits: Array
    """Albedo, normal and depth of what one ray per pixel hits, shape (h, w, 7)."""
    light: Array
    """Radiance of the coarse picture, shape (h / COARSE, w / COARSE, 3)."""


@dataclass(frozen=True)
class Background:
    """What a standing camera sees at one moment."""

    radiance: Array
    """Denoised radiance of surfaces with many samples, not multiplied by alpha, shape (h, w, 3)."""
    noisy: Array
    """The same with as few samples as the pictures, not denoised. Surroundings without noise would teach the denoiser
    that noise is texture."""
    alpha: Array
    """Coverage of each pixel, shape (h, w)."""
    guides: Array
    """Albedo, normal and depth, shape (h, w, 7)."""
    probe: Probe


def background_samples(samples: int) -> int:
    """Return the samples per pixel of the background of pictures with a number of samples."""
    return max(LEAST_SAMPLES, TIMES_SAMPLES * samples)


def probe(scene: Any, sensor: Any, coarse_sensor: Any, depth: int, seed: int) -> Probe:
    """Return what tells whether a picture differs.

    Args:
        scene: The scene.
        sensor: The camera.
        coarse_sensor: The same with pictures of `coarse_size`.
        depth: Maximum depth of paths.
        seed: Seed of the samples, the same for all pictures that are compared.
    """
    mi = mitsuba()
    path = mi.load_dict({"type": "path", "max_depth": depth, "hide_emitters": True})
    hits = render(scene, sensor, mi.load_dict({"type": "aov", "aovs": GUIDES}), 1, seed)
    return Probe(hits[..., -7:], render(scene, coarse_sensor, path, LIGHT_SAMPLES, seed)[..., :3])


def coarse_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of the coarse picture for those of a picture [pixels]."""
    return -(-size[0] // COARSE), -(-size[1] // COARSE)


def changed(now: Probe, before: Probe, gain: float) -> Mask:
    """Return the pixels (h, w) that differ, with a margin.

    Args:
        now: A picture.
        before: The moment with which it is compared.
        gain: Factor that maps a lit white sheet to 1.
    """
    difference = np.abs(now.hits - before.hits)
    depth = np.maximum(now.hits[..., 6], before.hits[..., 6])
    moved = (difference[..., :3] > ALBEDO).any(axis=-1) | (difference[..., 3:6] > NORMAL).any(axis=-1)
    moved |= difference[..., 6] > DEPTH * depth
    level = _averaged(before.light).max(axis=-1, keepdims=True) + DARK / gain
    # Of a single path that has changed, little is known.
    away = np.clip(now.light - before.light, -MOST_OF_ONE * level, MOST_OF_ONE * level)
    lit: Any = (np.abs(_averaged(away)) > LIGHT * level).any(axis=-1)
    lit = binary_opening(lit, np.ones((NARROWEST, NARROWEST)))
    lit |= ~np.isfinite(now.light).all(axis=-1)
    wide = np.kron(binary_dilation(lit, iterations=COARSE_MARGIN), np.ones((COARSE, COARSE), bool))
    return np.logical_or(binary_dilation(moved, iterations=MARGIN), wide[: moved.shape[0], : moved.shape[1]])


def faded(wanted: Mask) -> Array:
    """Return the weight of what was traced in a picture (h, w): 0 where it was not, and 1 away from there."""
    return np.clip(2 * uniform_filter(wanted.astype(np.float32), FADED) - 1, 0, 1)


def crops(wanted: Mask) -> list[tuple[slice, slice]]:
    """Return the parts of a picture to be denoised: around each connected part of what was traced, or all together."""
    near: Any = binary_dilation(wanted[::COARSE, ::COARSE], iterations=-(-CROP_MARGIN // COARSE))
    parts: Any = label(near)
    found = find_objects(parts[0] if parts[1] <= MOST_CROPS else near.astype(int))
    return [(_scaled(rows), _scaled(columns)) for rows, columns in found]


def references(pictures: Iterable[Frame], cameras: Cameras, samples: int) -> dict[Frame, Frame]:
    """Return the middle picture of all that a standing camera sees, for each picture for which it is worth tracing.

    Args:
        pictures: The pictures that are traced, in order.
        cameras: Their cameras.
        samples: Samples per pixel.
    """
    if samples > MOST_SAMPLES:
        return {}
    seen = defaultdict[bytes, list[Frame]](list)
    for frame in dict.fromkeys(pictures):
        views = [np.hstack(cameras.view(frame.camera, t, part)).tobytes() for t, part in frame.moments(2)]
        if len(set(views)) == 1:
            seen[views[0]].append(frame)
    least = WORTH * background_samples(samples)
    worth = [some for some in seen.values() if len(some) * (samples + FINISHING_SAMPLES) >= least]
    return {frame: some[len(some) // 2] for some in worth for frame in some}


def _scaled(side: slice) -> slice:
    return slice(side.start * COARSE, side.stop * COARSE)


def _averaged(values: Array) -> Array:
    return gaussian_filter(np.nan_to_num(values), (AROUND, AROUND, 0))
