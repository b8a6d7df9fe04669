"""What looks wrong in a run: of bodies that deform, of driven ones, of energy."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from text2sim.evidence.evidence import judge
from text2sim.evidence.suspicions import suspicions
from text2sim.spec_schema.load import load_text


def recording(path: list[float], solver: str = "mpm") -> Any:
    """A body that deforms, in a space of 1 m, and a ball that goes along x."""
    soft = SimpleNamespace(body="gel[1]", solver=solver, spacing=0.01, domain=((-1.0, -1, -1), (1.0, 1, 1)))
    places = np.zeros((len(path), 1, 3))
    places[:, 0, 0] = path
    states = SimpleNamespace(deformables=[soft], frames=len(path), pos=places, time=0.1 * np.arange(len(path)))
    names = SimpleNamespace(loose=[SimpleNamespace(soft=None, copy="ball", root=0)], touches_soft=lambda name: True)
    return SimpleNamespace(states=states, names=names)


def row(**values: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": "soft", "solver": "mpm", "every": 1}
    return {
        "gel": found | {key: {"value": v, "at": 0.25, "copy": "gel[1]", "in": "plate"} for key, v in values.items()}
    }


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"volume": 0.3}, "0.3 times the volume"),
        ({"inverted": 0.2}, "20 % of its tetrahedra"),
        ({"penetration": 0.03}, "30 mm deep in `plate`"),
        ({"torn": 0.3}, "is torn (up to 30 % of it were off the largest piece)"),
        ({"against_bounds": 0.05}, "5 % of its points at the walls of the space of mpm"),
    ],
)
def test_what_is_wrong_is_said_of_a_copy_and_a_time(values: dict[str, float], said: str) -> None:
    (words,) = suspicions(recording([0.0, 0.5]), row(**values))
    assert said in words
    assert words.startswith("`gel[1]`")
    assert words.endswith("at 0.25 s")


def test_an_ordinary_run_is_not_suspicious() -> None:
    usual = row(volume=0.85, inverted=0.0, penetration=0.02, against_bounds=0.001, stretch=2.0)
    assert suspicions(recording([0.0, 0.5]), usual) == []
    assert suspicions(recording([0.0]), {"gel": row(torn=0.3)["gel"] | {"tears": True}}) == [], "as its material is"
    assert suspicions(recording([3.0, 3.5]), {}) == [], "what never was in the grid did not leave it"


def test_a_rigid_body_that_leaves_the_grid_is_named() -> None:
    (words,) = suspicions(recording([0.0, 0.9, 1.1]), {})
    assert words == "`ball` leaves the grid of mpm, and touches nothing in it any more, at 0.2 s"


def test_a_driven_body_that_is_held_up_is_suspicious(new_run, make_case):
    """A sled is sent 1 m down within 1 s and stays at 0.4 m; a wheel turns at its 2 rad/s, another sticks after 0.5 s."""
    run = new_run(duration=1.0)
    t = run.time
    u = t * t * (3 - 2 * t)
    half = 0.5 * 2.0 * np.stack([t, np.minimum(t, 0.5)])
    quats = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)
    run.add_link("sled", pos=np.outer(np.maximum(-u, -0.4), [0, 0, 1]))
    run.add_link("wheel[0]", quat=quats[0])
    run.add_link("wheel[1]", quat=quats[1])
    down = {"kind": "waypoints", "times": [0, 1], "positions": [[0, 0, 0], [0, 0, -1]]}
    spin = {"kind": "spin", "speed": 2.0}
    sphere = {"kind": "sphere", "radius": 0.1}
    bodies = {
        "sled": {"kind": "driven", "shape": sphere, "motion": down},
        "wheel": {"kind": "driven", "shape": sphere, "motion": spin},
    }
    found = judge(run.write(), make_case(bodies=bodies))
    sled, wheel = found["off_path"]
    assert (sled["copy"], sled["unit"], sled["at"], sled["value"]) == ("sled", "m", 1.0, pytest.approx(0.6, abs=1e-5))
    assert (wheel["copy"], wheel["unit"], wheel["at"]) == ("wheel[1]", "rad", 1.0)
    assert wheel["value"] == pytest.approx(1.0, abs=1e-5)
    assert [row.partition(":")[0] for row in found["suspicions"]] == [
        "`sled` is 600 mm off its prescribed path at 1 s",
        "`wheel[1]` is 1 rad off its prescribed path at 1 s",
    ]
    run.columns[0]["links_pos"] = np.outer(-u, [0, 0, 1])
    run.columns[2]["links_quat"] = quats[0]
    assert judge(run.write(), make_case(bodies=bodies))["suspicions"] == []


CHEEKS = """
text2sim: 2
name: cheeks
scene: {duration: 1}
bodies:
  cheek:
    kind: driven
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    motion: {kind: waypoints, times: [0, 1], positions: [[0, 0, 0], ["${0.1 - 0.2 * i}", 0, 0]]}
    repeat: {kind: line, count: 2, step: [1, 0, 0]}
"""


def test_each_copy_of_a_driven_body_has_a_path_of_its_own(new_run):
    run = new_run(duration=1.0)
    u = run.time**2 * (3 - 2 * run.time)
    run.add_link("cheek[0]", pos=np.outer(0.1 * u, [1, 0, 0]))
    run.add_link("cheek[1]", pos=np.outer(np.maximum(-0.1 * u, -0.06), [1, 0, 0]))
    loaded = load_text(CHEEKS)
    (cheek,) = judge(run.write(), loaded.case, loaded)["off_path"]
    assert (cheek["copy"], cheek["at"], cheek["value"]) == ("cheek[1]", 1.0, pytest.approx(0.04, abs=1e-5))


@pytest.mark.parametrize(
    ("mount", "gain", "said"),
    [
        ({"kind": "slider", "axis": "x"}, 0.2, True),
        ({"kind": "slider", "axis": "x"}, 0.02, False),  # of integrating along joints
        ({"kind": "slider", "axis": "x", "spring": 5}, 0.2, False),
        ({"kind": "slider", "axis": "x", "actuator": {"stiffness": 5}}, 0.2, False),
    ],
)
def test_joints_without_motor_and_spring_are_passive(new_run, make_case, mount, gain, said):
    run = new_run(duration=1.0)
    speed = np.where(run.time >= 0.5, 2 * np.sqrt(1 + gain), 2.0)
    run.add_link("ball", mass=1.0, vel=np.outer(speed, [1, 0, 0]))
    body = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}, "mount": mount}
    found = judge(run.write(), make_case(bodies={"ball": body}))["suspicions"]
    assert [row[:12] for row in found if "energy" in row] == ["energy grows"] * said


@pytest.mark.parametrize(("gain", "pushed", "said"), [(0.02, False, True), (0.005, False, False), (0.02, True, False)])
def test_a_passive_scene_that_gains_energy_is_suspicious(new_run, make_case, gain, pushed, said):
    """A ball flies at 2 m/s at one height, and its kinetic energy grows from 0.5 s on."""
    run = new_run(duration=1.0)
    speed = np.where(run.time >= 0.5, 2 * np.sqrt(1 + gain), 2.0)
    run.add_link("ball", mass=1.0, vel=np.outer(speed, [1, 0, 0]))
    push = {"push": {"kind": "force", "body": "ball", "force": [1, 0, 0]}}
    start = {"start": {"kind": "initial_velocity", "body": "ball", "linear": [2, 0, 0]}}
    found = judge(run.write(), make_case(controls=push if pushed else start))["suspicions"]
    assert [row[:20] for row in found] == (["energy grows by 2 % "] if said else [])
