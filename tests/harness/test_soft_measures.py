"""Measures of bodies that deform, against shapes and motions whose every number is known."""

import numpy as np
import pytest
from soft_shapes import deformed, lattice, sheet, sphere, tets, turns

from text2sim.evidence.measures import Series, evaluate
from text2sim.evidence.recorded_case import RecordedCase

G = 9.81
SOFT = {"kind": "soft", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}
CLOTH = {"kind": "cloth", "shape": {"kind": "sheet", "size": [1.0, 1.0]}}
SAND = {"kind": "granular", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}


@pytest.fixture
def measure(make_case):
    """Return a function that evaluates one measure of a written run."""

    def one(run, bodies=None, statics=("floor",), **measure) -> Series:
        case = make_case(bodies=bodies or {"jelly": SOFT}, statics=statics, measures={"m": measure})
        folder = run.write() if hasattr(run, "write") else run
        return evaluate(RecordedCase.load(folder, case))["m"]

    return one


@pytest.fixture
def small(new_run):
    """A run of eleven frames with a floor."""
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    return run


# --- volume, strain, stretch ---------------------------------------------------------


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
def test_strain_is_exact_where_a_body_deforms_evenly(small, measure, kind, inside):
    rest = lattice(5, 0.1)
    f, expected = gradients(kind, np.linspace(0, 0.2, 11))
    extra = {"tets": tets(5), "solver": "fem"} if inside == "tets" else {}
    small.add_soft("jelly", deformed(rest, turns(np.linspace(0, 3, 11)) @ f) + [0, 0, 1], **extra)
    folder = small.write()
    for stat in ("max", "min", "mean", "p99"):
        values = measure(folder, kind="strain", of="jelly", stat=stat).values
        np.testing.assert_allclose(values, expected, rtol=1e-4, atol=2e-5)


def test_strain_of_grains_that_moved_at_random_is_not_small(small, measure):
    random = np.random.default_rng(1).normal(size=(11, 125, 3)) * 0.03
    small.add_soft("jelly", lattice(5, 0.1) + random * np.linspace(0, 1, 11)[:, None, None])
    values = measure(small, kind="strain", of="jelly", stat="mean").values
    assert values[0] == pytest.approx(0, abs=1e-5)
    assert values[-1] > 0.08


def test_particles_in_one_plane_have_no_strain(small, measure):
    small.add_soft("jelly", sheet(5, 5, 0.1)[0])
    assert "plane" in measure(small, kind="strain", of="jelly").problem


def test_volume_of_a_sphere_whatever_its_place_and_turn(small, measure):
    points, faces = sphere(0.5)
    moved = deformed(points, turns(np.linspace(0, 2, 11)) * np.linspace(1, 2, 11)[:, None, None]) + [3, -2, 7]
    small.add_soft("jelly", lattice(2, 0.1), surface=moved, faces=faces)
    folder = small.write()
    values = measure(folder, kind="volume", of="jelly").values
    assert values[0] == pytest.approx(4 / 3 * np.pi * 0.125, rel=0.01)
    relative = measure(folder, kind="volume", of="jelly", relative=True)
    np.testing.assert_allclose(relative.values, np.linspace(1, 2, 11) ** 3, rtol=1e-4)
    assert relative.unit == ""


def test_volume_of_tetrahedra(small, measure):
    grow = np.linspace(1, 0.5, 11)
    small.add_soft("jelly", lattice(4, 0.1) * grow[:, None, None] + [9, 9, 9], tets=tets(4), solver="fem")
    np.testing.assert_allclose(measure(small, kind="volume", of="jelly").values, (0.3 * grow) ** 3, rtol=1e-4)


@pytest.mark.parametrize("faces", [[[0, 1, 2]], None])
def test_what_has_no_inside_has_no_volume(small, measure, faces):
    surface = {} if faces is None else {"surface": lattice(2, 0.1), "faces": np.array(faces)}
    small.add_soft("jelly", lattice(2, 0.1), **surface)
    series = measure(small, kind="volume", of="jelly")
    assert ("not closed" if faces else "no surface") in series.problem
    assert np.isnan(series.values).all()


