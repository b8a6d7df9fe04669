"""Bodies that start inside each other."""

from collections.abc import Iterator
from dataclasses import dataclass

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.concave import roughness
from text2sim.lint.start.escape import GLANCES, Effort, Overlap, Way, inside, moved_part, overlap_of, plain
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.text.document import Path

PUSH = 0.52
"""Speed [m/s] at which overlapping bodies are pushed apart, times the timeconst [s], over the depth [m]. Measured:
boxes and spheres of 100 mm in others that are fixed, 0.5 to 80 mm deep, with timeconst 5 to 20 ms: 0.50 to 0.52."""
GENTLE = 0.05
"""Slower [m/s] than this nothing is thrown: it rises 0.1 mm."""
PART = 0.005
"""An overlap is not worth a word if it is less than this part of the thickness."""
LEAST = 1e-4
"""Nor if it is less than this [m]."""
TESTED = 4000
"""Pairs of pieces that are looked at in a case, which takes 0.2 s; what is left waits for the next check."""
STEPS = 8000
"""Steps for finding depths and ways out, half a second in all; then overlaps are only counted."""
RANKS = {"free": 0, "tree": 1, "driven": 3, "fixed": 4, "static": 5}


@dataclass
class _Found:
    """Overlaps between copies of two bodies."""

    any: tuple[Copy, Copy]
    """Some of them."""
    deepest: tuple[Copy, Copy, Overlap] | None = None
    """Of those that were measured."""
    count: int = 0


def _overlap(facts: Facts) -> Iterator[Problem]:
    """One finding for each pair of bodies, however many of their copies overlap."""
    welded = _welded(facts)
    tests, effort = Effort(TESTED), Effort(STEPS)
    found: dict[tuple[str, str], _Found] = {}
    for a, b in facts.near(slack=LEAST):
        if tests.left < 0:
            break
        a, b = (b, a) if _rank(facts, b) < _rank(facts, a) else (a, b)
        pairs = _pieces_inside(facts, a, b, welded, tests)
        if not pairs:
            continue
        both = found.setdefault((a.body, b.body), _Found((a, b)))
        if effort.left <= 0:
            both.count += 1
            continue
        overlap = overlap_of(facts.parts(a), facts.parts(b), pairs, effort)
        if overlap.depth > max(
            GENTLE / push_speed(facts, 1.0), PART * overlap.thickness, LEAST, roughness(*overlap.pair)
        ):
            both.count += 1
            if both.deepest is None or overlap.depth > both.deepest[2].depth * (1 + 1e-6):
                both.deepest = a, b, overlap
    for both in found.values():
        if both.deepest is not None:
            yield _finding(facts, *both.deepest, both.count, effort, all_seen=tests.left >= 0)
        elif both.count:
            a, b = both.any
            text = f"`{a.name}` and `{b.name}` overlap at the start, like many others; move one, or use place"
            yield facts.problem("overlap", _pointer(facts, a, b), text, key=True)


def push_speed(facts: Facts, depth: float) -> float:
    """Return the speed [m/s] at which the engine pushes something out that is so deep [m] in something else."""
    settings = facts.settings
    return depth / settings.bounce_time if settings.bounce_time else PUSH * depth / settings.timeconst


