"""Films that nobody has described, made of what was recorded: where the camera stands, how quickly it all goes."""

import numpy as np
import pytest

from text2sim.templates.cameras import Cameras, project
from text2sim.templates.directing import directed
from text2sim.templates.playback import Boxes
from text2sim.templates.viewpoints import place

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
DURATION = 6.0


class Ways:
    """Boxes on ways: name -> half sizes, and a function of the time that returns the middle."""

    def __init__(self, things, colors=None):
        self._things, self._colors = things, colors or {}
        self.time = np.linspace(0, DURATION, 301)

    def _clouds(self, names, t):
        return [way(t) + CORNERS * half for name, (half, way) in self._things.items() if name in names]

    def bounds(self, names, t):
        return np.concatenate([np.zeros((0, 3)), *self._clouds(names, t)])

    tracks = bounds

    def spring_ends(self, t):
        return np.zeros((0, 2, 3))

    def boxes(self, names):
        kept = [name for name in self._things if name in names]
        half = np.array([self._things[name][0] for name in kept], float).reshape(-1, 3)
        color = np.array([self._colors.get(name, (0.5, 0.5, 0.5)) for name in kept], float).reshape(-1, 3)
        n = len(kept)
        return Boxes(kept, np.arange(n), np.zeros((n, 3)), half, np.zeros((n, 4)), color, np.ones(n, bool))

    def placed(self, boxes, t):
        centers = np.array([self._things[name][1](t) for name in boxes.names], float).reshape(-1, 3)
        return centers, np.tile(np.eye(3), (len(centers), 1, 1)), boxes.half


def standing(*pos):
    return lambda t: np.array(pos, float)


def film(moving, statics=(), **more):
    camera = {
        "kind": "still", "up": (0, 0, 1), "fov": 32.0, "pos": (3.0, -5.0, 2.5), "look_at": (0, 0, 0.2),
        "frame": {"bodies": [*moving, *statics], "margin": 0.08, "within": None, "direction": (0.55, -1.0, 0.5)},
    }  # fmt: skip
    auto = {
        "times": True, "camera": True, "turn_lights": True, "moving": list(moving), "statics": list(statics),
        "standing": list(statics), "clear": [],
    }  # fmt: skip
    lights = {"key": {"kind": "sun", "direction": (0.5, 0.5, -1.0)}}
    plain = {"resolution": (1280, 720), "fps": 25.0, "speed": 1.0, "start": 0.0, "end": DURATION, "shots": []}
    plain |= {"cameras": {"main": camera}, "auto": auto, "lights": lights, "background": (0.8, 0.8, 0.8)}
    return plain | {"overlay": {"title": None, "time": False, "values": [], "inset": False}} | more


def falls(t):
    """Waits for 2 s, falls a metre, and lies there."""
    return np.array([0.0, 0.0, max(1.1 - 4.905 * max(t - 2.0, 0.0) ** 2, 0.1)])


def test_waiting_is_left_out_and_the_film_ends_on_what_came_of_it():
    made = directed(film(["ball"]), Ways({"ball": ((0.1, 0.1, 0.1), falls)}))
    shots = made["shots"]
    assert 1.0 < shots[0]["from"] < 2.0, "the two seconds before the fall are not shown"
    assert 2.45 < shots[-1]["to"] < 4.0, "nor is all the time in which it lies there"
    lying = (shots[-1]["to"] - 2.45) / shots[-1]["speed"] + shots[-1]["hold"]
    assert 0.5 < lying < 1.6, "but it is seen lying"
    assert all(a["to"] == pytest.approx(b["from"]) for a, b in zip(shots, shots[1:], strict=False)), "no jump in time"
    assert made["overlay"]["pace"], "slow motion is said"


def test_the_decisive_moment_is_slow():
    def struck(t):
        return np.array([-2.0 + 4 * min(t, 0.5) + 0.2 * max(t - 0.5, 0.0), 0, 0.1])

    ways = Ways({"ball": ((0.1, 0.1, 0.1), struck), "post": ((0.1, 0.1, 1), standing(1.0, 0.5, 1.0))})
    shots = directed(film(["ball"], ["post"]), ways)["shots"]
    (slow,) = [shot for shot in shots if shot["from"] <= 0.5 < shot["to"]]
    assert slow["speed"] < 0.6 * max(shot["speed"] for shot in shots)


def test_a_steady_motion_is_shown_as_it_is():
    def turns(t):
        return np.array([np.cos(2 * t), 0.0, 1.2 + np.sin(2 * t)])

    (shot,) = directed(film(["ball"]), Ways({"ball": ((0.3, 0.3, 0.3), turns)}))["shots"]
    assert (shot["from"], shot["to"], shot["speed"]) == (0.0, DURATION, 1.0)


