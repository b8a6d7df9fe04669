"""Motors at their limit: which are reported, which fail, and what excuses them."""

import numpy as np
import pytest

from text2sim.evidence.evidence import judge

HINGE = {"kind": "hinge", "axis": [0, 1, 0], "actuator": {"stiffness": 100, "max_force": 5}}
SLIDER = {"kind": "slider", "axis": [1, 0, 0], "actuator": {"stiffness": 100, "max_force": 5}}
BOX = {"kind": "box", "size": [0.1, 0.1, 0.1]}
RAMP = {"kind": "ramp", "to": 1.0, "start": 0.2, "end": 0.6}


def rigid(mount=None):
    return {"kind": "rigid", "shape": BOX} | ({"mount": mount} if mount else {})


def arm(run, q, force, *, kind="hinge", dq=0.0, limits=(None, None), max_force: float | None = 5.0, fixed=True):
    """A base, and an arm on a joint about y (a hinge at 1 m height) or along x (a slider)."""
    base = run.add_link("arm", link="base", fixed=fixed)
    link = run.add_link("arm", link="upper", pos=(0, 0, 1))
    run.add_joint("arm", "upper", kind, q=q, dq=dq, force=force, limits=limits, link=link)
    run.links[link]["parent"] = base
    axis = [0.0, 1.0, 0.0] if kind == "hinge" else [1.0, 0.0, 0.0]
    run.joints[-1] |= {"max_force": [max_force], "axis": axis, "anchor": [0.0, 0.0, 1.0]}
    return link


def case_of(make_case, mount=HINGE, bodies=("ball",), file=None, **drives):
    links = {"base": {"shape": BOX}, "upper": {"parent": "base", "shape": BOX, "joint": mount}}
    body = {"kind": "articulated", "file": file} if file else {"kind": "articulated", "links": links}
    controls = {name: {"kind": "drive", "joint": "arm.upper", **drive} for name, drive in drives.items()}
    others = {name: rigid() for name in bodies}
    return make_case(bodies={"arm": body, **others}, controls=controls)


def told(run, case):
    found = judge(run.write(), case)
    return found["motors_at_limit"], [row for row in found["suspicions"] if row.startswith("motor")]


def test_a_motor_that_sinks_under_its_load_is_suspicious(new_run, make_case):
    """It is at its limit from 0.3 s on, and 1.2 rad below its target of 1 rad at the end."""
    run = new_run()
    arm(run, q=np.where(run.time > 0.3, -0.2, 0.0), force=np.where(run.time > 0.3, 5.0, 1.0))
    (row,), (words,) = told(run, case_of(make_case, lift={"position": RAMP}))
    assert (row["joint"], row["control"], row["max_force"]) == ("arm.upper", "lift", 5.0)
    assert (row["share"], row["off"], row["failed"]) == (pytest.approx(0.7), pytest.approx(1.2, abs=1e-6), True)
    assert words.startswith(
        "motor `arm.upper` works at its max_force of 5 N m for 70% of the time from 0 to 1 s (`lift`), 1.2 rad from "
        "its target at the end"
    )


@pytest.mark.parametrize(
    ("q", "force", "reported"),
    [
        (1.0, 5.0, True),  # at its limit and on its target
        (0.5, 4.9, False),  # off its target, but not at its limit
        (0.91, 5.0, True),  # within the tolerance of 0.1 rad
        (1.3, 5.0, True),  # beyond its target: what it does is not too little
    ],
)
def test_a_motor_that_reaches_its_target_is_not(new_run, make_case, q, force, reported):
    run = new_run()
    arm(run, q=q, force=force)
    rows, words = told(run, case_of(make_case, lift={"position": RAMP}))
    assert [row["failed"] for row in rows] == [False] * reported
    assert not words


