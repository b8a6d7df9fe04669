"""Measures against motions whose every number is known."""

import numpy as np
import pytest

from text2sim.evidence.measures import _COLLECTIVE, _PER_TARGET
from text2sim.spec_schema.models.measures import Measure
from text2sim.spec_schema.published.language_reference import section_kinds

G = 9.81


def turn(angle, axis):
    """Quaternions (F, 4) of turns about a unit axis."""
    half = np.atleast_1d(angle) / 2
    return np.column_stack([np.cos(half), np.outer(np.sin(half), axis)])


@pytest.fixture
def fall(new_run):
    """Two kilograms falling from ten metres."""
    run = new_run()
    t = run.time
    down = np.outer(np.ones_like(t), [0.0, 0.0, 1.0])
    run.add_link("floor", fixed=True, mass=1e9)
    run.add_link("ball", mass=2.0, pos=down * (10 - G / 2 * t**2)[:, None], vel=down * (-G * t)[:, None])
    return run


@pytest.mark.parametrize(
    ("wanted", "unit", "expected"),
    [
        ({"kind": "position", "of": "ball", "axis": "z"}, "m", lambda t: 10 - G / 2 * t**2),
        ({"kind": "velocity", "of": "ball", "axis": "z"}, "m/s", lambda t: -G * t),
        ({"kind": "speed", "of": "ball"}, "m/s", lambda t: G * t),
        ({"kind": "displacement", "of": "ball"}, "m", lambda t: G / 2 * t**2),
        ({"kind": "displacement", "of": "ball", "axis": "z"}, "m", lambda t: -G / 2 * t**2),
        ({"kind": "energy", "part": "kinetic"}, "J", lambda t: (G * t) ** 2),
        ({"kind": "energy", "part": "potential"}, "J", lambda t: 2 * G * (10 - G / 2 * t**2)),
        ({"kind": "energy"}, "J", lambda t: 200 * G / 10 + 0 * t),
        ({"kind": "momentum", "axis": "z"}, "kg m/s", lambda t: -2 * G * t),
        ({"kind": "distance", "between": ["ball", "floor"]}, "m", lambda t: 10 - G / 2 * t**2),
        ({"kind": "tilt", "of": "ball"}, "deg", lambda t: 0 * t),
    ],
)
def test_free_fall(fall, measure, wanted, unit, expected):
    series = measure(fall, **wanted)
    assert series.unit == unit
    np.testing.assert_allclose(series.values, expected(fall.time), rtol=1e-6, atol=1e-5)


def test_a_body_whose_origin_is_not_its_centre_of_mass(new_run, measure):
    run = new_run()
    w = 3.0
    angle = w * run.time
    vel = np.column_stack([0 * angle, -np.sin(angle), np.cos(angle)]) * 0.5 * w
    run.add_link(
        "ball",
        mass=2.0,
        com=(0, 0.5, 0),
        quat=turn(angle, [1, 0, 0]),
        vel=vel,
        ang=(w, 0, 0),
        inertia=np.diag([0.3, 9, 9]),
    )
    folder = run.write()
    kinetic, potential = (measure(folder, kind="energy", part=part).values for part in ("kinetic", "potential"))
    np.testing.assert_allclose(kinetic, 0.5 * 2 * (0.5 * w) ** 2 + 0.5 * 0.3 * w**2, rtol=1e-5)
    np.testing.assert_allclose(potential, 2 * G * 0.5 * np.sin(angle), atol=1e-4)
    np.testing.assert_allclose(measure(folder, kind="angular_speed", of="ball").values, w, rtol=1e-6)


def test_the_inertia_turns_with_the_body(new_run, measure):
    run = new_run()
    # The body lies on its side, its z axis along x of the world: spinning about that has the small inertia.
    run.add_link("ball", quat=turn(np.pi / 2, [0, 1, 0]), ang=(4.0, 0, 0), inertia=np.diag([5, 5, 0.5]))
    np.testing.assert_allclose(measure(run, kind="energy", part="kinetic").values, 0.5 * 0.5 * 16, rtol=1e-5)


def test_tilt_is_exact_for_small_and_large_angles(new_run, measure):
    run = new_run()
    angle = np.linspace(0, np.pi, len(run.time))
    angle[1] = 1e-4
    run.add_link("ball", quat=turn(angle, [1, 0, 0]))
    folder = run.write()
    np.testing.assert_allclose(measure(folder, kind="tilt", of="ball").values, np.degrees(angle), rtol=2e-3, atol=1e-5)
    np.testing.assert_allclose(measure(folder, kind="tilt", of="ball", axis="x").values, 0, atol=1e-4)


