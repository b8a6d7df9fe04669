"""Links of one body with self-collision that overlap at the start."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.trees.tree import Tree, TreeLink, tree_links
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.start.escape import Effort, overlap_of, overlapping
from text2sim.lint.start.overlap import MIN_DEPTH, STEP_BUDGET, push_speed
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated


def _self_overlap(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        if not isinstance(body, Articulated) or not body.self_collision:
            continue
        copy = facts.placed[name][0]
        tree = facts.tree(copy)
        if tree is None:
            continue
        pairs = _collidable_pairs(tree)
        neutral = _overlapping(copy, replace(tree, initial={}), pairs)
        started = _overlapping(copy, tree, pairs) if tree.initial else {}
        where = facts.where(name, "self_collision")
        if neutral:
            (a, b), depth = next(iter(neutral.items()))
            text = (
                f"`{name}.{a}` and `{name}.{b}` overlap by {length(depth)} where all joints are at 0"
                f"{more_copies(len(neutral), 'pairs of links')}: the engine treats such links as neighbours, which "
                "never collide; make one shorter or thinner, or move it"
            )
            yield facts.problem("self-overlap", where, text, key=True)
        started = {pair: depth for pair, depth in started.items() if pair not in neutral}
        if started:
            (a, b), depth = next(iter(started.items()))
            text = (
                f"`{name}.{a}` and `{name}.{b}` overlap by {length(depth)} at their `initial` positions"
                f"{more_copies(len(started), 'pairs of links')}: the engine pushes them apart at "
                f"{push_speed(facts, depth):.2g} m/s; increase their distance at the start"
            )
            yield facts.problem("self-overlap", facts.where(name, "initial"), text, key=True)


def _collidable_pairs(tree: Tree) -> set[tuple[str, str]]:
    """Return the pairs of links that can collide: those that no joint connects, directly or through welded links."""
    above: dict[str, TreeLink] = {child.name: link for link in tree.links() for child in link.children}
    jointed = {link.name: bool(link.all_joints()) for link in tree.links()}

    def near(name: str) -> Iterator[str]:
        while name in above:
            fixed = not jointed[name]
            name = above[name].name
            yield name
            if not fixed:
                return

    neighbours = {frozenset((name, other)) for name in jointed for other in near(name)}
    return {pair for pair in combinations(jointed, 2) if frozenset(pair) not in neighbours}


def _overlapping(copy: Copy, tree: Tree, pairs: set[tuple[str, str]]) -> dict[tuple[str, str], float]:
    """Return the pairs of links that overlap at the start positions of a tree, with the depth [m], deepest first."""
    parts = {
        link.name: [StandingPart(geom.piece, pos, quat, True, link.name) for geom in link.geoms]
        for link, pos, quat, _ in tree_links(tree, copy.pos, copy.quat)
    }
    found, effort = {}, Effort(STEP_BUDGET)
    for a, b in sorted(pairs):
        touching = [(one, other) for one in parts[a] for other in parts[b] if overlapping(one, other)]
        if touching and (depth := overlap_of(parts[a], parts[b], touching, effort).depth) > MIN_DEPTH:
            found[a, b] = depth
    return dict(sorted(found.items(), key=lambda item: -item[1]))


RULES = (
    Rule(
        id="self-overlap",
        title="Links of one body with self-collision overlap at the start.",
        reason="""\
With `self_collision`, links that are not neighbours collide. But the engine treats pairs that overlap where all joints
are at 0 as neighbours, which pass through each other for the whole run; it only writes a line to its log. Links that
overlap only at their `initial` positions are pushed apart like any overlapping bodies.""",
        remedy="Make the links shorter or thinner, or separate them by their `pose`.",
        example="""\
bodies:
  gripper:
    kind: articulated
    self_collision: true
    links:
      palm: {shape: {kind: box, size: [0.2, 0.05, 0.05]}, pose: {pos: [0, 0, 1]}}
      left: {parent: palm, shape: {kind: box, size: [0.1, 0.04, 0.2]}, pose: {pos: [-0.04, 0, -0.13]},
             joint: {kind: slider, axis: x}}
      right: {parent: palm, shape: {kind: box, size: [0.1, 0.04, 0.2]}, pose: {pos: [0.04, 0, -0.13]},
              joint: {kind: slider, axis: x}}
""",
        fix="""\
bodies: {gripper: {links: {left: {pose: {pos: [-0.06, 0, -0.13]}}, right: {pose: {pos: [0.06, 0, -0.13]}}}}}
""",
        run=_self_overlap,
    ),
)