def test_stretch_of_a_sheet_pulled_along_one_side(small, measure):
    points, faces = sheet(11, 11, 0.1)
    pull = np.linspace(1, 1.3, 11)
    small.add_soft("towel", points * np.stack([pull, 1 + 0 * pull, 1 + 0 * pull], 1)[:, None], surface=None,
                   kind="cloth", solver="ipc", faces=faces)  # fmt: skip
    folder, bodies = small.write(), {"towel": CLOTH}
    value = {stat: measure(folder, bodies, kind="stretch", of="towel", stat=stat).values for stat in ("max", "min")}
    np.testing.assert_allclose(value["max"], pull, rtol=1e-5)
    np.testing.assert_allclose(value["min"], 1, rtol=1e-5)
    mean = measure(folder, bodies, kind="stretch", of="towel", stat="mean").values
    edges, diagonals = 110, 100
    expected = (edges * pull + edges + diagonals * np.sqrt((pull**2 + 1) / 2)) / (2 * edges + diagonals)
    np.testing.assert_allclose(mean, expected, rtol=1e-5)


def test_threads_count_before_what_is_drawn(small, measure):
    points, faces = sheet(3, 3, 0.1)
    grow = np.linspace(1, 1.5, 11)[:, None, None]
    small.add_soft("towel", points * grow, surface=points, kind="cloth", solver="pbd",
                   faces=faces, edges=np.array([[0, 1]]))  # fmt: skip
    np.testing.assert_allclose(
        measure(small, {"towel": CLOTH}, kind="stretch", of="towel").values, grow[:, 0, 0], rtol=1e-5
    )


def test_the_99th_percentile_leaves_out_one_in_a_hundred(small, measure):
    points, _ = sheet(101, 2, 0.1)
    pairs = np.array([[2 * i, 2 * i + 2] for i in range(100)])
    moved = np.tile(points, (11, 1, 1))
    moved[5:, -2:, 0] += 0.1  # the last edge twice as long
    moved[7:, 2:, 0] += 0.1  # and the first
    small.add_soft("towel", moved, kind="cloth", solver="pbd", edges=pairs)
    values = measure(small, {"towel": CLOTH}, kind="stretch", of="towel", stat="p99").values
    np.testing.assert_allclose(values, [1] * 7 + [2] * 4, rtol=1e-4)


# --- cloth on itself -----------------------------------------------------------------


def folded(angle, n=41, step=0.025):
    """A sheet whose right half is turned up about its middle by angles (F,), a thickness above where it lies double."""
    points, faces = sheet(n, n, step)
    right = points[:, 0] > 1e-9
    moved = np.tile(points, (len(angle), 1, 1))
    moved[:, right, 0] = points[right, 0] * np.cos(angle)[:, None]
    moved[:, right, 2] = points[right, 0] * np.sin(angle)[:, None] + 0.02 * (1 - np.cos(angle))[:, None] / 2
    return moved, faces


def test_a_folded_sheet_hides_half_of_itself(small, measure):
    angle = np.linspace(0, np.pi, 11)
    moved, faces = folded(angle)
    small.add_soft("towel", moved, surface=moved, kind="cloth", solver="pbd", spacing=0.025, faces=faces)
    folder, bodies = small.write(), {"towel": CLOTH}
    values = measure(folder, bodies, kind="folded_area", of="towel").values
    # Beyond a right angle it hides what its shadow covers: half the area times the cosine.
    expected = np.where(angle > np.pi / 2, -np.cos(angle) / 2, 0.0)
    np.testing.assert_allclose(values, expected, atol=0.02)
    np.testing.assert_array_equal(values[:5], 0)
    np.testing.assert_allclose(measure(folder, bodies, kind="folded_area", of="towel", axis="y").values, 0, atol=0.01)


def test_what_has_flown_apart_has_no_shadow(small, measure):
    points, faces = sheet(5, 5, 0.1)
    moved = np.tile(points, (11, 1, 1))
    moved[5] *= 1e7
    moved[6, 3] = np.nan
    small.add_soft("towel", moved, surface=moved, kind="cloth", solver="pbd", faces=faces)
    values = measure(small, {"towel": CLOTH}, kind="folded_area", of="towel").values
    assert np.isnan(values[5:7]).all()
    np.testing.assert_array_equal(values[[0, 4, 7, 10]], 0)


