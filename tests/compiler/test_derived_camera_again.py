"""What is decided by what is recorded is not written out: the case that is written out gets the same film."""

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
def test_the_film_is_the_same(z: float) -> None:
    case = resolve_case(load_text(CASE.format(z=z)))
    again = resolve_case(load_text(explicit(case).text()))
    assert again.plan.render == case.plan.render