@pytest.mark.parametrize(
    ("stat", "expected"),
    [("max", 3.0), ("min", 1.0), ("mean", 2.0), ("sum", 6.0), ("range", 2.0), ("std", (2 / 3) ** 0.5)],
)
def test_several_copies_become_one_number(new_run, measure, stat, expected):
    run = new_run(duration=0.1)
    for i in range(3):
        run.add_link(f"brick[{i}]", vel=(i + 1.0, 0, 0))
    series = measure(run, bodies=("brick",), kind="speed", of="brick", stat=stat)
    np.testing.assert_allclose(series.values, expected)


def test_counting_and_choosing_copies(new_run, measure):
    run = new_run(duration=0.1)
    for i in range(5):
        run.add_link(f"brick[{i}]", vel=(float(i), 0, 0), pos=(0, 0, float(i)))
    folder = run.write()
    of = {"bodies": ("brick",), "kind": "speed"}
    assert measure(folder, of="brick[*]", stat="count", above=1.0, **of).values[0] == 3
    assert measure(folder, of="brick", stat="count", above=1.0, below=4.0, **of).values[0] == 2
    assert measure(folder, of="brick[1:3]", stat="sum", **of).values[0] == 3
    assert measure(folder, of="brick[4]", **of).values[0] == 4
    assert measure(folder, of="brick", stat="count", above=1.0, **of).unit == ""
    assert "5 copies" in measure(folder, of="brick[7]", **of).problem
    assert "stat" in measure(folder, of="brick", **of).problem
    region = {"kind": "sphere", "center": [0, 0, 1], "radius": 1.0}
    assert measure(folder, bodies=("brick",), kind="count_in", of="brick", region=region).values[0] == 3


def test_joints(new_run, measure):
    run = new_run()
    run.add_link("drum")
    run.add_joint("drum", "drum", "hinge", q=2 * run.time, dq=2.0, force=-5.0)
    folder = run.write()
    of = {"bodies": ("drum",), "of": "drum"}
    position = measure(folder, kind="joint_position", **of)
    np.testing.assert_allclose(position.values, 2 * run.time, atol=1e-6)
    assert (position.unit, measure(folder, kind="joint_velocity", **of).values[3]) == ("rad", 2.0)
    force = measure(folder, kind="joint_force", **of)
    assert (force.unit, force.values[0]) == ("N m", -5.0)
    assert "no such joint" in measure(folder, bodies=("drum",), kind="joint_position", of="drum.hand").problem


