"""Joints with the mass, inertia and motor of everything beyond them.

All values are at the start pose. For a single joint (a mount) that is exact. In a tree the inertia is that of
everything beyond the joint as one rigid body, which is the entry M[j][j] of the mass matrix: no motion of the other
joints makes it larger.
"""

from collections.abc import Collection, Iterator
from functools import cache, cached_property

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.inertials import Inertial, combined_inertial, piece_inertial
from text2sim.compiler.shapes.rotation import frame_apply, quat_rotate
from text2sim.compiler.shapes.sweep import sweep
from text2sim.compiler.soft.solvers import is_soft
from text2sim.compiler.trees.tree import tree_links
from text2sim.lint.facts import Facts
from text2sim.lint.joints.linkage import Linkage
from text2sim.lint.joints.loaded_joint import LoadedJoint, far_from, pull_of
from text2sim.lint.motion.flight import MAX_RESTING_GAP
from text2sim.spec_schema.names.selectors import body_of, keys_for
from text2sim.spec_schema.text.document import Path

ONE_DOF = ("hinge", "slider")
_MOTION_FIELDS = ("shape", "material", "mount", "links", "loops", "initial", "file", "joints", "base")
"""Fields of a body that determine the motion of its joints."""


class Mechanics:
    """The joints of a case, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.joint = cache(self._joint)
        """The hinge or slider of a copy with a name; None if there is none, or it is not known."""
        self._links_of = cache(lambda copy: _Links(facts, copy, self._rho.get(copy.name)))
        self._equivalent_copy = cache(self._find_equivalent)
        """The first copy with the same orientation and load; the copy itself if there is none."""
        self._firsts: dict[str, Copy] = {}
        self._uniform: dict[str, bool] = {}
        self.motors = {(motor.entity, motor.joint): motor for motor in facts.lowering.motors}

    def joints(self) -> Iterator[LoadedJoint]:
        """Yield every hinge and slider that physics moves; for identical copies, only the first."""
        for body, group in self.facts.placed.items():
            if body not in self.facts.case.bodies or self.facts.case.bodies[body].kind == "driven":
                continue
            for copy in group:
                if self.facts.mount(copy) in ("free", "fixed", "ball") or self._equivalent_copy(copy) is not copy:
                    continue
                tree = self.facts.tree(copy)
                for link in tree.links() if tree is not None else ():
                    for name, _ in link.all_joints():
                        if (joint := self.joint(copy, name)) is not None:
                            yield joint

    def _joint(self, copy: Copy, name: str) -> LoadedJoint | None:
        twin = self._equivalent_copy(copy)
        return self._make(copy, name) if twin is copy else self.joint(twin, name)

    def where(self, joint: LoadedJoint, *keys: str) -> Path:
        """Return the path of a joint in the case, or of a value inside it."""
        model, body = joint.copy.model, joint.copy.body
        if model.kind == "rigid":
            return ("bodies", body, "mount", *keys)
        if getattr(model, "links", None) is not None and not isinstance(model.links, int):
            return ("bodies", body, "links", joint.name, "joint", *keys)
        if getattr(model, "file", None) is not None:
            joint_keys = keys_for(joint.name, model.joints)
            return ("bodies", body, "joints", joint_keys[-1], *keys) if joint_keys else ("bodies", body)
        return ("bodies", body)

    def label(self, joint: LoadedJoint) -> str:
        """Return the selector of a joint."""
        return joint.copy.name if joint.copy.model.kind == "rigid" else f"{joint.copy.name}.{joint.name}"

    def inertial(self, copy: Copy) -> Inertial:
        """Return the inertial of a whole copy, in the world at the start."""
        return self._links_of(copy).whole

    def totals(self, copy: Copy) -> dict[str, Inertial]:
        """Return the inertial of every link of a copy with all links beyond it, in the world at the start, by link."""
        return self._links_of(copy).totals

    def linkage(self, joint: LoadedJoint, held: Collection[str]) -> Linkage | None:
        """Return the mechanism that a joint moves, if nothing but its own loops closes it; None otherwise.

        Args:
            joint: The joint.
            held: Names of joints that other drives hold.
        """
        tree, (carried, closed) = self.facts.tree(joint.copy), self._carried
        if tree is None or not tree.loops or joint.floating or joint.copy.name in closed:
            return None
        loads = [
            (link or tree.roots[0].name, load)
            for (name, link), masses in carried.items()
            if name == joint.copy.name
            for load in masses
        ]
        return Linkage(joint, tree, held, self.facts.plan.gravity, loads)

    def beyond(self, joint: LoadedJoint) -> set[str]:
        """Return the names of all links that a joint carries."""
        links = self._links_of(joint.copy)
        return links.beyond(links.of_joint[joint.name].link.name)

    @cached_property
    def _rho(self) -> dict[str, float | None]:
        return {entity.name: entity.rho for group in self.facts.plan.bodies for entity in group.entities}

    @cached_property
    def _carried(self) -> tuple[dict[tuple[str, str], list[Inertial]], set[str]]:
        """Inertials on links from the start, welded or placed there, and the copies that something else also holds."""
        groups: dict[tuple[str, str], set[tuple[str, str]]] = {}
        closed = {name for name in self.facts.sprung if self._is_held(name)}
        for weld in self.facts.rows.welds:
            ends = [(name, link or "") for name, link in ((weld.a, weld.a_link), (weld.b, weld.b_link))]
            held = [self._is_held(name) for name, _ in ends]
            if not weld.on:
                continue
            if weld.at > 0.0:
                closed |= {name for name, _ in ends} if all(held) else set()
                continue
            group = set().union(*(groups.get(end, {end}) for end in ends))
            groups |= {end: group for end in group}
        carried: dict[tuple[str, str], list[Inertial]] = {}
        for group in {id(group): group for group in groups.values()}.values():
            held_ends = sorted(end for end in group if self._is_held(end[0]))
            if len(held_ends) == 1:
                loads = [
                    self.inertial(self.facts.copies[name]) for name, _ in sorted(group) if (name, _) != held_ends[0]
                ]
                carried[held_ends[0]] = loads
            elif held_ends:
                closed |= {name for name, _ in held_ends}
        welded = {name for weld in self.facts.rows.welds for name in (weld.a, weld.b)}
        for copy in self.facts.copies.values():
            if copy.name not in welded and (end := self._stands_on(copy)) is not None:
                carried.setdefault(end, []).append(self.inertial(copy))
        return carried, closed

    def _stands_on(self, copy: Copy) -> tuple[str, str] | None:
        """Return the copy with motors, and its link, on which the case places a free rigid copy; None if on none."""
        place = getattr(copy.model, "place", None)
        below = place and (place.on or place.inside)
        if not below or is_soft(copy.model) or not self.facts.free(copy) or not self.facts.pull:
            return None  # without gravity, nothing is a load
        down = (-self.facts.up[0], -self.facts.up[1], -self.facts.up[2])
        own = [part.solid for part in self.facts.parts(copy)]
        powered = {entity for entity, _ in self.motors}
        gaps: dict[tuple[str, str], float] = {}
        for other in self.facts.placed.get(body_of(below), ()):
            driven = other.name in powered and self._is_held(other.name) and self.facts.tree(other) is not None
            parts = self.facts.parts(other) if driven else []
            for link in {part.link for part in parts if part.moves and part.link}:
                gap = sweep(own, [part.solid for part in parts if part.link == link], down)
                if gap is not None and gap < MAX_RESTING_GAP:
                    gaps[other.name, link] = gap
        return min(gaps, key=lambda end: gaps[end], default=None)

    @cached_property
    def _loaded(self) -> set[str]:
        """Copies to which something is welded later; see `loads`."""
        return {name for weld in self.facts.rows.welds if weld.at > 0.0 for name in (weld.a, weld.b)}

    def _is_held(self, name: str) -> bool:
        return not self.facts.free(self.facts.copies[name])

    def _find_equivalent(self, copy: Copy) -> Copy:
        carried, closed = self._carried
        alone = copy.name not in closed | self._loaded and not any(name == copy.name for name, _ in carried)
        first = self._firsts.setdefault(copy.body, copy) if alone else copy
        if first is copy or (first.quat == copy.quat and self._alike(first, copy)):
            return first
        self._firsts[copy.body] = copy
        return copy

    def _alike(self, a: Copy, b: Copy) -> bool:
        """Return whether two copies of a body differ only in pose and look."""
        if a.body not in self._uniform:
            varies = self.facts.loaded.varies
            self._uniform[a.body] = not any(varies(("bodies", a.body, field)) for field in _MOTION_FIELDS)
        if self._uniform[a.body]:
            return getattr(a.model.repeat, "kind", None) != "running_bond" or a.shape == b.shape  # half boxes differ
        fields = [(getattr(a.model, field, None), getattr(b.model, field, None)) for field in _MOTION_FIELDS]
        return a.shape == b.shape and all(x == y for x, y in fields)

    def _make(self, copy: Copy, name: str) -> LoadedJoint | None:
        tree = self.facts.tree(copy)
        if tree is None:
            return None
        links = self._links_of(copy)
        standing = links.of_joint.get(name)
        spec = dict(standing.link.all_joints()).get(name) if standing is not None else None
        if standing is None or spec is None or spec.kind not in ONE_DOF:
            return None
        carried, closed = self._carried
        beyond = links.beyond(standing.link.name)
        main = tree.roots[0].name
        loads = [
            inertial
            for (other, link), masses in carried.items()
            if other == copy.name and (link or main) in beyond
            for inertial in masses
        ]
        inertial = combined_inertial([links.totals[standing.link.name], *loads])
        axis = quat_rotate(standing.quat, spec.axis)
        anchor = frame_apply(standing.pos, standing.quat, spec.anchor)
        inertia = 0.0
        if inertial.mass > 0.0:
            inertia = inertial.mass if spec.kind == "slider" else inertial.about(anchor, axis)
            inertia += spec.armature
        reaches = [far_from(anchor, ball) for ball in self.facts.balls(copy)] or [0.0]
        return LoadedJoint(
            copy=copy,
            name=name,
            spec=spec,
            motor=self.motors.get((copy.name, name)),
            axis=axis,
            start=tree.initial.get(name, 0.0),
            mass=inertial.mass,
            inertia=inertia,
            pull=pull_of(spec.kind, axis, anchor, inertial, self.facts.plan.gravity),
            closed=bool(tree.loops) or copy.name in closed or len(tree.roots) > 1,
            floating=self.facts.free(copy),
            size=max(reaches),
        )


class _Links:
    """The links of a copy, with the inertial of each and of all beyond it, in the world.

    Args:
        facts: The case.
        copy: The copy.
        rho: Density [kg/m3] of a primitive of the engine.
    """

    def __init__(self, facts: Facts, copy: Copy, rho: float | None) -> None:
        tree = facts.tree(copy)
        found = tree_links(tree, copy.pos, copy.quat) if tree is not None else []
        self.standing = {standing.link.name: standing for standing in found}
        self.of_joint = {name: standing for standing in found for name, _ in standing.link.all_joints()}
        self.totals: dict[str, Inertial] = {}
        if tree is None:
            parts = facts.parts(copy) if rho else []
            self.whole = combined_inertial(piece_inertial(p.piece, rho or 0.0).at(p.pos, p.quat) for p in parts)
            return
        for link in reversed(tree.links()):  # children first
            own = link.inertial.at(self.standing[link.name].pos, self.standing[link.name].quat)
            self.totals[link.name] = combined_inertial([own, *(self.totals[child.name] for child in link.children)])
        self.whole = combined_inertial(self.totals[root.name] for root in tree.roots)

    def beyond(self, name: str) -> set[str]:
        """Return the names of a link and of all links beyond it."""
        found, waiting = set(), [self.standing[name].link]
        while waiting:
            link = waiting.pop()
            found.add(link.name)
            waiting += link.children
        return found