def test_what_an_author_decides_stays():
    given = film(["ball"])
    given["auto"] |= {"times": False}
    assert directed(given, Ways({"ball": ((0.1, 0.1, 0.1), falls)}))["shots"] == []
    decided = film(["ball"], auto=None)
    assert directed(decided, Ways({"ball": ((0.1, 0.1, 0.1), falls)})) is decided


def swings(t):
    return np.array([np.sin(2 * t), 0.0, 0.5])


def stands_at(made, t=1.0):
    camera = made["cameras"]["main"]
    pos, look_at = (np.asarray(point, float) for point in place(camera, t, 0.0, None)[:2])
    return (pos - look_at) / np.linalg.norm(pos - look_at)


def test_nothing_stands_between_the_camera_and_what_moves():
    wall = ((3.0, 0.05, 1.0), standing(0, -1.0, 1.0))
    open_ = directed(film(["ball"]), Ways({"ball": ((0.2, 0.2, 0.2), swings)}))
    assert stands_at(open_)[1] < -0.5, "from the front"
    ways = Ways({"ball": ((0.2, 0.2, 0.2), swings), "wall": wall})
    behind = film(["ball"])
    behind["auto"]["standing"] = ["wall"]
    way = stands_at(directed(behind, ways))
    assert way[1] > -0.1 or way[2] > 0.7, "from behind, beside, or above"


def test_motion_goes_across_the_picture_and_lamps_come_along():
    def comes(t):
        return np.array([0.0, np.sin(2 * t), 0.5])

    made = directed(film(["ball"]), Ways({"ball": ((0.2, 0.2, 0.2), comes)}))
    assert abs(stands_at(made)[0]) > abs(stands_at(made)[1]), "from the side, not head-on"
    x, y, z = made["lights"]["key"]["direction"]
    assert np.hypot(x, y) == pytest.approx(np.hypot(0.5, 0.5), abs=1e-3)
    assert (x, y) != (0.5, 0.5)
    assert z == -1.0


def test_a_flat_thing_is_not_seen_edge_on():
    flat = Ways({"card": ((0.01, 0.5, 0.5), lambda t: np.array([0, 0, 0.6 + 0.2 * np.sin(3 * t)]))})
    assert abs(stands_at(directed(film(["card"]), flat))[0]) > 0.6


def test_a_dark_thing_is_not_shown_before_a_dark_one():
    moves = ((0.2, 0.2, 0.2), lambda t: np.array([0, 0, 0.6 + 0.3 * np.sin(3 * t)]))
    post = ((0.6, 0.1, 2.0), standing(-0.62, 1.1, 1.0))  # right behind it, from where one usually looks
    dark = (0.05, 0.05, 0.05)
    before = {}
    for color in (dark, (0.9, 0.9, 0.9)):
        given = film(["anchor"])
        given["auto"]["standing"] = ["post"]
        ways = Ways({"anchor": moves, "post": post}, {"anchor": dark, "post": color})
        before[color] = stands_at(directed(given, ways))
    assert not np.allclose(before[dark], before[0.9, 0.9, 0.9])


def test_the_camera_goes_along_where_the_way_is_long():
    made = directed(film(["ball"]), Ways({"ball": ((0.1, 0.1, 0.1), lambda t: np.array([1.5 * t, 0, 0.1]))}))
    assert made["cameras"]["main"]["kind"] == "keyframed"
    cameras = Cameras(made, None)
    for t in np.linspace(0.2, DURATION - 0.2, 8):
        cloud = np.array([1.5 * t, 0, 0.1]) + CORNERS * 0.1
        places = project(cameras.view("main", t), cloud, 16 / 9)
        assert (np.abs(places[:, :2]) < 1).all(), "it is never cut off"
        assert np.ptp(places[:, 0]) > 0.05, "and never a speck"