def test_a_body_of_several_links_moves_as_its_common_centre(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("arm", link="world", mass=0.0, fixed=True)
    run.add_link("arm", link="upper", mass=1.0, vel=(4, 0, 0), pos=(1, 0, 0))
    run.add_link("arm", link="hand", mass=3.0, vel=(0, 0, 0), pos=(2, 0, 0))
    folder = run.write()
    assert measure(folder, bodies=("arm",), kind="speed", of="arm").values[0] == 1.0
    assert measure(folder, bodies=("arm",), kind="speed", of="arm.upper").values[0] == 4.0
    assert measure(folder, bodies=("arm",), kind="position", axis="x", of="arm").values[0] == 1.0
    assert "upper" in measure(folder, bodies=("arm",), kind="speed", of="arm.foot").problem


def test_extent_follows_a_turning_box(new_run, measure):
    run = new_run()
    angle = np.linspace(0, np.pi / 2, len(run.time))
    link = run.add_link("ball", quat=turn(angle, [0, 1, 0]), pos=np.outer(run.time, [0, 0, 1.0]))
    run.add_box(link, (0.3, 0.1, 0.1))
    folder = run.write()
    half = 0.3 * np.sin(angle) + 0.1 * np.cos(angle)
    for stat, expected in (("max", run.time + half), ("min", run.time - half), ("range", 2 * half)):
        np.testing.assert_allclose(
            measure(folder, kind="extent", of="ball", axis="z", stat=stat).values, expected, atol=1e-5
        )


def test_extent_in_the_frame_of_another_body_is_not_changed_by_its_turning(new_run, measure):
    run = new_run()
    angle = np.linspace(0, np.pi / 2, len(run.time))
    way = np.outer(run.time, [2.0, 0, 1.0])
    car = run.add_link("car", quat=turn(angle, [0, 1, 0]), pos=way)
    run.add_box(car, (0.3, 0.1, 0.1))
    # It rides 0.4 m above the car, as the car sees it: R(angle) (0, 0, 0.4) = 0.4 (sin, 0, cos).
    above = 0.4 * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    load = run.add_link("load", quat=turn(angle, [0, 1, 0]), pos=way + above)
    run.add_box(load, (0.05, 0.05, 0.05))
    folder = run.write()
    asked = {"bodies": ("car", "load"), "kind": "extent", "of": "load", "axis": "z"}
    for stat, expected in (("max", 0.45), ("min", 0.35), ("range", 0.1)):
        np.testing.assert_allclose(measure(folder, **asked, frame="car", stat=stat).values, expected, atol=1e-5)
    assert np.ptp(measure(folder, **asked, stat="range").values) > 0.03, "in the world it is that of a turning box"


def test_displacement_in_the_frame_of_another_body_is_what_moves_on_it(new_run, measure):
    run = new_run()
    angle = np.linspace(0, np.pi / 2, len(run.time))
    way = np.outer(run.time, [2.0, 0, 1.0])
    run.add_link("car", quat=turn(angle, [0, 1, 0]), pos=way)
    # It slides by 0.1 t along the x axis of the car, R(angle) (0.1 t, 0, 0) = 0.1 t (cos, 0, -sin).
    slide = 0.1 * run.time[:, None] * np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], axis=1)
    run.add_link("load", quat=turn(angle, [0, 1, 0]), pos=way + slide)
    folder = run.write()
    asked = {"bodies": ("car", "load"), "kind": "displacement", "of": "load", "frame": "car"}
    np.testing.assert_allclose(measure(folder, **asked).values, 0.1 * run.time, atol=1e-5)
    np.testing.assert_allclose(measure(folder, **asked, axis="x").values, 0.1 * run.time, atol=1e-5)
    np.testing.assert_allclose(measure(folder, **asked, axis="z").values, 0.0, atol=1e-5)


def test_extent_of_a_detailed_mesh_is_that_of_its_corners(new_run, measure):
    run = new_run(duration=0.2)
    rng = np.random.default_rng(1)
    corners = rng.normal(size=(500, 3))
    quat = turn(rng.uniform(0, 6, len(run.time)), [0.6, 0.0, 0.8])
    link = run.add_link("ball", quat=quat)
    run.add_mesh(link, "cloud", corners)
    from scipy.spatial.transform import Rotation

    turned = [Rotation.from_quat(q, scalar_first=True).apply(corners)[:, 1].max() for q in quat]
    np.testing.assert_allclose(measure(run, kind="extent", of="ball", axis="y", stat="max").values, turned, atol=1e-5)


def test_a_flat_mesh_has_an_extent_and_a_body_without_shape_has_none(new_run, measure):
    run = new_run(duration=0.1)
    link = run.add_link("ball")
    run.add_link("ghost")
    flat = np.column_stack([np.random.default_rng(0).uniform(-1, 1, (100, 2)), np.zeros(100)])
    run.add_mesh(link, "sheet", flat)
    folder = run.write()
    assert measure(folder, kind="extent", of="ball", axis="z", stat="range").values[0] == 0.0
    assert (
        "no recorded shape"
        in measure(folder, bodies=("ball", "ghost"), kind="extent", of="ghost", axis="z", stat="max").problem
    )


def test_a_mesh_cannot_name_a_file_elsewhere(new_run, measure):
    run = new_run(duration=0.1)
    link = run.add_link("ball")
    np.savez(run.folder / "secret.npz", vertices=np.ones((3, 3)))
    run.add_box(link, (1, 1, 1))
    run.geometry["0"] = [{"mesh": "../secret.npz"}]
    assert "no recorded shape" in measure(run, kind="extent", of="ball", axis="z", stat="max").problem


