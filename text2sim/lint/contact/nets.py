"""Nets that cannot give way."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Net

USUAL = 0.1
"""Sag of a net that gives way, as a part of its shorter side."""


def _flat(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        if isinstance(body, Net) and body.sag == 0.0:
            text = (
                f"`{name}` is built flat, and its strands do not stretch: it stays flat under any load, like a grate; "
                f"`sag: {USUAL * min(body.size):.2g}` ({length(USUAL * min(body.size))}) would let it give way"
            )
            yield facts.problem("flat-net", facts.where(name), text, key=True)


RULES = (
    Rule(
        id="flat-net",
        severity="warning",
        title="A net is built flat, and stays flat under any load.",
        reason="""\
A net is made of rigid links on ball joints, and its edges are held by the world. Its strands cannot stretch, so that
all that it can give way is built into it: one that is built flat stays flat.""",
        remedy="Give it a `sag`: a tenth of its shorter side catches what falls like a net.",
        example="""\
bodies:
  net: {kind: net, cells: [4, 4], size: [1, 1], radius: 0.01, pose: {pos: [0, 0, 1]}}
""",
        fix="bodies: {net: {sag: 0.1}}",
        run=_flat,
    ),
)
