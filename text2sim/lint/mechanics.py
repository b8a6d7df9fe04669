"""Joints with all that hangs on them: what they weigh, how hard they are to turn, and who drives them.

All of it is at the start pose, with the other joints of a tree where they start. For a joint of its own (a mount) that
is exact; in a tree the inertia is that of everything beyond the joint taken as one rigid body, which is the entry
M[j][j] of the mass matrix: no motion of the other joints makes it larger.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import atan2, ceil, cos, floor, pi, sin

from text2sim.compiler.placement import Copy
from text2sim.compiler.plan import Motor
from text2sim.compiler.rotation import Vec, frame_apply, quat_rotate, vector_cross
from text2sim.compiler.tree import StandingLink, Tree, TreeJoint, tree_links
from text2sim.lint.facts import Facts
from text2sim.lint.lumps import NOTHING, Lump, lump_of, piece_lump, together
from text2sim.spec_schema.document import Path

ONE_DOF = ("hinge", "slider")


@dataclass(frozen=True)
class Swing:
    """A hinge or slider and everything beyond it."""

    copy: Copy
    name: str
    """Of the joint."""
    joint: TreeJoint
    motor: Motor | None
    axis: Vec
    """In the world, at the start."""
    start: float
    """Position at the start [rad or m]."""
    mass: float
    """Of all that it carries [kg]."""
    inertia: float
    """About its axis, or mass, with the rotor's [kg m2 or kg]; 0 if it is not known."""
    pull: tuple[float, float]
    """Gravity's torque [N m] at the angle q from the start is `pull[0] cos q + pull[1] sin q`; of a slider, the force
    [N] along its axis comes first, and stays."""
    closed: bool
    """Loops or welds tie it to something else, which helps to carry or to hold."""
    floating: bool
    """The root of its tree moves freely."""
    size: float
    """Largest distance [m] of a piece from the joint."""

    @property
    def hinge(self) -> bool:
        """Whether it turns."""
        return self.joint.kind == "hinge"

    @property
    def units(self) -> tuple[str, str]:
        """Units of position and force."""
        return ("rad", "N m") if self.hinge else ("m", "N")

    def gravity(self, q: float) -> float:
        """Torque [N m] or force [N] of gravity along the axis at position q."""
        if not self.hinge:
            return self.pull[0]
        turn = q - self.start
        return self.pull[0] * cos(turn) + self.pull[1] * sin(turn)

    def heaviest(self, low: float, high: float) -> tuple[float, float]:
        """Return the position between `low` and `high` at which gravity pulls hardest, and how it pulls there."""
        candidates = [low, high]
        if self.hinge and any(self.pull):
            top = atan2(self.pull[1], self.pull[0]) + self.start
            first, last = ceil((low - top) / pi), floor((high - top) / pi)
            candidates += [top + k * pi for k in range(first, min(last, first + 2) + 1)]
        return max(((q, self.gravity(q)) for q in candidates), key=lambda pair: abs(pair[1]))


