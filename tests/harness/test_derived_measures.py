"""Rings on rods, and differences and ratios of measures, against poses with known answers."""

import json
from typing import Any

import numpy as np
import pytest

from text2sim.compiler.shapes.rotation import quat_multiply, quat_rotate
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase

R, BAR, SEGMENTS = 0.1, 0.01, 16
TORUS = {"kind": "torus", "radius": R, "bar_radius": BAR}
POLE = {"kind": "cylinder", "radius": 0.02, "height": 1.0}
SIDEWAYS = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
"""A quarter turn about x: the axis z of a ring or rod points along -y."""


def capsules(radius: float, part: str = "", quat: Any = (1.0, 0.0, 0.0, 0.0)) -> list[dict[str, Any]]:
    """The pieces of a torus as the program records them, turned by a quaternion."""
    rows = []
    for k in range(SEGMENTS):
        a, b = (radius * np.array([np.cos(t), np.sin(t), 0]) for t in 2 * np.pi * (k + np.arange(2)) / SEGMENTS)
        length = float(np.linalg.norm(b - a))
        dx, dy, _ = (b - a) / length * np.sqrt(0.5)
        along = quat_multiply(quat, (np.sqrt(0.5), -dy, dx, 0.0))
        pos = quat_rotate(quat, tuple((a + b) / 2))
        rows.append({"kind": "capsule", "pos": pos, "quat": along, "size": [BAR, length], "part": part})
    return rows


@pytest.fixture
def threaded(new_run, make_case):
    """Return a function that counts rings on a pole about z with its foot at the origin; poses are (pos, quat)."""

    def count(rings, pole_solid=None, pole=POLE, ring=TORUS, of="ring", by="pole", solids=None, removed=None):
        run = new_run(duration=0.02)
        index = {}
        for k, (pos, quat) in enumerate(rings):
            link = run.add_link(f"ring[{k}]", pos=pos, quat=quat)
            index[str(link)] = capsules(R) if solids is None else solids[k]
        link = run.add_link("pole", pos=(0, 0, 0.5))
        index[str(link)] = [pole_solid or {"kind": "cylinder", "size": [0.02, 1.0]}]
        body = {"kind": "rigid", "shape": ring, "repeat": {"kind": "line", "count": len(rings), "step": [1, 0, 0]}}
        bodies = {"ring": body, "pole": {"kind": "rigid", "shape": pole}}
        case = make_case(bodies=bodies, measures={"m": {"kind": "threaded", "of": of, "by": by}}, statics=())
        folder = run.write()
        (folder / "geometry").mkdir(exist_ok=True)
        (folder / "geometry" / "solids.json").write_text(json.dumps(index))
        if removed is not None:
            (folder / "states" / "removed.json").write_text(json.dumps(removed))
        series = evaluate(RecordedCase.load(folder, case))["m"]
        assert not series.problem
        return series.values.tolist()

    return count


FLAT = (1.0, 0.0, 0.0, 0.0)
TILTED = (np.cos(0.6), np.sin(0.6), 0.0, 0.0)


@pytest.mark.parametrize(
    ("pos", "quat", "expected"),
    [
        ((0, 0, 0.5), FLAT, 1),
        ((0.07, 0, 0.02), FLAT, 1),  # against the pole, at its foot
        ((0, 0, 0.5), TILTED, 1),
        ((0.12, 0, 0.5), FLAT, 0),  # beside it
        ((0, 0, 1.01), FLAT, 0),  # just above its end
        ((0, 0, -0.01), FLAT, 0),
        ((0, 0, 0.5), SIDEWAYS, 0),  # upright, in the plane of the pole
        ((0.05, 0, 0.98), TILTED, 1),
        ((0, 0.2, 0.98), TILTED, 0),  # its plane meets the pole outside of the ring
    ],
)
def test_a_ring_is_on_a_pole_if_the_axis_crosses_its_disc(threaded, pos, quat, expected):
    assert threaded([(pos, quat)]) == [expected] * 3


def test_copies_are_counted(threaded):
    poses = [((0, 0, 0.1), FLAT), ((0, 0, 0.2), TILTED), ((0.5, 0, 0.1), FLAT), ((0.02, 0, 0.3), FLAT)]
    assert threaded(poses) == [3.0] * 3
    assert threaded(poses, of="ring[1:3]") == [1.0] * 3
    assert threaded(poses, removed={"ring[0]": 0.01}) == [3.0, 3.0, 2.0]


def test_the_size_of_each_copy_counts(threaded):
    poses = [((0.12, 0, 0.1), FLAT), ((0.12, 0, 0.2), FLAT)]
    assert threaded(poses, solids=[capsules(R), capsules(2 * R)]) == [1.0] * 3


