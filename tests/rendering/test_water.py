"""Clear liquids refract, absorb by the length of the way through them, and are smooth where they rest."""

from typing import Any

import numpy as np
import pytest
from filmed import BOX, BOX_FACES

from text2sim.rendering.particle_surface import liquid_surface
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import FilmMoment
from text2sim.rendering.shapes import mesh_shape
from text2sim.rendering.trace import Quality, trace
from text2sim.rendering.water import INDEX, PUREST, SIDES, VEIL, absorption, clear_liquid, through_liquids, way
from text2sim.templates.shading import smooth_normals

HEAD_ON = ((INDEX - 1) / (INDEX + 1)) ** 2
"""Fraction of the light that water reflects at normal incidence (Fresnel)."""
COLOR = np.array([0.2, 0.5, 0.9])


def cuboid(name: str, low: Any, high: Any, bsdf: Any, coefficient: Any = None) -> Any:
    """A box whose corners share no vertices, so that its sides are flat."""
    corners = np.add(low, high) / 2 + BOX * np.subtract(high, low) / 2
    vertices, faces = corners[BOX_FACES].reshape(-1, 3), np.arange(36).reshape(-1, 3)
    if np.einsum("fi,fi->f", vertices[0::3], np.cross(vertices[1::3], vertices[2::3])).sum() < 0:
        faces = faces[:, ::-1]
    normals = np.repeat(np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))), 3, axis=0)
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).reshape(-1, 3)
    order = np.argsort(faces.ravel())
    shades = None if coefficient is None else np.broadcast_to(coefficient, vertices.shape)
    return mesh_shape(name, bsdf, vertices, faces, normals[order], shades=shades)


def pool(depth: float, length: float = 1.0) -> tuple[Any, Any]:
    """A floor at z = 0 that shines, and both with water of a depth [m] that reaches below the floor.

    Light has the colour after a length [m].
    """
    mi = mitsuba()
    light = {"type": "area", "radiance": {"type": "rgb", "value": 0.5}}
    shape = {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(9), "emitter": light}
    floor = mi.load_dict(shape)
    water = cuboid("water", (-5, -5, -0.5), (5, 5, depth), clear_liquid(), absorption(COLOR, length))
    solid = mi.load_dict({"type": "scene", "floor": floor}, optimize=False)
    return solid, mi.load_dict({"type": "scene", "floor": floor, "water": water}, optimize=False)


def room() -> Any:
    return mitsuba().load_dict({"type": "constant", "radiance": {"type": "rgb", "value": 2.0}})


