"""Sheets that start in folds too sharp for their cells."""

from collections.abc import Iterator

from text2sim.compiler.shapes.sagging import fold_radius
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.sheets import Sheet
from text2sim.spec_schema.rounding import at_most

MIN_FOLD_CELLS = 1.45
"""Smallest radius of a fold in cells. The engine cuts a cloth into triangles of its own, which are crowded where it
bends. Sheets of 1.6 m with cells of 25 mm flew apart in the first step with 0.6 and 1.1 cells, and hung with 1.48."""


@first_per_place
def _sharp_folds(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body in soft.of("pbd"):
        sheet = body.model.shape
        if not isinstance(sheet, Sheet) or not sheet.folds:
            continue
        cell, radius = soft.scales.spacing(body.body, body.solver), fold_radius(sheet)
        if radius >= MIN_FOLD_CELLS * cell * (1 - 1e-6):
            continue
        text = (
            f"the folds of `{body.name}` bend with a radius of {length(radius)}, {radius / cell:.2g} of its cells: it "
            f"flies apart; take at most {int(sheet.folds * radius / (MIN_FOLD_CELLS * cell))} folds, a smaller "
            f"`fullness`, or `cell` {at_most(radius / MIN_FOLD_CELLS)}"
        )
        yield facts.problem("sharp-folds", facts.first_given(body.body, "shape"), text, key=True)


RULES = (
    Rule(
        id="sharp-folds",
        severity="error",
        title="A sheet starts in folds that are too sharp for its cells.",
        reason="""\
The engine cuts a cloth into triangles of its own, and where it bends sharply their corners are nearer to each other
than particles may be, which throws it apart in the first step. Sheets of 1.6 m with cells of 25 mm flew apart with
folds of 0.6 and 1.1 cells radius, and hung with 1.48.""",
        remedy="Use fewer folds, less `fullness`, or smaller cells.",
        example="""\
bodies:
  curtain:
    kind: cloth
    cell: 0.025
    shape: {kind: sheet, size: [1.6, 0.9], folds: 6, fullness: 1.6}
    pose: {pos: [0, 0, 0.6], euler_deg: [90, 0, 0]}
""",
        fix="bodies: {curtain: {shape: {fullness: 1.2}}}",
        run=_sharp_folds,
    ),
)
