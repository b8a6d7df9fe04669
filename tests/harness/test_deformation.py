"""Measures of how a body is deformed, against deformations whose every number is known."""

import numpy as np
import pytest
from soft_shapes import CLOTH, deformed, lattice, sheet, sphere, tets, turns


def gradients(kind, amount):
    """Deformation gradients (F, 3, 3) that grow with an amount (F,), and the equivalent strain of each."""
    f = np.tile(np.eye(3), (len(amount), 1, 1))
    if kind == "stretched":
        f[:, 0, 0] += amount
        e = ((1 + amount) ** 2 - 1) / 2
        return f, 2 / 3 * e  # uniaxial: deviator (2, -1, -1) e / 3
    if kind == "sheared":
        f[:, 0, 1] = amount
        # E = [[0, a/2], [a/2, a^2/2]]: deviator squares to a^2/2 + (a^2/2)^2 2/3.
        return f, np.sqrt(2 / 3 * (amount**2 / 2 + amount**4 / 6))
    if kind == "swollen":
        return f * (1 + amount)[:, None, None], 0 * amount
    return turns(20 * amount), 0 * amount


@pytest.mark.parametrize("inside", ["tets", "particles"])
@pytest.mark.parametrize("kind", ["stretched", "sheared", "swollen", "turned"])
def test_strain_is_exact_where_a_body_deforms_evenly(soft_run, measure_soft, kind, inside):
    rest = lattice(5, 0.1)
    f, expected = gradients(kind, np.linspace(0, 0.2, 11))
    extra = {"tets": tets(5), "solver": "fem"} if inside == "tets" else {}
    soft_run.add_soft("jelly", deformed(rest, turns(np.linspace(0, 3, 11)) @ f) + [0, 0, 1], **extra)
    folder = soft_run.write()
    for stat in ("max", "min", "mean", "p99"):
        values = measure_soft(folder, kind="strain", of="jelly", stat=stat).values
        np.testing.assert_allclose(values, expected, rtol=1e-4, atol=2e-5)


def test_strain_of_grains_that_moved_at_random_is_not_small(soft_run, measure_soft):
    random = np.random.default_rng(1).normal(size=(11, 125, 3)) * 0.03
    soft_run.add_soft("jelly", lattice(5, 0.1) + random * np.linspace(0, 1, 11)[:, None, None])
    values = measure_soft(soft_run, kind="strain", of="jelly", stat="mean").values
    assert values[0] == pytest.approx(0, abs=1e-5)
    assert values[-1] > 0.08


def test_particles_in_one_plane_have_no_strain(soft_run, measure_soft):
    soft_run.add_soft("jelly", sheet(5, 5, 0.1)[0])
    assert "plane" in measure_soft(soft_run, kind="strain", of="jelly").problem


def test_volume_of_a_sphere_whatever_its_place_and_turn(soft_run, measure_soft):
    points, faces = sphere(0.5)
    moved = deformed(points, turns(np.linspace(0, 2, 11)) * np.linspace(1, 2, 11)[:, None, None]) + [3, -2, 7]
    soft_run.add_soft("jelly", lattice(2, 0.1), surface=moved, faces=faces)
    folder = soft_run.write()
    values = measure_soft(folder, kind="volume", of="jelly").values
    assert values[0] == pytest.approx(4 / 3 * np.pi * 0.125, rel=0.01)
    relative = measure_soft(folder, kind="volume", of="jelly", relative=True)
    np.testing.assert_allclose(relative.values, np.linspace(1, 2, 11) ** 3, rtol=1e-4)
    assert relative.unit == ""


def test_volume_of_tetrahedra(soft_run, measure_soft):
    grow = np.linspace(1, 0.5, 11)
    soft_run.add_soft("jelly", lattice(4, 0.1) * grow[:, None, None] + [9, 9, 9], tets=tets(4), solver="fem")
    np.testing.assert_allclose(measure_soft(soft_run, kind="volume", of="jelly").values, (0.3 * grow) ** 3, rtol=1e-4)


