"""Deformable bodies that start inside other bodies or below the ground, or too late."""

from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import NamedTuple

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.soft.solvers import unfelt_links
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.lint.soft.families import TOUCHING_PAIRS
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.start.escape import Effort, Escape, axes_first, overlap_of, overlapping
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.shapes import Stream
from text2sim.spec_schema.text.document import Path

MAX_DEPTH = 1e-3
"""Largest depth [m] without a warning."""
MIN_SPACING = 0.9
"""Smallest gap between two cloths, in units of their particle distance, which contact keeps."""
STEP_BUDGET = 4000
"""Budget for finding depths."""
ROUNDING = 1e-9
"""Distance [m] of bodies that touch."""


def _inside(facts: Facts) -> Iterator[Problem]:
    """Report each deformable body and each rigid one that it starts in once."""
    soft = facts.once(SoftFacts)
    effort = Effort(STEP_BUDGET)
    found: dict[tuple[str, str], list[tuple[float, str, SoftBody, Copy]]] = {}
    for body in soft.bodies:
        if frozenset(("rigid", body.solver)) not in TOUCHING_PAIRS[soft.model] or soft.model == "ipc":
            continue  # they have no contact, or another rule covers them
        tolerated = max(MAX_DEPTH, {"mpm": soft.cell / 2, "pbd": soft.particle / 2}.get(body.solver, 0.0))
        for ground in soft.planes:
            depth = max((ground.depth(part) for part in facts.parts(body.copy)), default=0.0)
            if depth > tolerated:
                direction = "up" if ground.up[2] > 1 - 1e-9 else f"along {vector(ground.up)}"
                found.setdefault((body.body, ground.copy.body), []).append((depth, direction, body, ground.copy))
        for copy in soft.rigid:
            if (row := _overlap(facts, body, copy, tolerated, effort)) is not None:
                found.setdefault((body.body, copy.body), []).append((*row, body, copy))
    for rows in found.values():
        depth, direction, body, other = max(rows, key=lambda row: row[0])
        text = (
            f"`{body.name}` starts {length(depth)} deep in `{other.name}`"
            f"{more_copies(len(rows), 'pairs of their copies')}: {_CONSEQUENCES[body.solver]}; move it {direction}"
        )
        text += f" by {length(depth)}" if direction else " out of it"
        yield facts.problem("soft-inside", facts.first_given(body.body, "place", "pose", "repeat"), text, key=True)


_CONSEQUENCES = {
    "mpm": "its particles inside are stuck or thrown out",
    "pbd": "its particles inside are moved out within one substep, and fly off at that speed",
    "fem": "contact pushes it out with a destructive force",
    "ipc": "",
}


def _overlap(facts: Facts, body: SoftBody, copy: Copy, min_depth: float, effort: Effort) -> tuple[float, str] | None:
    """Return how deep [m] a body is in a rigid copy, and which way leads out; None if it is not in it."""
    box, other_box = body.box, facts.box(copy)
    if other_box is None or apart(box, other_box, 0.0 if body.model.kind == "cloth" else min_depth):
        return None
    felt = [part for part in facts.parts(copy) if part.link not in unfelt_links(copy.model)]
    others = [part for part in felt if not apart(part.box, box)]
    pairs = [(a, b) for a in facts.parts(body.copy) for b in others if effort.spend() and overlapping(a, b)]
    if not pairs or effort.left <= 0:
        return None
    overlap = overlap_of(facts.parts(body.copy), felt, pairs, effort)
    escapes = axes_first([escape for escape in overlap.escapes if not _grounded(facts.once(SoftFacts), body, escape)])
    depth = escapes[0].length if escapes and body.model.kind == "cloth" else overlap.depth
    return (depth, f"towards {escapes[0].words}" if escapes else "") if depth > min_depth else None


def _grounded(soft: SoftFacts, body: SoftBody, escape: Escape) -> bool:
    """Return whether a translation moves a body below the ground."""
    down = -escape.direction[2] * escape.length
    lowest = body.box[0][2] - down
    return down > 0.0 and any(ground.up[2] > 0.99 and lowest < ground.level - MAX_DEPTH for ground in soft.planes)


