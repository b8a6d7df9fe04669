"""Motion that no force explains, in recordings that are written by equations."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.harness.conftest import WrittenRun
from text2sim.evaluation.keyframes import Motion, motion_of
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.spec_schema.models.case import Case

G = 9.81
BALL = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}


def moved(tmp_path: Path, record: Callable[[WrittenRun], Any], bodies: Any = None, **actions: Any) -> Motion:
    (tmp_path / "run").mkdir()
    run = WrittenRun(tmp_path / "run")
    record(run)
    run.write()
    case = Case.model_validate({
        "text2sim": 2, "name": "case", "scene": {"duration": 1.0, "statics": {"floor": {"shape": {"kind": "plane"}}}},
        "bodies": bodies or {"ball": BALL}, "actions": actions,
    })  # fmt: skip
    return motion_of(RecordedCase.load(run.folder, case))


def along(run: WrittenRun, z: Any, v: Any) -> dict[str, Any]:
    zero = 0 * run.time
    return {"pos": np.stack([zero, zero, z + zero], 1), "vel": np.stack([zero, zero, v + zero], 1)}


def bounce(run: WrittenRun) -> None:
    """A ball of 2 kg falls for 0.5 s, is given its momentum back twofold in one step, and rises."""
    run.add_link("floor", fixed=True)
    t, up = run.time, run.time > 0.5
    before = 0.5 * G
    z = np.where(up, 5 - G / 8 + before * (t - 0.5) - G / 2 * (t - 0.5) ** 2, 5 - G / 2 * t**2)
    ball = run.add_link("ball", mass=2.0, **along(run, z, np.where(up, before - G * (t - 0.5), -G * t)))
    run.touch(0, ball, [51], (0, 0, 2 * 2 * before / run.dt))


def test_fall_and_bounce_are_explained(tmp_path: Path) -> None:
    found = moved(tmp_path, bounce)
    assert (found.keyframed, found.part, found.looked_at) == ({}, 0.0, 1)


def test_a_bounce_without_a_contact_is_one_odd_frame_and_no_keyframes(tmp_path: Path) -> None:
    def record(run: WrittenRun) -> None:
        bounce(run)
        run.contacts.clear()

    assert moved(tmp_path, record).keyframed == {}


def hover(run: WrittenRun) -> None:
    """At a steady speed through the air, with velocities that fit: only the forces are missing."""
    run.add_link("floor", fixed=True)
    run.add_link("ball", **along(run, 1 + run.time, 1.0))


def test_a_path_without_forces_is_keyframed_even_if_velocities_fit(tmp_path: Path) -> None:
    found = moved(tmp_path, hover)
    assert found.mainly_keyframed
    assert found.part == pytest.approx(1.0)
    assert "do not follow from forces in 100 % of its path" in found.keyframed["ball"]


def test_a_fall_pays_for_no_flight(tmp_path: Path) -> None:
    """It falls for half of the time, and floats up, more slowly, for the other half."""

    def record(run: WrittenRun) -> None:
        half = run.time[-1] / 2
        down = 3 - 9.81 * np.minimum(run.time, half) ** 2 / 2
        run.add_link("floor", fixed=True)
        run.add_link(
            "ball",
            **along(run, down + 0.3 * np.maximum(run.time - half, 0), np.where(run.time < half, -9.81 * run.time, 0.3)),
        )

    assert "do not follow from forces over" in moved(tmp_path, record).keyframed["ball"]


def test_motion_that_a_control_may_explain_is_not_keyframed(tmp_path: Path) -> None:
    lift = {"kind": "force", "body": "ball", "force": [0, 0, 9.81]}
    assert moved(tmp_path, hover, controls={"lift": lift}).keyframed == {}


def test_positions_that_are_set_are_found_without_a_look_at_forces(tmp_path: Path) -> None:
    lift = {"kind": "force", "body": "ball", "force": [0, 0, 9.81]}

    def record(run: WrittenRun) -> None:
        run.add_link("floor", fixed=True)
        run.add_link("ball", **along(run, 1 + run.time, 0.0))

    assert moved(tmp_path, record, controls={"lift": lift}).mainly_keyframed


def test_a_motor_whose_target_changes_in_steps_is_none(tmp_path: Path) -> None:
    """The velocity at the end of a step is 0.8 of the mean: the last of an exponential decay within the step."""
    slider = BALL | {"mount": {"kind": "slider", "axis": "z", "actuator": {"stiffness": 10000, "damping": 150}}}
    up = {"kind": "drive", "joint": "ball", "position": {"kind": "ramp", "to": 1.0, "end": 1.0}}

    def record(run: WrittenRun) -> None:
        run.add_link("ball", **along(run, run.time, 0.8))

    assert not moved(tmp_path, record, {"ball": slider}, controls={"up": up}).keyframed


def test_a_body_without_a_motor_may_not_move_so(tmp_path: Path) -> None:
    assert moved(tmp_path, lambda run: run.add_link("ball", **along(run, run.time, 0.8))).mainly_keyframed


def test_one_jump_is_enough(tmp_path: Path) -> None:
    def record(run: WrittenRun) -> None:
        run.add_link("floor", fixed=True)
        run.add_link("ball", **along(run, 5 - G / 2 * run.time**2 + 0.4 * (run.time > 0.3), -G * run.time))

    assert moved(tmp_path, record).keyframed == {
        "ball": "it jumps by 0.38 m more than its velocity explains, at 0.31 s"
    }


def test_driven_bodies_are_listed_with_their_share_of_the_path(tmp_path: Path) -> None:
    driven = {"kind": "driven", "shape": {"kind": "box", "size": [1, 1, 1]}, "motion": {"kind": "spin", "axis": "z", "speed": 1.0}}  # fmt: skip

    def record(run: WrittenRun) -> None:
        run.add_link("floor", fixed=True)
        run.add_link("ball", **along(run, 5 - G / 2 * run.time**2, -G * run.time))
        run.add_link("belt", **along(run, run.time * G / 2, G / 2))

    found = moved(tmp_path, record, bodies={"ball": BALL, "belt": driven})
    assert found.keyframed == {}
    assert found.driven["belt"] == pytest.approx(0.5)
    assert "`belt` moves along a prescribed path (`driven`), 50 % of all paths" in found.rows()[0]


def test_the_path_of_a_driven_body_ends_when_it_is_removed(tmp_path: Path) -> None:
    driven = {"kind": "driven", "shape": {"kind": "box", "size": [1, 1, 1]}, "motion": {"kind": "spin", "axis": "z", "speed": 1.0}}  # fmt: skip

    def record(run: WrittenRun) -> None:
        run.add_link("floor", fixed=True)
        run.add_link("ball", **along(run, 2 * run.time, 0))
        run.add_link("belt", **along(run, run.time, 1))
        (run.folder / "states").mkdir()
        (run.folder / "states" / "removed.json").write_text('{"belt": 0.5}')

    found = moved(tmp_path, record, bodies={"ball": BALL, "belt": driven})
    assert found.driven["belt"] == pytest.approx(0.2)
    assert found.mainly_keyframed


def test_a_cloth_whose_points_are_set_is_found(tmp_path: Path) -> None:
    cloth = {"kind": "cloth", "solver": "pbd", "shape": {"kind": "sheet", "size": [1, 1]}}

    def record(run: WrittenRun) -> None:
        run.add_link("floor", fixed=True)
        square = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], float)
        run.add_soft("sheet", square + np.stack([run.time, 0 * run.time, 0 * run.time], 1)[:, None], solver="pbd")

    assert moved(tmp_path, record, bodies={"sheet": cloth}).mainly_keyframed


@pytest.mark.parametrize(("jump", "found"), [(0.0, False), (0.5, True)])
def test_of_what_is_attached_only_a_jump_is_odd(jump: float, found: bool, tmp_path: Path) -> None:
    cloth = {"kind": "cloth", "solver": "pbd", "shape": {"kind": "sheet", "size": [1, 1]}}
    hang = {"kind": "attach", "body": "sheet", "region": {"edge": "back"}, "to": "ball"}

    def record(run: WrittenRun) -> None:
        run.add_link("ball", **along(run, 2 + run.time, 1.0))
        square = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], float)
        z = run.time + jump * (run.time > 0.3)
        run.add_soft("sheet", square + np.stack([0 * z, 0 * z, z], 1)[:, None], solver="pbd")

    motion = moved(tmp_path, record, bodies={"sheet": cloth, "ball": BALL}, controls={"hang": hang})
    assert ("sheet" in motion.keyframed) == found
