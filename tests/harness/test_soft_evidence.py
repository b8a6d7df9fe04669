"""What evidence, report and comparison say of bodies that deform."""

import json

import numpy as np
import pytest
from soft_shapes import lattice, sheet, sphere, tets

from text2sim.comparison.compare import compare
from text2sim.comparison.page import write_comparison
from text2sim.comparison.runs import read_runs
from text2sim.evidence.evidence import judge
from text2sim.evidence.report import write_report
from text2sim.recording.record import RunRecord

BODIES = {
    "jelly": {
        "kind": "soft",
        "shape": {"kind": "sphere", "radius": 0.2},
        "repeat": {"kind": "line", "count": 2, "step": [1, 0, 0]},
    },
    "towel": {"kind": "cloth", "shape": {"kind": "sheet", "size": [1.0, 1.0]}},
    "rod": {"kind": "rigid", "shape": {"kind": "box", "size": [1, 1, 1]}, "material": {"touch_soft": False}},
}
ACTIONS = {
    "measures": {"size": {"kind": "volume", "of": "jelly", "relative": True}},
    "events": {"lands": {"kind": "contact", "between": ["jelly", "floor"]}},
    "expect": {
        "keeps_its_size": {"measure": "size", "during": "all", "stat": "min", "above": 0.9},
        "lands": {"event": "lands"},
    },
}


@pytest.fixture
def run(new_run):
    """Two balls, one of which is pressed into the floor, and a sheet that lies in a rod and is pulled to 1.3 of it."""
    run = new_run()
    t = run.time
    run.add_link("floor", fixed=True)
    run.add_link("rod", pos=(0, 9, 0))
    run.add_box(1, (0.5, 0.5, 0.5))
    vertices, faces = sphere(0.2)
    squash = np.stack([0 * t + 1, 0 * t + 1, 1 - 0.4 * t], 1)[:, None]
    down = np.outer(0.2 - 0.23 * t, [0, 0, 1])[:, None]
    domain = [[-1, -1, -1], [9, 9, 9]]
    run.add_soft("jelly[0]", lattice(4, 0.1) + [0, 0, 1], surface=vertices + [0, 0, 1], faces=faces, domain=domain)
    run.add_soft("jelly[1]", lattice(4, 0.1) * squash + down, surface=vertices * squash + down, faces=faces,
                 domain=domain, speed=t, mass=3.0)  # fmt: skip
    points, triangles = sheet(6, 6, 0.2)
    pull = np.stack([1 + 0.3 * t, 1 + 0 * t, 1 + 0 * t], 1)[:, None]
    run.add_soft("towel", points * pull + [0, 9, 0], surface=points * pull + [0, 9, 0], kind="cloth", solver="pbd",
                 spacing=0.2, faces=triangles, domain=[[-9, 8, -9], [9, 9.5, 9]])  # fmt: skip
    return run


@pytest.fixture
def judged(run, make_case):
    folder = run.write()
    return folder, judge(folder, make_case(bodies=BODIES, **ACTIONS))


def test_the_worst_of_all_copies_with_when_and_where(judged):
    found = judged[1]["deformables"]
    jelly, towel = found["jelly"], found["towel"]
    assert (jelly["kind"], jelly["solver"], jelly["every"]) == ("soft", "mpm", 1)
    assert jelly["volume"] == {"value": pytest.approx(0.6, rel=1e-3), "at": 1.0, "unit": "", "copy": "jelly[1]"}
    depth = jelly["penetration"]
    assert (depth["in"], depth["copy"], depth["at"]) == ("floor", "jelly[1]", pytest.approx(1.0))
    assert depth["value"] == pytest.approx(0.15 * 0.6 + 0.03)
    assert jelly["speed"]["value"] == pytest.approx(1.0)
    assert "self_penetration" not in jelly
    assert towel["stretch"]["value"] == pytest.approx(1.3)
    assert "in" not in towel["penetration"]
    assert towel["penetration"]["value"] == 0, "it does not feel the rod"
    assert towel["against_bounds"]["value"] == pytest.approx(1 / 6)
    assert "volume" not in towel


