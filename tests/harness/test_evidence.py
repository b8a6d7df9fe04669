"""Evidence: what is written of a run, however the run went."""

import json

import numpy as np
import pytest

from text2sim.evidence import evidence as module
from text2sim.evidence.evidence import judge
from text2sim.recording.record import RunRecord

G = 9.81


def strict(text: str):
    """Parse JSON as the standard has it."""

    def refuse(name: str):
        raise AssertionError(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture
def drop(new_run):
    """A ball falls from 1 m, touches the floor at 0.45 s, and lies there; a motor turns a drum."""
    run = new_run()
    t = run.time
    landed = t >= 0.45
    z = np.where(landed, 0.1, 1.1 - G / 2 * t**2)
    v = np.where(landed, 0, -G * t)
    up = np.array([0.0, 0.0, 1.0])
    floor = run.add_link("floor", fixed=True, mass=1e9)
    ball = run.add_link("ball", mass=2.0, pos=np.outer(z, up), vel=np.outer(v, up))
    run.add_link("drum", mass=1.0)
    run.add_joint("drum", "drum", "hinge", q=2.1 * t, dq=2.0, force=3.0, limits=(-1.0, 2.0))
    run.touch(floor, ball, range(45, 46), (0, 0, 880.0), depth=0.004)
    run.touch(floor, ball, range(46, 101), (0, 0, 2 * G), depth=0.001)
    return run


ACTIONS = {
    "measures": {
        "height": {"kind": "position", "of": "ball", "axis": "z"},
        "speed": {"kind": "speed", "of": "ball"},
    },
    "events": {
        "landing": {"kind": "contact", "between": ["ball", "floor"]},
        "rest": {"kind": "rest", "of": "ball"},
    },
    "expect": {
        "lands": {"event": "landing", "within": [0.4, 0.5]},
        "stays": {"measure": "height", "during": [0.5, 1.0], "equals": 0.1, "tolerance": 0.01},
    },
}


@pytest.fixture
def case(make_case):
    return make_case(bodies=("ball", "drum"), **ACTIONS)


def test_the_speed_of_a_mechanism_is_that_of_its_fastest_link(new_run, make_case):
    """Not of its centre of mass: a drawer is faster than its cabinet and it together."""
    run = new_run(duration=0.1)
    run.add_link("cabinet", link="case", mass=6.0)
    run.add_link("cabinet", link="drawer", mass=2.0, vel=(0, 0.5, 0), ang=(0, 0, 3.0))
    found = judge(run.write(), make_case(bodies=("cabinet",)))["speeds"]["cabinet"]
    assert found["linear"]["max"] == pytest.approx(0.5)
    assert found["angular"]["max"] == pytest.approx(3.0)


def test_a_run_that_is_as_expected_passes(drop, case):
    folder = drop.write()
    found = judge(folder, case)
    assert (found["verdict"], found["why"]) == ("passed", "all 2 expectations came true")
    assert found["expect"]["lands"]["value"] == pytest.approx(0.45)
    assert found["measures"]["height"]["first"] == pytest.approx(1.1)
    assert (found["measures"]["speed"]["max"], found["measures"]["speed"]["max_at"]) == (
        pytest.approx(0.44 * G, rel=1e-5),
        pytest.approx(0.44),
    )
    energy = found["energy"]
    assert energy["start"] == pytest.approx(2 * G * 1.1, rel=1e-5)
    assert energy["work_of_motors"] == pytest.approx(6.0)
    assert energy["change"] == pytest.approx(-2 * G * 1.0 - 6.0, rel=1e-5)
    assert energy["not_counted"] == []
    assert found["penetration"] == {
        "value": pytest.approx(0.004),
        "unit": "m",
        "between": ["floor", "ball"],
        "time": pytest.approx(0.45),
    }
    assert found["speeds"]["ball"]["linear"]["max"] == pytest.approx(0.44 * G, rel=1e-5)
    assert "floor" not in found["speeds"]
    assert found["joint_limits"] == [
        {
            "joint": "drum",
            "end": "upper",
            "limit": 2.0,
            "by": pytest.approx(0.1, abs=1e-6),
            "at": 1.0,
            "unit": "rad",
        }
    ]
    assert (found["driven"], found["non_finite"], found["left_out"], found["visibility"]) == (
        [],
        None,
        [],
        None,
    )


def test_the_files_are_strict_and_say_the_same(drop, case):
    folder = drop.write()
    found = judge(folder, case)
    assert strict((folder / "evidence.json").read_text()) == found
    lines = [strict(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    assert [(row["name"], row["kind"]) for row in lines] == [
        ("rest", "rest"),
        (None, "contact"),
        ("landing", "contact"),
    ]
    assert [row["time"] for row in lines] == sorted(row["time"] for row in lines)
    rows = (folder / "measures.csv").read_text().splitlines()
    assert rows[0] == "time,height,speed"
    assert len(rows) == 102
    assert [float(x) for x in rows[1].split(",")] == [0.0, pytest.approx(1.1), 0.0]


def test_judging_again_gives_the_same_bytes(drop, case):
    folder = drop.write()
    names = ("evidence.json", "events.jsonl", "measures.csv")
    judge(folder, case)
    before = {name: (folder / name).read_bytes() for name in names}
    judge(folder, case)
    assert {name: (folder / name).read_bytes() for name in names} == before


def test_editing_an_expectation_judges_anew_without_a_run(drop, make_case, case):
    folder = drop.write()
    judge(folder, case)
    other = make_case(
        bodies=("ball", "drum"),
        **(ACTIONS | {"expect": {"flies": {"measure": "height", "at": "end", "above": 5}}}),
    )
    found = judge(folder, other)
    assert found["verdict"] == "failed"
    assert found["expect"]["flies"] == {
        "name": "flies",
        "ok": False,
        "value": pytest.approx(0.1),
        "unit": "m",
        "wanted": "`height` above 5 m at the end",
        "why": "0.1 m at 1 s",
        "at": pytest.approx(1.0),
    }


def test_a_finding_says_when_it_was_decided(drop, make_case):
    folder = drop.write()
    rows = {
        "lands": {"event": "landing", "within": [0.4, 0.5]},
        "late": {"measure": "height", "at": 0.3, "above": 0.1},
        "fastest": {"measure": "speed", "during": "all", "stat": "max", "above": 1},
        "stays": {"measure": "height", "during": [0.2, 1.0], "below": 2},
        "usual": {"measure": "height", "during": "all", "stat": "mean", "above": 0},
        "falls": {"measure": "height", "during": "all", "stat": "range", "above": 0},
    }
    found = judge(folder, make_case(bodies=("ball", "drum"), **(ACTIONS | {"expect": rows})))["expect"]
    assert found["fastest"]["why"].endswith(" at 0.44 s")
    decided = {name: row["at"] for name, row in found.items()}
    assert decided == {
        "lands": pytest.approx(0.45), "late": pytest.approx(0.3), "fastest": pytest.approx(0.44),
        "stays": pytest.approx(0.2), "usual": None, "falls": pytest.approx(0.45),
    }  # fmt: skip


def test_a_diverged_run_fails_and_names_the_body(drop, case):
    drop.columns[1]["links_pos"][30:] = np.nan
    folder = drop.write(
        state="diverged",
        upto=40,
        message="diverged at t = 0.4 s",
        where={"body": "ball", "quantity": "speed"},
    )
    found = judge(folder, case)
    assert found["verdict"] == "failed"
    assert found["why"].startswith("the run did not finish (diverged at t = 0.4 s); ")
    assert found["non_finite"] == {"time": pytest.approx(0.3), "frame": 30, "bodies": ["ball"]}
    assert found["where"] == {"body": "ball", "quantity": "speed"}
    assert found["expect"]["lands"]["ok"] is False
    assert "not reached" in found["expect"]["lands"]["why"]
    strict((folder / "evidence.json").read_text())


def test_a_stopped_run_is_incomplete(drop, case):
    found = judge(drop.write(state="interrupted", upto=30), case)
    assert found["verdict"] == "incomplete"
    assert {row["ok"] for row in found["expect"].values()} == {None}


def test_the_record_knows_better_than_the_program_how_it_ended(drop, case):
    folder = drop.write(state="interrupted", upto=30)
    RunRecord(case="case", state="timeout", key={}, message="it took longer than 5 s").write(folder)
    found = judge(folder, case)
    assert (found["verdict"], found["state"], found["message"]) == (
        "failed",
        "timeout",
        "it took longer than 5 s",
    )
    assert {row["ok"] for row in found["expect"].values()} == {False}


def test_a_damaged_last_chunk_is_said(drop, case):
    folder = drop.write()
    last = folder / "states" / "chunk_00002.npz"
    last.write_bytes(last.read_bytes()[:50])
    found = judge(folder, case)
    assert "chunk_00002.npz" in found["left_out"][0]
    assert found["time"]["reached"] == pytest.approx(0.79)


def test_without_frames_and_without_measures_there_is_still_evidence(new_run, make_case):
    run = new_run()
    run.add_link("ball")
    run.add_joint("ball", "ball", "hinge", limits=(0, 1))
    folder = run.write(upto=0, state="failed", message="the engine refused")
    found = judge(folder, make_case(**ACTIONS))
    assert (found["verdict"], found["time"]["frames"]) == ("failed", 0)
    assert (folder / "measures.csv").read_text() == "time,height,speed\n"
    strict((folder / "evidence.json").read_text())
    whole = judge(folder, make_case())
    assert whole["measures"] == {}
    assert (folder / "measures.csv").read_text() == "time\n"


EVERY_MEASURE = {
    "a": {"kind": "position", "of": "ball", "axis": "z"},
    "b": {"kind": "velocity", "of": "ball", "axis": "z"},
    "c": {"kind": "angular_speed", "of": "ball"},
    "d": {"kind": "displacement", "of": "ball"},
    "e": {"kind": "tilt", "of": "ball"},
    "f": {"kind": "joint_position", "of": "drum"},
    "g": {"kind": "joint_force", "of": "drum"},
    "h": {"kind": "extent", "of": "ball", "axis": "z", "stat": "range"},
    "i": {"kind": "distance", "between": ["ball", "drum"]},
    "j": {"kind": "contact_force", "of": "ball"},
    "k": {"kind": "contact_count", "of": "ball"},
    "l": {"kind": "penetration", "of": "ball"},
    "m": {"kind": "energy"},
    "n": {"kind": "momentum", "axis": "x"},
    "o": {"kind": "count_in", "of": "ball", "region": {"kind": "sphere", "center": [0, 0, 0], "radius": 9.0}},
}
EVERY_EVENT = {
    "a": {"kind": "contact", "between": ["ball", "floor"]},
    "b": {"kind": "separation", "between": ["ball", "floor"]},
    "c": {"kind": "threshold", "measure": "a", "above": 0.5},
    "d": {"kind": "rest", "of": "ball"},
    "e": {"kind": "left_domain", "of": "ball"},
    "f": {"kind": "enters", "of": "ball", "region": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}},
    "g": {"kind": "joint_limit", "of": "drum"},
}


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_nothing_needs_more_than_a_few_frames(drop, make_case, frames):
    scene = {"domain": {"min": [-5, -5, -5], "max": [5, 5, 5]}}
    case = make_case(bodies=("ball", "drum"), scene=scene, measures=EVERY_MEASURE, events=EVERY_EVENT)
    drop.add_box(1, (0.1, 0.1, 0.1))
    found = judge(drop.write(state="failed", upto=frames), case)
    assert [row["problem"] for row in (*found["measures"].values(), *found["events"].values()) if row["problem"]] == []
    assert all((row["first"] is None) == (frames == 0) for row in found["measures"].values())


def test_the_work_of_a_moving_surface_is_declared_and_its_energy_is_not_from_nowhere(new_run, make_case):
    run = new_run(duration=1.0)
    run.add_link("belt", mass=1.0, vel=(0.5, 0, 0))
    run.add_link("ball", mass=1.0, vel=np.outer(run.time, [1, 0, 0]))
    belt = {"shape": {"kind": "box", "size": [1, 1, 0.1]}}
    assert judge(run.write(), make_case(scene={"statics": {"belt": belt}}))["suspicions"]
    found = judge(run.write(), make_case(scene={"statics": {"belt": belt | {"surface_velocity": [0.5, 0, 0]}}}))
    assert found["energy"]["not_counted"] == ["work of the moving surface of `belt`"]
    assert found["suspicions"] == []
    assert found["driven"] == []
    assert [*found["speeds"]] == ["ball"]


def test_prescribed_motion_and_pushes_are_declared(new_run, make_case):
    run = new_run(duration=0.1)
    run.add_link("ball", mass=1.0)
    run.add_link("paddle", mass=100.0, pos=(0, 0, 7))
    sphere = {"kind": "sphere", "radius": 0.1}
    motion = {"kind": "spin", "speed": 1.0}
    bodies = {
        "ball": {"kind": "rigid", "shape": sphere},
        "paddle": {"kind": "driven", "shape": sphere, "motion": motion},
    }
    case = make_case(bodies=bodies, controls={"wind": {"kind": "force", "body": "ball", "force": [1, 0, 0]}})
    found = judge(run.write(), case)
    assert found["driven"] == ["paddle"]
    assert found["energy"]["start"] == 0.0
    assert found["energy"]["not_counted"] == ["work of the driven body `paddle`"]


def test_forces_and_torques_have_their_work(new_run, make_case):
    """A ball of 1 kg goes at v = t along x and spins at 2 rad/s about z: W = F (t1^2 - t0^2) / 2 and W = M w t."""
    run = new_run(duration=1.0)
    along = np.stack([run.time, 0 * run.time, 0 * run.time], axis=1)
    run.add_link("ball", mass=1.0, vel=along, ang=(0, 0, 2.0), pos=0.5 * along * run.time[:, None])
    case = make_case(
        bodies=("ball",),
        controls={
            "push": {"kind": "force", "body": "ball", "force": [3, 0, 0], "during": [0.205, 0.8]},
            "ramp": {"kind": "force", "body": "ball", "force": [0, 0, 1], "point": [0, 0.1, 0], "frame": "body"},
            "edge": {"kind": "force", "body": "ball", "force": [1, 0, 0], "point": [0, 0.1, 0], "during": [0, 0.5]},
            "spin": {"kind": "torque", "body": "ball", "torque": [0, 0, 0.1],
                     "scale": {"kind": "ramp", "from": 0, "to": 1, "end": 1, "ease": "linear"}},
            "blow": {"kind": "impulse", "body": "ball", "impulse": [0, 0, 1], "at": 0.1},
        },
    )  # fmt: skip
    energy = judge(run.write(), case)["energy"]
    assert energy["works"]["controls"] == {
        "push": pytest.approx(3 * (0.8**2 - 0.205**2) / 2, rel=1e-4),
        "ramp": pytest.approx(0.0),
        "edge": pytest.approx(0.5**2 / 2 - 2.0 * 0.1 * 0.5, rel=1e-3),  # v + w x r: the spin takes 0.2 m/s off
        "spin": pytest.approx(0.1 * 2.0 * 0.5, rel=1e-4),
    }
    assert energy["not_counted"] == ["work of the control `blow`"]
    gained = energy["end"] - energy["start"]
    assert energy["change"] == pytest.approx(gained - sum(energy["works"]["controls"].values()))


def test_work_on_a_body_ends_when_it_is_removed(new_run, make_case):
    run = new_run(duration=1.0)
    run.add_link("ball", mass=1.0, vel=(2, 0, 0))
    run.add_link("drum", mass=1.0)
    run.add_joint("drum", "drum", "hinge", q=2.0 * run.time, dq=2.0, force=3.0)
    folder = run.write()
    (folder / "states" / "removed.json").write_text('{"ball": 0.5, "drum": 0.25}')
    push = {"kind": "force", "body": "ball", "force": [3, 0, 0]}
    works = judge(folder, make_case(bodies=("ball", "drum"), controls={"push": push}))["energy"]["works"]
    assert works["controls"] == {"push": pytest.approx(3 * 2 * 0.5)}
    assert works["motors"] == {"drum": pytest.approx(3 * 2 * 0.25, rel=0.03)}


def test_visibility_adds_up_the_copies(drop, make_case):
    folder = drop.write()
    shares = [{"t": 0.0, "shares": {"ball": 0.1, "floor": 0.5}}, {"t": 0.5, "shares": {"ball": 0.3}}]
    (folder / "visibility.json").write_text(json.dumps({"main": shares}))
    seen = judge(folder, make_case(bodies=("ball", "drum")))["visibility"]["main"]
    assert seen == {
        "pictures": 2,
        "bodies": {"ball": {"largest": 0.3, "at": 0.5, "pictures": 2}},
        "never_seen": ["drum"],
    }


@pytest.fixture
def pile(new_run):
    """Sixty bricks: each touches the next, and each touches the floor the harder the higher its number."""
    run = new_run()
    floor = run.add_link("floor")
    bricks = [run.add_link(f"brick[{i}]") for i in range(60)]
    for i, brick in enumerate(bricks):
        run.touch(floor, brick, [10], (0, 0, i + 1.0))
        if i:
            run.touch(brick - 1, brick, [20], (0, 0, 100.0))
    return run.write()


def listed(folder) -> list[list[str]]:
    return [json.loads(line)["between"] for line in (folder / "events.jsonl").read_text().splitlines()]


def test_touches_within_a_repeated_body_are_counted_and_not_listed(pile, make_case):
    found = judge(pile, make_case(bodies=("brick",)))
    assert len(listed(pile)) == 60
    assert found["contacts"] == {
        "recorded": True,
        "rows": 119,
        "episodes": 119,
        "listed": 60,
        "left_out": 0,
        "within_repeated_bodies": 59,
    }
    assert "59 touches between copies" in found["left_out"][0]


def test_they_are_listed_where_the_case_watches_them(pile, make_case):
    case = make_case(bodies=("brick",), measures={"m": {"kind": "contact_force", "of": "brick[0]", "by": "brick"}})
    assert judge(pile, case)["contacts"]["within_repeated_bodies"] == 0
    assert len(listed(pile)) == 119


def test_above_the_limit_the_hardest_touches_are_listed(pile, make_case, monkeypatch):
    monkeypatch.setattr(module, "MAX_LISTED_EPISODES", 10)
    found = judge(pile, make_case(bodies=("brick",)))
    assert sorted(listed(pile)) == sorted(["floor", f"brick[{i}]"] for i in range(50, 60))
    assert found["contacts"]["left_out"] == 50
