"""Events of bodies that deform, read from how near they come."""

import numpy as np
import pytest
from soft_shapes import lattice, sheet

from text2sim.evidence.events import EventLog, find_events
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase

SOFT = {"kind": "soft", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}}
CLOTH = {"kind": "cloth", "shape": {"kind": "sheet", "size": [1.0, 1.0]}}
BLOCK = {"kind": "rigid", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}}


@pytest.fixture
def find(make_case):
    """Return a function that finds one event in a written run, and all there is to know of it."""

    def one(run, bodies=None, scene=None, measures=None, events=None, controls=None, **event) -> EventLog:
        case = make_case(bodies=bodies or {"jelly": SOFT}, scene=scene, measures=measures or {},
                         events={**(events or {}), "e": event}, controls=controls or {})  # fmt: skip
        recording = RecordedCase.load(run.write() if hasattr(run, "write") else run, case)
        return find_events(recording, evaluate(recording))

    return one


@pytest.fixture
def bouncing(new_run):
    """A cube of mpm (spacing 6.4 mm, so cells of 1 cm) that touches the floor from 0.3 s to 0.5 s and at the end."""
    run = new_run()
    run.add_link("floor", fixed=True)
    height = np.interp(run.time, [0, 0.3, 0.4, 0.5, 0.7, 0.9, 1.0], [0.1, 0.01, 0.004, 0.01, 0.1, 0.01, 0.005])
    up = np.outer(height + 0.1, [0, 0, 1])[:, None]
    run.add_soft("jelly", lattice(3, 0.1) + up, spacing=0.0064, mass=2.0)
    return run


def test_a_touch_begins_and_ends(bouncing, find):
    folder = bouncing.write()
    first, second = find(folder, kind="contact", between=["jelly", "floor"]).occurrences["e"]
    assert first["time"] == pytest.approx(0.3, abs=1e-3)
    # It is over once it is 1.5 cells away.
    assert first["end"] == pytest.approx(0.5 + 0.2 * 0.005 / 0.09, abs=1e-3)
    assert (first["between"], first["ongoing"], second["ongoing"]) == (["jelly", "floor"], False, True)
    assert first["gap"] == pytest.approx(0.004, abs=1e-6)
    assert first["penetration"] == 0
    assert first["pos"][2] == pytest.approx(0.01, abs=1e-3)
    (apart,) = find(folder, kind="separation", between=["floor", "jelly"]).occurrences["e"]
    assert apart["time"] == pytest.approx(first["end"])
    assert apart["between"] == ["floor", "jelly"]
    assert find(folder, kind="separation", between=["floor", "jelly"], **{"for": 0.6}).occurrences["e"] == []


def test_what_touches_from_the_start_touches(new_run, find):
    run = new_run()
    run.add_link("floor", fixed=True)
    run.add_soft("jelly", lattice(3, 0.1) + [0, 0, 0.095], spacing=0.0064)
    (row,) = find(run, kind="contact", between=["jelly", "floor"]).occurrences["e"]
    assert (row["time"], row["end"], row["ongoing"]) == (0.0, pytest.approx(1.0), True)
    assert row["penetration"] == pytest.approx(0.005)


@pytest.mark.parametrize(
    ("solver", "spacing", "near"),
    [("pbd", 0.02, 0.012), ("mpm", 0.0128, 0.02), ("fem", 0.01, 0.002), ("fem", 0.1, 0.005), ("ipc", 0.02, 0.002)],
)
def test_how_near_a_touch_is_depends_on_the_solver(new_run, find, solver, spacing, near):
    run = new_run()
    run.add_link("floor", fixed=True)
    height = np.linspace(0.05, 0.0, len(run.time))
    points, faces = sheet(3, 3, 0.1)
    run.add_soft("jelly", points + np.outer(height, [0, 0, 1])[:, None], solver=solver, spacing=spacing, faces=faces)
    (row,) = find(run, kind="contact", between=["jelly", "floor"]).occurrences["e"]
    assert row["time"] == pytest.approx(1 - near / 0.05, abs=1e-4)


