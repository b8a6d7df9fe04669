"""Still backgrounds, and the samples of held frames."""

import numpy as np
import pytest
from filmed import MakeRun
from scipy.ndimage import gaussian_filter

from text2sim.recording.film_record import read_recording
from text2sim.rendering.background import BACKGROUND_SAMPLES, WORTH, Sampled, background, sharpened
from text2sim.rendering.film import Filming
from text2sim.rendering.resting import held_samples

TRUTH = 0.5 + 0.3 * np.sin(np.arange(96) * 1.3)[None, :, None] * np.ones((64, 1, 3))


def sampled(truth: np.ndarray, seed: int, first: np.ndarray, blur: float = 2.0) -> Sampled:
    noisy = truth + np.random.default_rng(seed).normal(0, 0.1, truth.shape)
    return Sampled(noisy, gaussian_filter(noisy, (blur, blur, 0)), first)


def rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error**2)))


def test_the_background_is_sharp_where_samples_are_equal_and_what_moves_is_as_it_was() -> None:
    nothing = np.zeros((64, 96, 8))
    body = nothing.copy()
    body[20:40, 10:30] = 1.0
    picture = sampled(np.where(body[..., :1] > 0, 0.9, TRUTH), 0, body)
    shown = sharpened(picture, background(sampled(TRUTH, 0, nothing), TRUTH))
    np.testing.assert_array_equal(shown[20:40, 10:30], picture.smooth[20:40, 10:30])
    np.testing.assert_allclose(shown[:, 60:], TRUTH[:, 60:], atol=1e-3)
    assert rms(picture.smooth[:, 60:] - TRUTH[:, 60:]) > 0.1


def test_a_shadow_keeps_its_light_and_other_samples_add_nothing() -> None:
    nothing, shade = np.zeros((64, 96, 8)), np.ones((64, 96, 1))
    shade[:, :40] = 0.5
    flat = np.full(TRUTH.shape, 0.6)
    same = background(sampled(flat, 0, nothing), flat)
    shown = sharpened(sampled(flat * shade, 0, nothing), same)
    assert shown[:, :25].mean() == pytest.approx(0.3, abs=0.01)
    other = sampled(flat, 1, nothing)
    assert rms(sharpened(other, same) - flat) < 1.2 * rms(other.smooth - flat)


def test_what_a_standing_camera_sees_is_traced_once_if_there_are_enough_pictures(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.5), "velocity": (9, 0, 0)}}, fps=50.0)
    film = Filming(read_recording(run), samples=4)
    reels = film.reels()
    assert len(reels[0].frames) * 4 >= WORTH * BACKGROUND_SAMPLES
    assert set(film._references.values()) == {reels[0].frames[len(reels[0].frames) // 2]}
    assert film.missing(reels) == (20, 20 * 4 + BACKGROUND_SAMPLES + 4)
    short = Filming(read_recording(run), samples=2)
    assert short.missing(short.reels()) == (20, 20 * 2)


@pytest.mark.parametrize(
    ("samples", "pictures", "held"), [(2, 1, 2), (2, 4, 4), (2, 25, 16), (8, 25, 64), (8, 2, 8), (36, 25, 64)]
)
def test_held_frames_have_more_samples(samples: int, pictures: int, held: int) -> None:
    assert held_samples(samples, pictures) == held


def test_a_body_that_was_there_leaves_no_ghost() -> None:
    """Denoising has mixed its brightness into its surroundings."""
    nothing = np.zeros((64, 96, 8))
    body = nothing.copy()
    body[20:40, 10:30] = 1.0
    bright = np.where(body[..., :1] > 0, 5.0, TRUTH)
    picture = sampled(TRUTH, 0, nothing, 12.0)
    shown = sharpened(picture, background(sampled(bright, 0, body, 12.0), bright))
    around = np.s_[14:46, 30:80]
    assert np.abs(shown[around] - picture.smooth[around]).max() < 1.2 * np.abs(TRUTH - picture.smooth)[around].max()
