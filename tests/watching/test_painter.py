"""The painter: cameras as the program has them, states while they are written, films that show what was recorded."""

import json
import threading
import time

import numpy as np
import pytest

from text2sim.compiler.build import plan_case
from text2sim.compiler.emit import emit
from text2sim.spec_schema.load import load_text
from text2sim.templates.cameras import View
from text2sim.watching.painter import film as film_module
from text2sim.watching.painter.context import NoOpenGL, open_context
from text2sim.watching.painter.creases import corners
from text2sim.watching.painter.film import Order, Studio, Superseded
from text2sim.watching.painter.live_states import LiveStates
from text2sim.watching.painter.rotation import multiply, rotate, slerp
from text2sim.watching.painter.script import Script, projection

CASE = """\
text2sim: 2
name: film
scene: {duration: 1.0, dt: 0.01, statics: {floor: {shape: {kind: plane}}}}
bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}}
render:
  resolution: [640, 360]
  fps: 10
  background: white
  cameras:
    main: {kind: still, from: [0, -3, 0.5], look_at: [0, 0, 0.5]}
    round: {kind: orbit, look_at: ball, radius: 2, height: 1, start_deg: 0, turn_deg: 90}
    after: {kind: follow, body: ball, offset: [0, -2, 0], smooth: 0.2}
  lights:
    sun: {kind: sun, direction: [0, 0, -2], strength: 3}
    lamp: {kind: lamp, pos: [1, 1, 2], color: red, strength: 2}
"""
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
    [1, 5, 7], [1, 7, 3],
])  # fmt: skip


@pytest.fixture(scope="module")
def text():
    """The program's `render.py`."""
    return emit(plan_case(load_text(CASE)))["render.py"].decode()


@pytest.fixture(scope="module")
def script(text):
    return Script(text)


@pytest.fixture(scope="module")
def studio():
    try:
        return Studio(open_context())
    except NoOpenGL as error:
        pytest.skip(str(error))


class Written:
    """A recording that is being written: a red cube of 0.4 m which climbs from 0 to 1 m in a second."""

    def __init__(self, folder):
        self.folder = folder
        self.chunks = 0
        (folder / "states").mkdir()
        (folder / "geometry").mkdir()
        links = [{"body": "ball", "link": "ball_baselink"}]
        (folder / "states/layout.json").write_text(json.dumps({"links": links}))
        row = {"mesh": "cube.npz", "pos": [0, 0, 0], "quat": [1, 0, 0, 0], "color": [1, 0, 0, 1]}
        (folder / "geometry/index.json").write_text(json.dumps({"0": [row]}))
        normals = CUBE / np.sqrt(3)
        np.savez(folder / "geometry/cube.npz", vertices=0.2 * CUBE, faces=FACES, normals=normals)

    def add(self, start, end):
        """Write the frames from one time to another, 100 in a second."""
        time_ = np.arange(round(start * 100), round(end * 100)) / 100
        pos = np.zeros((len(time_), 1, 3))
        pos[:, 0, 2] = time_
        quat = np.tile([1.0, 0, 0, 0], (len(time_), 1, 1))
        name = self.folder / f"states/chunk_{self.chunks:05d}.npz"
        np.savez(name.with_name("part.npz"), time=time_, links_pos=pos, links_quat=quat)
        name.with_name("part.npz").rename(name)
        self.chunks += 1

    def end(self):
        (self.folder / "status.json").write_text("{}")


@pytest.fixture
def written(tmp_path):
    return Written(tmp_path)


def order(text, folder, **options):
    return Order(**{"script": text, "out": folder, "width": 320, "ahead": 0.1, "colors": {}} | options)


def keep(films):
    """What films are told to, where only whole ones count."""
    return lambda name, path, whole: films.__setitem__(name, path) if whole else None


def pictures(path):
    import av

    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


# --- what the program says ------------------------------------------------------------------------------------


def test_the_script_says_what_the_case_says(script):
    assert script.resolution == (640, 360)
    assert (script.fps, script.end) == (10, 1)
    assert script.films == {"video": "main", "video_round": "round", "video_after": "after"}
    assert script.background == (1, 1, 1)
    sun, lamp = script.lights
    assert sun == ((0, 0, -1, 0), (3, 3, 3))
    assert lamp == ((1, 1, 2, 1), (2, 0, 0))
    assert len(script.pictures("video", 1.0)) == 10
    assert len(script.pictures("video", 0.5)) == 5
    assert script.pictures("video_round", 1.0)[5].t == 0.5