def test_flicker_between_touching_and_nearly_so_is_one_touch(new_run, find):
    run = new_run()
    run.add_link("floor", fixed=True)
    height = 0.0121 + 0.0005 * np.sin(40 * run.time)
    run.add_soft("jelly", sheet(3, 3, 0.1)[0] + np.outer(height, [0, 0, 1])[:, None], solver="pbd", spacing=0.02)
    assert len(find(run, kind="contact", between=["jelly", "floor"]).occurrences["e"]) == 1


def test_bodies_that_deform_touch_each_other(new_run, find):
    run = new_run()
    apart = np.linspace(0.1, 0.0, len(run.time))
    cube = lattice(3, 0.1)
    run.add_soft("jelly[0]", cube, spacing=0.0064)
    run.add_soft("jelly[1]", cube + np.outer(apart + 0.2, [1, 0, 0])[:, None], spacing=0.0064)
    run.add_soft("jelly[2]", cube + [0, 5, 0], spacing=0.0064)
    bodies = {"jelly": SOFT | {"repeat": {"kind": "line", "count": 3, "step": [1, 0, 0]}}}
    (row,) = find(run, bodies, kind="contact", between=["jelly", "jelly"]).occurrences["e"]
    assert row["between"] == ["jelly[0]", "jelly[1]"]
    assert row["time"] == pytest.approx(0.8, abs=1e-3)  # two cells apart


def test_a_sheet_on_one_of_several_blocks(new_run, find):
    run = new_run()
    run.add_link("block[0]", pos=(0, 0, 0.2))
    run.add_link("block[1]", pos=(3, 0, 0.2))
    for link in (0, 1):
        run.add_box(link, (0.2, 0.2, 0.2))
    height = np.linspace(0.6, 0.41, len(run.time))
    run.add_soft("towel", sheet(11, 11, 0.1)[0] + np.outer(height, [0, 0, 1])[:, None], kind="cloth", solver="pbd",
                 spacing=0.02)  # fmt: skip
    bodies = {"towel": CLOTH, "block": BLOCK | {"repeat": {"kind": "line", "count": 2, "step": [3, 0, 0]}}}
    folder = run.write()
    (row,) = find(folder, bodies, kind="contact", between=["block[*]", "towel"]).occurrences["e"]
    assert row["between"] == ["block[0]", "towel"]
    assert np.interp(row["time"], run.time, height) == pytest.approx(0.412, abs=1e-4)
    assert find(folder, bodies, kind="contact", between=["block[1]", "towel"]).occurrences["e"] == []


@pytest.mark.parametrize(
    ("one", "other", "near"),
    [
        ("liquid", None, 0.01),  # mpm, spacing 6.4 mm: a cell of 1 cm
        ("granular", None, 0.01),
        ("liquid", "soft", 0.02),
        ("liquid", "cloth", 0.01 + 0.012),  # pbd, spacing 2 cm
        ("cloth", "cloth", 0.024),
        ("cloth", "soft", 0.012 + 0.01),
    ],
)
def test_all_kinds_of_bodies_touch(new_run, find, one, other, near):
    run, bodies = new_run(), {}
    height = np.outer(np.linspace(0.1, 0.0, len(run.time)), [0, 0, 1])[:, None]
    for name, kind, rise in (("upper", one, height), ("lower", other, 0 * height)):
        if kind is None:
            run.add_link("lower", pos=(0, 0, -0.1))
            run.add_box(0, (0.1, 0.1, 0.1))
            bodies[name] = BLOCK | {"mount": {"kind": "fixed"}}
        elif kind == "cloth":
            run.add_soft(name, sheet(5, 5, 0.02)[0] + rise, kind=kind, solver="pbd", spacing=0.02)
            bodies[name] = CLOTH
        else:
            below = 0.0 if name == "upper" else 0.2
            run.add_soft(name, lattice(3, 0.1) + [0, 0, 0.1 - below] + rise, kind=kind, spacing=0.0064)
            bodies[name] = SOFT | {"kind": kind}
    (row,) = find(run, bodies, kind="contact", between=["upper", "lower"]).occurrences["e"]
    assert row["time"] == pytest.approx(1 - near / 0.1, abs=0.011)
    assert row["between"] == ["upper", "lower"]


