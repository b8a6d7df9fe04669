"""Bodies below the ground, beside it or above nothing, and gravity that points up."""

from pathlib import Path

import pytest
from lint_support import findings

BALL = "bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: {0}}}{1}}}}}"


class TestUnderFloor:
    @pytest.mark.parametrize(
        ("height", "severity", "words"),
        [
            (0.06, "warning", "partly below `floor` at the start, by 40 mm"),
            (-0.05, "error", "partly below `floor` at the start, by 150 mm"),
            (-0.3, "error", "entirely below `floor` at the start, by 400 mm: the engine does not bring it back"),
        ],
    )
    def test_depth(self, tmp_path: Path, height: float, severity: str, words: str) -> None:
        (found,) = findings(tmp_path, "under-floor", BALL.format(f"[0, 0, {height}]", ""))
        assert found.severity == severity
        assert words in found.message
        assert found.path == "/bodies/ball/pose"

    @pytest.mark.parametrize("height", [0.1, 0.0995, 5])
    def test_what_touches_is_fine(self, tmp_path: Path, height: float) -> None:
        assert findings(tmp_path, "under-floor", BALL.format(f"[0, 0, {height}]", "")) == []

    def test_what_is_held_may_reach_into_the_ground(self, tmp_path: Path) -> None:
        assert findings(tmp_path, "under-floor", BALL.format("[0, 0, 0]", ", mount: {kind: fixed}")) == []
        (found,) = findings(tmp_path, "under-floor", BALL.format("[0, 0, 0]", ", mount: {kind: hinge}"))
        assert found.severity == "warning"

    def test_a_tilted_plane_has_its_own_up(self, tmp_path: Path) -> None:
        slope = "scene: {statics: {floor: {pose: {euler_deg: [0, 30, 0]}}}}"
        # The plane falls towards +x: 1 m there it is 0.58 m lower.
        assert findings(tmp_path, "under-floor", slope, BALL.format("[1, 0, 0]", "")) == []
        (found,) = findings(tmp_path, "under-floor", slope, BALL.format("[-1, 0, 0.5]", ""))
        assert "move it along [0.5, 0, 0.866]" in found.message

    def test_copies_are_counted(self, tmp_path: Path) -> None:
        more = ", repeat: {kind: line, count: 5, step: [0.3, 0, 0.01]}"
        (found,) = findings(tmp_path, "under-floor", BALL.format("[0, 0, 0.07]", more))
        assert "`ball[0]`" in found.message
        assert "by 30 mm (and 2 more of its copies)" in found.message


class TestFloorEnds:
    @pytest.mark.parametrize(("x", "count"), [(19, 0), (21, 1)])
    def test_the_plane_is_as_large_as_it_is_drawn(self, tmp_path: Path, x: float, count: int) -> None:
        assert len(findings(tmp_path, "floor-ends", BALL.format(f"[{x}, 0, 1]", ""))) == count

    def test_a_throw_that_comes_down_beside_it(self, tmp_path: Path) -> None:
        throw = "actions: {controls: {go: {kind: initial_velocity, body: ball, linear: [%s, 0, 9.81]}}}"
        longer = "scene: {duration: 4}"
        near = findings(tmp_path, "floor-ends", longer, BALL.format("[0, 0, 0.1]", ""), throw % 9)
        assert near == []
        (found,) = findings(tmp_path, "floor-ends", longer, BALL.format("[0, 0, 0.1]", ""), throw % 12)
        assert "comes down at x 24" in found.message
        assert "size: 60" in found.message

    def test_what_stands_on_something_else_does_not_need_it(self, tmp_path: Path) -> None:
        island = "scene: {statics: {island: {shape: {kind: box, size: [2, 2, 1]}, pose: {pos: [30, 0, -0.5]}}}}"
        assert findings(tmp_path, "floor-ends", island, BALL.format("[30, 0, 1]", "")) == []