@pytest.mark.parametrize("faces", [[[0, 1, 2]], None])
def test_what_has_no_inside_has_no_volume(soft_run, measure_soft, faces):
    surface = {} if faces is None else {"surface": lattice(2, 0.1), "faces": np.array(faces)}
    soft_run.add_soft("jelly", lattice(2, 0.1), **surface)
    series = measure_soft(soft_run, kind="volume", of="jelly")
    assert ("not closed" if faces else "no surface") in series.problem
    assert np.isnan(series.values).all()


def test_stretch_of_a_sheet_pulled_along_one_side(soft_run, measure_soft):
    points, faces = sheet(11, 11, 0.1)
    pull = np.linspace(1, 1.3, 11)
    soft_run.add_soft("towel", points * np.stack([pull, 1 + 0 * pull, 1 + 0 * pull], 1)[:, None], surface=None,
                   kind="cloth", solver="ipc", faces=faces)  # fmt: skip
    folder, bodies = soft_run.write(), {"towel": CLOTH}
    value = {
        stat: measure_soft(folder, bodies, kind="stretch", of="towel", stat=stat).values for stat in ("max", "min")
    }
    np.testing.assert_allclose(value["max"], pull, rtol=1e-5)
    np.testing.assert_allclose(value["min"], 1, rtol=1e-5)
    mean = measure_soft(folder, bodies, kind="stretch", of="towel", stat="mean").values
    edges, diagonals = 110, 100
    expected = (edges * pull + edges + diagonals * np.sqrt((pull**2 + 1) / 2)) / (2 * edges + diagonals)
    np.testing.assert_allclose(mean, expected, rtol=1e-5)


def test_threads_count_before_what_is_drawn(soft_run, measure_soft):
    points, faces = sheet(3, 3, 0.1)
    grow = np.linspace(1, 1.5, 11)[:, None, None]
    soft_run.add_soft("towel", points * grow, surface=points, kind="cloth", solver="pbd",
                   faces=faces, edges=np.array([[0, 1]]))  # fmt: skip
    np.testing.assert_allclose(
        measure_soft(soft_run, {"towel": CLOTH}, kind="stretch", of="towel").values, grow[:, 0, 0], rtol=1e-5
    )


def test_the_99th_percentile_leaves_out_one_in_a_hundred(soft_run, measure_soft):
    points, _ = sheet(101, 2, 0.1)
    pairs = np.array([[2 * i, 2 * i + 2] for i in range(100)])
    moved = np.tile(points, (11, 1, 1))
    moved[5:, -2:, 0] += 0.1  # the last edge twice as long
    moved[7:, 2:, 0] += 0.1  # and the first
    soft_run.add_soft("towel", moved, kind="cloth", solver="pbd", edges=pairs)
    values = measure_soft(soft_run, {"towel": CLOTH}, kind="stretch", of="towel", stat="p99").values
    np.testing.assert_allclose(values, [1] * 7 + [2] * 4, rtol=1e-4)


def folded(angle, n=41, step=0.025):
    """A sheet whose right half is turned up about its middle by angles (F,), a thickness above where it lies double."""
    points, faces = sheet(n, n, step)
    right = points[:, 0] > 1e-9
    moved = np.tile(points, (len(angle), 1, 1))
    moved[:, right, 0] = points[right, 0] * np.cos(angle)[:, None]
    moved[:, right, 2] = points[right, 0] * np.sin(angle)[:, None] + 0.02 * (1 - np.cos(angle))[:, None] / 2
    return moved, faces


def test_a_folded_sheet_hides_half_of_itself(soft_run, measure_soft):
    angle = np.linspace(0, np.pi, 11)
    moved, faces = folded(angle)
    soft_run.add_soft("towel", moved, surface=moved, kind="cloth", solver="pbd", spacing=0.025, faces=faces)
    folder, bodies = soft_run.write(), {"towel": CLOTH}
    values = measure_soft(folder, bodies, kind="folded_area", of="towel").values
    # Beyond a right angle it hides what its shadow covers: half the area times the cosine.
    expected = np.where(angle > np.pi / 2, -np.cos(angle) / 2, 0.0)
    np.testing.assert_allclose(values, expected, atol=0.02)
    np.testing.assert_array_equal(values[:5], 0)
    np.testing.assert_allclose(
        measure_soft(folder, bodies, kind="folded_area", of="towel", axis="y").values, 0, atol=0.01
    )


