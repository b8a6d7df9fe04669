"""Subjects that no camera shows, or that leave every picture; the cameras agree with those of the drawing."""

from pathlib import Path

import numpy as np
import pytest
from lint_support import data_of, findings

from text2sim.compiler.build import resolve_case
from text2sim.drawing.views import cameras, film_view
from text2sim.lint.facts import Facts
from text2sim.lint.film.case_cameras import views_at
from text2sim.spec_schema.load import load_case, load_text

BALL = "bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: {0}}}{1}}}}}"
SCRIPT = "actions: {measures: {height: {kind: position, of: ball, axis: z}}, expect: {falls: {measure: height, at: end, below: 0.2}}}"
STILL = "render: {{cameras: {{main: {{kind: still, from: {0}, look_at: {1}}}}}}}"


@pytest.mark.parametrize("t", [0.0, 0.7, 5.0])
def test_they_see_what_the_drawing_sees(cases: Path, t: float) -> None:
    points = np.array([[0, 0, 0], [1, 2, 0.5], [-0.3, 0.2, 0.1]], float)
    compared = 0
    for path in sorted(cases.iterdir()):
        if not (path / "case.yaml").is_file():
            continue
        resolution = resolve_case(load_case(path))
        for camera in views_at(Facts(resolution), t):
            view = film_view(resolution, camera.name, (160, 90), t)
            for point, (column, row) in zip(points, view.pixels(points), strict=True):
                x, y, depth = camera.project(tuple(point))
                if depth > 0:
                    assert ((x + 1) / 2 * view.width, (1 - y) / 2 * view.height) == pytest.approx(
                        (column, row), abs=0.5
                    )
                    compared += 1
        assert {camera.name for camera in views_at(Facts(resolution), t)} == set(cameras(resolution))
    assert compared > 10