def test_self_penetration_is_how_much_nearer_than_its_thickness(small, measure):
    points, faces = sheet(21, 3, 0.05)
    up = np.where(points[:, 0] > 0, 1.0, 0.0)
    height = np.linspace(0.2, 0.02, 11)
    moved = np.stack([np.where(up, -points[:, 0], points[:, 0]), points[:, 1], 0 * up], 1) + np.zeros((11, 1, 1))
    moved[:, :, 2] = up * height[:, None]
    small.add_soft("towel", moved, kind="cloth", solver="pbd", spacing=0.05, faces=faces)
    values = measure(small, {"towel": CLOTH}, kind="self_penetration", of="towel").values
    np.testing.assert_allclose(values, np.maximum(0.05 - height, 0), atol=1e-6)


# --- gaps ----------------------------------------------------------------------------


@pytest.fixture
def over_box(new_run):
    """A sheet that comes down on a box of half a metre, turned by 30 degrees, to 1 cm above it and then into it."""
    run = new_run(duration=0.1)
    half = np.pi / 12
    run.add_link("floor", fixed=True)
    run.add_link("block", fixed=True, pos=(0, 0, 0.25), quat=(np.cos(half), 0, 0, np.sin(half)))
    run.add_box(1, (0.25, 0.25, 0.25))
    points, faces = sheet(9, 9, 0.1)
    height = np.linspace(0.51, 0.49, 11)
    run.add_soft("towel", points + np.stack([0 * height, 0 * height, height], 1)[:, None], kind="cloth", solver="pbd",
                 spacing=0.02, faces=faces)  # fmt: skip
    return run, height


def test_the_gap_to_a_box_and_to_the_floor(over_box, measure):
    run, height = over_box
    folder, bodies, statics = run.write(), {"towel": CLOTH}, ("floor",)
    bodies["block"] = {"kind": "rigid", "shape": {"kind": "box", "size": [0.5] * 3}, "mount": {"kind": "fixed"}}
    values = measure(folder, bodies, statics, kind="gap", of="towel", to="block").values
    np.testing.assert_allclose(values, height - 0.5, atol=1e-6)
    np.testing.assert_allclose(measure(folder, bodies, statics, kind="gap", of="block", to="towel").values, values)
    np.testing.assert_allclose(measure(folder, bodies, kind="gap", of="towel", to="floor").values, height, atol=1e-6)
    for kind in ({"of": "towel"}, {"of": "towel", "by": "block"}, {"of": "block", "by": "towel"}, {"of": "block"}):
        depth = measure(folder, bodies, kind="penetration", **kind).values
        np.testing.assert_allclose(depth, np.maximum(0.5 - height, 0), atol=1e-6)
    np.testing.assert_array_equal(measure(folder, bodies, kind="penetration", of="towel", by="floor").values, 0)


def test_rods_that_bodies_do_not_feel_are_not_in_their_way(over_box, measure):
    run, _ = over_box
    block = {"kind": "rigid", "shape": {"kind": "box", "size": [0.5] * 3}, "material": {"touch_soft": False}}
    bodies = {"towel": CLOTH, "block": block}
    folder = run.write()
    np.testing.assert_array_equal(measure(folder, bodies, kind="penetration", of="towel").values, 0)
    assert measure(folder, bodies, kind="gap", of="towel", to="block").values.min() < -0.009


def test_the_gap_between_bodies_that_deform(small, measure):
    apart = np.linspace(0.5, 0.1, 11)
    cube = lattice(3, 0.1)
    small.add_soft("jelly[0]", cube)
    small.add_soft("jelly[1]", cube + np.stack([0.2 + apart, 0 * apart, 0 * apart], 1)[:, None])
    folder = small.write()
    bodies = {"jelly": SOFT | {"repeat": {"kind": "line", "count": 2, "step": [1, 0, 0]}}}
    for of, to in (("jelly[0]", "jelly[1]"), ("jelly[1]", "jelly[0]"), ("jelly", "jelly")):
        np.testing.assert_allclose(measure(folder, bodies, kind="gap", of=of, to=to).values, apart, atol=1e-6)