def test_a_ring_comes_off(threaded):
    way = np.column_stack([np.zeros(3), np.zeros(3), [0.8, 0.99, 1.2]])
    assert threaded([(way, FLAT)]) == [1.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("shape", "solid", "expected"),
    [
        ({"kind": "capsule", "radius": 0.02, "length": 0.9}, {"kind": "capsule", "size": [0.02, 0.9]}, 1),
        ({"kind": "box", "size": [0.02, 0.03, 0.9]}, {"kind": "box", "size": [0.02, 0.03, 0.9]}, 1),
        ({"kind": "box", "size": [0.9, 0.03, 0.02]}, {"kind": "box", "size": [0.9, 0.03, 0.02]}, 0),
    ],
)
def test_capsules_and_boxes_are_rods_too(threaded, shape, solid, expected):
    assert threaded([((0, 0, 0.7), FLAT)], solid, shape) == [expected] * 3


def test_parts_of_compounds_are_rings_and_rods(threaded):
    """The ring stands upright in its body, and the body lies on its side: the ring is level."""
    box = {"kind": "box", "pos": [0, 0, 0.15], "size": [0.02, 0.02, 0.1], "part": "gem"}
    parts = {
        "band": {"shape": TORUS, "pose": {"euler_deg": [90, 0, 0]}},
        "gem": {"shape": {"kind": "box", "size": [0.02, 0.02, 0.1]}, "pose": {"pos": [0, 0, 0.15]}},
    }
    ring = {"kind": "compound", "parts": parts}
    solids = [[*capsules(R, "band", SIDEWAYS), box]]
    poses = [((0, 0, 0.5), (np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0))]
    assert threaded(poses, ring=ring, of="ring.band", solids=solids) == [1.0] * 3
    assert threaded([((0, 0, 0.5), FLAT)], ring=ring, of="ring.band", solids=solids) == [0.0] * 3


@pytest.fixture
def pair(new_run, make_case):
    """Return a function that evaluates `m`, of the heights 1 + t of `a` and t of `b`, and the speed of `a`."""

    def one(**wanted):
        run = new_run(duration=0.1)
        up = np.outer(run.time, [0, 0, 1.0])
        run.add_link("a", pos=up + [0, 0, 1], vel=(0, 0, 1.0))
        run.add_link("b", pos=up)
        measures = {
            "m": wanted,
            "high": {"kind": "position", "of": "a", "axis": "z"},
            "low": {"kind": "position", "of": "b", "axis": "z"},
            "v": {"kind": "speed", "of": "a"},
            "lost": {"kind": "joint_position", "of": "a"},
            "apart": {"kind": "difference", "measures": ["high", "low"]},
        }
        found = evaluate(RecordedCase.load(run.write(), make_case(bodies=("a", "b"), measures=measures, statics=())))
        assert list(found) == list(measures)
        return run.time, found["m"]

    return one


def test_a_difference_has_the_unit_of_both(pair):
    _, series = pair(kind="difference", measures=["high", "low"])
    np.testing.assert_allclose(series.values, 1.0, rtol=1e-6)
    assert series.unit == "m"
    assert "`v` in m/s" in pair(kind="difference", measures=["high", "v"])[1].problem


def test_a_ratio_has_no_value_where_it_divides_by_zero(pair):
    time, series = pair(kind="ratio", measures=["high", "low"])
    assert np.isnan(series.values[0])
    np.testing.assert_allclose(series.values[1:], (1 + time[1:]) / time[1:], rtol=1e-5)
    assert series.unit == ""
    assert pair(kind="ratio", measures=["high", "v"])[1].unit == "m/(m/s)"
    assert pair(kind="ratio", measures=["low", "high"], change_from="start")[1].values[0] == 0.0


def test_pairs_are_measures_of_pairs_in_any_order(pair):
    time, series = pair(kind="ratio", measures=["apart", "low"])  # stands before `apart`
    np.testing.assert_allclose(series.values[1:], 1 / time[1:], rtol=1e-5)
    assert series.unit == ""


def test_what_lacks_a_measure_has_no_value(pair):
    _, series = pair(kind="ratio", measures=["high", "lost"])
    assert "`lost`" in series.problem
    assert np.isnan(series.values).all()


def test_extremes_so_far_of_a_swing(new_run, measure):
    run = new_run(duration=1.0)
    swing = 0.3 * np.sin(2 * np.pi * run.time)
    run.add_link("bob", pos=np.outer(swing, [1, 0, 0]))
    folder = run.write()
    of = {"bodies": ("bob",), "kind": "position", "of": "bob", "axis": "x"}
    late = run.time >= 0.25
    highest = measure(folder, so_far="max", **of).values
    np.testing.assert_allclose(highest[~late], swing[~late], atol=1e-6)
    np.testing.assert_allclose(highest[late], 0.3, atol=1e-6)
    assert measure(folder, so_far="min", **of).values[[25, -1]] == pytest.approx([0.0, -0.3], abs=1e-6)
    assert measure(folder, so_far="range", **of).values[[0, 25, 75]] == pytest.approx([0.0, 0.3, 0.6], abs=1e-6)
    # The change since 0.25 s, when it is farthest out, is never above 0.
    assert measure(folder, so_far="max", change_from=0.25, **of).values[-1] == pytest.approx(0.0, abs=1e-6)