def test_cameras_stand_where_the_program_puts_them(script, written):
    written.add(0, 1.01)
    recording = LiveStates(written.folder)
    recording.read()
    view = script.view(script.pictures("video_round", 1.0)[-1], recording)
    np.testing.assert_allclose(view.pos, [0, 2, 2], atol=1e-6)
    np.testing.assert_allclose(view.look_at, [0, 0, 1])
    view = script.view(script.pictures("video_after", 1.0)[5], recording)
    np.testing.assert_allclose(view.pos, [0, -2, 0.5], atol=1e-6)
    np.testing.assert_allclose(view.look_at, [0, 0, 0.5], atol=1e-6)


def test_what_the_camera_looks_at_is_in_the_middle():
    def seen(*way):
        return View(*(np.array(point, float) for point in way), 40.0, 1.0, 0.0)

    view = projection(seen([1, -2, 3], [0.5, 0, 1], [0, 0, 1]), (0.1, 100), 16 / 9)
    x, y, z, w = view @ [0.5, 0, 1, 1]
    assert (x, y) == pytest.approx((0, 0), abs=1e-12)
    assert w == pytest.approx(np.linalg.norm([0.5, -2, 2]))
    above = view @ [0.5, 0, 1.1, 1]
    assert above[1] / above[3] > 0.01
    assert np.isfinite(projection(seen([0, 0, 3], [0, 0, 0], [0, 0, 1]), (0.1, 100), 1)).all(), "straight down"


# --- what was recorded ----------------------------------------------------------------------------------------


def test_states_are_read_as_they_are_written(written):
    recording = LiveStates(written.folder)
    assert recording.read() is False
    written.add(0, 0.2)
    assert recording.read() is True
    assert recording.read() is False
    assert len(recording.time) == 20
    written.add(0.2, 0.3)
    recording.read()
    written.chunks -= 1  # the chunk in hand is written again when there is more of it
    written.add(0.2, 0.5)
    recording.read()
    assert len(recording.time) == 50
    written.add(0.5, 0.6)
    written.end()
    assert not recording.complete
    recording.read()
    assert recording.complete
    assert len(recording.time) == 60
    pos, quat = recording.poses(0.255)
    assert pos[0, 2] == pytest.approx(0.255)
    assert quat[0] == pytest.approx([1, 0, 0, 0])
    assert recording.poses(7.0)[0][0, 2] == pytest.approx(0.59), "the last, after the end"


def test_turning_goes_the_short_way():
    a, b = np.array([[1.0, 0, 0, 0]]), -np.array([[np.cos(0.4), 0, 0, np.sin(0.4)]])
    half = slerp(a, b, 0.5)[0]
    assert abs(half @ [np.cos(0.2), 0, 0, np.sin(0.2)]) == pytest.approx(1)
    np.testing.assert_allclose(rotate(np.array([np.cos(0.25), 0, 0, np.sin(0.25)]), np.array([1.0, 0, 0])),
                               [np.cos(0.5), np.sin(0.5), 0])  # fmt: skip
    np.testing.assert_allclose(multiply(b, b * [1, -1, -1, -1]), [[1, 0, 0, 0]], atol=1e-12)


def test_a_box_keeps_its_edges_and_a_ball_is_round():
    vertex, outward = corners(CUBE, FACES, CUBE / np.sqrt(3))
    assert vertex.tolist() == FACES.ravel().tolist()
    assert np.isclose(np.abs(outward).max(axis=1), 1).all(), "every corner faces as its side does"
    assert ((outward * CUBE[vertex]).sum(axis=1) > 0).all(), "outwards"
    import trimesh

    ball = trimesh.creation.icosphere(3)
    vertex, outward = corners(np.asarray(ball.vertices), np.asarray(ball.faces), np.asarray(ball.vertex_normals))
    np.testing.assert_allclose(outward, ball.vertex_normals[vertex])


# --- films ----------------------------------------------------------------------------------------------------