class ClosePair(NamedTuple):
    """The closest copies of two deformable bodies that start too close together."""

    gap: float
    """Distance [m]; 0 if they overlap."""
    a: SoftBody
    b: SoftBody
    pairs: int
    """Number of pairs of copies of these bodies that are too close."""

    def where(self, facts: Facts) -> Path:
        """Return the path of the value that places the second body."""
        keys = ("repeat", "place", "pose") if self.a.body == self.b.body else ("place", "pose")
        return facts.first_given(self.b.body, *keys)


def closest_pairs(gaps: Gaps, pairs: Iterable[tuple[SoftBody, SoftBody]], room: float) -> list[ClosePair]:
    """Return the closest copies of each two bodies that are closer than they should be.

    Args:
        gaps: Distances of copies.
        pairs: Pairs of copies to test.
        room: Distance [m] that they should have.
    """
    found: dict[tuple[str, str], list[tuple[float, SoftBody, SoftBody]]] = {}
    for a, b in pairs:
        gap = gaps.between(a.copy, b.copy, room)
        if gap < room * (1 - 1e-3):
            found.setdefault((a.body, b.body), []).append((gap, a, b))
    return [ClosePair(*min(rows, key=lambda row: row[0]), len(rows)) for rows in found.values()]


def _into_each_other(facts: Facts) -> Iterator[Problem]:
    """Report each pair of fem bodies, or of cloths, that start in each other once."""
    soft = facts.once(SoftFacts)
    gaps = Gaps(facts)
    fem = closest_pairs(gaps, combinations(soft.of("fem"), 2), ROUNDING)
    pbd = closest_pairs(gaps, combinations(soft.of("pbd"), 2), MIN_SPACING * soft.particle)
    for pair in (*fem, *pbd):
        how = f"are {length(pair.gap)} apart" if pair.gap > 0 else "start in each other"
        then = "contact throws them apart with its full stiffness"
        if pair.a.solver == "pbd":
            then = (
                f"particles of cloth are {length(soft.particle)} thick, and closer ones are separated at once, or are "
                "on the wrong side"
            )
        more = more_copies(pair.pairs, "pairs of their copies")
        text = f"`{pair.a.name}` and `{pair.b.name}` {how}{more}: {then}; move one of them"
        severity = "error" if pair.a.solver == "fem" else None
        yield facts.problem("soft-in-soft", pair.where(facts), text, key=True, severity=severity)


@first_per_place
def _dry(facts: Facts) -> Iterator[Problem]:
    duration = facts.case.scene.duration
    for body in facts.once(SoftFacts).of("mpm"):
        shape = body.model.shape
        if isinstance(shape, Stream) and shape.start >= duration:
            text = f"`{body.name}` begins to flow at {shape.start:g} s, and the run ends at {duration:g} s"
            yield facts.problem("dry-stream", facts.where(body.body, "shape", "start"), text)


RULES = (
    Rule(
        id="soft-inside",
        title="A deformable body starts inside a rigid one, or below the ground.",
        reason="""\
The solvers only know the positions of points, not their history. Particles of cloth inside a rigid body are moved to
its surface within one substep, which is a speed of metres per second per millimetre; particles of mpm bodies are stuck
in the walls around them; tetrahedra are pushed out with the full stiffness of contact.""",
        remedy="Move the body as the message says, or place it with `place`.",
        example="""\
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.05]}}
""",
        fix="bodies: {jelly: {pose: null, place: {on: floor}}}",
        run=_inside,
    ),
    Rule(
        id="soft-in-soft",
        title="Two fem bodies, or two cloths, start in each other.",
        reason=f"""\
Contact of points and tetrahedra depends only on their positions: bodies that start in each other are thrown apart, or
stay entangled. Cloths count as in each other if they are closer than {MIN_SPACING:g} of their particle distance. For
mpm bodies see `soft-too-near`.""",
        remedy="Move one of them, or place it with `place`.",
        example="""\
bodies:
  lower: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.4, 0.4]}, pose: {pos: [0, 0, 0.3]}}
  upper: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.4, 0.4]}, pose: {pos: [0.1, 0, 0.302]}}
""",
        fix="bodies: {upper: {pose: {pos: [0.1, 0, 0.33]}}}",
        run=_into_each_other,
    ),
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
