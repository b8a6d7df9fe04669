"""Bodies that are too fast for the first body they meet, and the predicted flight up to it."""

import math
from pathlib import Path

import pytest
from lint_support import facts_of, findings

from text2sim.lint.motion.flight import flight_of

PLATE = "scene: {gravity: [0, 0, 0], dt: 0.01, substeps: %d, statics: {plate: {shape: {kind: box, size: [1, %s, 1]}, pose: {pos: [0, 2, 0.5], euler_deg: %s}}}}"
SHOT = "bodies: {shot: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.8]}}}"
LAUNCH = "actions: {controls: {launch: {kind: initial_velocity, body: shot, linear: %s}}}"


def plate(substeps: int = 2, thickness: float = 0.01, turned: str = "[0, 0, 0]") -> str:
    return PLATE % (substeps, thickness, turned)


@pytest.mark.parametrize(
    ("speed", "substeps", "thickness", "count"),
    [
        # Past the middle in one substep of 5 ms from (40 mm + thickness) / 2 on.
        (4.9, 2, 0.01, 0),
        (5.2, 2, 0.01, 1),
        (4.9, 1, 0.01, 1),
        (10.0, 2, 0.07, 0),
        (30.0, 20, 0.01, 0),
    ],
)
def test_the_bound(tmp_path: Path, speed: float, substeps: int, thickness: float, count: int) -> None:
    parts = plate(substeps, thickness), SHOT, LAUNCH % f"[0, {speed}, 0]"
    assert len(findings(tmp_path, "tunnelling", *parts)) == count


def test_the_way_out_is_one(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "tunnelling", plate(), SHOT, LAUNCH % "[0, 12, 0]")
    assert found.path == "/actions/controls/launch"
    assert "`shot` meets `plate` at 12 m/s" in found.message
    assert "scene.substeps of 5 or more" in found.message
    assert findings(tmp_path, "tunnelling", plate(5), SHOT, LAUNCH % "[0, 12, 0]") == []


def test_what_flies_past_meets_nothing(tmp_path: Path) -> None:
    assert findings(tmp_path, "tunnelling", plate(), SHOT, LAUNCH % "[8, 20, 0]") == []


def test_what_is_thick_stops_it_first(tmp_path: Path) -> None:
    block = "scene: {statics: {block: {shape: {kind: box, size: [1, 0.4, 1]}, pose: {pos: [0, 1, 0.5]}}}}"
    assert findings(tmp_path, "tunnelling", plate(), block, SHOT, LAUNCH % "[0, 12, 0]") == []


def test_a_glancing_hit_is_slow_across_the_plate(tmp_path: Path) -> None:
    assert len(findings(tmp_path, "tunnelling", plate(turned="[0, 0, 20]"), SHOT, LAUNCH % "[0, 6, 0]")) == 1
    assert findings(tmp_path, "tunnelling", plate(turned="[0, 0, 70]"), SHOT, LAUNCH % "[0, 6, 0]") == []


def test_a_fall(tmp_path: Path) -> None:
    table = "scene: {dt: 0.02, substeps: 1, duration: 3, statics: {table: {shape: {kind: box, size: [1, 1, 0.01]}, pose: {pos: [0, 0, 0.5]}}}}"
    high = "bodies: {shot: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, %s]}}}"
    assert findings(tmp_path, "tunnelling", table, high % 0.56) == []
    (found,) = findings(tmp_path, "tunnelling", table, high % 2.5)
    assert found.path == "/bodies/shot/pose"


def test_the_ground_is_passed_by_what_is_wholly_below_it(tmp_path: Path) -> None:
    fall = "bodies: {shot: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 20]}}}"
    scene = "scene: {duration: 5, dt: 0.01, substeps: %d}"
    # 19.8 m/s: 40 mm in 2 ms.
    assert findings(tmp_path, "tunnelling", scene % 5, fall) == []
    assert len(findings(tmp_path, "tunnelling", scene % 4, fall)) == 1