def test_what_the_grid_turns_back_before_its_side_is_against_it(new_run, make_case):
    run = new_run(duration=0.1)
    ball = lattice(4, 0.1)
    side = ball[:, 0].max() + 0.04  # a rolling ball of cells of 0.03 m came to 0.28 cells before its wall
    run.add_soft("jelly", np.tile(ball, (11, 1, 1)), spacing=0.1, domain=[[-9, -9, -9], [side, 9, 9]])
    found = judge(run.write(), make_case(bodies={"jelly": BODIES["jelly"] | {"repeat": None}}))
    assert found["deformables"]["jelly"]["against_bounds"]["value"] == pytest.approx(1 / 4)
    assert any("invisible wall" in text for text in found["suspicions"])


def test_tetrahedra_turned_inside_out(new_run, make_case):
    run = new_run(duration=0.1)
    points = np.tile(lattice(3, 0.1), (11, 1, 1))
    points[6, :, 2] *= -1
    run.add_soft("jelly", points, tets=tets(3), solver="fem")
    bodies = {"jelly": BODIES["jelly"] | {"repeat": None}}
    found = judge(run.write(), make_case(bodies=bodies))["deformables"]["jelly"]
    assert found["inverted"]["value"] == pytest.approx(1.0)
    assert found["inverted"]["at"] == pytest.approx(0.06)


def test_the_energy_account_says_what_is_not_in_it(judged):
    energy = judged[1]["energy"]
    assert energy["not_counted"] == ["what deformation stores in `jelly`", "what deformation stores in `towel`"]
    assert energy["start"] == pytest.approx(9.81 * (1 * 1.0 + 3 * 0.2))
    assert energy["end"] - energy["start"] == pytest.approx(-3 * 9.81 * 0.23, rel=1e-4)


def test_the_rest_of_the_evidence(judged):
    _, evidence = judged
    assert evidence["verdict"] == "failed"
    assert evidence["expect"]["lands"]["ok"]
    assert evidence["expect"]["keeps_its_size"]["value"] == pytest.approx(0.8, rel=1e-3)
    assert evidence["speeds"]["jelly"].keys() == {"linear"}
    assert evidence["non_finite"] is None
    assert any("deformable bodies" in row for row in evidence["left_out"])


def test_the_first_point_that_is_no_number_is_found(run, make_case):
    points = run.soft_arrays[1][0].copy()
    points[40:, 7] = np.inf
    run.soft_arrays[1] = (points, *run.soft_arrays[1][1:])
    folder = run.write("diverged", message="nan")
    evidence = judge(folder, make_case(bodies=BODIES, **ACTIONS))
    assert evidence["non_finite"] == {"time": pytest.approx(0.4), "frame": 40, "bodies": ["jelly[1]"]}
    assert evidence["verdict"] == "failed"
    write_report(folder, make_case(bodies=BODIES, **ACTIONS))


def test_long_runs_are_looked_at_every_few_frames_and_that_is_said(judged, make_case, monkeypatch):
    folder, whole = judged
    monkeypatch.setattr("text2sim.evidence.soft_diagnostics.LOOKED_AT", 64 * 30)
    thin = judge(folder, make_case(bodies=BODIES, **ACTIONS))["deformables"]["jelly"]
    assert thin["every"] == 4
    assert thin["penetration"] == whole["deformables"]["jelly"]["penetration"]
    write_report(folder, make_case(bodies=BODIES, **ACTIONS))
    assert "one in 4 frames" in (folder / "report.html").read_text()


def test_judging_again_gives_the_same_bytes(judged, make_case):
    folder, _ = judged
    first = (folder / "evidence.json").read_bytes(), (folder / "events.jsonl").read_bytes()
    judge(folder, make_case(bodies=BODIES, **ACTIONS))
    assert ((folder / "evidence.json").read_bytes(), (folder / "events.jsonl").read_bytes()) == first


