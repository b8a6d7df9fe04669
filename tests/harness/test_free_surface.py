"""The free surface of what flows, and how much of a body is below it, against geometry."""

import json

import numpy as np
import pytest

STEP = 0.01
WATER = {"kind": "liquid", "shape": {"kind": "box", "size": [0.4, 0.4, 0.2]}}
BALL = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.05}}


def pool(surface=lambda x: 0.2 + 0 * x, low=(-0.2, -0.2, 0.0), high=(0.2, 0.2, 0.4)):
    """Particles of a pool, as irregular as those of a liquid, from `low` up to the height of its surface at x."""
    sides = [np.arange(a + STEP / 2, b, STEP) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, 3)
    points += np.random.default_rng(1).uniform(-0.3, 0.3, points.shape) * STEP
    return points[points[:, 2] < surface(points[:, 0]) - 0.2 * STEP]


@pytest.fixture
def water(new_run, measure_soft):
    """Return a function that measures water of which particles are given, shape (n, 3) or (11, n, 3)."""

    def one(points, bodies=None, **measure):
        run = new_run(duration=0.1)
        run.add_link("floor", fixed=True)
        run.add_soft("water", points, kind="liquid", spacing=STEP)
        return measure_soft(run, {"water": WATER} | (bodies or {}), kind="surface_level", of="water", **measure).values

    return one


def test_the_level_of_a_pool_whatever_is_in_the_air(water):
    spray = np.random.default_rng(2).uniform((-0.2, -0.2, 0.2), (0.2, 0.2, 1.0), (1500, 3))
    for points in (pool(), np.concatenate([pool(), spray])):
        np.testing.assert_allclose(water(points), 0.2, atol=STEP / 2)


def test_the_level_at_a_place_is_that_of_the_wave_there(water):
    wave = pool(lambda x: 0.2 + 0.05 * np.sin(np.pi * x / 0.2))
    for x in (-0.1, 0.0, 0.1):
        gauge = {"kind": "cylinder", "center": [x, 0, 0.25], "radius": 0.03, "height": 0.5}
        expected = 0.2 + 0.05 * np.sin(np.pi * x / 0.2)
        np.testing.assert_allclose(water(wave, region=gauge), expected, atol=STEP / 2)
    empty = {"kind": "box", "min": [1, 1, 0], "max": [2, 2, 1]}
    assert np.isnan(water(wave, region=empty)).all()


def test_what_waits_in_the_mouth_of_a_stream_is_not_on_the_surface(new_run, measure_soft):
    waiting = np.array([0.0, 0.0, 1.0]) + np.random.default_rng(3).uniform(-1, 1, (500, 3)) * [0.02, 0.02, 0]
    points = np.stack([waiting] + [np.concatenate([pool()[:100], waiting[100:]])] * 10)
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    run.add_soft("water", points, kind="liquid", spacing=STEP)
    mouth = {"kind": "stream", "radius": 0.02, "speed": 1, "duration": 1}
    values = measure_soft(run, {"water": WATER | {"shape": mouth}}, kind="surface_level", of="water").values
    assert np.isnan(values[0])
    assert (values[1:] < 0.3).all()


@pytest.fixture
def sink(new_run, measure_soft):
    """Return a function that measures how much of a ball is submerged, whose solids and heights are given."""

    def one(points, solids, heights, where=(0.0, 0.0), quat=(1, 0, 0, 0)):
        run = new_run(duration=0.1)
        run.add_link("floor", fixed=True)
        heights = np.broadcast_to(heights, 11)
        run.add_link("ball", pos=np.stack([0 * heights + where[0], 0 * heights + where[1], heights], 1), quat=quat)
        run.add_soft("water", points, kind="liquid", spacing=STEP)
        folder = run.write()
        (folder / "geometry" / "solids.json").write_text(json.dumps({"1": solids}))
        bodies = {"water": WATER, "ball": BALL}
        return measure_soft(folder, bodies, kind="submerged", of="ball", by="water").values

    return one


def without(points, center, radius):
    return points[np.linalg.norm(points - center, axis=1) > radius]


def test_a_ball_that_sinks_is_submerged_by_the_volume_of_its_cap(sink):
    """A cap of height h has the volume pi h^2 (3 r - h) / 3."""
    r, heights = 0.05, np.linspace(0.27, 0.1, 11)
    h = np.clip(0.2 - heights + r, 0, 2 * r)
    cap = h**2 * (3 * r - h) / (4 * r**3)
    kept = np.stack([np.where(np.linalg.norm(pool() - [0, 0, z], axis=1, keepdims=True) > r + STEP / 2, pool(), np.nan)
                     for z in heights])  # fmt: skip
    values = sink(kept, [{"kind": "sphere", "size": [r]}], heights)
    # The slope of the cap's volume is at most 3 / (4 r) in h, which is known to half a particle distance.
    np.testing.assert_allclose(values, cap, atol=0.75 / r * STEP / 2)
    assert (values[0], values[-1]) == (0.0, pytest.approx(1.0))


def test_solids_that_overlap_count_once_and_a_body_counts_as_it_lies(sink):
    """Two bars of 0.2 x 0.04 x 0.04 m cross; turned by 45 deg about y, with the cross upright, half is submerged."""
    bars = [{"kind": "box", "size": size} for size in ([0.2, 0.04, 0.04], [0.04, 0.04, 0.2])]
    points = without(pool(), [0, 0, 0.2], 0.11)
    values = sink(points, bars, 0.2)
    np.testing.assert_allclose(values, 0.5, atol=0.2 * STEP / 0.04)
    # Of the cross, 0.2 + 0.16 m of bars, what is above the upper face of the flat one is 0.08 m.
    np.testing.assert_allclose(sink(points, bars, 0.2 - 0.025), 1 - (0.08 - 0.005) / 0.36, atol=STEP / 2 / 0.36)
    turned = (np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0)
    np.testing.assert_allclose(sink(points, bars, 0.2, quat=turned), 0.5, atol=0.05)


def test_what_is_beside_or_below_the_water_is_dry(sink):
    ball = [{"kind": "sphere", "size": [0.05]}]
    assert (sink(pool(), ball, 0.1, where=(0.6, 0)) == 0).all()
    on_table = pool(lambda x: 1.2 + 0 * x, low=(-0.2, -0.2, 1.0), high=(0.2, 0.2, 1.4))
    assert (sink(on_table, ball, 0.5) == 0).all()


def test_a_ball_sunk_in_a_tube_hardly_wider_than_itself_is_submerged(sink):
    tube = pool(low=(-0.06, -0.06, 0.0), high=(0.06, 0.06, 0.4))
    values = sink(without(tube, [0, 0, 0.08], 0.055), [{"kind": "sphere", "size": [0.05]}], 0.08)
    np.testing.assert_allclose(values, 1.0)
