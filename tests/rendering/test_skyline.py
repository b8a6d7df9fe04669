"""What stands at the horizon of an open place."""

from types import SimpleNamespace

import numpy as np
import pytest

from text2sim.rendering.backdrop import haze_distance, sky
from text2sim.rendering.noise import fractal_noise, sampled
from text2sim.rendering.skies import Skies
from text2sim.rendering.skyline import FARTHEST, ROWS, distance_of, skyline
from text2sim.templates.cameras import View

HAZE = np.array([0.87, 0.91, 0.93])
BLUE = np.array([0.5, 0.7, 0.9])
PIXEL = 0.002


def painted(kind, turn, rise, far=1):
    """Colours of a skyline in directions: fractions of a turn and elevations [rad], both of shape (n,)."""
    flat, angle = np.cos(rise), 2 * np.pi * np.asarray(turn)
    rays = np.stack([flat * np.cos(angle), flat * np.sin(angle), np.sin(rise)], axis=-1)
    return skyline(kind, rays[None], HAZE, PIXEL, np.broadcast_to(BLUE, rays[None].shape), far)[0]


@pytest.mark.parametrize("kind", ROWS)
def test_it_closes_around_the_viewer_and_stays_low(kind):
    tallest = 2.2 * max(height for _, height, _ in ROWS[kind])
    turn, low = np.linspace(0, 1, 500), np.full(500, 0.004)
    assert painted(kind, [1e-9], [0.004]) == pytest.approx(painted(kind, [1 - 1e-9], [0.004]), abs=0.02)
    assert (np.abs(painted(kind, turn, low) - BLUE).max(axis=1) > 0.1).all(), "there is no gap at the horizon"
    high = painted(kind, turn, np.full(500, tallest))
    assert (high.min(axis=1) >= BLUE.min() - 1e-9).all(), "above it are sky and clouds only"
    assert 0 <= painted(kind, np.repeat(turn, 3), np.tile([-0.5, 0.01, 1.2], 500)).min()


@pytest.mark.parametrize("kind", ROWS)
def test_far_below_the_horizon_nothing_is_painted(kind):
    assert painted(kind, np.linspace(0, 1, 50), np.full(50, -0.4)) == pytest.approx(np.tile(BLUE, (50, 1)))


def test_a_place_without_a_skyline_keeps_its_plain_sky():
    view = View(np.zeros(3), np.array([1.0, 0, 0.1]), np.array([0, 0, 1.0]), 30.0, 1.0, 0.0)
    plain = sky({"sky": BLUE}, HAZE, view, (64, 36))
    assert np.ptp(plain, axis=1).max() < 0.02, "a row differs by the picture's curvature alone"
    wood = {"sky": BLUE, "skyline": "wood"}
    sharp = sky(wood, HAZE, view, (64, 36))
    assert np.ptp(sharp[20], axis=0).max() > 0.05
    soft = sky(wood, HAZE, view._replace(aperture=0.05), (64, 36))
    assert np.abs(np.diff(soft, axis=1)).max() < np.abs(np.diff(sharp, axis=1)).max(), "a wide lens blurs it"


def test_ground_reaches_farther_before_a_skyline():
    far = {"kind": "horizon", "radius": 8.0}
    places, eye = np.zeros((4, 3)), np.array([0.0, -3.0, 1.0])
    assert haze_distance(far | {"skyline": "wood"}, eye, places) > 2 * haze_distance(far, eye, places)
    assert haze_distance({"kind": "wall", "radius": 8.0, "skyline": "wood"}, eye, places) == 0


def test_noise_repeats_without_a_seam():
    tile = fractal_noise(np.random.default_rng(1), 1.5, 64)
    assert (tile.mean(), tile.std()) == pytest.approx((0, 1), abs=1e-9)
    x = np.linspace(0, 1, 40)
    assert sampled(tile, x + 1, x - 2) == pytest.approx(sampled(tile, x, x))
    assert sampled(tile, np.array([5 / 64]), np.array([7 / 64]))[0] == pytest.approx(tile[7, 5])


def test_a_skyline_stands_far_enough_away_for_its_top_to_be_in_the_picture():
    assert distance_of("wood", [0.3]) == 1, "sky above it"
    assert distance_of("wood", [-0.1]) == 1, "no picture shows it"
    assert distance_of("wood", [0.3, 0.03]) == 3, "the lowest picture counts"
    assert distance_of("wood", [0.004]) == FARTHEST
    turn, rise = np.full(200, 0.3), np.linspace(0.0, 0.08, 200)
    tops = [rise[np.abs(painted("wood", turn, rise, far) - BLUE).max(axis=1) > 0.05].max() for far in (1, 3)]
    assert tops[1] < 0.45 * tops[0]


def test_cameras_that_share_a_view_keep_their_own_distances():
    """One stands still, the other starts there and tilts down, until its upper edge cuts the trees."""
    level = View(np.zeros(3), np.array([1.0, 0, 0.1]), np.array([0, 0, 1.0]), 30.0, 1.0, 0.0)
    tilted = level._replace(look_at=np.array([1.0, 0, -0.22]))
    cameras = SimpleNamespace(view=lambda camera, t, part: tilted if camera == "tilts" and part == 1 else level)
    film = {"backdrop": {"sky": BLUE, "skyline": "wood"}, "background": HAZE}
    for order in (("still", "tilts"), ("tilts", "still")):
        skies = Skies(film, cameras, np.array([0.0, 1.0]), (64, 36))
        behind = {camera: skies.behind(level, camera) for camera in order}
        assert np.abs(behind["still"] - behind["tilts"]).max() > 0.05
        assert behind["still"] == pytest.approx(sky(film["backdrop"], HAZE, level, (64, 36)))
