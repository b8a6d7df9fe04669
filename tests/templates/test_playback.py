"""Recorded states, read back between the frames that were recorded."""

import json

import numpy as np
import pytest

from text2sim.templates.cameras import Cameras, project
from text2sim.templates.playback import States, outermost, slerp


@pytest.fixture
def folder(tmp_path):
    """A drum of two links that turns a quarter about z in a second, and two bricks that drift."""
    links = [("drum", "base"), ("drum", "rim"), ("brick[0]", "brick"), ("brick[1]", "brick")]
    rows = [{"body": body, "link": link} for body, link in links]
    (tmp_path / "states").mkdir()
    (tmp_path / "geometry").mkdir()
    (tmp_path / "states" / "layout.json").write_text(json.dumps({"links": rows, "joints": []}))
    for chunk, times in enumerate(([0.0, 0.5], [1.0])):
        turns = [[np.cos(np.pi / 4 * t), 0, 0, np.sin(np.pi / 4 * t)] for t in times]
        pos = [[[0, 0, 1], [0, 0, 1], [t, 0, 0], [0, t, 0]] for t in times]
        quat = [[turn, turn, [1, 0, 0, 0], [1, 0, 0, 0]] for turn in turns]
        arrays = {"time": times, "qpos": np.zeros((len(times), 0)), "links_pos": pos, "links_quat": quat}
        np.savez(tmp_path / "states" / f"chunk_{chunk:05d}.npz", **{k: np.array(v) for k, v in arrays.items()})
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    np.savez(tmp_path / "geometry" / "cube.npz", vertices=np.concatenate([corners, np.zeros((1, 3))]))
    piece = {"mesh": "cube.npz", "pos": [2.0, 0, 0], "quat": [1, 0, 0, 0]}
    index = {"0": [], "1": [piece], "2": [piece | {"pos": [0, 0, 0]}], "3": [piece | {"pos": [0, 0, 0]}]}
    (tmp_path / "geometry" / "index.json").write_text(json.dumps(index))
    return tmp_path


def test_between_frames(folder):
    states = States(folder)
    assert states.time.tolist() == [0, 0.5, 1]
    assert states.position("brick[0]", 0.25) == pytest.approx((0.25, 0, 0))
    assert states.position("drum", 0.3, "rim") == pytest.approx((0, 0, 1))
    pos, quat = states.poses(0.75)
    assert pos[3] == pytest.approx((0, 0.75, 0))
    # It turns evenly: three quarters of 90 degrees.
    assert quat[1] == pytest.approx((np.cos(0.75 * np.pi / 4), 0, 0, np.sin(0.75 * np.pi / 4)))
    assert states.poses(99.0)[0][2] == pytest.approx((1, 0, 0))


def test_bounds_go_with_the_bodies(folder):
    states = States(folder)

    def box(names, t):
        points = states.bounds(names, t)
        return [*points.min(axis=0).round(6).tolist(), *points.max(axis=0).round(6).tolist()]

    assert box(["brick[1]"], 0.5) == [-1, -0.5, -1, 1, 1.5, 1]
    assert box(["brick"], 1.0) == [-1, -1, -1, 2, 2, 1]
    assert box(["drum.rim"], 0.0) == [1, -1, 0, 3, 1, 2]
    turned = states.bounds(["drum"], 1.0)
    assert turned.max(axis=0)[:2] == pytest.approx((1, 3))
    assert len(states.bounds(["nobody"], 0.0)) == 0


def test_ends_of_springs_go_with_their_links(folder):
    layout = folder / "states" / "layout.json"
    spring = {"links": [1, 2], "points": [[1, 0, 0], [0, 0, 0.5]]}
    layout.write_text(json.dumps(json.loads(layout.read_text()) | {"springs": [spring]}))
    (ends,) = States(folder).spring_ends(1.0)
    np.testing.assert_allclose(ends, [[0, 1, 1], [1, 0, 0.5]], atol=1e-9)
    (folder / "states" / "removed.json").write_text(json.dumps({"brick[0]": 0.5}))
    assert np.isnan(States(folder).spring_ends(1.0)).all()


