"""Reach of bodies that the world holds.

A body on a hinge or ball joint stays within a ball around its anchor; one on a slider within that ball extended by its
range; a tree with a fixed root within the sum of its links. Bodies that are free, driven, or on a slider without a
range can move anywhere. Bodies that never meet make no contact, and a body never enters a region out of reach.
"""

from math import dist, inf

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, frame_apply, quat_rotate
from text2sim.compiler.trees.tree import StandingLink, Tree, TreeJoint, tree_links
from text2sim.lint.facts import Facts

Ball = tuple[Vec, float]
"""Centre and radius [m]."""
COMPLIANCE_FACTOR = 1.05
"""Factor for the compliance of joints and limits."""


class LinkReach:
    """Balls that links never leave, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self._trees: dict[str, dict[str, tuple[Ball, Ball]]] = {}
        self.welded = {name for weld in facts.rows.welds for name in (weld.a, weld.b)}

    def body(self, copy: Copy, part: str | None = None) -> list[Ball] | None:
        """Return balls that a copy (or one link) never leaves; None if it can move anywhere, or is a plane."""
        tree = self.facts.tree(copy)
        if tree is None:
            return None if self.facts.moves(copy) else self.facts.balls(copy) or None
        found = [pieces for pieces, _ in self._links(tree, copy, part) if pieces[1] > 0.0]
        if not found or any(radius == inf for _, radius in found):
            return None
        return found + (self.facts.balls(copy) if tree.fixtures and part is None else [])

    def origin(self, copy: Copy, part: str | None = None) -> Ball | None:
        """Return a ball that the origin of a copy (or of one link) never leaves; None if it can move anywhere."""
        tree = self.facts.tree(copy)
        if tree is None:
            return None if self.facts.moves(copy) else (copy.pos, 0.0)
        if part is None and tree.roots:
            part = tree.roots[0].name
        found = [origin for _, origin in self._links(tree, copy, part)]
        return found[0] if found and found[0][1] < inf else None

    def _links(self, tree: Tree, copy: Copy, part: str | None) -> list[tuple[Ball, Ball]]:
        """Return the balls of a link, or of all links of a copy; none if something is welded to it."""
        if copy.name in self.welded and self.facts.moves(copy):
            return []  # a weld holds by a spring, and may pull a joint apart
        if copy.name not in self._trees:
            self._trees[copy.name] = _tree(tree_links(tree, copy.pos, copy.quat), tree.initial)
        links = self._trees[copy.name]
        return list(links.values()) if part is None else [links[part]] if part in links else []


def never_meet(a: list[Ball] | None, b: list[Ball] | None) -> bool:
    """Return whether two bodies can never meet."""
    if not a or not b:
        return False
    return all(dist(p, q) > r + s for p, r in a for q, s in b)


def _tree(standing: list[StandingLink], initial: dict[str, float]) -> dict[str, tuple[Ball, Ball]]:
    """Return a ball for the pieces and one for the origin of each link, by name.

    Each link keeps its distance from the joint that carries it. So everything beyond the first moving joint of a branch
    stays within the sum of those distances around that joint's anchor.
    """
    found: dict[str, tuple[Ball, Ball]] = {}
    # By link: the point of the world around which it moves, the largest distance of its own anchor from that point, and
    # the position of that anchor at the start; None for fixed links.
    moved: dict[str, tuple[Vec, float, Vec] | None] = {}
    parents = {child.name: link.name for link, *_ in standing for child in link.children}
    for link, pos, quat, _ in standing:
        state = moved.get(parents.get(link.name, ""))
        for name, joint in link.all_joints():
            anchor = frame_apply(pos, quat, joint.anchor)
            slack = _slack(joint)
            if state is None:
                start = anchor if joint.kind != "slider" else pos
                axis = quat_rotate(quat, joint.axis)
                limits = joint.range if joint.kind == "slider" else None
                middle = sum(limits) / 2 - initial.get(name, 0.0) if limits is not None else 0.0
                center = tuple(s + middle * a for s, a in zip(start, axis, strict=True))
                state = ((center[0], center[1], center[2]), slack, start)
            else:
                center, reach, before = state
                state = (center, reach + dist(before, anchor) + 2 * slack, anchor)
        moved[link.name] = state
        points = [(frame_apply(pos, quat, c), r) for c, r in (g.piece.ball for g in link.geoms if g.touches)]
        if state is None:
            far = max((dist(pos, p) + r for p, r in points), default=0.0)
            found[link.name] = ((pos, far), (pos, 0.0))
            continue
        center, reach, anchor = state
        far = max((dist(anchor, p) + r for p, r in points), default=0.0)
        body = COMPLIANCE_FACTOR * (reach + far) if points else 0.0
        found[link.name] = ((center, body), (center, COMPLIANCE_FACTOR * (reach + dist(anchor, pos)) + 1e-3))
    return found


def _slack(joint: TreeJoint) -> float:
    """Return how far [m] a joint lets its anchor move to either side of the middle of its range."""
    if joint.kind in ("hinge", "ball"):
        return 0.0
    if joint.kind == "slider" and joint.range is not None:
        return (joint.range[1] - joint.range[0]) / 2
    return inf