def test_a_ball_in_the_middle_of_a_large_triangle_is_near(small, measure):
    corners = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [1, 1, -1.0]])
    small.add_soft("jelly", corners, solver="fem", faces=np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    small.add_link("ball", pos=(1, 1, 0.3))
    small.add_box(1, (0.1, 0.1, 0.1))
    bodies = {"jelly": SOFT, "ball": {"kind": "rigid", "shape": {"kind": "box", "size": [0.2] * 3}}}
    np.testing.assert_allclose(measure(small, bodies, kind="gap", of="jelly", to="ball").values, 0.2, atol=1e-6)


def test_two_rigid_bodies_have_a_distance_not_a_gap(small, measure):
    small.add_link("ball")
    assert "distance" in measure(small, {"ball": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 1}}},
                                 kind="gap", of="ball", to="floor").problem  # fmt: skip


# --- the measures of every body ------------------------------------------------------


@pytest.fixture
def fall(new_run):
    """Two kilograms in 27 points falling from ten metres, one point as heavy as all the others together."""
    run = new_run()
    t = run.time
    down = np.outer(np.ones_like(t), [0.0, 0.0, 1.0])
    run.add_link("floor", fixed=True, mass=1e9)
    masses = np.full(27, 1 / 26)
    masses[0] = 1.0
    cube = lattice(3, 0.1) + [0.1, 0.1, 0.1]
    run.add_soft("jelly", cube + (down * (10 - G / 2 * t**2)[:, None])[:, None], mass=2.0, masses=masses, spacing=0.09,
                 vel=down * (-G * t)[:, None], kinetic=(G * t) ** 2, speed=G * t)  # fmt: skip
    return run


CENTRE = 1.35 / 26
"""Each coordinate of the centre of mass of `fall` within the body: half of all lies in 26 points about 0.1."""


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        ({"kind": "position", "of": "jelly", "axis": "z"}, lambda t: 10 + CENTRE - G / 2 * t**2),
        ({"kind": "velocity", "of": "jelly", "axis": "z"}, lambda t: -G * t),
        ({"kind": "speed", "of": "jelly"}, lambda t: G * t),
        ({"kind": "displacement", "of": "jelly"}, lambda t: G / 2 * t**2),
        ({"kind": "extent", "of": "jelly", "axis": "z", "stat": "max"}, lambda t: 10.2 - G / 2 * t**2),
        ({"kind": "extent", "of": "jelly", "axis": "x", "stat": "range"}, lambda t: 0.2 + 0 * t),
        (
            {"kind": "extent", "of": "jelly", "axis": "z", "stat": "max", "frame": "floor"},
            lambda t: 10.2 - G / 2 * t**2,
        ),
        (
            {"kind": "extent", "of": "jelly", "axis": "z", "stat": "max", "region": {"face": "bottom"}},
            lambda t: 10 - G / 2 * t**2,
        ),
        ({"kind": "energy", "part": "kinetic"}, lambda t: (G * t) ** 2),
        ({"kind": "energy", "part": "potential"}, lambda t: 2 * G * (10 + CENTRE - G / 2 * t**2)),
        ({"kind": "energy", "of": "jelly"}, lambda t: 2 * G * (10 + CENTRE) + 0 * t),
        ({"kind": "momentum", "axis": "z"}, lambda t: -2 * G * t),
        ({"kind": "gap", "of": "jelly", "to": "floor"}, lambda t: 10 - G / 2 * t**2),
        ({"kind": "position", "of": "jelly", "axis": "z", "region": {"face": "top"}}, lambda t: 10.2 - G / 2 * t**2),
        (
            {"kind": "position", "of": "jelly", "axis": "x", "region": {"corner": ["left", "front", "top"]}},
            lambda t: 0 * t,
        ),
        (
            {"kind": "displacement", "of": "jelly", "axis": "z", "region": {"nearest": [0, 0, 1]}},
            lambda t: -G / 2 * t**2,
        ),
    ],
)
def test_free_fall(fall, measure, wanted, expected):
    values = measure(fall, **wanted).values
    np.testing.assert_allclose(values, expected(fall.time), rtol=1e-5, atol=1e-5)


