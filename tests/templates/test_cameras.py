"""Where cameras stand, and that they show what they are asked to."""

import math

import numpy as np
import pytest

from text2sim.spec_schema.models.cameras import fov_of_lens
from text2sim.templates.cameras import Cameras, View, framed_balls, project
from text2sim.templates.viewpoints import along, aperture_radius, basis, clip, place

UP = (0.0, 0.0, 1.0)
FILM = {"resolution": (1600, 900), "start": 0.0, "end": 1.0, "shots": []}
ASPECT = 16 / 9


class Thrown:
    """A ball that flies along x, and a wall that stands."""

    time = np.linspace(0, 1, 11)

    def position(self, body, t, link=None):
        return np.array((4.0 * t, 0.0, 1.0 + 2 * t * (1 - t)))

    def bounds(self, bodies, t):
        ways = np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)])
        return np.concatenate([self.position(body, t) + ways for body in bodies])


def cameras(camera, states=None, **film):
    return Cameras(FILM | {"cameras": {"main": {"up": UP, "fov": 40.0} | camera}} | film, states or Thrown())


def seen(view):
    points = np.concatenate([Thrown().bounds(["ball"], t) for t in Thrown.time])
    return project(view, points, ASPECT)


def test_kinds_of_cameras():
    def at(camera, t=0.0, part=0.0):
        return tuple(np.round(point, 6).tolist() for point in place({"up": UP} | camera, t, part, Thrown())[:2])

    assert at({"kind": "still", "pos": (0, -1, 0), "look_at": (0, 0, 0)}) == ([0, -1, 0], [0, 0, 0])
    dolly = {"kind": "dolly", "pos": (0, -1, 0), "to": (2, -1, 0), "look_at": (0, 0, 0)}
    assert at(dolly, part=0.5)[0] == [1, -1, 0]
    orbit = {"kind": "orbit", "look_at": (1, 0, 0), "radius": 2.0, "height": 1.0, "start": 0.0, "turn": math.pi}
    assert at(orbit, part=0.5) == ([1, 2, 1], [1, 0, 0])
    follow = {"kind": "follow", "body": "ball", "link": None, "smooth": 0.0, "offset": (0, -2, 0)}
    assert at(follow, t=0.5) == ([2, -2, 1.5], [2, 0, 1.5])
    with pytest.raises(ValueError, match="kind"):
        place({"kind": "hover"}, 0, 0, None)


def test_a_mounted_camera_moves_and_turns_with_its_carrier():
    class Swing:
        """A body that moves along x and turns about the axis (1, 2, 2) / 3."""

        def pose(self, body, t, link):
            assert (body, link) == ("arm", "hand")
            return np.array((4.0 * t, 0.0, 1.0)), (math.cos(t), *(math.sin(t) * np.array((1, 2, 2)) / 3))

    camera = {
        "kind": "mounted",
        "body": "arm",
        "link": "hand",
        "pos": (0.2, 0, 0.1),
        "look_at": (0.2, 0, 1.1),
        "up": (0, 1, 0),
    }
    mounted, local = cameras(camera, Swing()), np.array(((0.3, 0.1, 0.6), (0.1, -0.1, 2.1)))
    for t in (0.0, 0.4, 1.1, 3.0):
        angle, axis = 2 * t, np.array((1, 2, 2)) / 3
        # Rodrigues' formula: v cos a + (n x v) sin a + n (n . v) (1 - cos a).
        turned = local * math.cos(angle) + np.cross(axis, local) * math.sin(angle)
        turned += np.outer(local @ axis, axis) * (1 - math.cos(angle))
        seen_at = project(mounted.view("main", t), turned + (4 * t, 0, 1), ASPECT)
        # A pinhole at (0.2, 0, 0.1) that looks along z, y up, so that x is to the left; half the picture is tan 20 deg high.
        depth, half = local[:, 2] - 0.1, math.tan(math.radians(20))
        expected = (0.2 - local[:, 0]) / depth / half / ASPECT, local[:, 1] / depth / half, depth
        assert seen_at == pytest.approx(np.stack(expected, axis=1), abs=1e-9)