def test_all_bodies_are_those_that_move_freely(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("floor", mass=1e6, pos=(0, 0, 1.0))
    run.add_link("ball", mass=2.0, vel=(3, 0, 0))
    run.add_link("paddle", mass=50.0, vel=(1, 0, 0))
    sphere = {"kind": "sphere", "radius": 0.1}
    bodies = {
        "ball": {"kind": "rigid", "shape": sphere},
        "paddle": {
            "kind": "driven",
            "shape": sphere,
            "motion": {"kind": "oscillate", "amplitude": 1.0, "frequency": 1.0},
        },
    }
    folder = run.write()
    assert measure(folder, bodies=bodies, kind="momentum", axis="x").values[0] == 6.0
    assert measure(folder, bodies=bodies, kind="energy").values[0] == pytest.approx(9.0)
    assert measure(folder, bodies=bodies, kind="momentum", of="paddle", axis="x").values[0] == 50.0


def test_angular_velocity_has_a_sign_and_a_frame(new_run, measure):
    run = new_run()
    # It lies on its side, z of the body along x of the world, and spins backwards about that.
    run.add_link("ball", quat=turn(np.pi / 2, [0, 1, 0]), ang=(-4.0, 0, 0))
    folder = run.write()
    of = {"kind": "angular_velocity", "of": "ball"}
    np.testing.assert_allclose(measure(folder, axis="x", **of).values, -4.0, atol=1e-6)
    np.testing.assert_allclose(measure(folder, axis="z", frame="body", **of).values, -4.0, atol=1e-6)
    np.testing.assert_allclose(measure(folder, axis="x", frame="body", **of).values, 0.0, atol=1e-6)
    assert measure(folder, axis="x", **of).unit == "rad/s"


def test_turns_of_a_free_body_add_up(new_run, measure):
    run = new_run(duration=2.0)
    # w = 20 t makes w t / 2 pi = 10 t^2 / (2 pi) turns: 6.4 in all, and the orientation shows no more than a part of one.
    w = 20.0 * run.time
    run.add_link("ball", quat=turn(10 * run.time**2, [0, 0, 1]), ang=np.outer(w, [0, 0, 1.0]))
    turned = measure(run, kind="turns", of="ball", axis="z")
    np.testing.assert_allclose(turned.values, 10 * run.time**2 / (2 * np.pi), atol=1e-5)
    assert turned.unit == ""


def test_turns_are_those_of_the_poses_where_velocities_are_not(new_run, measure):
    """What squeezes a body may slow it at the end of each step; it spins fast enough for a turn between pictures, too."""
    run = new_run(duration=2.0)
    period = run.time[1] - run.time[0]
    for name, rate in (("slow", 3.0), ("fast", 0.9 * 2 * np.pi / period)):
        for axis, letter in (([0, 0, 1.0], "z"), ([0, 1.0, 0], "y")):
            quat = turn(rate * run.time, axis)
            run.add_link(f"{name}_{letter}", quat=quat, ang=np.outer(0.985 * rate * np.ones_like(run.time), axis))
    folder = run.write()
    for name, rate in (("slow", 3.0), ("fast", 0.9 * 2 * np.pi / period)):
        for letter in "zy":
            turned = measure(folder, kind="turns", of=f"{name}_{letter}", axis=letter, frame="body")
            np.testing.assert_allclose(turned.values, rate * run.time / (2 * np.pi), atol=1e-4)


def test_angular_momentum_of_a_dumbbell(new_run, measure):
    run = new_run()
    # Two masses at +-r about an axis through a centre that drifts: L = 2 m r^2 w about it, whatever the drift.
    w, r, m, drift = 3.0, 0.5, 2.0, np.array([1.0, 2.0, 0.0])
    angle = w * run.time
    arm = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) * r
    around = np.column_stack([-np.sin(angle), np.cos(angle), 0 * angle]) * r * w
    center = np.outer(run.time, drift) + [0, 1.0, 0]
    for name, sign in (("a", 1.0), ("b", -1.0)):
        run.add_link(name, mass=m, pos=center + sign * arm, vel=drift + sign * around, ang=(0, 0, w),
                     quat=turn(angle, [0, 0, 1]), inertia=np.diag([0.1, 0.2, 0.3]))  # fmt: skip
    folder = run.write()
    of = {"bodies": ("a", "b"), "kind": "angular_momentum", "axis": "z"}
    own = 2 * m * r**2 * w + 2 * 0.3 * w
    found = measure(folder, **of)
    np.testing.assert_allclose(found.values, own, rtol=1e-5)
    assert found.unit == "kg m2/s"
    # About the origin the drift counts as well: M (c x u), with c x u = -1 m^2/s here.
    np.testing.assert_allclose(measure(folder, about=[0, 0, 0], **of).values, own + 2 * m * -1.0, rtol=1e-5)


