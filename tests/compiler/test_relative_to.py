"""`relative_to`: poses in the frame of another body, as it starts."""

import numpy as np
import pytest
from place_words import CUBE, HEAD, placed, start
from scipy.spatial.transform import Rotation

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

RAMP = np.array([-9.0, 0.0, 1.0]), Rotation.from_euler("y", 30, degrees=True)
"""Position [m] and orientation of the ramp of `HEAD`."""


def in_ramp(*pos: float) -> np.ndarray:
    """Return where a point of the ramp's frame is in the world [m]."""
    return RAMP[0] + RAMP[1].apply(pos)


def turned(quat: tuple[float, float, float, float]) -> Rotation:
    return Rotation.from_quat(quat, scalar_first=True)


def test_pose_is_composed_with_that_of_the_other() -> None:
    (peg,) = placed(f"peg: {{{CUBE}, place: {{relative_to: ramp, pos: [0.5, -0.2, 0.1], euler_deg: [0, 0, 40]}}}}")[
        "peg"
    ]
    assert peg.pos == pytest.approx(in_ramp(0.5, -0.2, 0.1))
    expected = RAMP[1] * Rotation.from_euler("z", 40, degrees=True)
    assert (turned(peg.quat) * expected.inv()).magnitude() == pytest.approx(0.0, abs=1e-9)


def test_without_pos_it_is_at_the_origin_of_the_other() -> None:
    assert placed(f"peg: {{{CUBE}, place: {{relative_to: ramp}}}}")["peg"][0].pos == pytest.approx(RAMP[0])


def test_frames_can_be_chained() -> None:
    copies = placed(
        f"arm: {{{CUBE}, place: {{relative_to: ramp, pos: [0, 0, 1], euler_deg: [0, -30, 0]}}}}",
        f"tip: {{{CUBE}, place: {{relative_to: arm, pos: [0, 0, 1]}}}}",
    )
    assert copies["tip"][0].pos == pytest.approx(in_ramp(0, 0, 1) + (0, 0, 1))


def test_a_pattern_lies_in_the_frame() -> None:
    row = f"{CUBE}, repeat: {{kind: line, count: 3, step: [0.3, 0, 0]}}"
    pegs = placed(f"peg: {{{row}, place: {{relative_to: ramp, pos: [0, 0.1, 0.2]}}}}")["peg"]
    assert [peg.pos for peg in pegs] == [pytest.approx(in_ramp(0.3 * k, 0.1, 0.2)) for k in range(3)]


def test_each_copy_in_the_frame_of_its_own_partner() -> None:
    row = "repeat: {kind: line, count: 3, step: [0, 2, 0]}"
    copies = placed(
        f"plate: {{{CUBE}, {row}, pose: {{pos: [20, 0, 1], euler_deg: [90, 0, 0]}}}}",
        f'peg: {{{CUBE}, {row}, place: {{relative_to: "plate[*]", pos: [0, 0, 0.5]}}}}',
    )
    assert [peg.pos for peg in copies["peg"]] == [pytest.approx((20, 2 * k - 0.5, 1)) for k in range(3)]


def problems(*bodies: str) -> list[str]:
    return [problem.message for problem in check_references(load_text(HEAD + "".join(f"  {b}\n" for b in bodies)))]


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("{relative_to: ramp, at: [1, 2]}", "`at` has no effect with `relative_to`"),
        ("{relative_to: ramp, offset: [0, 0, 1]}", "`offset` has no effect with `relative_to`"),
        ("{on: ramp, pos: [0, 0, 1]}", "`pos` has no effect with `on`"),
        ("{relative_to: peg}", "is placed relative to itself"),
        ("{relative_to: rmap}", "rmap"),
    ],
)
def test_what_makes_no_sense_is_reported(place: str, message: str) -> None:
    assert any(message in found for found in problems(f"peg: {{{CUBE}, place: {place}}}"))


def test_the_frame_of_several_is_none() -> None:
    row = "repeat: {kind: line, count: 2, step: [0, 2, 0]}"
    _, found = start(f"plate: {{{CUBE}, {row}}}", f"peg: {{{CUBE}, place: {{relative_to: plate}}}}")
    assert "a frame is that of one, such as `plate[0]`" in found[0].message
