"""Measures of bodies that deform, against shapes and motions whose every number is known."""

import numpy as np
import pytest
from soft_shapes import CLOTH, SOFT, lattice, sheet, tets

G = 9.81
SAND = {"kind": "granular", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}


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


def test_the_gap_to_a_box_and_to_the_floor(over_box, measure_soft):
    run, height = over_box
    folder, bodies, statics = run.write(), {"towel": CLOTH}, ("floor",)
    bodies["block"] = {"kind": "rigid", "shape": {"kind": "box", "size": [0.5] * 3}, "mount": {"kind": "fixed"}}
    values = measure_soft(folder, bodies, statics, kind="gap", of="towel", to="block").values
    np.testing.assert_allclose(values, height - 0.5, atol=1e-6)
    np.testing.assert_allclose(measure_soft(folder, bodies, statics, kind="gap", of="block", to="towel").values, values)
    np.testing.assert_allclose(
        measure_soft(folder, bodies, kind="gap", of="towel", to="floor").values, height, atol=1e-6
    )
    for kind in ({"of": "towel"}, {"of": "towel", "by": "block"}, {"of": "block", "by": "towel"}, {"of": "block"}):
        depth = measure_soft(folder, bodies, kind="penetration", **kind).values
        np.testing.assert_allclose(depth, np.maximum(0.5 - height, 0), atol=1e-6)
    np.testing.assert_array_equal(measure_soft(folder, bodies, kind="penetration", of="towel", by="floor").values, 0)


def test_the_depth_of_a_list_is_that_of_what_deforms_and_of_what_does_not(over_box, measure_soft):
    run, height = over_box
    run.touch(0, 1, [3], (0, 0, 1.0), depth=0.004)  # the block in the floor
    folder, both = run.write(), ["towel", "block"]
    bodies = {"towel": CLOTH, "block": {"kind": "rigid", "shape": {"kind": "box", "size": [0.5] * 3}}}
    inside = np.maximum(0.5 - height, 0)
    pressed = np.where(run.step == 3, 0.004, 0)
    for asked, depth in (
        ({"of": both}, np.maximum(inside, pressed)),
        ({"of": both, "by": "floor"}, pressed),
        ({"of": "block", "by": ["floor", "towel"]}, np.maximum(inside, pressed)),
        ({"of": ["towel"], "by": ["block", "floor"]}, inside),
    ):
        values = measure_soft(folder, bodies, kind="penetration", **asked).values
        np.testing.assert_allclose(values, depth, atol=1e-6)


def test_rods_that_bodies_do_not_feel_are_not_in_their_way(over_box, measure_soft):
    run, _ = over_box
    block = {"kind": "rigid", "shape": {"kind": "box", "size": [0.5] * 3}, "material": {"touch_soft": False}}
    bodies = {"towel": CLOTH, "block": block}
    folder = run.write()
    np.testing.assert_array_equal(measure_soft(folder, bodies, kind="penetration", of="towel").values, 0)
    assert measure_soft(folder, bodies, kind="gap", of="towel", to="block").values.min() < -0.009


def test_the_gap_between_bodies_that_deform(soft_run, measure_soft):
    apart = np.linspace(0.5, 0.1, 11)
    cube = lattice(3, 0.1)
    soft_run.add_soft("jelly[0]", cube)
    soft_run.add_soft("jelly[1]", cube + np.stack([0.2 + apart, 0 * apart, 0 * apart], 1)[:, None])
    folder = soft_run.write()
    bodies = {"jelly": SOFT | {"repeat": {"kind": "line", "count": 2, "step": [1, 0, 0]}}}
    for of, to in (("jelly[0]", "jelly[1]"), ("jelly[1]", "jelly[0]"), ("jelly", "jelly")):
        np.testing.assert_allclose(measure_soft(folder, bodies, kind="gap", of=of, to=to).values, apart, atol=1e-6)


