"""Bodies that overlap at the start."""

from collections.abc import Iterator
from dataclasses import dataclass

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.shapes.sculpting import sculpted, whole_piece
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.concave import inside, roughness
from text2sim.lint.start.escape import (
    BOX_TESTS_PER_STEP,
    Effort,
    Escape,
    Overlap,
    axes_first,
    moved_part,
    overlap_of,
    overlapping,
)
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.text.document import Path

PUSH_FACTOR = 0.52
"""Speed [m/s] at which overlapping bodies are pushed apart, times the timeconst [s], over the depth [m]. Measured:
boxes and spheres of 100 mm in others that are fixed, 0.5 to 80 mm deep, with timeconst 5 to 20 ms: 0.50 to 0.52."""
MIN_PUSH = 0.05
"""Smallest push [m/s] that is reported: at this speed a body rises 0.1 mm."""
MIN_SHARE = 0.005
"""Smallest overlap that is reported, as a share of the thickness."""
MIN_DEPTH = 1e-4
"""Smallest overlap that is reported [m]."""
ROOM = 0.3
"""A step that frees a body from the surface of a sculpt, as a share of its overlap with the convex pieces, below which
the pieces are to blame."""
MAX_TESTED_PAIRS = 4000
"""Most pairs of pieces that are tested in a case, which takes 0.2 s; the next check finds the rest."""
STEP_BUDGET = 8000
"""Budget for depths and translations, half a second in all; further overlaps are only counted."""
MOBILITY_RANKS = {"free": 0, "tree": 1, "driven": 3, "fixed": 4, "static": 5}


@dataclass
class _Found:
    """Overlaps between copies of two bodies."""

    any: tuple[Copy, Copy]
    """An overlapping pair."""
    deepest: tuple[Copy, Copy, Overlap] | None = None
    """The deepest of the measured pairs."""
    count: int = 0


def _overlap(facts: Facts) -> Iterator[Problem]:
    """Report each pair of bodies once, however many of their copies overlap."""
    welded = _welded(facts)
    tests, effort = Effort(MAX_TESTED_PAIRS), Effort(STEP_BUDGET)
    found: dict[tuple[str, str], _Found] = {}
    for a, b in facts.near(slack=MIN_DEPTH):
        if tests.left < 0:
            break
        if a.body == b.body and isinstance(a.shape, Fragment):
            continue  # fragments touch all over, and their pieces lie in different cells
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
            MIN_PUSH / push_speed(facts, 1.0), MIN_SHARE * overlap.thickness, MIN_DEPTH, roughness(*overlap.pair)
        ):
            both.count += 1
            if both.deepest is None or overlap.depth > both.deepest[2].depth * (1 + 1e-6):
                both.deepest = a, b, overlap
    for both in found.values():
        if both.deepest is not None:
            yield _finding(facts, *both.deepest, both.count, effort, all_seen=tests.left >= 0)
        elif both.count:
            a, b = both.any
            text = f"`{a.name}` and `{b.name}` overlap at the start, as do many others; move one, or use place"
            yield facts.problem("overlap", _pointer(facts, a, b), text, key=True)


def push_speed(facts: Facts, depth: float) -> float:
    """Return the speed [m/s] at which the engine separates bodies that overlap by a depth [m]."""
    settings = facts.settings
    return depth / settings.bounce_time if settings.bounce_time else PUSH_FACTOR * depth / settings.timeconst