def test_a_film_shows_what_was_recorded(studio, text, written):
    written.add(0, 1.01)
    written.end()
    films = {}
    assert studio.film(order(text, written.folder), lambda: True, keep(films)) == 10
    assert list(films) == ["main", "round", "after"]
    shots = pictures(films["main"])
    assert len(shots) == 10
    assert shots[0].shape == (180, 320, 3)
    rows = []
    for shot in shots:
        red = (shot[..., 0].astype(int) - shot[..., 1] > 60).nonzero()
        assert red[1].mean() == pytest.approx(159.5, abs=2), "in the middle of the width"
        rows.append(red[0].mean())
    assert rows == sorted(rows, reverse=True), "it climbs"
    assert rows[5] == pytest.approx(89.5, abs=3), "half a metre up is the middle of the picture"
    assert (shots[0][0, 0] > 245).all(), "a white background"


def test_a_film_is_made_while_the_states_are_written(studio, text, written):
    films = {}
    maker = threading.Thread(target=studio_in_thread, args=(text, written.folder, films))
    maker.start()
    for start in np.arange(0, 1.0, 0.1):
        written.add(start, start + 0.1)
        time.sleep(0.03)
        assert "main" not in films, "not before the last frame is there"
    written.add(1.0, 1.01)
    written.end()
    maker.join(30)
    assert len(pictures(films["main"])) == 10


def studio_in_thread(text, folder, films):
    """A context belongs to the thread that opened it."""
    Studio(open_context()).film(order(text, folder), lambda: True, keep(films))


def test_a_long_simulation_is_shown_before_its_end(studio, text, written, monkeypatch):
    """The whole film is not the worse for it."""
    monkeypatch.setattr(film_module, "GLIMPSE", 0.0)
    written.add(0, 0.51)
    seen = []

    def done(name, path, whole):
        if name == "main":
            seen.append((whole, pictures(path)))
        if len(seen) == 3:
            written.add(0.51, 1.01)
            written.end()

    studio.film(order(text, written.folder), lambda: True, done)
    assert [whole for whole, _ in seen] == [False] * (len(seen) - 1) + [True]
    early = [len(shots) for _, shots in seen[:3]]  # how many at a time depends on the machine
    assert 0 < early[0] < early[1] < early[2] < len(seen[-1][1])
    assert len(seen[-1][1]) == 10
    for _, shots in seen:
        assert (shots[0] == seen[-1][1][0]).all(), "the same pictures"
    assert not list(written.folder.glob("glimpse*"))


def test_a_run_that_ended_early_is_filmed_as_far_as_it_came(studio, text, written):
    written.add(0, 0.51)
    written.end()
    films = {}
    assert studio.film(order(text, written.folder), lambda: True, keep(films)) == 5
    assert len(pictures(films["main"])) == 5


def test_nothing_recorded_is_no_film(studio, text, written):
    written.end()
    assert studio.film(order(text, written.folder), lambda: True, lambda *film: None) == 0
    assert not list(written.folder.glob("video*"))


def test_a_film_that_nobody_wants_any_more_is_left(studio, text, written):
    written.add(0, 0.5)
    wanted = iter([True] * 20)
    with pytest.raises(Superseded):
        studio.film(order(text, written.folder), lambda: next(wanted, False), lambda *film: None)
    assert not list(written.folder.glob("video*"))


def test_another_colour_needs_no_other_recording(studio, text, written):
    written.add(0, 1.01)
    written.end()
    films = {}
    studio.film(order(text, written.folder, colors={"ball": [0, 0, 1, 1]}), lambda: True, keep(films))
    shot = pictures(films["main"])[5].astype(int)
    assert (shot[85:95, 155:165, 2] > shot[85:95, 155:165, 0] + 60).all()


def test_what_is_clear_lets_through_what_is_behind(studio, text, written):
    """Half of the blue cube, half of the white behind it."""
    written.add(0, 1.01)
    written.end()
    shots = {}
    for name, alpha in (("solid", 1.0), ("clear", 0.5)):
        films = {}
        colors = {"ball": [0.0, 0.0, 1.0, alpha]}
        studio.film(order(text, written.folder, colors=colors), lambda: True, keep(films))
        shots[name] = pictures(films["main"])[5][90, 160].astype(int)
    assert shots["clear"][0] > shots["solid"][0] + 60


def test_a_picture_is_never_larger_than_the_film(studio, text, written):
    written.add(0, 1.01)
    written.end()
    films = {}
    studio.film(order(text, written.folder, width=4000), lambda: True, keep(films))
    assert pictures(films["main"])[0].shape == (360, 640, 3)