def test_the_velocity_of_a_region_is_that_of_its_middle(fall, measure):
    values = measure(fall, kind="velocity", of="jelly", axis="z", region={"face": "top"}).values
    np.testing.assert_allclose(values[1:-1], -G * fall.time[1:-1], atol=0.01)


def test_regions_are_said_in_the_body_s_own_frame(small, measure):
    half = np.pi / 4  # turned by 90 degrees about z: its left is the world's front
    cube = lattice(3, 0.1)
    small.add_soft("jelly", cube + [5, 6, 7], spacing=0.09, pos=(5, 6, 7), quat=(np.cos(half), 0, 0, np.sin(half)))
    folder = small.write()
    where = {"kind": "position", "of": "jelly"}
    assert measure(folder, **where, axis="y", region={"face": "left"}).values[0] == pytest.approx(5.9)
    assert measure(folder, **where, axis="x", region={"box": {"min": [-9, -9, -9], "max": [9, -0.05, 9]}}).values[
        0
    ] == (pytest.approx(5.1))
    assert measure(folder, **where, axis="z", region={"sphere": {"center": [0, 0, 0.1], "radius": 0.01}}).values[0] == (
        pytest.approx(7.1)
    )
    assert "no" in measure(folder, **where, axis="z", region={"box": {"min": [1, 1, 1], "max": [2, 2, 2]}}).problem


def test_a_share_of_the_mass_in_a_region(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    grains = np.zeros((11, 10, 3))
    for frame in range(11):
        grains[frame, :frame, 2] = -1  # one more has fallen through in each frame
    run.add_soft("sand", grains, kind="granular")
    region = {"kind": "box", "min": [-1, -1, -2], "max": [1, 1, -0.5]}
    values = measure(run, {"sand": SAND}, kind="share_in", of="sand", region=region).values
    np.testing.assert_allclose(values, np.arange(11) / 10)


def test_a_region_goes_and_turns_with_what_carries_it(new_run, measure):
    """A tray goes along x and turns by 180 degrees; what lies on it stays in its region, what stands beside does not."""
    run = new_run()
    t, along = run.time, np.array([1.0, 0, 0])
    tray = np.outer(2 * t, along)
    turned = np.column_stack([np.cos(np.pi * t), np.sin(np.pi * t), 0 * t])
    run.add_link("tray", pos=tray, quat=np.column_stack([np.cos(np.pi * t / 2), 0 * t, 0 * t, np.sin(np.pi * t / 2)]))
    run.add_link("brick[0]", pos=tray + 0.5 * turned)
    run.add_link("brick[1]", pos=0.5 * along)
    run.add_soft("sand", (tray + 0.5 * turned)[:, None] + np.array([[0.0, 0, 0], [0, 9, 0]]), kind="granular")
    folder, rigid = run.write(), {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}
    bodies = {"tray": rigid, "brick": rigid, "sand": SAND}
    region = {"kind": "box", "min": [0.4, -0.1, -1], "max": [0.6, 0.1, 1], "moves_with": "tray"}
    inside = measure(folder, bodies, kind="count_in", of="brick", region=region).values
    assert inside[0] == 2
    assert (inside[20:] == 1).all()
    assert np.allclose(measure(folder, bodies, kind="share_in", of="sand", region=region).values, 0.5)
    still = {key: value for key, value in region.items() if key != "moves_with"}
    assert measure(folder, bodies, kind="count_in", of="brick", region=still).values[-1] == 1, "the one beside"


def test_copies_of_bodies_that_deform(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    for i in range(3):
        run.add_soft(f"jelly[{i}]", lattice(2, 0.1) + [0, 0, float(i)], vel=(i, 0, 0))
    folder = run.write()
    bodies = {"jelly": SOFT | {"repeat": {"kind": "line", "count": 3, "step": [0, 0, 1]}}}
    assert measure(folder, bodies, kind="position", of="jelly[1:3]", axis="z", stat="mean").values[0] == pytest.approx(
        1.5
    )
    assert measure(folder, bodies, kind="speed", of="jelly[*]", stat="sum").values[0] == pytest.approx(3)
    assert measure(folder, bodies, kind="distance", between=["jelly[0]", "jelly[2]"]).values[0] == pytest.approx(2)
    region = {"kind": "box", "min": [-1, -1, 0.5], "max": [1, 1, 9]}
    assert measure(folder, bodies, kind="count_in", of="jelly", region=region).values[0] == 2
    assert "4 copies" not in measure(folder, bodies, kind="speed", of="jelly[3]").problem
    assert "has 3 copies" in measure(folder, bodies, kind="speed", of="jelly[3]").problem


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ({"kind": "tilt", "of": "jelly"}, "deforms"),
        ({"kind": "angular_speed", "of": "jelly"}, "deforms"),
        ({"kind": "contact_force", "of": "jelly"}, "gap"),
        ({"kind": "contact_count", "of": "floor", "by": "jelly"}, "gap"),
        ({"kind": "strain", "of": "floor"}, "does not deform"),
        ({"kind": "speed", "of": "jelly.leg"}, "no links"),
        ({"kind": "joint_position", "of": "jelly"}, "no joints"),
        ({"kind": "position", "of": "floor", "axis": "z", "region": {"face": "top"}}, "region"),
    ],
)
def test_measures_that_a_body_has_not(fall, measure, wanted, said):
    assert said in measure(fall, **wanted).problem