def test_angular_momentum_of_a_body_that_deforms(new_run, measure):
    run = new_run()
    # A block of 2 kg at x = 1 m that goes along y at 3 m/s and turns; a ball of 1 kg goes the other way twice as fast.
    center = np.column_stack([1 + 0 * run.time, 3 * run.time, 0 * run.time])
    corners = np.array([[-0.1, 0, 0], [0.1, 0, 0]])
    run.add_soft("gel", center[:, None] + corners, mass=2.0, vel=(0, 3, 0), spin=(0.1, 0.2, 0.7))
    run.add_link("ball", mass=1.0, pos=-2 * center, vel=(0, -6, 0), inertia=np.zeros((3, 3)))
    folder = run.write()
    of = {"kind": "angular_momentum", "axis": "z"}
    np.testing.assert_allclose(measure(folder, of="gel", **of).values, 0.7, rtol=1e-5)
    np.testing.assert_allclose(measure(folder, of="gel", about=[0, 0, 0], **of).values, 0.7 + 2 * 3, rtol=1e-5)
    # Their common centre of mass rests at the origin: m x v of both is 6 + 12.
    np.testing.assert_allclose(measure(folder, of=["gel", "ball"], **of).values, 0.7 + 6 + 12, rtol=1e-5)


def test_change_is_counted_from_the_start_or_a_time(fall, measure):
    folder = fall.write()
    of = {"kind": "position", "of": "ball", "axis": "z"}
    t = fall.time
    np.testing.assert_allclose(measure(folder, change_from="start", **of).values, -G / 2 * t**2, atol=1e-5)
    since = measure(folder, change_from=0.505, **of)  # between two frames, on a straight line
    np.testing.assert_allclose(since.values, -G / 2 * (t**2 - (0.5**2 + 0.51**2) / 2), atol=1e-5)
    assert since.unit == "m"
    assert "ended at 1 s" in measure(folder, change_from=2.0, **of).problem


def test_a_pattern_names_many_links(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("net", link="world", fixed=True)
    for name, speed in (("x1_0", 1.0), ("x1_1", 2.0), ("y1_0", 6.0)):
        run.add_link("net", link=name, vel=(speed, 0, 0), pos=(speed, 0, 0))
    folder = run.write()
    of = {"bodies": ("net",), "kind": "speed"}
    assert measure(folder, of="net.x1_*", stat="mean", **of).values[0] == 1.5
    assert measure(folder, of="net.*", stat="max", **of).values[0] == 6.0
    assert measure(folder, of="net.*_0", stat="count", above=0.5, **of).values[0] == 2
    assert "3 bodies" in measure(folder, of="net.*", **of).problem
    assert "no link `z*`" in measure(folder, of="net.z*", stat="max", **of).problem
    apart = measure(folder, bodies=("net",), kind="distance", between=["net.x1_0", "net.y*"])
    assert apart.values[0] == 5.0


def test_bend_of_hinges_and_balls(new_run, measure):
    run = new_run()
    run.add_link("arm", link="upper")
    run.add_link("arm", link="lower")
    run.add_joint("arm", "elbow", "hinge", q=0.5 - 2 * run.time, link=0)
    run.add_ball("arm", "wrist", turn(0.4 + run.time, [0.6, 0, 0.8]), link=1)
    folder = run.write()
    of = {"bodies": ("arm",), "kind": "bend"}
    np.testing.assert_allclose(measure(folder, of="arm.upper", **of).values, np.degrees(2 * run.time), atol=1e-4)
    np.testing.assert_allclose(measure(folder, of="arm.lower", **of).values, np.degrees(run.time), atol=1e-4)
    np.testing.assert_allclose(
        measure(folder, of="arm", stat="mean", **of).values, np.degrees(1.5 * run.time), atol=1e-4
    )
    assert "2 joints" in measure(folder, of="arm", **of).problem


def test_every_kind_has_its_function():
    others = {"joint_position", "joint_velocity", "joint_force", "bend", "difference", "ratio"}
    assert {*_PER_TARGET, *_COLLECTIVE, *others} ^ {*section_kinds(Measure)} == set()


def test_every_kind_answers_what_the_program_asks_of_it():
    assert {kind for kind, model in section_kinds(Measure).items() if hasattr(model, "traits")} == {
        *section_kinds(Measure)
    }