def sensor(size: int, eye: tuple[float, ...] = (0, 0, 6), target: tuple[float, ...] = (0, 0, 0)) -> Any:
    """A camera, which looks down if nothing is said, with a square picture of some pixels."""
    mi = mitsuba()
    return mi.load_dict({
        "type": "perspective", "fov": 0.5, "to_world": mi.ScalarTransform4f().look_at(eye, target, [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgba"},
    })  # fmt: skip


@pytest.mark.usefixtures("tracer")
@pytest.mark.parametrize("depth", [0.1, 0.8])
def test_water_over_a_floor_absorbs_by_its_depth(depth: float) -> None:
    mi = mitsuba()
    solid, surfaces = pool(depth)
    path = mi.load_dict({"type": "path", "max_depth": 4})
    seen = through_liquids(surfaces, path, path, room(), white=0.7)
    wet = np.array(mi.render(solid, sensor=sensor(2), integrator=seen, spp=4))
    hue = COLOR**depth / max(COLOR**depth)
    veil = VEIL * (1 - min(hue))
    scattered = veil * 0.7 * hue ** min(0.5, PUREST / -np.log(min(hue)))
    # Beer and Lambert, scattering, Fresnel.
    expected = (1 - veil) * (1 - HEAD_ON) * COLOR**depth * 0.5 + scattered + HEAD_ON * 2.0
    assert wet[..., :3].mean(axis=(0, 1)) == pytest.approx(expected, rel=1e-3)
    assert wet[..., -1] == pytest.approx(1.0), "nothing of the background is seen"


@pytest.mark.usefixtures("tracer")
def test_an_upright_face_of_deep_water_is_darker_than_its_top() -> None:
    mi = mitsuba()
    solid, surfaces = pool(0.8)
    path = mi.load_dict({"type": "path", "max_depth": 4})
    seen = through_liquids(surfaces, path, path, room(), white=0.7)
    wet = np.array(mi.render(solid, sensor=sensor(2, (7, 0, 0.4), (5, 0, 0.4)), integrator=seen, spp=4))
    hue = COLOR / max(COLOR)
    # Ten metres of water let nothing pass; however deep it is, the colour is that of the same optical depth.
    scattered = VEIL * 0.7 * hue ** (PUREST / -np.log(min(hue))) * SIDES
    assert wet[..., :3].mean(axis=(0, 1)) == pytest.approx(scattered + HEAD_ON * 2.0, rel=2e-3)
    seen = through_liquids(pool(0.8, 0.05)[1], path, path, room(), white=0.7)
    deeper = np.array(mi.render(solid, sensor=sensor(2, (7, 0, 0.4), (5, 0, 0.4)), integrator=seen, spp=4))
    assert deeper[..., [0, 2]] == pytest.approx(wet[..., [0, 2]], rel=2e-3), "where too little passes for a number"


@pytest.mark.usefixtures("tracer")
def test_a_blurred_frame_in_which_a_stream_begins_is_the_mean_of_its_moments() -> None:
    solid, surfaces = pool(0.5)
    dry, wet = FilmMoment(solid), FilmMoment(solid, liquids=surfaces, room=room())
    depths = [
        trace([(moment, sensor(16)) for moment in moments], Quality(4, 3, 2), 1.0).depth.mean()
        for moments in ([dry], [wet], [dry, wet], [wet, dry])
    ]
    assert depths[2:] == pytest.approx([np.mean(depths[:2])] * 2, rel=1e-4)


@pytest.mark.usefixtures("tracer")
def test_rays_bend_by_snells_law() -> None:
    mi = mitsuba()
    _, surfaces = pool(0.8)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, 1)
    slanted = mi.Ray3f(mi.Point3f(0, 0, 2), mi.Vector3f(0.6, 0, -0.8))
    found = way(surfaces, sampler, slanted, True)
    along = np.array(found.ray.d).ravel()
    assert along == pytest.approx([0.6 / INDEX, 0, -np.sqrt(1 - (0.6 / INDEX) ** 2)], abs=1e-5)
    assert np.array(found.mirrored.d).ravel() == pytest.approx([0.6, 0, 0.8], abs=1e-5)
    passed = (1 - np.array(found.reflected)) * COLOR ** (0.8 / -along[2])
    assert np.array(found.passed).ravel() == pytest.approx(passed, rel=1e-3)


def test_a_pool_at_rest_is_level() -> None:
    spacing, chance = 0.01, np.random.default_rng(3)
    axes = [np.arange(n) * spacing for n in (30, 30, 8)]
    particles = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    particles += chance.uniform(-0.25, 0.25, particles.shape) * spacing  # about as uneven as mpm leaves them
    vertices, faces = liquid_surface(particles, spacing / 2)
    normals = smooth_normals(vertices[faces], faces.ravel(), len(vertices))
    inner = (np.abs(vertices[:, :2] - 0.145) < 0.1).all(axis=1) & (vertices[:, 2] > 0.04)
    tilt = np.degrees(np.arccos(np.clip(normals[inner, 2], -1, 1)))
    assert np.percentile(tilt, 95) < 4.0
    assert vertices[inner, 2].mean() == pytest.approx(0.075, abs=0.3 * spacing), "half a distance above the highest"
