"""Clear liquids: camera rays are bent by them and absorbed on their way, before paths are traced.

A path tracer finds no lamp through a refracting surface, so a tub of refracting water would be black and full of noise.
Here only the way from the camera to the first solid surface is refracted. From there on paths do not see the liquid: it
casts no shadow and no caustics, and has as little noise as the scene without it. What its surface reflects is traced
by a second path. Coloured liquids scatter a little light of their own colour, as if lit like a white sheet: water that
only absorbed light would be black before dark surroundings, and it looks blue there.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.finishes import SHADE
from text2sim.rendering.renderer import mitsuba

Array = NDArray[np.floating]

INDEX = 1.33
"""Refractive index of water."""
DARKEST = 0.01
"""Smallest fraction of the light that passes where a liquid has its colour."""
EVENTS = 10
"""Largest number of surfaces of liquids on the way of a ray."""
GLINT = 12.0
"""Largest radiance that liquids mirror, relative to a white sheet: lamps in ripples would be noise."""
VEIL = 0.5
"""Radiance of the light that a coloured liquid scatters, relative to a white sheet, where it is deep."""
PUREST = 2.6
"""Largest optical depth, by colour, from which scattered light comes: deep water is blue, but not as blue as light that
only passed through it."""
FAINTEST = 1e-36
"""Fraction of the light that passes below which no colour is told apart."""
SIDES = 0.85
"""Part of that radiance on upright faces of a liquid: most light comes from above."""
COVER = "cover"
"""Channel of a picture with its coverage: Mitsuba's own coverage knows only hits and misses."""


def clear_liquid() -> Any:
    """Return the material of clear liquids."""
    return mitsuba().load_dict({"type": "dielectric", "int_ior": INDEX})


def absorption(color: Array, depth: float) -> Array:
    """Return the absorption coefficient [1/m] of a liquid through which light takes on a linear colour.

    Args:
        color: The colour that white light has after a way through it.
        depth: Length of the way [m].
    """
    return -np.log(np.maximum(color, DARKEST)) / depth


class Way(NamedTuple):
    """Ways of camera rays through liquids."""

    ray: Any
    """The rest, which meets no liquid."""
    passed: Any
    """Fraction of the light that passes."""
    length: Any
    """Length so far [m]."""
    wet: Any
    """Whether it met a liquid."""
    normal: Any
    """Normal of the first surface of a liquid."""
    mirrored: Any
    """The ray that this surface reflects."""
    reflected: Any
    """Fraction of the light that it reflects."""


def way(scene: Any, sampler: Any, ray: Any, active: Any) -> Way:
    """Follow camera rays through liquids.

    Args:
        scene: All surfaces; those of liquids transmit light. The attribute `SHADE` of a liquid's face is its absorption
            coefficient [1/m].
        sampler: The sampler.
        ray: The rays.
        active: Which rays.
    """
    import drjit as dr

    mi = mitsuba()
    wet, zero = mi.Bool(False), mi.Float(0.0)
    start = Way(mi.Ray3f(ray), mi.Color3f(1.0), zero, wet, mi.Normal3f(0.0), mi.Ray3f(ray), zero)

    def step(active: Any, left: Any, ray: Any, inside: Any, so_far: Any, sampler: Any) -> Any:
        found = Way(*so_far)
        hit = scene.ray_intersect(ray, active)
        there = active & hit.is_valid()
        if there is False:  # of one ray, in the scalar variant
            return False, left, ray, inside, so_far, sampler
        passed = found.passed * dr.select(there, dr.exp(-inside * hit.t), 1.0)
        bsdf = hit.bsdf(ray)
        liquid = there & mi.has_flag(bsdf.flags(), mi.BSDFFlags.DeltaTransmission)
        entering, leaving = dr.dot(ray.d, hit.n) < 0, dr.dot(ray.d, hit.n) >= 0
        wi = mi.Vector3f(hit.wi.x, hit.wi.y, dr.select(entering, 1, -1) * dr.maximum(dr.abs(hit.wi.z), 1e-3))
        wi = dr.normalize(wi)
        back, cosine, _, ratio = mi.fresnel(wi.z, INDEX)
        mirror, bent = (hit.spawn_ray(hit.to_world(way)) for way in (mi.reflect(wi), mi.refract(wi, cosine, ratio)))
        # In a liquid chance decides whether light is reflected, so that it does not get lost.
        chance = sampler.next_1d(there)
        kept = liquid & leaving & (chance < back)
        # Likewise, whether a ray passes through a half-transparent surface.
        solid = there ^ liquid
        hole = solid & (chance < dr.mean(bsdf.eval_null_transmission(hit, solid)))
        ray = dr.select(liquid, dr.select(kept, mirror, bent), dr.select(hole, hit.spawn_ray(ray.d), ray))
        coefficient = inside if liquid is False else hit.shape.eval_attribute_3(SHADE, hit, liquid)
        inside = dr.select(liquid, dr.select(entering | kept, coefficient, 0.0), inside)
        first = liquid & (found.wet ^ True)
        found = Way(
            ray=dr.select(liquid, ray, found.ray),
            passed=passed * dr.select(liquid & entering, 1 - back, 1.0),
            length=found.length + dr.select(liquid, hit.t, 0.0),
            wet=found.wet | liquid,
            normal=dr.select(first, hit.sh_frame.n, found.normal),
            mirrored=dr.select(first & entering, mirror, found.mirrored),
            reflected=dr.select(first & entering, back, found.reflected),
        )
        return (liquid | hole) & (left > 0), left - 1, ray, inside, tuple(found), sampler

    state = (mi.Bool(active), mi.UInt32(EVENTS), mi.Ray3f(ray), mi.Color3f(0.0), tuple(start), sampler)
    *_, found, _ = dr.while_loop(state, lambda active, *_: active, step, label="liquids")
    return Way(*found)