def test_a_body_that_became_no_number_does_not_stop_anything(small, measure):
    points = np.tile(lattice(4, 0.1), (11, 1, 1))
    points[5:] = np.nan
    small.add_soft("jelly", points, tets=tets(4), solver="fem")
    folder = small.write()
    for kind in ("strain", "volume", "gap"):
        extra = {"to": "floor"} if kind == "gap" else {}
        values = measure(folder, kind=kind, of="jelly", **extra).values
        assert np.isfinite(values[:5]).all()
        assert not np.isfinite(values[5:]).any()


# --- how a cloth is bent ---------------------------------------------------------------


def rolled(points, radius):
    """Points (n, 3) of a flat sheet, laid on cylinders of radii (F,) about the y axis."""
    angle = points[:, 0] / radius[:, None]
    y = np.broadcast_to(points[:, 1], angle.shape)
    return np.stack([radius[:, None] * np.sin(angle), y, radius[:, None] * (1 - np.cos(angle))], -1)


@pytest.mark.parametrize("way", [0.0, 30.0, 45.0, 135.0])
def test_a_rolled_sheet_is_curved_as_its_radius_says(small, measure, way):
    points, faces = sheet(31, 21, 0.02)
    around = np.radians(way)
    turned = points @ np.array([[np.cos(around), np.sin(around), 0], [-np.sin(around), np.cos(around), 0], [0, 0, 1]])
    radius = np.linspace(0.3, 2.0, 11)
    small.add_soft("towel", rolled(turned, radius), kind="cloth", solver="pbd", spacing=0.02, point_faces=faces)
    found = measure(small, {"towel": CLOTH}, kind="wrinkling", of="towel")
    # A chord is shorter than its arc: (w / R)^2 / 24 for edges of length w.
    np.testing.assert_allclose(found.values, 1 / radius, rtol=2e-3)
    assert found.unit == "1/m"


def test_waves_of_a_sheet(small, measure):
    points, faces = sheet(121, 11, 0.01)
    height, length = np.linspace(0, 0.004, 11), 0.2
    waves = np.repeat(points[None], 11, axis=0)
    waves[..., 2] = height[:, None] * np.sin(2 * np.pi * points[:, 0] / length)
    small.add_soft("towel", waves, kind="cloth", solver="pbd", spacing=0.01, point_faces=faces)
    found = measure(small, {"towel": CLOTH}, kind="wrinkling", of="towel").values
    # The slope goes up and down by 4 atan(2 pi a / l) in one wave of length l: 8 pi a / l^2, for small slopes.
    np.testing.assert_allclose(found, 8 * np.pi * height / length**2, rtol=0.02, atol=1e-4)