def test_what_has_flown_apart_has_no_shadow(soft_run, measure_soft):
    points, faces = sheet(5, 5, 0.1)
    moved = np.tile(points, (11, 1, 1))
    moved[5] *= 1e7
    moved[6, 3] = np.nan
    soft_run.add_soft("towel", moved, surface=moved, kind="cloth", solver="pbd", faces=faces)
    values = measure_soft(soft_run, {"towel": CLOTH}, kind="folded_area", of="towel").values
    assert np.isnan(values[5:7]).all()
    np.testing.assert_array_equal(values[[0, 4, 7, 10]], 0)


def test_self_penetration_is_how_much_nearer_than_its_thickness(soft_run, measure_soft):
    points, faces = sheet(21, 3, 0.05)
    up = np.where(points[:, 0] > 0, 1.0, 0.0)
    height = np.linspace(0.2, 0.02, 11)
    moved = np.stack([np.where(up, -points[:, 0], points[:, 0]), points[:, 1], 0 * up], 1) + np.zeros((11, 1, 1))
    moved[:, :, 2] = up * height[:, None]
    soft_run.add_soft("towel", moved, kind="cloth", solver="pbd", spacing=0.05, faces=faces)
    values = measure_soft(soft_run, {"towel": CLOTH}, kind="self_penetration", of="towel").values
    np.testing.assert_allclose(values, np.maximum(0.05 - height, 0), atol=1e-6)


def rolled(points, radius):
    """Points (n, 3) of a flat sheet, laid on cylinders of radii (F,) about the y axis."""
    angle = points[:, 0] / radius[:, None]
    y = np.broadcast_to(points[:, 1], angle.shape)
    return np.stack([radius[:, None] * np.sin(angle), y, radius[:, None] * (1 - np.cos(angle))], -1)


@pytest.mark.parametrize("way", [0.0, 30.0, 45.0, 135.0])
def test_a_rolled_sheet_is_curved_as_its_radius_says(soft_run, measure_soft, way):
    points, faces = sheet(31, 21, 0.02)
    around = np.radians(way)
    turned = points @ np.array([[np.cos(around), np.sin(around), 0], [-np.sin(around), np.cos(around), 0], [0, 0, 1]])
    radius = np.linspace(0.3, 2.0, 11)
    soft_run.add_soft("towel", rolled(turned, radius), kind="cloth", solver="pbd", spacing=0.02, point_faces=faces)
    found = measure_soft(soft_run, {"towel": CLOTH}, kind="wrinkling", of="towel")
    # A chord is shorter than its arc: (w / R)^2 / 24 for edges of length w.
    np.testing.assert_allclose(found.values, 1 / radius, rtol=2e-3)
    assert found.unit == "1/m"


def test_waves_of_a_sheet(soft_run, measure_soft):
    points, faces = sheet(121, 11, 0.01)
    height, length = np.linspace(0, 0.004, 11), 0.2
    waves = np.repeat(points[None], 11, axis=0)
    waves[..., 2] = height[:, None] * np.sin(2 * np.pi * points[:, 0] / length)
    soft_run.add_soft("towel", waves, kind="cloth", solver="pbd", spacing=0.01, point_faces=faces)
    found = measure_soft(soft_run, {"towel": CLOTH}, kind="wrinkling", of="towel").values
    # The slope goes up and down by 4 atan(2 pi a / l) in one wave of length l: 8 pi a / l^2, for small slopes.
    np.testing.assert_allclose(found, 8 * np.pi * height / length**2, rtol=0.02, atol=1e-4)