def test_bounds_of_patterns_and_of_parts_of_compounds(folder):
    here = {"pos": [0, 0, 0], "quat": [1, 0, 0, 0]}
    parts = [
        here | {"part": "base", "kind": "box", "size": [4, 2, 1]},
        here | {"part": "knob", "kind": "cylinder", "size": [0.5, 3], "pos": [1, 0, 0]},
        here | {"part": "kneeler", "kind": "mesh", "mesh": "cube.npz"},
        here | {"part": "ball", "kind": "sphere", "size": [2]},
        here | {"part": "pill", "kind": "capsule", "size": [1, 4]},
    ]
    (folder / "geometry" / "solids.json").write_text(json.dumps({"2": parts}))
    states = States(folder)

    def box(name, t=0.0):
        points = states.bounds([name], t)
        return [*points.min(axis=0).round(6).tolist(), *points.max(axis=0).round(6).tolist()]

    assert box("drum.r*") == box("drum.*") == box("drum.rim")
    assert len(states.bounds(["drum.*x"], 0.0)) == 0
    assert box("brick[0].base", 0.5) == [-1.5, -1, -0.5, 2.5, 1, 0.5]
    assert box("brick.knob") == [0.5, -0.5, -1.5, 1.5, 0.5, 1.5]
    assert box("brick.kn*") == [-1, -1, -1.5, 1.5, 1, 1.5]
    assert box("brick.ball") == [-2, -2, -2, 2, 2, 2]
    assert box("brick[0].b*") == [-2, -2, -2, 2, 2, 2], "parts, not the link `brick`"
    assert box("brick.pill") == [-1, -1, -3, 1, 1, 3]
    assert box("brick[0]") == [-1, -1, -1, 1, 1, 1], "what is drawn of it"


def test_a_brief_leap_in_a_long_shot_stays_in_the_picture(folder):
    """Within a minute a brick leaps a metre, and the rim of the drum turns up and back, in a tenth of a second."""
    time = np.arange(0, 60, 0.02)
    leap = np.clip(1 - ((time - 30.35) / 0.05) ** 2, 0, None)
    pos = np.zeros((len(time), 4, 3))
    pos[:, 3, 2] = leap
    quat = np.tile([1.0, 0, 0, 0], (len(time), 4, 1))
    quat[:, 1] = np.stack([np.cos(leap * np.pi / 4), 0 * leap, -np.sin(leap * np.pi / 4), 0 * leap], axis=1)
    for path in (folder / "states").glob("*.npz"):
        path.unlink()
    arrays = {"time": time, "qpos": np.zeros((len(time), 0)), "links_pos": pos, "links_quat": quat}
    np.savez(folder / "states" / "chunk_00000.npz", **arrays)
    states = States(folder)
    for name, highest in (("brick[1]", 2.0), ("drum.rim", 3.0)):
        still = {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0, -9, 0), "look_at": (0, 0, 0)}
        frame = {"bodies": [name], "margin": 0.0, "within": None, "direction": (0.0, -1.0, 0.0)}
        film = {
            "resolution": (160, 90),
            "start": 0.0,
            "end": 60.0,
            "shots": [],
            "cameras": {"a": still | {"frame": frame}},
        }
        view = Cameras(film, states).view("a", 0.0)
        places = project(view, states.bounds([name], 30.36), 16 / 9)
        assert states.bounds([name], 30.36)[:, 2].max() == pytest.approx(highest, abs=0.1)
        assert np.abs(places[:, :2]).max() < 1.001, name
    assert len(states.extremes(["nobody"], time)) == 0


def test_only_what_is_outermost_counts():
    ball = np.random.default_rng(0).normal(size=(500, 3))
    found = outermost(ball)
    assert len(found) <= 26
    assert found.max(axis=0) == pytest.approx(ball.max(axis=0))


def test_orientations_go_the_short_way():
    a, b = np.array([1.0, 0, 0, 0]), np.array([-np.cos(0.5), 0, 0, -np.sin(0.5)])
    assert slerp(a, b, 0.5) == pytest.approx((np.cos(0.25), 0, 0, np.sin(0.25)))