def test_a_way_through_keyframes_passes_them_and_rests_at_both_ends():
    times, points = [0.0, 1.0, 3.0], [(0.0, 0, 0), (1.0, 0, 0), (1.0, 4.0, 0)]
    for t, point in zip(times, points, strict=True):
        assert along(times, points, t) == pytest.approx(point)
    assert along(times, points, -5) == pytest.approx(points[0])
    assert along(times, points, 9) == pytest.approx(points[-1])
    assert math.dist(along(times, points, 0.01), points[0]) < 0.001
    before, after = along(times, points, 1 - 1e-6), along(times, points, 1 + 1e-6)
    middle = along(times, points, 1.0)
    left = np.subtract(middle, before) / 1e-6
    assert np.subtract(after, middle) / 1e-6 == pytest.approx(left, abs=1e-3), "no jolt"


@pytest.mark.parametrize("direction", [(0.5, -1, 0.4), (0, 0, 1), (-1, 0, 0)])
@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_a_frame_shows_all_that_was_recorded_and_no_more(direction, margin):
    frame = {"bodies": ["ball"], "margin": margin, "within": None, "direction": direction}
    start = {"kind": "still", "pos": (0, -1, 1), "look_at": (0, 0, 1), "frame": frame}
    view = cameras(start).view("main", 0.3)
    places = seen(view)
    assert places[:, 2].min() > 0
    assert np.abs(places[:, :2]).max() == pytest.approx(1 - 2 * margin, abs=1e-6)
    assert np.asarray(view.pos - view.look_at) / np.linalg.norm(view.pos - view.look_at) == pytest.approx(
        np.array(direction) / np.linalg.norm(direction)
    )


def test_a_frame_from_a_given_place_chooses_the_lens():
    frame = {"bodies": ["ball"], "margin": 0.1, "within": None}
    view = cameras({"kind": "still", "pos": (2, -9, 1), "look_at": (0, 0, 1), "frame": frame}).view("main", 0)
    assert view.pos == pytest.approx((2, -9, 1))
    assert np.abs(seen(view)[:, :2]).max() == pytest.approx(0.8, abs=0.02)


def test_an_orbit_sees_all_from_everywhere():
    frame = {"bodies": ["ball"], "margin": 0.05, "within": None, "fit": True}
    orbit = {"kind": "orbit", "look_at": (0, 0, 0), "radius": 1, "height": 0.4, "start": 0, "turn": 3, "frame": frame}
    views = [cameras(orbit).view("main", 0, part) for part in np.linspace(0, 1, 12)]
    assert max(np.abs(seen(view)[:, :2]).max() for view in views) == pytest.approx(0.9, abs=1e-6)


@pytest.mark.parametrize("smooth", [0.0, 0.3])
def test_a_frame_is_held_by_a_camera_that_moves_along(smooth):
    class Convoy(Thrown):
        """The ball, and a cart that runs ahead of it at 3 m/s and gains half a metre per second."""

        def bounds(self, bodies, t):
            cart = np.array((1.0 + 3.5 * t, 0.2, 0.1)) + np.array([(x, 0, z) for x in (-0.2, 0.2) for z in (-0.1, 0.1)])
            return np.concatenate([super().bounds(["ball"], t), cart])

    frame = {"bodies": ["ball", "cart"], "margin": 0.1, "within": None, "direction": (0.2, -1, 0.3)}
    start = {"kind": "follow", "body": "ball", "link": None, "smooth": smooth, "offset": (0, -1, 0), "frame": frame}
    made = cameras(start, Convoy())
    views = [(t, made.view("main", t)) for t in Thrown.time]
    places = np.concatenate([project(view, Convoy().bounds([], t), ASPECT) for t, view in views])
    assert np.abs(places[:, :2]).max() == pytest.approx(0.8, abs=1e-6)
    (_, first), (_, last) = views[0], views[-1]
    moved = Thrown().position("ball", 1.0) - Thrown().position("ball", 0.0)
    assert last.pos - first.pos == pytest.approx(moved, abs=0.6 * smooth * 4), "at the end the mean lags"
    assert first.pos - last.pos == pytest.approx(first.look_at - last.look_at), "it does not turn"