def test_a_ball_in_the_middle_of_a_large_triangle_is_near(soft_run, measure_soft):
    corners = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [1, 1, -1.0]])
    soft_run.add_soft("jelly", corners, solver="fem", faces=np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    soft_run.add_link("ball", pos=(1, 1, 0.3))
    soft_run.add_box(1, (0.1, 0.1, 0.1))
    bodies = {"jelly": SOFT, "ball": {"kind": "rigid", "shape": {"kind": "box", "size": [0.2] * 3}}}
    np.testing.assert_allclose(measure_soft(soft_run, bodies, kind="gap", of="jelly", to="ball").values, 0.2, atol=1e-6)


def test_two_rigid_bodies_have_a_distance_not_a_gap(soft_run, measure_soft):
    soft_run.add_link("ball")
    assert "distance" in measure_soft(soft_run, {"ball": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 1}}},
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
def test_free_fall(fall, measure_soft, wanted, expected):
    values = measure_soft(fall, **wanted).values
    np.testing.assert_allclose(values, expected(fall.time), rtol=1e-5, atol=1e-5)


def test_the_velocity_of_a_region_is_that_of_its_middle(fall, measure_soft):
    values = measure_soft(fall, kind="velocity", of="jelly", axis="z", region={"face": "top"}).values
    np.testing.assert_allclose(values[1:-1], -G * fall.time[1:-1], atol=0.01)


def test_regions_are_said_in_the_body_s_own_frame(soft_run, measure_soft):
    half = np.pi / 4  # turned by 90 degrees about z: its left is the world's front
    cube = lattice(3, 0.1)
    soft_run.add_soft("jelly", cube + [5, 6, 7], spacing=0.09, pos=(5, 6, 7), quat=(np.cos(half), 0, 0, np.sin(half)))
    folder = soft_run.write()
    where = {"kind": "position", "of": "jelly"}
    assert measure_soft(folder, **where, axis="y", region={"face": "left"}).values[0] == pytest.approx(5.9)
    assert measure_soft(folder, **where, axis="x", region={"box": {"min": [-9, -9, -9], "max": [9, -0.05, 9]}}).values[
        0
    ] == (pytest.approx(5.1))
    assert measure_soft(folder, **where, axis="z", region={"sphere": {"center": [0, 0, 0.1], "radius": 0.01}}).values[
        0
    ] == (pytest.approx(7.1))
    assert "no" in measure_soft(folder, **where, axis="z", region={"box": {"min": [1, 1, 1], "max": [2, 2, 2]}}).problem


def test_a_share_of_the_mass_in_a_region(new_run, measure_soft):
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    grains = np.zeros((11, 10, 3))
    for frame in range(11):
        grains[frame, :frame, 2] = -1  # one more has fallen through in each frame
    run.add_soft("sand", grains, kind="granular")
    region = {"kind": "box", "min": [-1, -1, -2], "max": [1, 1, -0.5]}
    values = measure_soft(run, {"sand": SAND}, kind="share_in", of="sand", region=region).values
    np.testing.assert_allclose(values, np.arange(11) / 10)


def test_chunks_of_snow_are_pieces(soft_run, measure_soft):
    """A block of 4 x 4 x 4 particles loses a quarter, which flies off at 10 m/s: apart after two cells, 2 / 0.64 spacings."""
    block = lattice(4, 0.1)
    off = (block[:, 0] == block[:, 0].max()).astype(float)
    points = block + np.einsum("f,p,x->fpx", 10.0 * soft_run.time, off, [1.0, 0, 0])
    soft_run.add_soft("snow", points, kind="snow")
    bodies = {"snow": {"kind": "snow", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}}
    folder = soft_run.write()
    apart = 0.1 + 10.0 * soft_run.time > 2 / 0.64 * 0.1 + 1e-6
    counts, largest = (measure_soft(folder, bodies, kind=kind, of="snow") for kind in ("pieces", "largest_piece"))
    assert (counts.problem, largest.problem) == ("", "")
    np.testing.assert_array_equal(counts.values, 1.0 + apart)
    np.testing.assert_allclose(largest.values, 1.0 - 0.25 * apart)
    assert 0 < apart.sum() < len(apart)


