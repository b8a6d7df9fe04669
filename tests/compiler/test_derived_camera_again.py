"""The camera that a case gets is written out as a frame, and that frame is the same camera."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.explicit import explicit
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: small
scene:
  duration: 1
  statics:
    floor: {{shape: {{kind: plane}}}}
    post: {{shape: {{kind: box, size: [0.2, 0.2, 1]}}, pose: {{pos: [1, 0, {z}]}}}}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 0, {z}]}}}}
"""


@pytest.mark.parametrize("z", [0.5, 2.0])
def test_what_falls_is_in_both_frames(z: float) -> None:
    case = resolve_case(load_text(CASE.format(z=z)))
    again = resolve_case(load_text(explicit(case).text()))
    assert again.plan.render == case.plan.render