def test_a_following_camera_has_nothing_to_catch_up_with():
    follow = {"kind": "follow", "body": "ball", "link": None, "smooth": 0.6, "offset": (0, -2, 0)}
    assert cameras(follow).view("main", 0.0).look_at == pytest.approx(Thrown().position("ball", 0.0))


def test_what_leaves_the_space_is_given_up_and_only_shots_count():
    frame = {"bodies": ["ball"], "margin": 0.0, "within": ((-1, -1, 0), (2, 1, 3)), "direction": (0, -1, 0)}
    camera = {"kind": "still", "pos": (0, -1, 1), "look_at": (0, 0, 1), "frame": frame}
    assert 0.5 < cameras(camera).view("main", 0).look_at[0] < 1.1
    shots = [{"camera": "main", "from": 0.0, "to": 0.2}, {"camera": "other", "from": 0.0, "to": 1.0}]
    all_of_it = camera | {"frame": frame | {"within": None}}
    assert cameras(all_of_it, shots=shots).view("main", 0).look_at[0] == pytest.approx(0.4, abs=0.01)


def test_without_a_recording_it_stands_where_the_start_would_have_it():
    class Blind:
        def position(self, body, t, link=None):
            return (0, 0, 0)

    frame = {"bodies": ["ball"], "margin": 0.0, "within": None, "direction": (0, -1, 0)}
    camera = {"kind": "still", "pos": (0, -7, 1), "look_at": (0, 0, 1), "frame": frame}
    assert cameras(camera, Blind()).view("main", 0).pos == pytest.approx((0, -7, 1))


def test_balls_are_framed_whole():
    frame = {"bodies": [], "margin": 0.0, "within": None, "direction": (0, -1, 0)}
    found = framed_balls({"kind": "still", "up": UP, "fov": 90.0, "frame": frame}, [((0, 0, 0), 1.0)], 1.0)
    # A ball of radius 1 touches the edges of a right angle at a distance of the root of two.
    assert -found["pos"][1] == pytest.approx(math.sqrt(2), rel=0.02)


def test_a_real_lens():
    assert fov_of_lens(50) == pytest.approx(26.99, abs=0.01)
    assert aperture_radius(fov_of_lens(50), 2.0) == pytest.approx(0.0125)
    still = {"kind": "still", "pos": (0, -3, 1), "look_at": (0, 0, 1), "f_stop": 2.8}
    assert cameras(still).view("main", 0).focus == pytest.approx(3.0)
    assert cameras(still | {"f_stop": None}).view("main", 0).aperture == 0
    sharp = cameras(still | {"focus": {"body": "ball", "link": None}})
    assert sharp.view("main", 1.0).focus == pytest.approx(3.0), "the distance along the axis, not to the ball"


def test_pictures_stand_upright():
    right, up, ahead = basis((0, -1, 0), (0, 0, 0), UP)
    assert (right, up, ahead) == ((1, 0, 0), (0, 0, 1), (0, 1, 0))
    assert basis((0, 0, 3), (0, 0, 0), UP)[1] == pytest.approx((0, 1, 0))
    assert np.isfinite(basis((1, 1, 1), (1, 1, 1), UP)).all()
    view = View(np.array((0.0, -2, 0)), np.zeros(3), np.array(UP), 90.0, 2.0, 0.0)
    assert project(view, [(2.0, 0, 1), (0, 0, 2)], 1.0) == pytest.approx(np.array([(1, 0.5, 2), (0, 1, 2)]))


def test_what_is_drawn_reaches_from_near_to_far():
    assert clip({"kind": "orbit", "radius": 5.0}) == (0.1, 100.0)
    assert clip({"kind": "follow", "pos": (0, 0, 0)}) == (0.06, 60.0)
    keyframed = {"kind": "keyframed", "positions": [(0, -9, 0), (0, -1, 0)], "look_at": (0, 0, 0)}
    assert clip(keyframed) == (0.02, 60.0)