def test_few_frames_are_enough(run, make_case):
    for upto in (0, 1, 2):
        evidence = judge(run.write(upto=upto), make_case(bodies=BODIES, **ACTIONS))
        assert bool(evidence["deformables"]) == (upto > 0)


def test_the_report_shows_it(judged, make_case):
    folder, _ = judged
    page = write_report(folder, make_case(bodies=BODIES, **ACTIONS)).read_text()
    assert "Bodies that deform" in page
    assert "deepest point in something rigid (<code>floor</code>)" in page
    assert "what deformation stores in <code>jelly</code>" in page


def test_runs_are_compared(judged, make_case, tmp_path):
    folders = []
    for number, worst in enumerate((0.6, 0.9)):
        folder = tmp_path / f"drop-{number}"
        folder.mkdir()
        evidence = json.loads((judged[0] / "evidence.json").read_text())
        evidence["deformables"]["jelly"]["volume"]["value"] = worst
        (folder / "evidence.json").write_text(json.dumps(evidence))
        (folder / "resolved.json").write_text("{}")
        RunRecord(case="drop", state="finished", key={}, time=1.0).write(folder)
        folders.append(folder)
    found = compare(read_runs(folders))
    assert {"name": "jelly: worst volume", "values": [0.6, 0.9]} in found.diagnostics
    assert "jelly: worst volume" in write_comparison(found, tmp_path / "page.html").read_text()


def test_what_gets_through_walls_and_floors_is_suspicious(new_run, make_case):
    """Of 20 grains 4 go through a wall, 2 of them between two frames, 1 through the ground, 1 past its edge, 1 into a float."""
    run = new_run(duration=1.0)
    t = run.time
    run.add_link("floor", fixed=True)
    wall = run.add_link("wall", fixed=True, pos=(1, 0, 0.5))
    run.add_box(wall, (0.1, 2, 0.5))
    stone = run.add_link("stone", pos=(-1, 0, 0.5))
    run.add_box(stone, (0.3, 0.3, 0.3))
    way = np.zeros((len(t), 20, 3))
    way[:, :, 1], way[:, :, 2] = np.linspace(-1, 1, 20), 0.5
    way[:, :2, 0] = (2 * t)[:, None]
    way[:, 2:4, 0] = np.where(t > 0.5, 2.0, 0.0)[:, None]
    way[:, 4, 2] = 0.5 - t
    way[:, 5, 1], way[:, 5, 2] = 9.0, 0.5 - t
    way[:, 6] = [-1, 0, 0.5]
    way[:, 7, 0] = 0.92  # it lies against the wall, as deep as soft contact lets it
    run.add_soft("sand", way, kind="granular", spacing=0.02, mass=3.0)
    shape = {"kind": "box", "size": [0.2, 4, 1]}
    bodies = {
        "sand": {"kind": "granular", "shape": {"kind": "box", "size": [1, 1, 1]}},
        "stone": {"kind": "rigid", "shape": shape},
    }
    scene = {"statics": {"floor": {"shape": {"kind": "plane", "size": 10}}, "wall": {"shape": shape}}}
    measures = {"spilt": {"kind": "leaked", "of": "sand"}}
    expect = {
        "holds_at_first": {"measure": "spilt", "at": 0.4, "below": 0.01},
        "holds": {"measure": "spilt", "at": "end", "below": 0.01},
    }
    found = judge(run.write(), make_case(bodies=bodies, scene=scene, measures=measures, expect=expect))
    assert [found["expect"][name]["ok"] for name in expect] == [True, False]
    leaked = found["deformables"]["sand"]["leaked"]
    assert leaked["value"] == pytest.approx(5 / 20)
    assert (leaked["in"], leaked["at"]) == ("wall", pytest.approx(0.55, abs=0.011))
    (words,) = [row for row in found["suspicions"] if "behind" in row]
    assert words.startswith("`sand` has 25 % of its mass in or behind walls and floors, most of it by `wall`")
