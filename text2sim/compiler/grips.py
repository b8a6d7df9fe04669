"""Grips: parts of mechanisms that motors close on each other, so that friction holds a free body between them."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from math import dist
from typing import NamedTuple

from text2sim.compiler.controls import ControlRows
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.schedules import extremes
from text2sim.compiler.shapes.boxes import around
from text2sim.compiler.shapes.rotation import Vec, frame_apply, vector_dot, vector_minus
from text2sim.compiler.trees.tree import Tree, TreeLink, tree_links
from text2sim.spec_schema.models.bodies import Rigid

MIN_COSINE = 0.7
"""Least cosine of the angle between the way of a jaw and the direction to the other."""
FORCE_STEP = 1e-3
"""Change [rad or m] of a joint that a force or a speed stands for: only its direction matters."""


class Jaw(NamedTuple):
    """What a driven joint moves."""

    copy: str
    joint: str
    links: frozenset[str]
    """Names of the links beyond the joint."""
    middle: Vec
    """Their middle [m] at the start, in the world."""
    ways: tuple[Vec, ...]
    """Where the middle goes [m] by the motor alone, as far as it goes either way."""

    def closes_on(self, other: "Jaw") -> bool:
        """Return whether it goes towards another."""
        gap = vector_minus(other.middle, self.middle)
        return any(vector_dot(way, gap) > MIN_COSINE * dist(way, (0, 0, 0)) * dist(gap, (0, 0, 0)) for way in self.ways)


def grips(copies: Iterable[Copy], trees: Mapping[str, Tree], rows: ControlRows) -> Iterator[tuple[Jaw, Jaw]]:
    """Yield pairs of jaws that close on each other, in a scene with a free rigid body that may come between them.

    Args:
        copies: Of bodies.
        trees: Trees of links by copy.
        rows: Controls, lowered.
    """
    found = {copy.name: copy for copy in copies}
    if not any(isinstance(copy.model, Rigid) and copy.model.mount.kind == "free" for copy in found.values()):
        return
    jaws = [jaw for key in rows.joints.targets if (jaw := _jaw(*key, found, trees, rows))]
    for a, b in combinations(jaws, 2):
        apart = a.copy != b.copy or not a.links & b.links
        if apart and a.closes_on(b) and b.closes_on(a):
            yield a, b


def _jaw(name: str, joint: str, copies: Mapping[str, Copy], trees: Mapping[str, Tree], rows: ControlRows) -> Jaw | None:
    copy, tree = copies.get(name), trees.get(name)
    if copy is None or tree is None:
        return None
    root = next((link for link in tree.links() if joint in dict(link.all_joints())), None)
    if root is None:
        return None
    links = frozenset(link.name for link in _beyond(root))
    start = tree.initial.get(joint, 0.0)
    middle = _middle(copy, tree, links)
    if middle is None:
        return None
    ends = set()
    for target in rows.joints.all_of(name, joint):
        for value in extremes(target.schedule):
            ends.add(value if target.mode == "position" else start + FORCE_STEP * ((value > 0) - (value < 0)))
    goals = [_middle(copy, replace(tree, initial={**tree.initial, joint: end}), links) for end in ends - {start}]
    return Jaw(name, joint, links, middle, tuple(vector_minus(goal, middle) for goal in goals if goal is not None))


def _beyond(link: TreeLink) -> Iterator[TreeLink]:
    yield link
    for child in link.children:
        yield from _beyond(child)


def _middle(copy: Copy, tree: Tree, links: frozenset[str]) -> Vec | None:
    """Return the middle [m] of the pieces of links; None if nothing of them touches."""
    points = [
        frame_apply(stand.pos, stand.quat, geom.piece.ball[0])
        for stand in tree_links(tree, copy.pos, copy.quat)
        if stand.link.name in links
        for geom in stand.link.geoms
        if geom.touches
    ]
    if not points:
        return None
    (x, y, z), (right, back, top) = around(points)
    return (x + right) / 2, (y + back) / 2, (z + top) / 2