def _pieces_inside(
    facts: Facts, a: Copy, b: Copy, welded: set[frozenset], tests: Effort
) -> list[tuple[StandingPart, StandingPart]]:
    """Return the pairs of pieces of two copies that overlap and can collide."""
    around_a, around_b = facts.box(a), facts.box(b)
    assert around_a is not None
    assert around_b is not None
    others = [part for part in facts.parts(b) if not apart(part.box, around_a, MIN_DEPTH)]
    pairs: list[tuple[StandingPart, StandingPart]] = []
    tests.spend(len(facts.parts(a)) * len(others) // BOX_TESTS_PER_STEP)
    for one in facts.parts(a):
        if not others or apart(one.box, around_b, MIN_DEPTH):
            continue
        for other in others:
            if not (one.moves or other.moves) or apart(one.box, other.box, MIN_DEPTH):
                continue
            if welded and frozenset(((a.name, one.link), (b.name, other.link))) in welded:
                continue
            tests.spend()
            if overlapping(one, other):
                pairs.append((one, other))
    return pairs


def _rank(facts: Facts, copy: Copy) -> int:
    """Return a rank that is lower, the easier it is for the author to move the copy."""
    return MOBILITY_RANKS.get(facts.mount(copy), 2)


def _welded(facts: Facts) -> set[frozenset]:
    """Return the pairs of links (copy, link) attached to each other from the start, which do not collide."""
    found = set()
    for weld in facts.rows.welds:
        if weld.on and weld.at <= facts.case.scene.dt / 2:
            ends = []
            for name, link in ((weld.a, weld.a_link), (weld.b, weld.b_link)):
                tree = facts.lowering.trees.get(name)
                ends.append((name, link or (tree.roots[0].name if tree is not None and tree.roots else None)))
            found.add(frozenset(ends))
    return found | {frozenset(((bond.a, None), (bond.b, None))) for bond in facts.rows.bonds}


def _finding(
    facts: Facts, a: Copy, b: Copy, overlap: Overlap, count: int, effort: Effort, *, all_seen: bool
) -> Problem:
    depth, thickness = overlap.depth, overlap.thickness
    known = all(part.mesh is None for part in overlap.pair)
    deep = known and facts.free(a) and depth >= thickness / 2 * (1 - 1e-6)
    one, other = (_name_of(facts, copy, overlap, side) for side, copy in enumerate((a, b)))
    more = more_copies(count, "pairs of their copies" if all_seen else "pairs of their copies at least")
    text = f"{one} and {other} overlap by {length(depth)} at the start{more}"
    if deep:
        text += (
            f", where one is {length(thickness)} thick: the engine throws them apart at "
            f"{push_speed(facts, depth):.2g} m/s, to either side"
        )
    elif facts.free(a):
        text += ": the engine pushes them apart" + (f" at {push_speed(facts, depth):.2g} m/s" if known else "")
    else:
        text += ": they press against their mounts or joints for the whole run"
    escape = _way_out(facts, a, b, overlap, effort)
    if escape is None:
        text += "; move one, or use place"
    elif a.body == b.body:
        text += f"; {length(escape.length)} more between them along {escape.words.lstrip('+-')} frees them"
    else:
        text += f"; {length(escape.length)} towards {escape.words} frees `{a.name}`"
    hull = next((part.piece for part in overlap.pair if part.piece.kind == "mesh"), None)
    if hull is not None and hull.collision == "hull":
        text += f" (`{hull.file}` collides by its convex hull; `collision: decompose` or `exact` keeps its hollows)"
    elif (filled := _filled(facts, a, b, overlap)) is not None:
        text += f" (the convex pieces of `{filled}` fill its hollow: `collision: exact`, or `decompose`, keeps it)"
    return facts.problem("overlap", _pointer(facts, a, b), text, key=True, severity="error" if deep else None)


def _filled(facts: Facts, a: Copy, b: Copy, overlap: Overlap) -> str | None:
    """Return which of two bodies is a sculpt that overlaps the other mainly where its surface leaves room."""
    import numpy as np

    depth = ROOM * overlap.depth
    one, other = overlap.pair
    for copy, own, rest in ((a, one, other), (b, other, one)):
        if isinstance(copy.shape, Sculpt) and copy.shape.collision in ("parts", "hull"):
            whole = sculpted(copy.shape)
            surface = StandingPart(whole_piece(whole, "decompose"), own.pos, own.quat, own.moves, own.link, whole.mesh)
            steps: list[Vec] = [(x, y, z) for x, y, z in (depth * np.vstack([np.eye(3), -np.eye(3)])).tolist()]
            if any(not inside(rest, surface, step) for step in steps):
                return copy.name
    return None


def _name_of(facts: Facts, copy: Copy, overlap: Overlap, side: int) -> str:
    """Return the name of the copy, with the link if it has several."""
    link, tree = overlap.pair[side].link, facts.tree(copy)
    several = tree is not None and len(tree.links()) > 1
    return f"`{copy.name}.{link}`" if several and link is not None else f"`{copy.name}`"


def _pointer(facts: Facts, a: Copy, b: Copy) -> Path:
    """Return the path of the value that places the first copy."""
    if a.body == b.body:
        return facts.first_given(a.body, "repeat", "place", "pose")
    return facts.first_given(a.body, "place", "pose", "repeat")


def _way_out(facts: Facts, a: Copy, b: Copy, overlap: Overlap, effort: Effort) -> Escape | None:
    """Return the shortest translation, preferably along an axis, and not into another body."""
    escapes = axes_first(overlap.escapes)
    if a.body == b.body:
        return escapes[0] if escapes else None
    return next(
        (escape for escape in escapes if not _blocked(facts, a, b, escape, effort)), escapes[0] if escapes else None
    )


def _blocked(facts: Facts, a: Copy, b: Copy, escape: Escape, effort: Effort) -> bool:
    """Return whether a translation moves a copy into another body or below a plane."""
    parts = [moved_part(part, escape) for part in facts.parts(a)]
    for plane in facts.planes:
        if any(plane.depth(part) > MIN_DEPTH for part in parts):
            return True
    for copy in facts.copies.values():
        box = facts.box(copy)
        if copy in (a, b) or box is None:
            continue
        for one in parts:
            if not apart(one.box, box, MIN_DEPTH):
                others = (other for other in facts.parts(copy) if not apart(one.box, other.box, MIN_DEPTH))
                if any(effort.spend() and overlapping(one, other) for other in others):
                    return True
    return False


RULES = (
    Rule(
        id="overlap",
        title="Two bodies overlap at the start.",
        reason=f"""\
The engine treats an overlap as a compressed contact and pushes the bodies apart, at {PUSH_FACTOR:g} m/s for each metre
of depth over the `timeconst` of contacts (measured, 0.5 to 80 mm deep): 10 mm at the usual 10 ms give 0.5 m/s, and 50
mm throw a brick. A body on a hinge or a fixed mount cannot move away and presses against its joint instead.

A free body that is as deep as half the thickness of one of the two is an error: the side on which it comes out is
random. The rule includes copies of one body and links of different bodies. It skips bodies attached to each other from
the start, which do not collide, and overlaps that separate at less than {MIN_PUSH:g} m/s.""",
        remedy="""\
Move the body as the message says, or place it with `place: {on: …}`, which uses the true geometry; give a `repeat` more
room. A mesh collides by its convex hull unless it has `collision: decompose`; the convex pieces of a sculpt fill its
hollows unless it has `collision: exact` or `decompose`.""",
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