def test_one_shard_does_not_make_all_others_small():
    def shard(t):
        return np.array([0.0, 0.0, 0.1]) + t * np.array([2.0, 0.3, 0])

    things = {f"brick[{k}]": ((0.1, 0.1, 0.1), standing(0.25 * (k % 6), 0, 0.1 + 0.2 * (k // 6))) for k in range(60)}
    still = {name: thing for name, thing in things.items() if name != "brick[7]"}

    class Bricks(Ways):
        def bounds(self, names, t):
            return super().bounds(list(self._things), t)

        tracks = bounds

        def boxes(self, names):
            return super().boxes(list(self._things))

    def away(things):
        camera = directed(film(["brick"]), Bricks(things))["cameras"]["main"]
        return np.linalg.norm(np.subtract(camera["pos"], camera["look_at"]))

    whole = {**still, "brick[7]": ((0.1, 0.1, 0.1), shard)}
    assert away(whole) < 2.5 * away(things), "12 m away it may leave the picture"


def test_a_camera_that_goes_along_leaves_out_what_is_lost():
    class Broken(Ways):
        def bounds(self, names, t):
            return np.concatenate([super().bounds(names, t), np.full((1, 3), np.nan)])

        tracks = Ways.bounds

    camera = directed(film(["ball"]), Broken({"ball": ((0.05, 0.05, 0.05), lambda t: np.array([2.0 * t, 0, 0.5]))}))
    (made,) = camera["cameras"].values()
    assert made["kind"] == "keyframed"
    assert np.isfinite(made["positions"]).all()
    assert np.isfinite(made["look_at"]).all()


def test_the_camera_goes_along_with_what_moves_and_not_with_what_waits_for_it():
    def rolls(t):
        return np.array([-3.0 + 6.0 * min(t / 4, 1.0), 0, 0.15])

    def is_hit(t):
        return np.array([3.4 + 0.3 * max(min(t, 4.6) - 4, 0.0), 0, 0.1])

    def drops(t):
        return np.array([-3.5, 0, 0.4 - 0.3 * min(t / 0.3, 1.0)])

    ways = Ways({"cart": ((0.3, 0.2, 0.15), rolls), "cone": ((0.1, 0.1, 0.2), is_hit), "peg": ((0.05,) * 3, drops)})
    made = directed(film(["cart", "cone", "peg"], overlay={}), ways)
    camera = made["cameras"]["main"]
    assert camera["kind"] == "keyframed"
    away = np.linalg.norm(np.subtract(camera["positions"], camera["look_at"]), axis=1)
    whole = away[0]
    assert away.min() < 0.6 * whole, "it comes nearer than all three together allow"
    view = Cameras(made, None).view("main", float(camera["times"][-1]))
    last = camera["times"][-1]
    for way, half, seen in ((rolls, 0.3, True), (is_hit, 0.1, True), (drops, 0.05, False)):
        places = project(view, way(last) + CORNERS * half, 16 / 9)[:, :2]
        assert (np.abs(places) < 1).all() == seen, "the peg has lain there long since"


OUTSIDE = {"backdrop": {"kind": "horizon", "level": 0.0, "skyline": "wood"}}


@pytest.mark.parametrize(
    ("height", "place_", "table", "low"),
    [
        (3.0, OUTSIDE, 0.5, True),
        (0.5, OUTSIDE, 0.02, False),
        (3.0, OUTSIDE, 2.5, False),
        (3.0, {"backdrop": {"kind": "wall", "level": 0.0}}, 0.5, False),
    ],
    ids=["aloft", "near the ground", "on a table", "indoors"],
)
def test_what_stays_aloft_out_of_doors_is_seen_against_the_sky(height, place_, table, low):
    def waves(t):
        return np.array([0.6 + 0.1 * np.sin(3 * t), 0.3 * np.sin(2 * t), height + 0.2 * np.sin(3 * t)])

    things = {"flag": ((0.6, 0.02, 0.3), waves), "table": ((1.5, 1.5, table / 2), standing(0.6, 0, table / 2))}
    made = directed(film(["flag"], ["table"], **place_), Ways(things))
    x, y, z = stands_at(made)
    assert (np.degrees(np.arctan2(z, np.hypot(x, y))) < 5) == low
    camera = made["cameras"]["main"]
    pos = camera["pos"] if "pos" in camera else camera["positions"][0]
    assert pos[2] > 0.1, "and not from below the ground"


class Copies(Ways):
    """The same, where `brick` stands for all its copies."""

    def _all(self, names):
        return [name for name in self._things if name in names or name.split("[")[0] in names]

    def bounds(self, names, t):
        return super().bounds(self._all(names), t)

    tracks = bounds

    def boxes(self, names):
        return super().boxes(self._all(names))


def sizes(made, points_at):
    """The larger of width and height that points fill in the picture, 0 to 1, at times over all of the film."""
    cameras, found = Cameras(made, None), []
    for t in np.linspace(made["shots"][0]["from"], made["shots"][-1]["to"], 25):
        places = project(cameras.view("main", t), points_at(t), 16 / 9)
        assert (np.abs(places[:, :2]) < 1).all(), f"nothing of it is cut off at {t:.2f} s"
        found.append(np.ptp(places[:, :2], axis=0).max() / 2)
    return np.array(found)


def test_what_most_of_a_burst_wall_does_fills_the_picture_while_a_tenth_of_it_flies_off():
    def brick(k):
        start = np.array([0.25 * (k % 10), 0, 0.1 + 0.2 * (k // 10)])
        heap, thrown = np.array([0.25 * (k % 10), 0.3 * (k // 10), 0.1]), start + (6.0 - 12.0 * (k % 20 == 9), 0, 0)

        def way(t):
            there = np.clip(t - 1, 0, 1)
            return start + there * ((thrown if k % 10 == 9 else heap) - start)

        return way

    ways = Copies({f"brick[{k}]": ((0.12, 0.06, 0.1), brick(k)) for k in range(60)})
    rest = [f"brick[{k}]" for k in range(60) if k % 10 != 9]
    filled = sizes(directed(film(["brick"]), ways), lambda t: ways.bounds(rest, t))
    assert filled.min() > 0.6


def test_a_tower_that_has_fallen_is_seen_from_nearer():
    def block(k):
        return lambda t: np.array([0.27 * k * np.clip(t - 1, 0, 1), 0, 0.1 + 0.2 * k * (1 - np.clip(t - 1, 0, 1))])

    ways = Copies({f"block[{k}]": ((0.1, 0.1, 0.1), block(k)) for k in range(12)})
    made = directed(film(["block"]), ways)
    filled = sizes(made, lambda t: ways.bounds(["block"], t))
    assert filled[-1] > 0.7, "what lies there at last, and not in the room that the tower took up"
    assert np.median(filled) > 0.6


def test_what_waits_beside_what_moves_is_not_cut_off():
    def turns(t):
        return np.array([-0.4, 0, 0.6 + 0.9 * max(1 - t, 0)])

    def swings_little(t):
        return np.array([0.0, 0.0, 0.5 + 0.05 * np.sin(3 * t)])

    holder = ((0.08, 0.08, 0.08), standing(0.42, 0, 0.6))
    ways = Ways({"turner": ((0.08,) * 3, turns), "cord": ((0.34, 0.02, 0.05), swings_little), "holder": holder})
    made = directed(film(["turner", "cord", "holder"]), ways)
    assert made["cameras"]["main"]["kind"] == "keyframed"
    assert sizes(made, lambda t: ways.bounds(["holder", "cord"], t)).min() > 0.25


def test_one_ball_among_many_bricks_is_not_hidden():
    wall = {f"brick[{k}]": ((0.12, 0.06, 0.1), standing(0.25 * (k % 10), 0, 0.1 + 0.2 * (k // 10))) for k in range(61)}
    ball = {"ball": ((0.1, 0.1, 0.1), lambda t: np.array([1.1 + 0.2 * np.sin(2 * t), 0.8, 0.4]))}
    made = directed(film(["brick", "ball"]), Copies(wall | ball))
    way = stands_at(made)
    assert way[1] > -0.1 or way[2] > 0.6, "from in front of the wall nobody sees it"


def test_what_moves_in_a_glass_is_seen_with_all_of_the_glass():
    def sinks(t):
        return np.array([0.0, 0.0, max(0.7 - 0.6 * t, 0.1)])

    ways = Ways({"ball": ((0.08, 0.08, 0.08), sinks), "glass": ((0.15, 0.15, 0.4), standing(0, 0, 0.4))})
    filled = sizes(directed(film(["ball"], ["glass"]), ways), lambda t: ways.bounds(["glass"], t))
    assert filled.min() > 0.6


def test_a_body_with_far_larger_decor_is_seen_as_near_as_without():
    def rolls(t):
        return np.array([0.3 * t - 1, 0, 0.1])

    def distance(auto, things):
        given = film(["cart"])
        camera = directed(given | {"auto": given["auto"] | auto}, Ways(things))["cameras"]["main"]
        pos, look_at, _ = place(camera, 1.0, 0.0, None)
        return np.linalg.norm(np.subtract(pos, look_at))

    bed, whole = ((0.15, 0.1, 0.1), rolls), ((0.15, 0.1, 2.0), rolls)
    alone = distance({}, {"cart": bed})
    flagged = {"cart": whole, "cart.bed": bed}
    assert distance({}, flagged) > 1.5 * alone
    assert distance({"bare": {"cart": ["cart.bed"]}}, flagged) < 1.2 * alone


def test_what_a_spring_hangs_from_is_in_the_picture():
    def bounces(t):
        return np.array([0.3 * np.sin(t), 0.0, 1.0 + 0.2 * np.cos(6 * t)])

    class Hung(Ways):
        def spring_ends(self, t):
            return np.array([[bounces(t), [0.0, 0.0, 2.4]]])

    things = {"bob": ((0.1, 0.1, 0.1), bounces), "beam": ((0.5, 0.05, 0.05), standing(0, 0, 2.4))}
    for ways in (Hung(things), Ways(things)):
        cameras = Cameras(directed(film(["bob"], ["beam"]), ways), None)
        views = [cameras.view("main", t) for t in np.linspace(0.5, DURATION - 0.5, 9)]
        inside = [abs(project(view, np.array([[0.0, 0.0, 2.4]]), 16 / 9)[0, 1]) < 1 for view in views]
        assert all(inside) == isinstance(ways, Hung)
