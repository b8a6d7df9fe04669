"""Deformable bodies that start inside rigid ones, or under the ground."""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts, soft_facts
from text2sim.lint.soft.families import TOUCHING
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.start.escape import Effort, Way, inside, overlap_of, plain
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem

LEAST = 1e-3
"""Depth [m] that is nothing."""
PERSONAL = 0.9
"""How near particles of two cloths may be, in their distances from each other: contact keeps them one apart."""
STEPS = 4000
"""Steps for finding depths; then overlaps are only counted."""


def _inside(facts: Facts) -> Iterator[Problem]:
    """One finding for each body that deforms and each rigid one that it starts in."""
    soft = soft_facts(facts)
    effort = Effort(STEPS)
    found: dict[tuple[str, str], list[tuple[float, str, SoftBody, Copy]]] = {}
    for body in soft.bodies:
        if frozenset(("rigid", body.solver)) not in TOUCHING[soft.model] or soft.model == "ipc":
            continue  # they pass through each other, or another rule looks closer
        least = _least(soft, body)
        for ground in soft.planes:
            depth = max((ground.depth(part) for part in facts.parts(body.copy)), default=0.0)
            if depth > least:
                way = "up" if ground.up[2] > 1 - 1e-9 else f"along {vector(ground.up)}"
                found.setdefault((body.body, ground.copy.body), []).append((depth, way, body, ground.copy))
        for copy in soft.rigid:
            if (row := _overlap(facts, body, copy, least, effort)) is not None:
                found.setdefault((body.body, copy.body), []).append((*row, body, copy))
    for rows in found.values():
        depth, way, body, other = max(rows, key=lambda row: row[0])
        text = (
            f"`{body.name}` starts {length(depth)} deep in `{other.name}`"
            f"{more_copies(len(rows), 'pairs of their copies')}: {_WHAT[body.solver]}; move it {way}"
        )
        text += f" by {length(depth)}" if way else " out of it"
        yield facts.problem("soft-inside", facts.said(body.body, "place", "pose", "repeat"), text, key=True)


_WHAT = {
    "mpm": "its particles in there are held fast or thrown out",
    "pbd": "its particles in there are put outside within one substep, and fly off at that speed",
    "fem": "contact pushes it out with a force that no body stands",
    "ipc": "",
}


def _least(soft: SoftFacts, body: SoftBody) -> float:
    """Depth [m] that a solver bears: particles have a size."""
    return max(LEAST, {"mpm": soft.cell / 2, "pbd": soft.particle / 2}.get(body.solver, 0.0))


def _overlap(facts: Facts, body: SoftBody, copy: Copy, least: float, effort: Effort) -> tuple[float, str] | None:
    """How deep [m] a body is in a rigid copy, and which way leads out; None where it is not."""
    box, its = body.box, facts.box(copy)
    if its is None or apart(box, its, least) and body.model.kind != "cloth":
        return None
    if apart(box, its):
        return None
    pairs: list[tuple[StandingPart, StandingPart]] = []
    others = [part for part in facts.parts(copy) if not apart(part.box, box)]
    for one in facts.parts(body.copy):
        pairs += [(one, other) for other in others if effort.spend() and inside(one, other)]
    if not pairs or effort.left <= 0:
        return None
    overlap = overlap_of(facts.parts(body.copy), facts.parts(copy), pairs, effort)
    ways = plain([way for way in overlap.ways if not _grounded(soft_facts(facts), body, way)])
    depth = ways[0].length if ways and body.model.kind == "cloth" else overlap.depth
    return (depth, f"towards {ways[0].words}" if ways else "") if depth > least else None


def _grounded(soft: SoftFacts, body: SoftBody, way: Way) -> bool:
    """Whether a way leads down to where a body is under the ground."""
    down = -way.direction[2] * way.length
    lowest = body.box[0][2] - down
    return down > 0.0 and any(ground.up[2] > 0.99 and lowest < ground.level - LEAST for ground in soft.planes)


def _into_each_other(facts: Facts) -> Iterator[Problem]:
    """One finding for each pair of fem bodies, or of cloths, that start in each other."""
    soft = soft_facts(facts)
    gaps = Gaps(facts)
    found: dict[tuple[str, str], list[tuple[float, SoftBody, SoftBody]]] = {}
    for solver, room in (("fem", LEAST), ("pbd", PERSONAL * soft.particle)):
        bodies = soft.of(solver)
        for k, a in enumerate(bodies):
            for b in bodies[k + 1 :]:
                gap = gaps.between(a.copy, b.copy, room)
                if gap < room * (1 - 1e-3) and (gap <= 0.0 or solver == "pbd"):
                    found.setdefault((a.body, b.body), []).append((gap, a, b))
    for rows in found.values():
        gap, a, b = min(rows, key=lambda row: row[0])
        fem = a.solver == "fem"
        text = (
            f"`{a.name}` and `{b.name}` "
            + (f"are {length(gap)} apart" if gap > 0 else "start in each other")
            + f"{more_copies(len(rows), 'pairs of their copies')}: "
            + ("contact throws them apart with all of its stiffness" if fem else _THROWN.format(length(soft.particle)))
            + "; move one of them"
        )
        same = a.body == b.body
        where = facts.said(b.body, "repeat", "place", "pose") if same else facts.said(b.body, "place", "pose")
        severity = "error" if fem else None
        yield facts.problem("soft-in-soft", where, text, key=True, severity=severity)


_THROWN = "particles of cloth are {} thick, and those that are nearer are put apart at once, or lie on the wrong side"


RULES = (
    Rule(
        id="soft-inside",
        severity="warning",
        title="A deformable body starts inside a rigid one, or under the ground.",
        reason="""\
The solvers know only where points are, not how they got there. Particles of cloth that are inside a rigid body are put
onto its surface within one substep, which is a speed of metres per second for each millimetre; particles of mpm bodies
are held by the walls around them; tetrahedra are pushed out with the full stiffness of contact.""",
        remedy="Move the body as far as the message says, or say where it is with `place`.",
        example="""\
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.05]}}
""",
        fix="bodies: {jelly: {pose: null, place: {on: floor}}}",
        run=_inside,
    ),
    Rule(
        id="soft-in-soft",
        severity="warning",
        title="Two fem bodies, or two cloths, start in each other.",
        reason=f"""\
Contact of points and tetrahedra only knows where they are: what starts in each other is thrown apart, or stays
entangled for good. Cloths count as in each other when they are nearer than {PERSONAL:g} of the distance of their
particles. For bodies of mpm there is `soft-too-near`.""",
        remedy="Move one of them, or say where it is with `place`.",
        example="""\
bodies:
  lower: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.4, 0.4]}, pose: {pos: [0, 0, 0.3]}}
  upper: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.4, 0.4]}, pose: {pos: [0.1, 0, 0.302]}}
""",
        fix="bodies: {upper: {pose: {pos: [0.1, 0, 0.33]}}}",
        run=_into_each_other,
    ),
)