def test_what_counts_is_the_end_of_each_drive(new_run, make_case):
    """The first drive ends 1 rad short, the second brings the target to where the joint is."""
    run = new_run()
    arm(run, q=0.0, force=np.where(run.time <= 0.5, 5.0, 0.5))
    down = {"kind": "ramp", "to": 0.0, "start": 0.5, "end": 0.6}
    up = {"kind": "ramp", "to": 1.0, "start": 0.0, "end": 0.4}
    (row,), (words,) = told(run, case_of(make_case, up={"position": up}, down={"position": down}))
    assert (row["control"], row["end"], row["off"]) == ("up", 0.5, pytest.approx(1.0))
    assert "(`up`)" in words


def test_a_short_effort_is_not_reported(new_run, make_case):
    run = new_run()
    arm(run, q=1.0, force=np.where(run.time < 0.1, 5.0, 0.5))
    assert told(run, case_of(make_case, lift={"position": RAMP})) == ([], [])


@pytest.mark.parametrize(("speed", "failed"), [(1.0, True), (1.85, False), (2.5, False)])
def test_a_velocity_motor_fails_below_its_speed(new_run, make_case, speed, failed):
    run = new_run()
    arm(run, q=speed * run.time, dq=speed, force=5.0)
    mount = HINGE | {"actuator": {"damping": 10, "max_force": 5}}
    (row,), words = told(run, case_of(make_case, mount, spin={"velocity": 2.0}))
    assert (row["failed"], row["unit"]) == (failed, "rad/s")
    assert row["off"] == pytest.approx(abs(2.0 - speed), abs=1e-6)
    assert bool(words) == failed


def test_a_drive_that_waits_for_an_event_counts_from_it(new_run, make_case):
    """At 0.4 s the ball comes into reach; the target is 1 rad from there on."""
    run = new_run()
    arm(run, q=0.0, force=np.where(run.time > 0.45, 5.0, 0.0))
    run.add_link("ball", pos=np.outer(1.0 - run.time, [1, 0, 0]))
    case = case_of(make_case, lift={"position": {"kind": "ramp", "to": 1.0, "end": 0.1}, "on": "near"})
    data = case.model_dump(mode="json", exclude_unset=True, by_alias=True)
    data["actions"]["measures"] = {"x": {"kind": "position", "of": "ball", "axis": "x"}}
    data["actions"]["events"] = {"near": {"kind": "threshold", "measure": "x", "below": 0.6}}
    (row,), words = told(run, type(case).model_validate(data))
    assert row["start"] == pytest.approx(0.0)
    assert row["off"] == pytest.approx(1.0)
    assert words


def test_no_limit_and_old_recordings_tell_nothing(new_run, make_case):
    run = new_run()
    arm(run, q=0.0, force=5.0, max_force=None)
    assert told(run, case_of(make_case, lift={"position": RAMP})) == ([], [])
    for key in ("max_force", "axis", "anchor"):
        del run.joints[-1][key]
    assert told(run, case_of(make_case, lift={"position": RAMP})) == ([], [])


def test_the_stop_of_a_joint_excuses_its_motor(new_run, make_case):
    run = new_run()
    arm(run, q=0.5, force=5.0, limits=(-0.5, 0.5))
    (row,), words = told(run, case_of(make_case, lift={"position": RAMP}))
    assert (row["failed"], words) == (False, [])
    run.joints[-1]["limits"] = [[0.5, 2.0]]  # it has sunk onto the lower one
    assert told(run, case_of(make_case, lift={"position": RAMP}))[1]


