"""Nets that cannot yield."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Net

USUAL_SAG = 0.1
"""Sag of a compliant net, as a share of its shorter side."""


def _flat(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        if isinstance(body, Net) and body.sag == 0.0:
            sag = USUAL_SAG * min(body.size)
            text = (
                f"`{name}` is built flat, and its strands do not stretch: it stays flat under any load, like a grate; "
                f"`sag: {sag:.2g}` ({length(sag)}) lets it yield"
            )
            yield facts.problem("flat-net", facts.where(name), text, key=True)


RULES = (
    Rule(
        id="flat-net",
        title="A net is built flat, and stays flat under any load.",
        reason="""\
A net is made of rigid links on ball joints, and the world holds its edges. Its strands cannot stretch, so a net yields
only by the sag it is built with: one that is built flat stays flat.""",
        remedy="Give it a `sag`: with a tenth of its shorter side it catches falling bodies.",
        example="""\
bodies:
  net: {kind: net, cells: [4, 4], size: [1, 1], radius: 0.01, pose: {pos: [0, 0, 1]}}
""",
        fix="bodies: {net: {sag: 0.1}}",
        run=_flat,
    ),
)
