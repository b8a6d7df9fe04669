"""Tracing of some pixels of a picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.renderer import mitsuba

Array = NDArray[np.floating]


def render(
    scene: Any, sensor: Any, integrator: Any, spp: int, seed: int, wanted: NDArray[np.bool_] | None = None
) -> Array:
    """Return a picture, shape (h, w, channels), as `mitsuba.render` does; without meaning outside the wanted pixels.

    The samples of a pixel do not depend on which others are traced, so that its noise does not change.

    Args:
        scene: The scene.
        sensor: The camera; its film has a box filter, and no crop.
        integrator: Integrator of colour, which has the coverage as fourth channel, or of channels of its own alone.
        spp: Samples per pixel.
        seed: Seed of the samples.
        wanted: The pixels to trace, shape (h, w); None for all.
    """
    mi = mitsuba()
    if wanted is None or mi.variant().startswith("scalar"):
        return np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=spp, seed=seed))
    import drjit as dr

    height, width = wanted.shape
    sampler = sensor.sampler().clone()
    sampler.set_sample_count(spp)
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(seed, height * width * spp)
    pixel = dr.arange(mi.UInt32, height * width * spp) // spp
    active = dr.gather(mi.Bool, mi.Bool(wanted.ravel()), pixel)
    place = (mi.Vector2f(pixel % width, pixel // width) + sampler.next_2d(active)) / mi.Vector2f(width, height)
    lens = sampler.next_2d(active) if sensor.needs_aperture_sample() else mi.Point2f(0.5)
    ray, _ = sensor.sample_ray_differential(0.0, sampler.next_1d(active), place, lens, active)
    color, valid, own = integrator.sample(scene, sampler, ray, None, active)
    channels = [*own] or [*color, dr.select(valid & active, mi.Float(1.0), mi.Float(0.0))]
    dr.eval(channels)  # together: one after the other, each would trace all paths again
    means = [np.array(dr.block_sum(one, spp)) / np.float32(spp) for one in channels]
    return np.stack(means, axis=-1).reshape(height, width, -1)