def test_touches_need_no_recorded_contacts(bouncing, find):
    scene = {"record": {"contacts": False}}
    log = find(bouncing, scene=scene, kind="contact", between=["jelly", "floor"])
    assert len(log.occurrences["e"]) == 2
    assert log.problems == {}


def test_an_impulse_of_such_a_touch_is_not_known(bouncing, find):
    log = find(bouncing, kind="contact", between=["jelly", "floor"], min_impulse=0.1)
    assert "min_impulse" in log.problems["e"]


def test_rigid_bodies_under_sap_are_not_seen_to_touch(new_run, find):
    run = new_run()
    run.add_link("floor", fixed=True)
    run.add_link("block")
    log = find(run, {"block": BLOCK}, scene={"contact": {"model": "sap"}}, kind="contact", between=["block", "floor"])
    assert "sap" in log.problems["e"]


def test_rest_is_when_the_points_are_slow_not_their_middle(new_run, find):
    run = new_run()
    speed = np.interp(run.time, [0, 0.5, 0.6], [1.0, 1.0, 0.0])  # it swings about its middle, which does not move
    run.add_soft("jelly", lattice(3, 0.1), mass=2.0, kinetic=0.5 * 2.0 * speed**2, vel=(0, 0, 0))
    (row,) = find(run, kind="rest", of="jelly", speed=0.1, **{"for": 0.2}).occurrences["e"]
    assert row["time"] == pytest.approx(0.59, abs=2e-3)


def test_regions_thresholds_and_what_comes_after(bouncing, find):
    folder = bouncing.write()
    low = {"low": {"kind": "extent", "of": "jelly", "axis": "z", "stat": "min"}}
    (row,) = find(folder, measures=low, kind="threshold", measure="low", above=0.05).occurrences["e"]
    assert 0.5 < row["time"] < 0.7
    region = {"kind": "box", "min": [-1, -1, 0], "max": [1, 1, 0.15]}
    times = [r["time"] for r in find(folder, kind="enters", of="jelly", region=region).occurrences["e"]]
    assert len(times) == 2
    domain = {"domain": {"min": [-1, -1, 0.15], "max": [1, 1, 1]}}
    assert find(folder, scene=domain, kind="left_domain", of="jelly").occurrences["e"][0]["of"] == "jelly"
    touch = {"touch": {"kind": "contact", "between": ["jelly", "floor"]}}
    (later,) = find(folder, events=touch, kind="enters", of="jelly", region=region, after="touch").occurrences["e"]
    assert later["time"] == pytest.approx(times[1])


def test_what_is_released_on_an_event_is_released_then(new_run, find):
    run = new_run()
    run.add_link("floor", fixed=True)
    run.add_link("block", pos=np.outer(run.time, [0, 0, 1]))
    events = {
        "high": {"kind": "enters", "of": "block", "region": {"kind": "box", "min": [-1, -1, 0.305], "max": [1, 1, 9]}}
    }
    controls = {
        "grip": {"kind": "attach", "body": "block", "to": "floor"},
        "let_go": {"kind": "release", "attach": "grip", "on": "high"},
    }
    (row,) = find(run, {"block": BLOCK}, events=events, controls=controls, kind="released", attach="grip").occurrences[
        "e"
    ]
    assert row["time"] == pytest.approx(0.305, abs=1e-6)