class TestUnseen:
    def test_behind_the_camera(self, tmp_path: Path) -> None:
        parts = BALL.format("[0, -6, 0.5]", ""), SCRIPT, STILL.format("[0, -4, 1]", "[0, 0, 0.5]")
        (found,) = findings(tmp_path, "unseen-subject", *parts)
        assert found.path == "/render/cameras/main"
        assert "it is behind the camera; set look_at to [0, -6, 0.5]" in found.message

    def test_a_mounted_camera_is_told_the_point_in_its_own_frame(self, tmp_path: Path) -> None:
        pole = "bodies: {pole: {kind: driven, shape: {kind: box, size: [0.1, 0.1, 1]}, pose: {pos: [1, 2, 3], euler_deg: [0, 0, 90]}, motion: {kind: spin, axis: z, speed: 1}}}"
        camera = "render: {cameras: {main: {kind: mounted, on: pole, pos: [0, 0.2, 0.8], look_at: [0, 2, 0.8]}}}"
        (found,) = findings(tmp_path, "unseen-subject", BALL.format("[3, 2, 3]", ""), pole, SCRIPT, camera)
        # 2 m along the world's x is 2 m along -y of a frame turned by 90 deg about z; the camera looks along its y, -x.
        assert "it is behind the camera; set look_at to [0, -2, 0] in the frame of what carries it" in found.message

    def test_beside_the_picture_with_the_angle_that_holds_it(self, tmp_path: Path) -> None:
        parts = BALL.format("[0, 0, 3]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]")
        (found,) = findings(tmp_path, "unseen-subject", *parts)
        # 2.5 m up at a distance of 4 m: 2 atan(2.5 / 4) = 64 deg, and a tenth more.
        assert "from 40 to 70.4 deg" in found.message

    def test_one_camera_of_two_is_enough(self, tmp_path: Path) -> None:
        second = "render: {cameras: {second: {kind: still, from: [0, -4, 3], look_at: ball}}}"
        parts = BALL.format("[0, 0, 3]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]")
        assert findings(tmp_path, "unseen-subject", *parts, second) == []

    def test_only_what_the_script_is_about_counts(self, tmp_path: Path) -> None:
        parts = BALL.format("[0, -6, 0.5]", ""), STILL.format("[0, -4, 1]", "[0, 0, 0.5]")
        assert findings(tmp_path, "unseen-subject", *parts) == []
        throw = "actions: {controls: {go: {kind: initial_velocity, body: ball, linear: [1, 0, 0]}}}"
        assert len(findings(tmp_path, "unseen-subject", *parts, throw)) == 1

    @pytest.mark.parametrize(("pace", "count"), [(2, 0), (-2, 1), (0, 1)])
    def test_what_rolls_in_from_outside(self, tmp_path: Path, pace: float, count: int) -> None:
        # At 4 m the picture is 2 * 4 * tan(20 deg) * 16 / 9 = 5.2 m wide: it comes in after 1.4 m, in the first second.
        parts = BALL.format("[-4, 0, 0.1]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]")
        roll = f"actions: {{controls: {{roll: {{kind: initial_velocity, body: ball, linear: [{pace}, 0, 0]}}}}}}"
        still = "actions: {}"
        assert len(findings(tmp_path, "unseen-subject", *parts, roll if pace else still)) == count

    def test_what_is_drawn_invisible_is_meant_to_be(self, tmp_path: Path) -> None:
        ball = BALL.format("[0, -6, 0.5]", ", look: {visible: false}")
        assert findings(tmp_path, "unseen-subject", ball, SCRIPT, STILL.format("[0, -4, 1]", "[0, 0, 0.5]")) == []

    @pytest.mark.parametrize(("width", "count"), [(2, 1), (0.15, 0)])
    def test_behind_a_wall(self, tmp_path: Path, width: float, count: int) -> None:
        wall = f"scene: {{statics: {{wall: {{shape: {{kind: box, size: [{width}, 0.1, 1]}}, place: {{on: floor, at: [0, -1]}}}}}}}}"
        parts = BALL.format("[0, 0, 0.5]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]"), wall
        found = findings(tmp_path, "unseen-subject", *parts)
        assert len(found) == count
        assert all("hidden behind `wall`" in problem.message for problem in found)

    def test_glass_hides_nothing(self, tmp_path: Path) -> None:
        wall = "scene: {statics: {wall: {shape: {kind: box, size: [2, 0.1, 1]}, place: {on: floor, at: [0, -1]}, look: {opacity: 0.3}}}}"
        parts = BALL.format("[0, 0, 0.5]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]"), wall
        assert findings(tmp_path, "unseen-subject", *parts) == []

    @pytest.mark.parametrize(("look", "count"), [("{}", 1), ("{opacity: 0.3}", 0), ("{finish: glass}", 0), (None, 0)])
    def test_a_gate_with_a_door(self, tmp_path: Path, look: str | None, count: int) -> None:
        door = f"door: {{shape: {{kind: box, size: [0.8, 0.1, 1]}}, look: {look}}}," if look else ""
        post = "{{shape: {{kind: box, size: [0.2, 0.1, 1]}}, pose: {{pos: [{}, 0, 0]}}}}"
        gate = f"{{kind: compound, parts: {{{door} left: {post.format(-0.5)}, right: {post.format(0.5)}}}}}"
        parts = BALL.format("[0, 0, 0.5]", ""), SCRIPT, STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]")
        scene = f"scene: {{statics: {{gate: {{shape: {gate}, place: {{on: floor, at: [0, -1]}}}}}}}}"
        found = findings(tmp_path, "unseen-subject", *parts, scene)
        assert len(found) == count
        assert all("hidden behind `gate`" in problem.message for problem in found)


def test_a_tiny_subject_and_the_distance_that_shows_it(tmp_path: Path) -> None:
    far = BALL.format("[0, 0, 0.5]", ""), SCRIPT, STILL.format("[0, -12, 0.5]", "[0, 0, 0.5]")
    (problem,) = findings(tmp_path, "small-subject", *far)
    assert problem.message.endswith("move it to 2.89 m")
    farther = far[0], far[1], STILL.format("[0, -60, 0.5]", "[0, 0, 0.5]")
    (problem,) = findings(tmp_path, "small-subject", *farther)
    assert "add a second camera" in problem.message, "one there would show nothing else"
    near = STILL.format("[0, -5, 0.5]", "[0, 0, 0.5]")
    assert findings(tmp_path, "small-subject", *far, near) == []


def test_a_small_subject_that_is_framed_with_others(tmp_path: Path) -> None:
    frame = "render: {cameras: {main: {kind: still, direction: [0, -1, 0.3], frame: [ball, cube]}}}"
    cube = "bodies: {cube: {kind: rigid, shape: {kind: box, size: [2, 2, 2]}, pose: {pos: [%g, 0, 1]}}}"
    ball = BALL.format("[0, 0, 0.1]", "")
    assert findings(tmp_path, "small-subject", ball, SCRIPT, frame, cube % 9) == [], "no nearer place shows both"
    (problem,) = findings(tmp_path, "small-subject", ball, SCRIPT, frame, cube % 30)
    assert "add a second camera" in problem.message


