"""Tracing of one frame: samples, guides of the denoiser, and the denoiser.

Clear glass is traced separately. Lamps cannot be sampled through it, so its contents would be too noisy, and the
denoiser would be guided by the glass. Therefore the scene is traced without clear bodies, filtered by the colours of
those that have one (`filters.py`), and their reflections are added: lamps and bright rims, but no shadows and no
refraction. Clear liquids do refract, see `water.py`.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import grey_opening, maximum_filter, uniform_filter

from text2sim.rendering.background import GUIDES, Background, Mask, crops, faded
from text2sim.rendering.filters import passed
from text2sim.rendering.partly import render
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import FilmMoment
from text2sim.rendering.water import through_liquids

Array = NDArray[np.floating]

GUIDE_SAMPLES, GUIDE_SAMPLES_BLURRED = 8, 16
"""Guide samples per pixel of a sharp picture, and over all moments of a blurred one, where they are less evenly
distributed.

They determine how clean the edges of the picture are."""
COVERAGE = {"type": "depth"}
"""Integrator of coverage: it takes a tenth of the time of paths. It also hits what paths do not see, see `_edges`."""
SEEN_THROUGH = 0.2
"""Deficit in coverage of paths relative to first hits, averaged around a pixel, from which a surface is transparent."""
MIRRORED = 3
"""Maximum depth of paths that reflect the room in metals: those that one metal reflects in another are the longest."""
ROULETTE = 3
"""Bounces before Russian roulette, which saves a third of the time in a studio with walls."""
SAMPLES_OF_DRAFTS = 8
"""Largest number of samples per pixel for which the denoiser is fast: a third of its time, with little loss. With fewer
samples than guides have, it takes half the time, and textured walls are as clean as with four times as many samples."""
SEED = 0
"""Seed of every picture: resting parts do not flicker."""
BRIGHTEST = 24.0
"""Radiance, relative to a white sheet, above which a single pixel is noise, which glass causes."""
SHEEN, GLARE = 0.25, 0.3
"""Radiance of reflections of clear glass, relative to a white sheet, above which they are dimmed, and the fraction of
the excess that remains: otherwise lamps in a glass tube hide its contents behind bars as white as paper."""
WIDE, VEILED = 0.05, 0.3
"""Width of reflections of clear glass, as a fraction of the picture's shorter side, from which they hide what is behind
them like a veil, and the fraction of those that remains. Photographers take a polariser."""
RIM = 3
"""Pixels around visible surfaces that are filled like them before denoising."""


@dataclass(frozen=True)
class Quality:
    """Sampling quality of a frame."""

    samples: int
    """Samples per pixel; 4, 8, 16, 36 and 64 are exact."""
    depth: int
    """Maximum depth of paths, as Mitsuba counts it."""
    blur: int
    """Moments of a picture with motion blur."""


QUALITIES = {"draft": Quality(8, 6, 4), "final": Quality(36, 8, 9), "still": Quality(144, 10, 9)}


@dataclass(frozen=True)
class Surfaces:
    """A picture of surfaces alone, without what clear glass adds."""

    noisy: Array
    """Radiance, shape (h, w, 3)."""
    smooth: Array
    """Radiance denoised, shape (h, w, 3)."""
    alpha: Array
    """Coverage of each pixel, shape (h, w)."""
    guides: Array
    """Albedo, normal and depth, shape (h, w, 7)."""


@dataclass
class Traced:
    """A traced frame as radiance."""

    radiance: Array
    """Linear radiance of visible surfaces, not multiplied by alpha, shape (h, w, 3)."""
    alpha: Array
    """Coverage of each pixel by surfaces, 0 to 1, shape (h, w)."""
    depth: Array
    """Distance from the camera [m], 0 for empty pixels, shape (h, w)."""
    seconds: dict[str, float]
    """Time [s] by step."""
    behind: Array | None = None
    """Picture behind all surfaces, in sRGB; the background if None."""
    haze: float = 0.0
    """Distance from the camera at which endless ground fades [m]; 0 without haze."""
    surfaces: Surfaces | None = None
    """Surfaces alone; None with clear liquids."""


def trace(
    moments: Sequence[tuple[FilmMoment, Any]],
    quality: Quality,
    gain: float,
    behind: tuple[Background, Mask] | None = None,
) -> Traced:
    """Trace a frame as the mean over several moments.

    Args:
        moments: Scene and sensor of each.
        quality: Sampling quality.
        gain: Factor that maps a lit white sheet to 1.
        behind: Background of a standing camera, and the pixels (h, w) that differ from it; None to trace all. Not with
            clear liquids.
    """
    mi = mitsuba()
    path: dict[str, Any] = {"type": "path", "max_depth": quality.depth, "rr_depth": ROULETTE, "hide_emitters": True}
    guide, coverage = mi.load_dict({"type": "aov", "aovs": GUIDES}), mi.load_dict(COVERAGE)
    mirrored = mi.load_dict(path | {"max_depth": MIRRORED})
    integrator, wanted = mi.load_dict(path), None if behind is None else behind[1]
    # The moments of a motion-blurred frame share the samples of a sharp one.
    total = GUIDE_SAMPLES if len(moments) == 1 else GUIDE_SAMPLES_BLURRED
    samples, guiding = (ceil(many / len(moments)) for many in (quality.samples, total))
    seconds = {"trace": 0.0, "guides": 0.0, "gloss": 0.0, "denoise": 0.0}
    pictures, guides, alphas, glosses, filters = _Mean(), _Mean(), _Mean(), _Mean(), _Mean()
    for k, (moment, sensor) in enumerate(moments):
        seed, seen, guiding_by = SEED + 7919 * k, integrator, guide
        if moment.liquids is not None:
            mirror = mi.load_dict(path | {"hide_emitters": False})
            seen = through_liquids(moment.liquids, integrator, mirror, moment.room, 1 / gain)
            guiding_by = through_liquids(moment.liquids, guide)
        with _timed(seconds, "trace"):
            rendered = render(moment.solid, sensor, seen, samples, seed, wanted)
            if moment.metals is not None:
                rendered[..., :3] += render(moment.metals, sensor, mirrored, samples, seed, wanted)[..., :3]
            # Coverage is last; only pictures with liquids have another channel before it.
            there = pictures.add(rendered[..., [0, 1, 2, -1]])[..., 3]
        with _timed(seconds, "guides"):
            guides.add(render(moment.solid, sensor, guiding_by, guiding, seed, wanted)[..., -7:])
            if guiding > samples and there.min() < 1:  # edges before an empty background are noisy with few samples
                more = render(moment.solid, sensor, coverage, guiding, seed, wanted)
                there = _edges(there, more[..., 3])
            alphas.add(there)
        if moment.gloss is not None:
            with _timed(seconds, "gloss"):
                glosses.add(mi.render(moment.gloss, sensor=sensor, integrator=integrator, spp=samples, seed=seed))
                if moment.filters is not None:
                    # The mean of the depths of a pixel, where misses count as 0.
                    depth = guides.last[..., -1]
                    if behind is not None:
                        depth, there = (
                            _put(depth, behind[0].guides[..., -1], wanted),
                            _put(there, behind[0].alpha, wanted),
                        )
                    filters.add(passed(moment.filters, sensor, depth / np.maximum(there, 1e-3)))
    with _timed(seconds, "denoise"):
        surfaces = _surfaces(pictures.value, guides.value, np.clip(alphas.value, 0, 1), quality, gain, behind)
        radiance, alpha, seen = surfaces.smooth, surfaces.alpha, surfaces.guides
        if glosses.count:
            gloss = _limited(healed(glosses.value[..., :3]), gain)
            gloss = dimmed(_denoised(gloss, samples=quality.samples), gain)
            through = filters.value if filters.count else np.ones(3)
            lit = radiance * alpha[..., None] * through + gloss
            alpha = 1 - (1 - alpha) * through.mean(axis=-1)
            alpha = np.maximum(alpha, np.clip(gloss.mean(axis=-1) * gain, 0, 1))
            radiance = undimmed(lit, alpha)
    # Liquids bend rays after the first hit, so what is hit first does not tell what is seen.
    clear = all(moment.liquids is None for moment, _ in moments)
    return Traced(radiance, alpha, seen[..., 6], seconds, surfaces=surfaces if clear else None)


def _surfaces(
    picture: Array, guides: Array, alpha: Array, quality: Quality, gain: float, behind: tuple[Background, Mask] | None
) -> Surfaces:
    """Return a denoised picture of surfaces.

    Args:
        picture: Radiance, multiplied by coverage, and coverage, shape (h, w, 4).
        guides: Albedo, normal and depth, shape (h, w, 7).
        alpha: Coverage, shape (h, w).
        quality: Sampling quality.
        gain: Factor that maps a lit white sheet to 1.
        behind: The background, and where it does not show.
    """
    if behind is None:
        noisy = _limited(undimmed(picture[..., :3], picture[..., -1]), gain)
        smooth = _denoised(noisy, np.clip(guides[..., :3], 0, 1), guides[..., 3:6], samples=quality.samples)
        return Surfaces(noisy, smooth, alpha, guides)
    background, wanted = behind
    still = np.dstack([background.noisy * background.alpha[..., None], background.alpha])
    picture, guides = _put(picture, still, wanted), _put(guides, background.guides, wanted)
    alpha = _put(alpha, background.alpha, wanted)
    noisy = _limited(undimmed(picture[..., :3], picture[..., -1]), gain)
    smooth, weight = background.radiance.copy(), faded(wanted)[..., None]
    for part in crops(wanted):
        near = guides[part]
        shown = _denoised(noisy[part], np.clip(near[..., :3], 0, 1), near[..., 3:6], samples=quality.samples)
        smooth[part] += weight[part] * (shown - smooth[part])
    return Surfaces(noisy, smooth, alpha, guides)


def _put(traced: Array, still: Array, wanted: Mask | None) -> Array:
    """Return a picture with what was traced where it was wanted, and otherwise the background."""
    if wanted is None:
        return traced
    return np.where(wanted if traced.ndim == wanted.ndim else wanted[..., None], traced, still)


def _edges(few: Array, many: Array) -> Array:
    """Return the coverage of pixels (h, w) from many first hits.

    Where these hit a lamp, a hole of a cut-out or dark glass in front of the background, the few path samples are used.
    """
    hidden = maximum_filter((few == 0) & (many > 0.5), 3)
    return np.where(np.logical_or(hidden, uniform_filter(many - few, 5) > SEEN_THROUGH), few, many)


class _Mean:
    """Running mean of pictures."""

    def __init__(self) -> None:
        self.count, self._sum = 0, np.zeros(())
        self.last = np.zeros(())
        """The latest picture."""

    def add(self, picture: Any) -> Array:
        """Add a picture, and return it."""
        added = np.array(picture, dtype=np.float32)
        self.count, self._sum, self.last = self.count + 1, self._sum + added, added
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
    """Return reflections of glass (h, w, 3) that do not hide what is behind it: neither bright ones nor wide ones.

    Args:
        gloss: Radiance of the reflections, shape (h, w, 3).
        gain: Factor that maps a lit white sheet to 1.
    """
    bright = gloss.max(axis=-1) * gain
    soft = np.where(bright > SHEEN, SHEEN + GLARE * (bright - SHEEN), bright)
    width = max(3, round(WIDE * min(bright.shape)))
    # Opening keeps what is wider in both directions; its blocks are smoothed.
    wide = np.minimum(uniform_filter(grey_opening(soft, size=(width, width)), width), soft)
    return gloss * ((soft - (1 - VEILED) * wide) / np.maximum(bright, 1e-9))[..., None]


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


def _denoised(*pictures: Array, samples: int) -> Array:
    """Return the first picture denoised, which has so many samples per pixel; albedo and normals may follow as guides.

    Guides with more samples than the picture count as free of noise, so that it keeps the grain of its surfaces.
    """
    import mitsuba_oidn as oidn

    clean = len(pictures) > 1 and samples < GUIDE_SAMPLES
    draft = oidn.Quality.Balanced if clean else oidn.Quality.Fast
    quality = draft if samples <= SAMPLES_OF_DRAFTS else oidn.Quality.High
    arrays = (np.ascontiguousarray(a, np.float32) for a in pictures)
    return np.array(oidn.denoise(*arrays, hdr=True, clean_aux=clean, quality=quality))
