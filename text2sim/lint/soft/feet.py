"""Rigid bodies that stand on mpm bodies with a foot of a few grid nodes."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import length, length_of_at_least
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_most

MIN_FOOT_CELLS = 4.0
"""Smallest width of a foot [cells]. Cylinders of 120 mm on foam with cells of 20 mm: those up to 2 cells wide fell over
or went through the foam, of those of 3 cells one stood and one went through, and those of 4 and 6 stood within 0.6
degrees (`tests/physics/test_soft_feet.py`)."""
TALL_FEET = 1.5
"""Height, in widths of the foot, from which a body tips over instead of sinking in."""
MAX_GAP_CELLS = 2.5
"""Largest gap to the body on which it stands, in cells."""


@first_per_place
def _narrow_foot(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body, copy in soft.pairs("mpm"):
        box = facts.box(copy)
        if body.model.kind != "soft" or box is None or not facts.free(copy):
            continue
        low, high = box
        width, height = min(high[0] - low[0], high[1] - low[1]), high[2] - low[2]
        over = all(low[k] < body.box[1][k] and high[k] > body.box[0][k] for k in (0, 1))
        stands = over and abs(low[2] - body.box[1][2]) <= MAX_GAP_CELLS * soft.cell
        if not stands or height < TALL_FEET * width or width >= MIN_FOOT_CELLS * soft.cell * (1 - 1e-6):
            continue
        text = (
            f"`{copy.name}` stands on `{body.name}` with a foot {length(width)} wide, {soft.in_cells(width)}, "
            f"which feels it at a few nodes: it tips over or sinks in; make the "
            f"foot {length_of_at_least(MIN_FOOT_CELLS * soft.cell)} wide, or `scene.mpm.cell` "
            f"{at_most(width / MIN_FOOT_CELLS)}"
        )
        yield facts.problem("narrow-foot", facts.first_given(copy.body, "shape"), text, key=True)


RULES = (
    Rule(
        id="narrow-foot",
        title="A tall body stands on an mpm body with a foot so narrow that it tips over.",
        reason=f"""\
The grid of mpm bodies feels rigid ones at its nodes only, and a narrow foot has too few of them to hold a body upright.
Of cylinders on foam, those 2 cells wide fell over or went through it, and whether those of 3 cells did depended on the
place of the nodes; those of {MIN_FOOT_CELLS:g} and 6 cells stood.""",
        remedy="""\
Widen the foot (a `compound` may have a wide part that touches and a slim one above it), or make the grid finer with
`scene.mpm.cell`; half the cell takes sixteen times as long.""",
        example="""\
bodies:
  foam: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.3, 0.3, 0.1]}, pose: {pos: [0, 0, 0.06]}}
  glass: {kind: rigid, shape: {kind: cylinder, radius: 0.03, height: 0.15}, pose: {pos: [0, 0, 0.195]}}
""",
        fix="bodies: {glass: {shape: {radius: 0.045}}}",
        run=_narrow_foot,
    ),
)
