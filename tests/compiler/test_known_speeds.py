"""The speeds that a case gives its bodies decide how long the substeps may be."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: test
scene:
  duration: 1
  dt: 0.01
  statics: {{floor: {{shape: {{kind: plane}}}}, plate: {{shape: {{kind: box, size: [1, 0.02, 1]}}, pose: {{pos: [0, 2, 0.5]}}}}}}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.05}}, material: {{mass: 2}}, pose: {{pos: [0, 0, 0.5]}}}}
actions: {{controls: {{{controls}}}}}
"""


def settings_of(controls: str):
    return resolve_case(load_text(CASE.format(controls=controls))).settings


@pytest.mark.parametrize(
    ("blows", "speed"),
    [
        ("a: {kind: impulse, body: ball, impulse: [0, 20, 0], at: 0}", 10),
        ("a: {kind: impulse, body: ball, impulse: [0, 20, 0], at: 0.5, point: [0, 0, 0.05]}", 10),
        ("a: {kind: impulse, body: ball, impulse: [0, 8, 0], at: 0}, b: {kind: impulse, body: ball, impulse: [0, 12, 0], at: 0.2}", 10),
        ("a: {kind: initial_velocity, body: ball, linear: [0, 4, 0]}, b: {kind: impulse, body: ball, impulse: [0, 0, 12], at: 0.2}", 10),
    ],
)  # fmt: skip
def test_a_blow_counts_as_the_speed_that_it_gives(blows: str, speed: float) -> None:
    thrown = settings_of(f"a: {{kind: initial_velocity, body: ball, linear: [0, {speed}, 0]}}")
    struck = settings_of(blows)
    assert (struck.substeps, struck.why["substeps"]) == (thrown.substeps, thrown.why["substeps"])
    assert struck.substeps > settings_of("").substeps


def test_a_force_is_no_blow() -> None:
    pushed = settings_of("a: {kind: force, body: ball, force: [0, 20, 0], during: [0, 0.1]}")
    assert pushed.substeps == settings_of("").substeps
