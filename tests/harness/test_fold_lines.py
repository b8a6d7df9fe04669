"""Folds of a cloth, of forms whose waves are known."""

import numpy as np
import pytest
from soft_shapes import CLOTH, sheet

NX, NY, CELL = 97, 25, 0.0125
POINTS, FACES = sheet(NX, NY, CELL)
X, Y, FLAT = POINTS[:, 0], POINTS[:, 1], 0 * POINTS[:, 0]
LENGTH = (NX - 1) * CELL


@pytest.fixture
def folds(new_run, measure_soft):
    """Return a function that counts the folds of a cloth in several forms (n, 3), of which it starts in the first."""

    def count(*forms, faces=FACES, across="y", spacing=CELL, **extra):
        run = new_run(duration=0.01 * (len(forms) - 1))
        run.add_link("floor", fixed=True)
        run.add_soft("towel", np.stack(forms), kind="cloth", solver="pbd", spacing=spacing, point_faces=faces, **extra)
        return measure_soft(run, {"towel": CLOTH}, kind="folds", of="towel", across=across).values.tolist()

    return count


def wavy(waves, slope=1.0, phase=0.0, x=X, y=Y):
    """A sheet with sine waves along x, of a steepest slope."""
    k = 2 * np.pi * waves / LENGTH
    return np.stack([x, y, slope / k * np.sin(k * x + phase)], 1)


def test_waves_are_counted(folds):
    assert folds(POINTS, *(wavy(n) for n in range(1, 17))) == list(range(17))  # the last have six cells each
    assert folds(POINTS, *(wavy(n, slope=4.0) for n in (1, 3, 8))) == [0, 1, 3, 8]  # 76 deg steep


@pytest.mark.parametrize("phase", [0.5, 1.5, 2.5, 4.0])
def test_wherever_waves_begin_they_are_counted_to_one(folds, phase):
    """A wave that both ends cut is a whole one only if it bends both ways by 30 deg within the sheet."""
    found = folds(POINTS, *(wavy(n, phase=phase) for n in (2, 5, 9)))
    np.testing.assert_allclose(found, [0, 2, 5, 9], atol=1)


def test_a_curtain_that_hangs_is_cut_in_its_own_frame(folds):
    """It is turned by a quarter about x: its y points up, and its waves stand out along -y."""
    hung = [np.stack([row[:, 0], 3 - row[:, 2], 1 + row[:, 1]], 1) for row in (POINTS, wavy(2), wavy(7))]
    frame = {"pos": [0, 3, 1], "quat": [0.5**0.5, 0.5**0.5, 0, 0]}
    assert folds(*hung, **frame) == [0, 2, 7]
    assert folds(*hung, across="x", **frame) == [0, 0, 0]


def test_folds_are_seen_across_them_alone(folds):
    assert folds(POINTS, wavy(6), across="x") == [0, 0]


def test_what_bends_one_way_has_none(folds):
    arcs = [np.stack([r * np.sin(X / r), Y, r * np.cos(X / r)], 1) for r in (5.0, 1.0, 0.3)]  # the last is two turns
    folded = np.stack([np.abs(X), Y, np.where(X > 0, 0.03, 0)], 1)
    assert folds(POINTS, *arcs, folded) == [0, 0, 0, 0, 0]


def test_shallow_waves_and_jitter_are_no_folds(folds):
    random = np.random.default_rng(1)
    jitter = [random.uniform(-0.1, 0.1, POINTS.shape) * CELL for _ in range(6)]
    # A slope of 0.25 is 14 deg, so that it bends by 28 deg; at 0.3 by 33 deg.
    assert folds(POINTS, wavy(5, slope=0.25), wavy(5, slope=0.3)) == [0, 0, 5]
    assert folds(POINTS, *(POINTS + row for row in jitter[:3])) == [0, 0, 0, 0]
    assert folds(POINTS, *(wavy(5) + row for row in jitter[3:])) == [0, 5, 5, 5]


def test_a_buckled_strip_has_a_fold_for_each_lobe_that_bends_back(folds):
    # Clamped ends, where it bends from level up to its steepest slope, 50 deg: half as far as between lobes.
    waves = [2 * np.pi * n / LENGTH for n in (1, 2, 3)]
    lobes = [np.stack([X, Y, 1.2 / k * (1 - np.cos(k * (X - X[0])))], 1) for k in waves]
    assert folds(POINTS, *lobes) == [0, 1, 2, 3]
    assert folds(POINTS, np.stack([X, Y, 0.2 * np.cos(np.pi * X / LENGTH)], 1)) == [0, 0]  # hinged: an arch


def test_a_sheet_that_starts_in_waves(folds):
    assert folds(wavy(7), POINTS, wavy(4)) == [7, 0, 4]


def test_rings_and_pleats_of_a_sleeve(folds):
    around, up = 96, 61
    angle, height = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0, 0.6, up), indexing="ij")
    i, j = np.meshgrid(np.arange(around), np.arange(up - 1), indexing="ij")
    a, b = (i * up + j).ravel(), ((i + 1) % around * up + j).ravel()
    faces = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])

    def tube(radius, squeezed=1.0):
        r = np.broadcast_to(radius, angle.shape)
        return np.stack([r * np.cos(angle), r * np.sin(angle), squeezed * height], -1).reshape(-1, 3)

    # Five bulges on half the height, up to 57 deg steep: two lines in each cut, up and down the sleeve.
    rings = tube(0.15 + 0.015 * (1 - np.cos(2 * np.pi * 5 * height / 0.6)), squeezed=0.5)
    pleats = tube(0.15 + 0.02 * np.cos(12 * angle))
    options = {"faces": faces, "spacing": 0.01}
    assert folds(tube(0.15), rings, pleats, across="x", **options) == [0, 5, 0]
    ring = folds(tube(0.15), rings, pleats, across="z", **options)
    assert ring[:2] == [0, 0]
    assert ring[2] == pytest.approx(12, abs=1)  # one may begin in one of them


def test_cloth_that_has_flown_apart_has_no_number_of_folds(folds):
    broken = POINTS.copy()
    broken[7] = np.nan
    found = folds(POINTS, broken, wavy(3))
    assert (found[0], np.isnan(found[1]), found[2]) == (0, True, 3)


def test_a_cloth_without_extent_along_the_axis_has_no_lines(new_run, measure_soft):
    run = new_run(duration=0.01)
    run.add_link("floor", fixed=True)
    run.add_soft("towel", POINTS, kind="cloth", solver="pbd", spacing=CELL, point_faces=FACES)
    assert "no lines across z" in measure_soft(run, {"towel": CLOTH}, kind="folds", of="towel", across="z").problem
