"""Streams that never flow."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import soft_facts
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.shapes import Stream


@first_per_place
def _dry(facts: Facts) -> Iterator[Problem]:
    duration = facts.case.scene.duration
    for body in soft_facts(facts).of("mpm"):
        shape = body.model.shape
        if isinstance(shape, Stream) and shape.start >= duration:
            text = f"`{body.name}` begins to flow at {shape.start:g} s, and the run ends at {duration:g} s"
            yield facts.problem("dry-stream", facts.where(body.body, "shape", "start"), text)


RULES = (
    Rule(
        id="dry-stream",
        severity="error",
        title="A stream begins to flow after the end of the run.",
        reason="""\
Nothing comes out: all of it waits in the mouth, and nothing is drawn.""",
        remedy="""\
Let it begin earlier, or the run last longer.""",
        example="""\
scene: {duration: 1}
bodies:
  oil:
    kind: liquid
    shape: {kind: stream, radius: 0.02, speed: 0.5, duration: 1, start: 1.5}
    pose: {pos: [0, 0, 0.3]}
""",
        fix="bodies: {oil: {shape: {start: 0.2}}}",
        run=_dry,
    ),
)