def test_a_list_of_bodies_that_deform(soft_run, measure_soft):
    """A cube of 0.2 m and one of 0.4 m, 1 and 3 kg, with 0.5 m between them and 0.1 m below the first."""
    small, large = lattice(3, 0.1), lattice(3, 0.2)
    soft_run.add_soft("small", small + [0, 0, 0.2], tets=tets(3), spacing=0.09, mass=1.0, vel=(2.0, 0, 0))
    soft_run.add_soft("large", large + [0.8, 0, 0.5], tets=tets(3), spacing=0.19, mass=3.0)
    soft_run.add_soft("sand", small + [0.8, 2, 0.5], kind="granular", mass=4.0)
    bodies = {"small": SOFT, "large": SOFT, "sand": SAND}
    folder, both = soft_run.write(), {"of": ["small", "large"]}
    region = {"kind": "box", "min": [0.5, -1, 0], "max": [2, 1, 2]}
    for wanted, value in (
        ({"kind": "volume"} | both, 0.2**3 + 0.4**3),
        ({"kind": "volume", "relative": True} | both, 1.0),
        ({"kind": "share_in", "region": region} | both, 3 / 4),
        ({"kind": "share_in", "region": region, "of": ["small", "large", "sand"]}, 3 / 8),
        ({"kind": "momentum", "axis": "x"} | both, 2.0),
        ({"kind": "position", "axis": "z", "region": {"face": "bottom"}, "stat": "min"} | both, 0.1),
        ({"kind": "strain"} | both, 0.0),
        ({"kind": "gap", "to": "floor"} | both, 0.1),
        ({"kind": "gap", "of": "floor", "to": ["large", "small"]}, 0.1),
        ({"kind": "gap", "of": "small", "to": ["sand", "large"]}, 0.5),
    ):
        series = measure_soft(folder, bodies, **wanted)
        assert (series.problem, series.values[0]) == ("", pytest.approx(value, abs=1e-5)), wanted
    assert "floor does not deform" in measure_soft(folder, bodies, kind="volume", of=["small", "floor"]).problem


def test_a_region_goes_and_turns_with_what_carries_it(new_run, measure_soft):
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
    inside = measure_soft(folder, bodies, kind="count_in", of="brick", region=region).values
    assert inside[0] == 2
    assert (inside[20:] == 1).all()
    assert np.allclose(measure_soft(folder, bodies, kind="share_in", of="sand", region=region).values, 0.5)
    still = {key: value for key, value in region.items() if key != "moves_with"}
    assert measure_soft(folder, bodies, kind="count_in", of="brick", region=still).values[-1] == 1, "the one beside"


def test_copies_of_bodies_that_deform(new_run, measure_soft):
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    for i in range(3):
        run.add_soft(f"jelly[{i}]", lattice(2, 0.1) + [0, 0, float(i)], vel=(i, 0, 0))
    folder = run.write()
    bodies = {"jelly": SOFT | {"repeat": {"kind": "line", "count": 3, "step": [0, 0, 1]}}}
    assert measure_soft(folder, bodies, kind="position", of="jelly[1:3]", axis="z", stat="mean").values[
        0
    ] == pytest.approx(1.5)
    assert measure_soft(folder, bodies, kind="speed", of="jelly[*]", stat="sum").values[0] == pytest.approx(3)
    assert measure_soft(folder, bodies, kind="distance", between=["jelly[0]", "jelly[2]"]).values[0] == pytest.approx(2)
    region = {"kind": "box", "min": [-1, -1, 0.5], "max": [1, 1, 9]}
    assert measure_soft(folder, bodies, kind="count_in", of="jelly", region=region).values[0] == 2
    assert "4 copies" not in measure_soft(folder, bodies, kind="speed", of="jelly[3]").problem
    assert "has 3 copies" in measure_soft(folder, bodies, kind="speed", of="jelly[3]").problem


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
def test_measures_that_a_body_has_not(fall, measure_soft, wanted, said):
    assert said in measure_soft(fall, **wanted).problem


def test_a_body_that_became_no_number_does_not_stop_anything(soft_run, measure_soft):
    points = np.tile(lattice(4, 0.1), (11, 1, 1))
    points[5:] = np.nan
    soft_run.add_soft("jelly", points, tets=tets(4), solver="fem")
    folder = soft_run.write()
    for kind in ("strain", "volume", "gap"):
        extra = {"to": "floor"} if kind == "gap" else {}
        values = measure_soft(folder, kind=kind, of="jelly", **extra).values
        assert np.isfinite(values[:5]).all()
        assert not np.isfinite(values[5:]).any()