def _pieces_inside(
    facts: Facts, a: Copy, b: Copy, welded: set[frozenset], tests: Effort
) -> list[tuple[StandingPart, StandingPart]]:
    """Return the pieces of two copies that are inside each other, where the engine lets them touch."""
    around_a, around_b = facts.box(a), facts.box(b)
    assert around_a is not None
    assert around_b is not None
    others = [part for part in facts.parts(b) if not apart(part.box, around_a, LEAST)]
    pairs: list[tuple[StandingPart, StandingPart]] = []
    tests.spend(len(facts.parts(a)) * len(others) // GLANCES)
    for one in facts.parts(a):
        if not others or apart(one.box, around_b, LEAST):
            continue
        for other in others:
            if not (one.moves or other.moves) or apart(one.box, other.box, LEAST):
                continue
            if welded and frozenset(((a.name, one.link), (b.name, other.link))) in welded:
                continue
            tests.spend()
            if inside(one, other):
                pairs.append((one, other))
    return pairs


def _rank(facts: Facts, copy: Copy) -> int:
    """The less, the easier it is for the author to move the copy."""
    return RANKS.get(facts.mount(copy), 2)


def _welded(facts: Facts) -> set[frozenset]:
    """Links (copy, link) that are attached to each other from the start: the engine lets those not touch."""
    found = set()
    for weld in facts.rows.welds:
        if weld.on and weld.at <= facts.case.scene.dt / 2:
            ends = []
            for name, link in ((weld.a, weld.a_link), (weld.b, weld.b_link)):
                tree = facts.lowering.trees.get(name)
                ends.append((name, link or (tree.roots[0].name if tree is not None and tree.roots else None)))
            found.add(frozenset(ends))
    return found


def _finding(
    facts: Facts, a: Copy, b: Copy, overlap: Overlap, count: int, effort: Effort, *, all_seen: bool
) -> Problem:
    depth, thickness = overlap.depth, overlap.thickness
    known = all(part.mesh is None for part in overlap.pair)
    deep = known and facts.free(a) and depth >= thickness / 2 * (1 - 1e-6)
    one, other = (_named(facts, copy, overlap, side) for side, copy in enumerate((a, b)))
    more = more_copies(count, "pairs of their copies" if all_seen else "pairs of their copies at least")
    text = f"{one} and {other} overlap by {length(depth)} at the start{more}"
    if deep:
        text += (
            f", where one is {length(thickness)} thick: the engine throws them apart at "
            f"{push_speed(facts, depth):.2g} m/s, to whichever side"
        )
    elif facts.free(a):
        text += ": the engine pushes them apart" + (f" at {push_speed(facts, depth):.2g} m/s" if known else "")
    else:
        text += ": they press against what holds them, for the whole run"
    way = _way(facts, a, b, overlap, effort)
    if way is None:
        text += "; move one, or use place"
    elif a.body == b.body:
        text += f"; {length(way.length)} more between them along {way.words.lstrip('+-')} frees them"
    else:
        text += f"; {length(way.length)} towards {way.words} frees `{a.name}`"
    hull = next((part.piece for part in overlap.pair if part.piece.kind == "mesh"), None)
    if hull is not None and hull.collision == "hull":
        text += f" (`{hull.file}` touches by its convex hull; `collision: decompose` or `exact` keeps its hollows)"
    return facts.problem("overlap", _pointer(facts, a, b), text, key=True, severity="error" if deep else None)


def _named(facts: Facts, copy: Copy, overlap: Overlap, side: int) -> str:
    """The copy, with its link if it has several."""
    link, tree = overlap.pair[side].link, facts.tree(copy)
    several = tree is not None and len(tree.links()) > 1
    return f"`{copy.name}.{link}`" if several and link is not None else f"`{copy.name}`"


def _pointer(facts: Facts, a: Copy, b: Copy) -> Path:
    """Where the case says what puts the first copy where it is."""
    if a.body == b.body:
        return facts.said(a.body, "repeat", "place", "pose")
    return facts.said(a.body, "place", "pose", "repeat")


def _way(facts: Facts, a: Copy, b: Copy, overlap: Overlap, effort: Effort) -> Way | None:
    """Return the shortest plain way out, if possible one that does not lead into something else."""
    ways = plain(overlap.ways)
    if a.body == b.body:
        return ways[0] if ways else None
    return next((way for way in ways if not _blocked(facts, a, b, way, effort)), ways[0] if ways else None)


def _blocked(facts: Facts, a: Copy, b: Copy, way: Way, effort: Effort) -> bool:
    """Whether a copy would be in something else at the end of a way, or under a plane."""
    parts = [moved_part(part, way) for part in facts.parts(a)]
    for plane in facts.planes:
        if any(plane.depth(part) > LEAST for part in parts):
            return True
    for copy in facts.copies.values():
        box = facts.box(copy)
        if copy in (a, b) or box is None:
            continue
        for one in parts:
            if not apart(one.box, box, LEAST):
                others = (other for other in facts.parts(copy) if not apart(one.box, other.box, LEAST))
                if any(effort.spend() and inside(one, other) for other in others):
                    return True
    return False


RULES = (
    Rule(
        id="overlap",
        severity="warning",
        title="Two bodies are inside each other at the start.",
        reason=f"""\
The engine takes an overlap for a compressed contact and pushes the bodies apart, at {PUSH:g} m/s for each metre of
depth over the `timeconst` of contacts (measured, 0.5 to 80 mm deep): 10 mm at the usual 10 ms make 0.5 m/s, and 50 mm
throw a brick. What a hinge or the world holds cannot get away, and presses against its joint instead.

A free body that is as deep as half the thickness of one of the two is an error: on which side it comes out is chance.
Copies of one body count, and links of different bodies do. Bodies that are attached to each other from the start do not
touch in the engine and do not count, nor does what would be pushed apart at less than {GENTLE:g} m/s.""",
        remedy="""\
Move the body as far as the message says, or say where it is with `place: {on: …}`, which is resolved from true
geometry; give a `repeat` more room. A mesh touches by its convex hull unless it has `collision: decompose`.""",
        example="""\
bodies:
  peg: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.05]}}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}, pose: {pos: [0.09, 0, 0.06]}}
""",
        fix="bodies: {ball: {pose: null, place: {right_of: peg}}}",
        run=_overlap,
        own_contact=True,
    ),
)
