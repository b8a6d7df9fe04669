"""Tracing of one frame: samples, guides of the denoiser, and the denoiser.

Clear glass is traced separately. Lamps cannot be sampled through it, so its contents would drown in noise, and the
denoiser would be guided by the glass. So the scene is traced without clear things, and their reflections are added:
lamps and bright rims, but no shadows and no refraction.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, uniform_filter

from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import FilmMoment

Array = NDArray[np.floating]

GUIDES = "albedo:albedo,normal:sh_normal,depth:depth"
GUIDE_SAMPLES, GUIDE_SAMPLES_BLURRED = 8, 16
"""Per pixel, of a sharp picture and over all moments of a blurred one, whose samples are spread less evenly.

Edges of the picture are as clean as these."""
MET = {"type": "depth"}
"""Integrator of coverage: a tenth of the time of paths. It also hits what these do not see, see `_edges`."""
SEEN_THROUGH = 0.2
"""Coverage by which paths stay behind first hits, on average around a pixel, where they see through a surface."""
ROULETTE = 3
"""Bounces after which a path ends by chance, the darker the sooner: a third of the time of a studio with walls."""
SAMPLES_OF_DRAFTS = 8
"""Per pixel, up to which the denoiser takes its quick way: a third of its time, and little of what it does."""
SEED = 0
"""The same for every picture: then what does not move does not flicker."""
BRIGHTEST = 24.0
"""Radiance, in white sheets, above which a single pixel is noise: glass makes such."""
SHEEN, GLARE = 0.25, 0.3
"""What clear glass reflects, in white sheets, up to which it stays as it is, and the part of it that stays above: lamps
in a tube of glass are bars as white as paper, before what is inside it."""
RIM = 3
"""Pixels around what is there that the denoiser is told to be like it."""


@dataclass(frozen=True)
class Quality:
    """Sampling quality of a frame."""

    samples: int
    """Per pixel; 4, 8, 16, 36 and 64 are exact."""
    depth: int
    """Of paths."""
    blur: int
    """Moments that a picture with motion blur is made of."""


QUALITIES = {"draft": Quality(8, 6, 4), "final": Quality(36, 8, 9), "still": Quality(144, 10, 9)}


@dataclass
class Traced:
    """A traced frame as radiance."""

    radiance: Array
    """Linear, shape (h, w, 3); of what is there, however little of a pixel it fills."""
    alpha: Array
    """How much of a pixel something fills, 0 to 1, shape (h, w)."""
    depth: Array
    """Distance from the camera [m], 0 where there is nothing, shape (h, w)."""
    seconds: dict[str, float]
    """Time [s] by part."""
    behind: Array | None = None
    """What is seen where nothing is, in sRGB; the background if None."""


def trace(moments: Sequence[tuple[FilmMoment, Any]], quality: Quality, gain: float, *, denoise: bool = True) -> Traced:
    """Trace a frame as the mean over several moments.

    Args:
        moments: Scene and sensor of each.
        quality: Sampling quality.
        gain: Factor that maps a lit white sheet to 1.
        denoise: Whether to denoise.
    """
    mi = mitsuba()
    path: dict[str, Any] = {"type": "path", "max_depth": quality.depth, "rr_depth": ROULETTE, "hide_emitters": True}
    integrator, guide, met = mi.load_dict(path), mi.load_dict({"type": "aov", "aovs": GUIDES}), mi.load_dict(MET)
    # The moments of a motion-blurred frame share the samples of a sharp one.
    wanted = GUIDE_SAMPLES if len(moments) == 1 else GUIDE_SAMPLES_BLURRED
    samples, guiding = (ceil(total / len(moments)) for total in (quality.samples, wanted))
    seconds = {"trace": 0.0, "guides": 0.0, "gloss": 0.0, "denoise": 0.0}
    pictures, guides, alphas, glosses = _Mean(), _Mean(), _Mean(), _Mean()
    for k, (moment, sensor) in enumerate(moments):
        seed = SEED + 7919 * k
        with _timed(seconds, "trace"):
            made = mi.render(moment.solid, sensor=sensor, integrator=integrator, spp=samples, seed=seed)
            there = pictures.add(made)[..., 3]
        with _timed(seconds, "guides"):
            guides.add(mi.render(moment.solid, sensor=sensor, integrator=guide, spp=guiding, seed=seed))
            if guiding > samples and there.min() < 1:  # edges before an empty background are noisy with few samples
                more = mi.render(moment.solid, sensor=sensor, integrator=met, spp=guiding, seed=seed)
                there = _edges(there, np.array(more)[..., 3])
            alphas.add(there)
        if moment.gloss is not None:
            with _timed(seconds, "gloss"):
                glosses.add(mi.render(moment.gloss, sensor=sensor, integrator=integrator, spp=samples, seed=seed))
    with _timed(seconds, "denoise"):
        picture, seen = pictures.value, guides.value[..., -7:]
        radiance, alpha = _limited(undimmed(picture[..., :3], picture[..., 3]), gain), np.clip(alphas.value, 0, 1)
        fast = quality.samples <= SAMPLES_OF_DRAFTS
        if denoise:
            radiance = _denoised(radiance, np.clip(seen[..., :3], 0, 1), seen[..., 3:6], fast=fast)
        if glosses.count:
            gloss = _limited(healed(glosses.value[..., :3]), gain)
            gloss = dimmed(_denoised(gloss, fast=fast) if denoise else gloss, gain)
            lit = radiance * alpha[..., None] + gloss
            alpha = np.maximum(alpha, np.clip(gloss.mean(axis=-1) * gain, 0, 1))
            radiance = undimmed(lit, alpha)
    return Traced(radiance, alpha, seen[..., 6], seconds)


def _edges(few: Array, many: Array) -> Array:
    """Return the coverage of pixels (h, w), from many first hits.

    Where these hit a lamp, a hole of a cut-out or dark glass before the background, the few samples of the paths count.
    """
    hidden = maximum_filter((few == 0) & (many > 0.5), 3)
    return np.where(np.logical_or(hidden, uniform_filter(many - few, 5) > SEEN_THROUGH), few, many)


class _Mean:
    """Running mean of pictures."""

    def __init__(self) -> None:
        self.count, self._sum = 0, np.zeros(())

    def add(self, picture: Any) -> Array:
        """Add a picture, and return it."""
        added = np.array(picture, dtype=np.float32)
        self.count, self._sum = self.count + 1, self._sum + added
        return added

    @property
    def value(self) -> Array:
        return self._sum / self.count


@contextmanager
def _timed(seconds: dict[str, float], part: str) -> Iterator[None]:
    start = perf_counter()
    yield
    seconds[part] += perf_counter() - start


def _limited(radiance: Array, gain: float) -> Array:
    return np.minimum(radiance, BRIGHTEST / gain)


def dimmed(gloss: Array, gain: float) -> Array:
    """Return reflections of glass (h, w, 3), with lamps dimmed so that they do not outshine what is behind."""
    bright = gloss.max(axis=-1, keepdims=True) * gain
    soft = SHEEN + GLARE * (bright - SHEEN)
    return gloss * np.where(bright > SHEEN, soft / np.maximum(bright, 1e-9), 1.0)


def undimmed(radiance: Array, alpha: Array) -> Array:
    """Return a picture (h, w, 3) divided by its alpha, and extended slightly beyond its edges.

    Otherwise edges would become dark lines when composited over a background, or when the denoiser includes the dark
    surroundings.

    Non-finite pixels are filled from their neighbours; see `healed`.

    Args:
        radiance: Mean over pixels; empty parts count as black.
        alpha: Coverage of each pixel, shape (h, w).
    """
    known = (alpha > 0) & np.isfinite(radiance).all(axis=-1)
    return _filled(np.where(known[..., None], radiance / np.where(known, alpha, 1.0)[..., None], 0.0), known, RIM)


def healed(radiance: Array) -> Array:
    """Return a picture (h, w, 3) whose non-finite pixels are filled from their neighbours.

    Bump maps occasionally yield a non-finite sample, which spoils its pixel; black pixels would be specks
    that the denoiser enlarges.
    """
    known = np.asarray(np.isfinite(radiance).all(axis=-1))
    return _filled(np.where(known[..., None], radiance, 0.0), known, max(known.shape))


def _filled(picture: Array, known: NDArray[np.bool_], rings: int) -> Array:
    """Return a picture whose unknown pixels are filled from their neighbours, up to `rings` pixels from known ones."""
    for _ in range(rings):
        if known.all() or not known.any():
            break
        weight = uniform_filter(known.astype(np.float32), 3)
        around = np.stack([uniform_filter(picture[..., k], 3) for k in range(3)], axis=-1)
        reached = ~known & (weight > 0.05)
        picture[reached] = around[reached] / weight[reached, None]
        known = known | reached
    return picture


def _denoised(*pictures: Array, fast: bool) -> Array:
    """Return the first picture denoised; albedo and normals may follow as guides."""
    import mitsuba_oidn as oidn

    quality = oidn.Quality.Fast if fast else oidn.Quality.High
    return np.array(oidn.denoise(*(np.ascontiguousarray(a, np.float32) for a in pictures), hdr=True, quality=quality))