def through_liquids(surfaces: Any, inner: Any, mirror: Any = None, room: Any = None, white: float = 1.0) -> Any:
    """Return an integrator for the scene without its liquids, as seen through these.

    Args:
        surfaces: All surfaces; see `way`.
        inner: Integrator of the scene without liquids.
        mirror: Integrator of what liquids reflect; None for the guides of the denoiser.
        room: Environment that they reflect where there is nothing.
        white: Radiance of a lit white sheet.
    """
    guides, picture = _kinds()
    made = (guides if mirror is None else picture)(mitsuba().Properties())
    made.surfaces, made.inner, made.mirror, made.room, made.white = surfaces, inner, mirror, room, white
    return made


@cache
def _kinds() -> tuple[Any, Any]:
    """Return the classes of integrators for guides and for pictures."""
    import drjit as dr

    mi = mitsuba()

    class Guides(mi.SamplingIntegrator):
        """Albedo, normal and depth."""

        surfaces: Any
        inner: Any

        def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True) -> Any:
            """Return colour, validity and channels along camera rays."""
            found = way(self.surfaces, sampler, ray, active)
            _, valid, seen = self.inner.sample(scene, sampler, mi.RayDifferential3f(found.ray), None, active)
            albedo = mi.Color3f(seen[:3]) * found.passed
            # The mean of both normals shows the outlines of both surfaces.
            normal = dr.select(found.wet, (mi.Vector3f(seen[3:6]) + found.normal) / 2, mi.Vector3f(seen[3:6]))
            return mi.Color3f(0.0), valid, [*albedo, *normal, seen[6] + found.length]

        def aov_names(self) -> list[str]:
            """Return the names of the channels."""
            return self.inner.aov_names()

    class Picture(mi.SamplingIntegrator):
        """Radiance and coverage."""

        surfaces: Any
        inner: Any
        mirror: Any
        room: Any
        white: float

        def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True) -> Any:
            """Return colour, validity and channels along camera rays."""
            found = way(self.surfaces, sampler, ray, active)
            light, valid, _ = self.inner.sample(scene, sampler, mi.RayDifferential3f(found.ray), None, active)
            shiny = active & (found.reflected > 0)
            mirrored = mi.RayDifferential3f(found.mirrored)
            shown, _, _ = self.mirror.sample(scene, sampler, mirrored, None, shiny)
            nothing = shiny & (scene.ray_test(found.mirrored, shiny) ^ True)
            miss = dr.zeros(mi.SurfaceInteraction3f)
            miss.wi = -found.mirrored.d
            shown = dr.select(nothing, dr.maximum(shown, self.room.eval(miss, nothing)), shown)
            glint = dr.select(shiny, found.reflected * dr.minimum(shown, GLINT * self.white), 0.0)
            thick = -dr.log(dr.maximum(found.passed, FAINTEST))
            thick -= dr.min(thick)
            veil = VEIL * (1 - dr.exp(-dr.max(thick)))
            # Half of the scattered light comes from less deep, where it has lost less of its colour.
            hue = dr.exp(-thick * dr.minimum(0.5, PUREST / dr.maximum(dr.max(thick), 1e-6)))
            scattered = veil * self.white * hue * (SIDES + (1 - SIDES) * found.normal.z)
            cover = dr.select(valid, 1.0, dr.maximum(1 - dr.mean(found.passed), dr.minimum(dr.mean(glint), 1.0)))
            return (1 - veil) * found.passed * light + scattered + glint, valid, [cover]

        def aov_names(self) -> list[str]:
            """Return the names of the channels."""
            return [COVER]

    return Guides, Picture