@pytest.mark.parametrize(
    ("held_by", "pressed", "excused"),
    [
        ("floor", 5.0, True),  # squeezed against something fixed
        ("base", 5.0, True),  # or against another finger
        (None, 5.0, False),  # it only rests on the finger: a load
        ("floor", -5.0, False),  # it is pulled, not held back
        ("floor", 0.5, False),  # the contact takes a tenth of the motor's force
    ],
)
def test_a_gripper_that_has_closed_is_meant_so(new_run, make_case, held_by, pressed, excused):
    """A finger pushes a ball along x with 5 N; the ball pushes back."""
    run = new_run()
    floor = run.add_link("floor", fixed=True)
    finger = arm(run, q=0.0, force=5.0, kind="slider")
    ball = run.add_link("ball", pos=(0.1, 0, 1))
    run.add_joint("ball", "ball", "free", link=ball)
    run.touch(finger, ball, run.step[1:], (pressed, 0, 0))
    if held_by is not None:
        run.touch({"floor": floor, "base": finger - 1}[held_by], ball, run.step[1:], (-pressed, 0, 0))
    (row,), words = told(run, case_of(make_case, SLIDER, close={"position": 0.3}))
    assert (row["failed"], bool(words)) == (not excused, not excused)
    assert row["unit"] == "m"


def test_a_torque_of_contacts_is_taken_about_the_hinge(new_run, make_case):
    """An arm of 0.4 m about +y presses down on the ground, 2 N m of its 5; a push beside that along y has no torque."""
    run = new_run()
    floor = run.add_link("floor", fixed=True)
    upper = arm(run, q=0.0, force=5.0)
    run.touch(floor, upper, run.step[1:], (0, 0, 5.0), pos=(0.4, 0, 1))
    assert not told(run, case_of(make_case, lift={"position": RAMP}))[1]
    run.contacts.clear()
    run.touch(floor, upper, run.step[1:], (0, 5.0, 0), pos=(0.4, 0, 1))
    assert told(run, case_of(make_case, lift={"position": RAMP}))[1]


def test_the_ground_does_not_excuse_what_stands_on_it(new_run, make_case):
    """The leg of a robot that is loose presses on the ground with what it can, and the robot sinks."""
    run = new_run()
    floor = run.add_link("floor", fixed=True)
    upper = arm(run, q=0.0, force=5.0, fixed=False)
    run.add_joint("arm", "root", "free", link=upper - 1)
    run.touch(floor, upper, run.step[1:], (0, 0, 20.0), pos=(0.4, 0, 1))
    assert told(run, case_of(make_case, stand={"position": RAMP}))[1]


def test_a_reach_takes_over_from_a_drive_and_has_no_known_target(new_run, make_case):
    run = new_run()
    arm(run, q=0.0, force=np.where(run.time > 0.5, 5.0, 0.0))
    case = case_of(make_case, hold={"position": 1.0})
    reach = {"kind": "reach", "body": "arm.upper", "start": 0.5, "times": [0.8], "positions": [[0, 0, 2]]}
    data = case.model_dump(mode="json", exclude_unset=True, by_alias=True)
    data["actions"]["controls"]["go"] = reach
    rows, words = told(run, type(case).model_validate(data))
    assert [(row["control"], row["share"], row["off"], row["failed"]) for row in rows] == [("go", 1.0, None, False)]
    assert not words


@pytest.mark.parametrize(("held", "excused"), [(True, True), (False, False)])
def test_of_a_linkage_fingers_beyond_other_joints_count(new_run, make_case, held, excused):
    """The ball touches a finger on a branch of its own, which loops may couple to the motor, and the floor or nothing."""
    run = new_run()
    floor = run.add_link("floor", fixed=True)
    upper = arm(run, q=0.0, force=5.0)
    finger = run.add_link("arm", link="finger", pos=(0.2, 0, 1))
    run.links[finger]["parent"] = upper - 1
    ball = run.add_link("ball", pos=(0.3, 0, 1))
    run.add_joint("ball", "ball", "free", link=ball)
    run.touch(finger, ball, run.step[1:], (3.0, 0, 0))
    if held:
        run.touch(floor, ball, run.step[1:], (-3.0, 0, 0))
    case = case_of(make_case, file="hand.xml", close={"position": 1.0})
    (row,), _ = told(run, case)
    assert row["failed"] == (not excused)
    assert told(run, case_of(make_case, close={"position": 1.0}))[1], "an open tree has no such fingers"