class TestLeaves:
    THROW = "actions: {controls: {go: {kind: initial_velocity, body: ball, linear: %s}}}"
    VIEW = STILL.format("[0, -4, 0.5]", "[0, 0, 0.5]")

    def test_where_it_comes_down(self, tmp_path: Path) -> None:
        ball = BALL.format("[0, 0, 1]", "")
        assert findings(tmp_path, "leaves-picture", ball, self.VIEW, self.THROW % "[2, 0, 0]") == []
        (found,) = findings(tmp_path, "leaves-picture", ball, self.VIEW, self.THROW % "[8, 0, 0]")
        assert "flies out of every camera's picture after" in found.message

    def test_a_frame_follows_what_is_thrown(self, tmp_path: Path) -> None:
        ball = BALL.format("[0, 0, 0.5]", "")
        throw = self.THROW % "[8, 0, 4]"
        assert len(findings(tmp_path, "leaves-picture", ball, throw, STILL.format("[0, -4, 1]", "[0, 0, 0.5]"))) == 1
        frame = "render: {cameras: {main: {kind: still, frame: [ball]}}}"
        assert findings(tmp_path, "leaves-picture", ball, throw, frame) == []

    def test_a_camera_that_follows_it(self, tmp_path: Path) -> None:
        follow = "render: {cameras: {main: {kind: follow, body: ball, from: [0, -4, 0.5], look_at: null}}}"
        ball = BALL.format("[0, 0, 1]", "")
        assert findings(tmp_path, "leaves-picture", ball, self.VIEW, follow, self.THROW % "[8, 0, 0]") == []

    def test_what_is_expected_to_get_away(self, tmp_path: Path) -> None:
        gone = "scene: {domain: {min: [-1, -1, 0], max: [1, 1, 2]}}\nactions: {events: {gone: {kind: left_domain, of: ball}}}"
        ball = BALL.format("[0, 0, 1]", "")
        assert findings(tmp_path, "leaves-picture", ball, self.VIEW, gone, self.THROW % "[8, 0, 0]") == []

        of_several = gone.replace("of: ball", "of: [other, ball]")
        other = "bodies: {other: {kind: rigid, shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 0.5, 0.05]}}}"
        case = (ball, other, self.VIEW, of_several, self.THROW % "[8, 0, 0]")
        assert findings(tmp_path, "leaves-picture", *case) == []

    def test_what_is_driven_in_from_outside(self, tmp_path: Path) -> None:
        cart = "bodies: {cart: {kind: driven, shape: {kind: box, size: [0.3, 0.3, 0.3]}, pose: {pos: [-6, 0, 0.5]}, motion: {kind: waypoints, times: [0, 0.5], positions: [[0, 0, 0], [%s, 0, 0]]}}}"
        about = "actions: {measures: {x: {kind: position, of: cart, axis: x}}, expect: {goes: {measure: x, at: end, above: -5}}}"
        for rule in ("leaves-picture", "unseen-subject"):
            assert findings(tmp_path, rule, cart % 6, about, self.VIEW) == []
        assert len(findings(tmp_path, "unseen-subject", cart % -6, about, self.VIEW)) == 1

    # At 4 m the picture is 2.6 m wide to each side; a swing of A is outside it for 1 - 2/pi asin(2.6 / A) of the time.
    @pytest.mark.parametrize(("amplitude", "count"), [(1, 0), (3, 0), (6, 1)])
    def test_a_driven_body(self, tmp_path: Path, amplitude: float, count: int) -> None:
        cart = f"bodies: {{cart: {{kind: driven, shape: {{kind: box, size: [0.3, 0.3, 0.3]}}, pose: {{pos: [0, 0, 0.5]}}, motion: {{kind: oscillate, amplitude: {amplitude}, frequency: 1}}}}}}"
        about = "actions: {measures: {x: {kind: position, of: cart, axis: x}}, expect: {goes: {measure: x, at: 0.25, above: 0.5}}}"
        assert len(findings(tmp_path, "leaves-picture", cart, about, self.VIEW)) == count


def test_no_camera_no_finding() -> None:
    text = '{"text2sim": 1, "name": "a", "scene": {"duration": 1}, "bodies": {"b": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 1}}}}'
    assert data_of()["name"] == "example"
    assert views_at(Facts(resolve_case(load_text(text))), 0.0)[0].shows((0.0, 0.0, 0.0))
