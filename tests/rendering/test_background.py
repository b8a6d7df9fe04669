"""Still backgrounds: only what differs from one moment of a standing camera is traced; and the samples of held frames."""

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.recording.film_record import read_recording
from text2sim.rendering.background import (
    COARSE,
    FINISHING_SAMPLES,
    WORTH,
    Probe,
    background_samples,
    changed,
    crops,
    faded,
)
from text2sim.rendering.film import PROBE_SAMPLES, Filming, Work
from text2sim.rendering.resting import held_samples

SIZE = (64, 96)
BOX = {"half": 0.3, "pos": (-0.5, 0, 0.5), "velocity": (2.5, 0, 0)}


def seen(light: float = 0.5, noise: int = 0) -> Probe:
    hits = np.ones((*SIZE, 7)) * (0.5, 0.5, 0.5, 0, 0, 1, 3)
    coarse = np.full((SIZE[0] // COARSE, SIZE[1] // COARSE, 3), light)
    return Probe(hits, coarse * np.random.default_rng(noise).uniform(0.5, 1.5, coarse.shape))


def test_pixels_differ_where_something_else_is_hit() -> None:
    now = seen()
    now.hits[30, 40, :3] = 0.6  # another colour
    now.hits[10, 80, 6] = 2.9  # nearer
    now.hits[50:, :, 6] += 1e-4  # a body at rest trembles
    found = changed(now, seen(), 1.0)
    assert found[30, 40]
    assert found[10, 80]
    assert found.sum() < 2 * 81
    assert not found[45:].any()


@pytest.mark.parametrize(("shade", "differs"), [(0.9, True), (0.995, False)])
def test_pixels_differ_in_a_shadow_that_can_be_seen(shade: float, *, differs: bool) -> None:
    now = seen()
    now.light[4:9, 4:9] *= shade
    found = changed(now, seen(), 1.0)
    assert found[20:32, 20:32].all() == differs
    assert not found[:, 70:].any(), "samples are equal where nothing has changed, however noisy they are"


@pytest.mark.parametrize("columns", [1, 2])
def test_one_or_two_paths_that_have_changed_are_no_shadow(columns: int) -> None:
    now = seen()
    now.light[5, 5 : 5 + columns] *= 40
    assert not changed(now, seen(), 1.0).any()


def test_the_narrow_shadow_of_a_rod_is_one() -> None:
    now = seen()
    now.light[8, 4:14] *= 0.3
    assert changed(now, seen(), 1.0)[8 * COARSE, 5 * COARSE : 13 * COARSE].all()


def test_what_is_traced_fades_into_the_background_and_is_denoised_in_parts() -> None:
    wanted = np.zeros((400, 600), bool)
    wanted[40:80, 40:80] = wanted[300:340, 500:540] = True
    weight = faded(wanted)
    assert weight[60, 60] == 1
    assert (weight[~wanted] == 0).all()
    parts = crops(wanted)
    assert len(parts) == 2
    assert sum(wanted[part].sum() for part in parts) == wanted.sum(), "every wanted pixel is in one of them"
    wanted[::40, ::40] = True
    assert len(crops(wanted)) == 1


def test_what_a_standing_camera_sees_is_traced_once_if_there_are_enough_pictures(make_run: MakeRun) -> None:
    run = make_run({"box": BOX}, fps=50.0)
    film = Filming(read_recording(run), samples=4)
    reels = film.reels()
    assert len(reels[0].frames) * (4 + FINISHING_SAMPLES) >= WORTH * background_samples(4)
    assert set(film._standing.references.values()) == {reels[0].frames[len(reels[0].frames) // 2]}
    assert film.missing(reels) == Work(20, 20 + 2, 20 * (4 + PROBE_SAMPLES) + 36 + 4)
    assert film.missing(reels, 0.25) == Work(20, 5 + 2, 20 * (1 + PROBE_SAMPLES) + 36 + 4)
    assert [background_samples(samples) for samples in (2, 8, 36)] == [36, 36, 144]
    few = film.excerpt(reels[0], reels[0].frames[:3])
    assert film.missing([few]) == Work(3, 3, 3 * 4), "three pictures do not pay for a background of 36 samples"
    short = Filming(read_recording(make_run({"box": BOX}, "short", fps=25.0)), samples=2)
    assert short.missing(short.reels()) == Work(10, 10, 10 * 2)


@pytest.mark.usefixtures("tracer")
def test_a_frame_in_front_of_its_background_looks_as_if_all_of_it_were_traced(make_run: MakeRun) -> None:
    floor = {"half": (3, 3, 0.05), "pos": (0, 0, -0.05)}
    lamp = {"kind": "sun", "direction": (0.4, 0.3, -1.0), "color": (1, 1, 1), "strength": 3.0, "angle": 5.0}
    lights = {"dome": {"kind": "environment", "strength": 0.4, "color": (1, 1, 1), "horizon": (1, 1, 1)}, "sun": lamp}
    film = Filming(read_recording(make_run({"box": BOX, "floor": floor}, fps=50.0, lights=lights)), size=(96, 54))
    frames = film.reels()[0].frames
    assert film.has_background(frames[0])
    background, wanted = film._standing.behind(frames[0], film.samples) or (None, np.zeros(0))
    assert background is not None
    assert 0.05 < wanted.mean() < 0.7
    part, whole = (film.develop(film.trace(frames[0], with_background=on)).astype(float) for on in (True, False))
    assert np.sqrt(np.mean((part - whole) ** 2)) < 6, "apart from noise"
    np.testing.assert_allclose(part[~wanted].mean(), whole[~wanted].mean(), atol=1)
    np.testing.assert_allclose(part[wanted].mean(), whole[wanted].mean(), atol=1)
    share = film.traced_share(film.reels()[0])
    assert 0.02 < share < 0.7


@pytest.mark.parametrize(
    ("samples", "pictures", "held"), [(2, 1, 2), (2, 4, 4), (2, 25, 16), (8, 25, 64), (8, 2, 8), (36, 25, 64)]
)
def test_held_frames_have_more_samples(samples: int, pictures: int, held: int) -> None:
    assert held_samples(samples, pictures) == held