class Mechanics:
    """Everything about joints, worked out from the facts of a case; see `mechanics_of`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self._links: dict[str, _Links] = {}
        self._twins: dict[str, Copy] = {}
        self._firsts: dict[str, Copy] = {}
        self._swings: dict[tuple[str, str], Swing | None] = {}
        self.motors = {(motor.entity, motor.joint): motor for motor in facts.lowering.motors}

    def swings(self) -> Iterator[Swing]:
        """Yield every hinge and slider that physics moves; of copies that are alike, the first one only."""
        for body, group in self.facts.placed.items():
            if body not in self.facts.case.bodies or self.facts.case.bodies[body].kind == "driven":
                continue
            for copy in group:
                if self.facts.mount(copy) in ("free", "fixed", "ball") or self._twin(copy) is not copy:
                    continue
                tree = self.facts.tree(copy)
                for link in tree.links() if tree is not None else ():
                    for name, joint in link.all_joints():
                        if joint.kind in ONE_DOF and (swing := self.swing(copy, name)) is not None:
                            yield swing

    def swing(self, copy: Copy, name: str) -> Swing | None:
        """Return the hinge or slider of a copy that goes by that name; None if there is none, or it is not known."""
        key = (copy.name, name)
        if key not in self._swings:
            twin = self._twin(copy)
            self._swings[key] = self._make(copy, name) if twin is copy else self.swing(twin, name)
        return self._swings[key]

    def where(self, swing: Swing, *keys: str) -> Path:
        """Path of a joint in the case, or of a value inside it."""
        model, body = swing.copy.model, swing.copy.body
        if model.kind == "rigid":
            return ("bodies", body, "mount", *keys)
        if getattr(model, "links", None) is not None and not isinstance(model.links, int):
            return ("bodies", body, "links", swing.name, "joint", *keys)
        if getattr(model, "file", None) is not None:
            return ("bodies", body, "joints", swing.name, *keys) if swing.name in model.joints else ("bodies", body)
        return ("bodies", body)

    def label(self, swing: Swing) -> str:
        """How the case would name a joint."""
        return swing.copy.name if swing.copy.model.kind == "rigid" else f"{swing.copy.name}.{swing.name}"

    def lump(self, copy: Copy) -> Lump:
        """Return the mass of a whole copy, in the world at the start."""
        if copy.name not in self._links:
            self._links[copy.name] = _Links(self.facts, copy, self._rho.get(copy.name))
        return self._links[copy.name].whole

    def totals(self, copy: Copy) -> dict[str, Lump]:
        """Return the mass of every link of a copy with all beyond it, in the world at the start, by link."""
        self.lump(copy)
        return self._links[copy.name].totals

    @cached_property
    def _rho(self) -> dict[str, float | None]:
        return {entity.name: entity.rho for group in self.facts.plan.bodies for entity in group.entities}

    @cached_property
    def _carried(self) -> tuple[dict[tuple[str, str], list[Lump]], set[str]]:
        """What is welded to links from the start, and the copies whose joints something else holds, too."""
        groups: dict[tuple[str, str], set[tuple[str, str]]] = {}
        closed: set[str] = set()
        for weld in self.facts.rows.welds:
            ends = [(name, link or "") for name, link in ((weld.a, weld.a_link), (weld.b, weld.b_link))]
            held = [self._held(name) for name, _ in ends]
            if not weld.on:
                continue
            if weld.at > 0.0:
                closed |= {name for name, _ in ends} if all(held) else set()
                continue
            group = set().union(*(groups.get(end, {end}) for end in ends))
            groups |= {end: group for end in group}
        carried: dict[tuple[str, str], list[Lump]] = {}
        for group in {id(group): group for group in groups.values()}.values():
            held_ends = sorted(end for end in group if self._held(end[0]))
            if len(held_ends) == 1:
                loads = [self.lump(self.facts.copies[name]) for name, _ in sorted(group) if (name, _) != held_ends[0]]
                carried[held_ends[0]] = loads
            elif held_ends:
                closed |= {name for name, _ in held_ends}
        return carried, closed

    def _held(self, name: str) -> bool:
        return not self.facts.free(self.facts.copies[name])

    def _twin(self, copy: Copy) -> Copy:
        """A copy that hangs in the same way, with the same things on it; the copy itself if there is none."""
        if copy.name not in self._twins:
            carried, closed = self._carried
            alone = copy.name not in closed and not any(name == copy.name for name, _ in carried)
            first = self._firsts.setdefault(copy.body, copy) if alone else copy
            same = first.quat == copy.quat and first.shape == copy.shape and _alike(first.model, copy.model)
            if not same:
                self._firsts[copy.body] = copy
            self._twins[copy.name] = first if same else copy
        return self._twins[copy.name]

    def _make(self, copy: Copy, name: str) -> Swing | None:
        tree = self.facts.tree(copy)
        if tree is None:
            return None
        if copy.name not in self._links:
            self._links[copy.name] = _Links(self.facts, copy, self._rho.get(copy.name))
        links = self._links[copy.name]
        standing = links.of_joint.get(name)
        joint = dict(standing.link.all_joints()).get(name) if standing is not None else None
        if standing is None or joint is None or joint.kind not in ONE_DOF:
            return None
        carried, closed = self._carried
        beyond = links.beyond(standing.link.name)
        main = tree.roots[0].name
        loads = [
            lump
            for (other, link), lumps in carried.items()
            if other == copy.name and (link or main) in beyond
            for lump in lumps
        ]
        lump = together([links.totals[standing.link.name], *loads])
        axis = quat_rotate(standing.quat, joint.axis)
        anchor = frame_apply(standing.pos, standing.quat, joint.anchor)
        known = lump.mass > 0.0
        inertia = (lump.mass if joint.kind == "slider" else lump.about(anchor, axis)) + joint.armature if known else 0.0
        reaches = [_far(anchor, ball) for ball in self.facts.balls(copy)] or [0.0]
        return Swing(
            copy=copy,
            name=name,
            joint=joint,
            motor=self.motors.get((copy.name, name)),
            axis=axis,
            start=tree.initial.get(name, 0.0),
            mass=lump.mass,
            inertia=inertia,
            pull=_pull(joint.kind, axis, anchor, lump, self.facts.plan.gravity),
            closed=bool(tree.loops) or copy.name in closed or len(tree.roots) > 1,
            floating=self.facts.free(copy),
            size=max(reaches),
        )


@dataclass
class _Links:
    """The links of a copy, with the mass of each and of all beyond it, in the world."""

    facts: Facts
    copy: Copy
    rho: float | None
    """Density [kg/m3] of a primitive of the engine."""
    standing: dict[str, StandingLink] = field(init=False)
    of_joint: dict[str, StandingLink] = field(init=False)
    totals: dict[str, Lump] = field(init=False)
    whole: Lump = field(init=False)

    def __post_init__(self) -> None:
        copy, tree = self.copy, self.facts.tree(self.copy)
        if tree is None:
            self.standing, self.of_joint, self.totals = {}, {}, {}
            rho = self.rho or 0.0
            parts = self.facts.parts(copy) if rho else []
            self.whole = together(piece_lump(p.piece, rho).at(p.pos, p.quat) for p in parts)
            return
        found = tree_links(tree, copy.pos, copy.quat)
        self.standing = {one.link.name: one for one in found}
        self.of_joint = {name: one for one in found for name, _ in one.link.all_joints()}
        self.totals = {}
        for link, pos, quat, _ in _children_first(tree, self.standing):
            own = lump_of(link.geoms).at(pos, quat)
            self.totals[link.name] = together([own, *(self.totals[child.name] for child in link.children)])
        self.whole = together(self.totals[root.name] for root in tree.roots) if tree.roots else NOTHING

    def beyond(self, name: str) -> set[str]:
        """Names of a link and of all that hang on it."""
        found, waiting = set(), [self.standing[name].link]
        while waiting:
            link = waiting.pop()
            found.add(link.name)
            waiting += link.children
        return found


def mechanics_of(facts: Facts) -> Mechanics:
    """Return the joints of a case, worked out once."""
    return facts.own(Mechanics)


def _children_first(tree: Tree, standing: dict[str, StandingLink]) -> list[StandingLink]:
    return [standing[link.name] for link in reversed(tree.links())]


def _alike(a: object, b: object) -> bool:
    """Whether two models of a body differ in no more than where they are and how they look."""
    if a is b:
        return True
    fields = ("shape", "material", "mount", "links", "loops", "initial", "file", "joints", "base")
    return all(getattr(a, name, None) == getattr(b, name, None) for name in fields)


def _pull(kind: str, axis: Vec, anchor: Vec, lump: Lump, gravity: Vec) -> tuple[float, float]:
    weight = tuple(lump.mass * g for g in gravity)
    if kind == "slider":
        return (_dot(axis, weight), 0.0)
    arm = tuple(c - a for c, a in zip(lump.center, anchor, strict=True))
    along = _dot(arm, axis)
    across = tuple(r - along * a for r, a in zip(arm, axis, strict=True))
    turned = vector_cross(axis, across)
    return (_dot(axis, vector_cross(across, weight)), _dot(axis, vector_cross(turned, weight)))


def _far(anchor: Vec, ball: tuple[Vec, float]) -> float:
    (x, y, z), radius = ball
    return ((x - anchor[0]) ** 2 + (y - anchor[1]) ** 2 + (z - anchor[2]) ** 2) ** 0.5 + radius


def _dot(a: object, b: object) -> float:
    return sum(p * q for p, q in zip(a, b, strict=True))  # type: ignore[call-overload]