class TestFallsForEver:
    NONE = "scene: {duration: 3, statics: {floor: null}}"

    def test_nothing_below(self, tmp_path: Path) -> None:
        (found,) = findings(tmp_path, "falls-for-ever", self.NONE, BALL.format("[0, 0, 1]", ""))
        assert "44.1 m in 3 s" in found.message

    @pytest.mark.parametrize(
        "part",
        [
            "scene: {gravity: [0, 0, 0]}",
            "scene: {duration: 1}",
            "scene: {statics: {table: {shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [0, 0, 0.5]}}}}",
            "scene: {domain: {min: [-1, -1, -1], max: [1, 1, 1]}}\nactions: {events: {gone: {kind: left_domain, of: ball}}}",
            "actions: {controls: {lift: {kind: force, body: ball, force: [0, 0, 40]}}}",
            "bodies: {hook: {kind: rigid, shape: {kind: box, size: [1, 1, 0.1]}, mount: {kind: fixed}}}\n"
            "actions: {controls: {hang: {kind: attach, body: ball, to: hook}}}",
        ],
    )
    def test_something_holds_it_or_it_is_meant(self, tmp_path: Path, part: str) -> None:
        assert findings(tmp_path, "falls-for-ever", self.NONE, BALL.format("[0, 0, 1]", ""), part) == []

    def test_a_table_too_far_away(self, tmp_path: Path) -> None:
        table = "scene: {statics: {table: {shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [5, 0, 0.5]}}}}"
        assert len(findings(tmp_path, "falls-for-ever", self.NONE, table, BALL.format("[0, 0, 1]", ""))) == 1
        throw = "actions: {controls: {go: {kind: initial_velocity, body: ball, linear: [3, 0, 3]}}}"
        assert findings(tmp_path, "falls-for-ever", self.NONE, table, BALL.format("[0, 0, 1]", ""), throw) == []

    def test_gravity_may_point_elsewhere(self, tmp_path: Path) -> None:
        sideways = "scene: {gravity: [9.81, 0, 0], duration: 3}"
        (found,) = findings(tmp_path, "falls-for-ever", sideways, BALL.format("[0, 0, 1]", ""))
        assert found.path == "/bodies/ball"


def test_what_stands_beside_the_end_of_the_floor(tmp_path: Path) -> None:
    """It rests on nothing: the plane is only as large as it is drawn (in Genesis it fell 4.8 m in 1 s)."""
    pin = "bodies: {{pin: {{kind: rigid, shape: {{kind: cylinder, radius: 0.05, height: 0.3}}, place: {{on: floor, at: [{0}, 0]}}}}}}"
    small = "scene: {statics: {floor: {shape: {kind: plane, size: 10}}}}"
    (found,) = findings(tmp_path, "floor-ends", small, pin.format(6))
    assert "comes down at x 6, y 0 and falls past `floor`, which ends 5 m from its centre" in found.message
    assert not findings(tmp_path, "floor-ends", small, pin.format(4))


@pytest.mark.parametrize(
    ("gravity", "wanted"), [("[0, 0, 9.81]", True), ("[0, 0, -9.81]", False), ("[0, 0, 0]", False)]
)
def test_gravity_that_lifts(tmp_path: Path, gravity: str, wanted: bool) -> None:
    found = findings(tmp_path, "upward-gravity", f"scene: {{gravity: {gravity}}}", BALL.format("[0, 0, 1]", ""))
    assert bool(found) == wanted
    assert all("bodies fall at [0, 0, -9.81]" in problem.message for problem in found)


@pytest.mark.parametrize(
    ("gravity", "wanted"), [("[0, -9.81, 0]", True), ("[4, 0, -8.5]", False), ("[0, 0, 0]", False)]
)
def test_gravity_along_the_ground(tmp_path: Path, gravity: str, wanted: bool) -> None:
    scene = f"scene: {{gravity: {gravity}}}"
    found = findings(tmp_path, "sideways-gravity", scene, BALL.format("[0, 0, 1]", ""))
    assert bool(found) == wanted
    assert all("bodies fall at [0, 0, -9.81]" in problem.message for problem in found)
    no_ground = "scene: {statics: {floor: null}}"
    assert not findings(tmp_path, "sideways-gravity", scene, no_ground, BALL.format("[0, 0, 1]", ""))