def test_a_paddle_that_nothing_stops(tmp_path: Path) -> None:
    paddle = "paddle: {kind: driven, shape: {kind: box, size: [0.01, 0.3, 0.3]}, pose: {pos: [0, 0, 0.5]}, motion: {kind: oscillate, amplitude: 0.5, frequency: %s}}"
    leaf = "leaf: {kind: rigid, shape: {kind: sphere, radius: 0.01}, pose: {pos: [%s, 0, 0.5]}}"
    scene = "scene: {dt: 0.01, substeps: 2}"

    def found(frequency: float, x: float) -> int:
        return len(findings(tmp_path, "tunnelling", scene, f"bodies: {{{paddle % frequency}, {leaf % x}}}"))

    assert found(2, 0.3) == 1, "6.3 m/s make 31 mm in a substep"
    assert found(0.5, 0.3) == 0
    assert found(2, 0.8) == 0, "out of reach"


def test_a_blade_is_fast_at_its_end(tmp_path: Path) -> None:
    fan = "fan: {kind: driven, shape: {kind: box, size: [1, 0.01, 0.1]}, pose: {pos: [0, 0, 0.5]}, motion: {kind: spin, speed: %s}}"
    leaf = "leaf: {kind: rigid, shape: {kind: sphere, radius: 0.01}, pose: {pos: [0.2, 0.3, 0.5]}}"
    scene = "scene: {dt: 0.01, substeps: 2}"
    assert len(findings(tmp_path, "tunnelling", scene, f"bodies: {{{fan % 10}, {leaf}}}")) == 1
    assert findings(tmp_path, "tunnelling", scene, f"bodies: {{{fan % 2}, {leaf}}}") == []


class TestFlight:
    def test_a_fall_ends_on_the_ground(self) -> None:
        facts = facts_of("bodies: {b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 2.1]}}}")
        flight = flight_of(facts, facts.copies["b"])
        assert flight is not None
        assert flight.meeting is not None
        assert flight.end == pytest.approx(math.sqrt(2 * 2 / 9.81), rel=1e-6)
        assert flight.meeting.velocity == pytest.approx((0, 0, -math.sqrt(2 * 9.81 * 2)))

    def test_a_throw_meets_a_wall_where_the_parabola_does(self) -> None:
        facts = facts_of(
            "scene: {statics: {wall: {shape: {kind: box, size: [0.2, 4, 4]}, pose: {pos: [3.1, 0, 2]}}}}\n"
            "bodies: {b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}}\n"
            "actions: {controls: {go: {kind: initial_velocity, body: b, linear: [5, 0, 3]}}}"
        )
        flight = flight_of(facts, facts.copies["b"])
        assert flight is not None
        assert flight.meeting is not None
        assert flight.meeting.other.name == "wall"
        assert flight.end == pytest.approx((3.0 - 0.1) / 5, rel=2e-3)

    def test_what_stands_does_not_fall(self) -> None:
        facts = facts_of(
            "bodies: {a: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, place: {on: floor}}, "
            "b: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, place: {on: a}}}"
        )
        flights = [flight_of(facts, facts.copies[name]) for name in "ab"]
        assert [flight is not None and flight.moves for flight in flights] == [False, False]

    def test_what_slides_on_the_ground_meets_what_stands_there(self) -> None:
        facts = facts_of(
            "bodies: {a: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, place: {on: floor}}, "
            "b: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, place: {on: floor, at: [4, 0]}}}\n"
            "actions: {controls: {go: {kind: initial_velocity, body: a, linear: [5, 0, 0]}}}"
        )
        flight = flight_of(facts, facts.copies["a"])
        assert flight is not None
        assert flight.meeting is not None
        assert flight.meeting.other.name == "b"
        assert flight.end == pytest.approx(0.6, rel=1e-3)


@pytest.mark.parametrize(("height", "damping", "known"), [(0.8, 0, True), (0.8, 1, False), (0.02, 1, True)])
def test_the_path_of_a_damped_body_is_unknown_unless_it_lies(
    tmp_path: Path, height: float, damping: float, known: bool
) -> None:
    shot = f"bodies: {{shot: {{pose: {{pos: [0, 0, {height}]}}, mount: {{kind: free, damping: {damping}}}}}}}"
    facts = facts_of(SHOT, shot)
    assert (flight_of(facts, facts.copies["shot"]) is not None) == known
