"""Controls of the case become rows of the program: start velocities, drives, wrenches and welds.

Those of deformable bodies are lowered in `soft/controls.py`.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from text2sim.compiler.action_rows import Airflow as AirflowRow
from text2sim.compiler.action_rows import (
    FaceBond,
    Field,
    Hold,
    JointDrive,
    Origin,
    Prescribed,
    Push,
    Removal,
    StartVelocity,
    Weld,
    Wrench,
)
from text2sim.compiler.action_rows import Spring as SpringRow
from text2sim.compiler.drives import JointTargets, joints_named
from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.place_error import ReachError
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.schedules import constructor, oscillation, scale_constructor, value_at, waypoint_functions
from text2sim.compiler.selection import select, select_all
from text2sim.compiler.shapes.fragment import Fragment
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import ORIGIN, Vec, vector_cross, vector_minus, vector_plus
from text2sim.compiler.soft.control_checks import check_soft_controls
from text2sim.compiler.soft.controls import (
    ANY_FIELD,
    NEVER_REACHED,
    WORLD,
    SeamRegionError,
    SoftControls,
    ends_of,
    held_copies,
    lower_airflow,
    lower_field,
)
from text2sim.compiler.soft.solvers import is_soft
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.controls import (
    Attach,
    Bond,
    Control,
    Drive,
    Force,
    Impulse,
    InitialVelocity,
    Reach,
    Release,
    Remove,
    Spring,
    Torque,
)
from text2sim.spec_schema.models.fields import Airflow
from text2sim.spec_schema.models.motion import Oscillate, Spin
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.soft_bodies import Beam
from text2sim.spec_schema.names.selectors import body_of, parse_selector

MAX_BONDS = 3000
"""Most bonds of a scene: the engine solves six rows for each, over all degrees of freedom."""
Joining = TypeVar("Joining", Attach, Spring)


@dataclass
class ControlRows:
    """What the controls become in the program."""

    velocities: list[StartVelocity] = field(default_factory=list)
    drives: list[JointDrive] = field(default_factory=list)
    wrenches: list[Wrench] = field(default_factory=list)
    welds: list[Weld] = field(default_factory=list)
    springs: list[SpringRow] = field(default_factory=list)
    removals: list[Removal] = field(default_factory=list)
    bonds: list[FaceBond] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)
    pushes: list[Push] = field(default_factory=list)
    airflows: list[AirflowRow] = field(default_factory=list)
    fields: list[Field] = field(default_factory=list)
    joints: JointTargets = field(default_factory=JointTargets)
    """What `drives` are made of."""
    problems: list[Problem] = field(default_factory=list)
    """Empty regions, targets out of reach, and what a solver cannot do."""


def lower_controls(
    loaded: LoadedCase,
    copies: dict[str, list[Copy]],
    initial: dict[str, dict[str, float]],
    points: BodyPoints,
    soft: SoftControls | None,
    held: Mapping[str, Collection[str]],
) -> ControlRows:
    """Return the rows for all controls, in the order of the case.

    Args:
        loaded: The case.
        copies: Copies by body, statics included.
        initial: Start positions of joints by copy.
        points: Finds regions of bodies.
        soft: Lowers controls of deformable bodies; None if there are none.
        held: Joints whose actuators have a stiffness, by copy.
    """
    rows = ControlRows(problems=check_soft_controls(loaded))
    lowering = _Lowering(loaded, copies, points, soft, held, rows)
    for name, control in loaded.case.actions.controls.items():
        lowering.add(control, Origin(loaded.line(("actions", "controls", name)), name))
    rows.drives += rows.joints.drives(initial)
    rows.welds.sort(key=lambda weld: (weld.at, weld.on))
    rows.problems += _held_twice(loaded, rows)
    return rows


@dataclass(frozen=True)
class _Lowering:
    """Adds controls to rows; see `lower_controls`."""

    loaded: LoadedCase
    copies: dict[str, list[Copy]]
    points: BodyPoints
    soft: SoftControls | None
    held: Mapping[str, Collection[str]]
    rows: ControlRows

    def add(self, control: Control, origin: Origin) -> None:
        """Add the rows of a control, or what is wrong with it."""
        if isinstance(control, ANY_FIELD):
            self.rows.fields.append(lower_field(control, origin))
        elif isinstance(control, Release):
            attach = self.loaded.case.actions.controls[control.attach]
            assert isinstance(attach, Attach)
            if not is_soft(self.copies[body_of(attach.body)][0].model):
                self.rows.welds += [self._weld(a, b, attach, control, origin) for a, b in _pairs(attach, self.copies)]
        elif isinstance(control, Spring):
            self._springs(control, origin)
        elif isinstance(control, Bond):
            self._bond(control, origin)
        elif isinstance(control, Airflow):
            self._airflow(control, origin)
        else:
            chosen, part = select(control.joint if isinstance(control, Drive) else control.body, self.copies)
            try:
                self._act(control, chosen, part, origin)
            except SeamRegionError as error:
                self._report(origin, ("to_region",), str(error), "empty-region")
            except RegionError as error:
                key = next((key for key in ("region", "point") if getattr(control, key, None) is not None), "body")
                self._report(origin, (key,), f"`{chosen[0].body}`: {error}", "empty-region")
            except ReachError as error:
                self._report(origin, error.where, str(error), "out-of-reach")

    def _report(self, origin: Origin, where: tuple[str | int, ...], text: str, rule: str) -> None:
        self.rows.problems.append(self.loaded.problem(("actions", "controls", origin.control, *where), text, rule=rule))

    def _own_pairs(self, control: Joining, origin: Origin) -> Iterator[tuple[Joining, Copy, Copy]]:
        """Yield the pairs that a control joins, each with the control as the first copy has it."""
        if not self.loaded.varies(("actions", "controls", origin.control)):
            yield from ((control, a, b) for a, b in _pairs(control, self.copies))
            return
        for copy in select(control.body, self.copies)[0]:
            own = self.loaded.control_copy(origin.control, copy.variables)
            assert isinstance(own, type(control))
            yield from ((own, a, b) for a, b in _pairs(own, self.copies) if a is copy)

    def _airflow(self, control: Airflow, origin: Origin) -> None:
        acting = {row.entity: row.control for row in self.rows.airflows}
        for copy in select_all(control.body, self.copies):
            if copy.name in acting:
                text = f"`{acting[copy.name]}` already acts on `{copy.name}`; change it by its `scale`"
                self._report(origin, ("body",), text, "second-airflow")
            own = self.loaded.control_copy(origin.control, copy.variables)
            assert isinstance(own, Airflow)
            self.rows.airflows.append(lower_airflow(copy, own, self.loaded.case.scene.duration, origin))

    def _bond(self, control: Bond, origin: Origin) -> None:
        from text2sim.compiler.bonds import face_bonds  # arrays, which few cases need

        rows = self.rows
        bonds = face_bonds(control, select_all(control.of, self.copies), self.loaded.folder, origin)
        taken = {frozenset((bond.a, bond.b)) for bond in rows.bonds}
        twice = next((bond for bond in bonds if frozenset((bond.a, bond.b)) in taken), None)
        if not bonds:
            within = f"within {control.gap:g} m (`gap`)"
            text = f"no two of these bodies share a flat face {within}, so that nothing is bonded"
            self._report(origin, ("of",), text, "no-bond")
        elif twice is not None:
            self._report(origin, ("of",), f"`{twice.a}` and `{twice.b}` are bonded already", "no-bond")
        rows.bonds += bonds
        if len(rows.bonds) > MAX_BONDS:
            text = f"with this, the scene has {len(rows.bonds):,} bonds, and the engine can solve some {MAX_BONDS:,}"
            self._report(origin, ("of",), text, "too-many")

    def _springs(self, control: Spring, origin: Origin) -> None:
        for own, a, b in self._own_pairs(control, origin):
            ends: list[tuple[str, str | None, Vec]] = []
            for one, selector, key in ((a, own.body, "point"), (b, own.to, "to_point")):
                part = parse_selector(selector).part
                try:
                    ends.append((one.name, part, self.points.on_link(one, part, getattr(own, key)) or ORIGIN))
                except RegionError as error:
                    self._report(origin, (key,), f"`{one.body}`: {error}", "empty-region")
                    return
            k, c, length, span = own.stiffness, own.damping, own.length, span_of(own.during, NEVER_REACHED)
            self.rows.springs.append(SpringRow(*ends[0], *ends[1], k, c, length, own.form == "cord", *span, *origin))

    def _act(self, control: Control, chosen: list[Copy], part: str | None, origin: Origin) -> None:
        """Add the rows of a control that acts on copies one by one.

        Raises:
            RegionError: if one of them does not reach into a region.
            ReachError: if a target is out of reach.
        """
        loaded, rows, name = self.loaded, self.rows, origin.control
        soft = self.soft if is_soft(chosen[0].model) else None
        if isinstance(control, Attach):
            if soft is None:
                rows.welds += [self._weld(a, b, own, own, origin) for own, a, b in self._own_pairs(control, origin)]
            else:
                ends = ends_of(loaded, name)
                rows.holds += [soft.hold(copy, to, ends, origin) for copy, to in held_copies(loaded, name, self.copies)]
            return
        for copy in chosen:
            own = loaded.control_copy(name, copy.variables)
            if isinstance(own, Force | Impulse) and soft is not None:
                rows.pushes.append(soft.push(copy, own, origin))
            elif isinstance(own, InitialVelocity):
                linear = _linear_of_fragment(own, copy, self.copies[copy.body])
                rows.velocities.append(StartVelocity(copy.name, linear, own.angular, *origin))
            elif isinstance(own, Impulse | Force | Torque):
                rows.wrenches.append(self._wrench(own, copy, part, origin))
            elif isinstance(own, Remove):
                rows.removals.append(Removal(copy.name, own.at, own.on, *origin))
            elif isinstance(own, Drive):
                rows.joints.add(own, copy, joints_named(copy, part, self.points.trees), origin)
            elif isinstance(own, Reach):
                self._reach(own, copy, part or "", origin)

    def _reach(self, control: Reach, copy: Copy, link: str, origin: Origin) -> None:
        from text2sim.compiler.inverse_kinematics import Arm, reach_targets  # arrays, which few cases need

        before: dict[str, float] = {}
        for (entity, joint), targets in self.rows.joints.targets.items():
            earlier = [row for row in targets if row.mode == "position" and row.start <= control.start]
            if entity == copy.name and earlier:
                before[joint] = value_at(max(earlier, key=lambda row: row.start).schedule, control.start)
        arm = Arm(copy, self.points.trees[copy.name], link)
        for joint, found in reach_targets(control, arm, self.held.get(copy.name, ()), before, origin).items():
            self.rows.joints.targets.setdefault((copy.name, joint), []).extend(found)

    def _wrench(self, control: Impulse | Force | Torque, copy: Copy, part: str | None, origin: Origin) -> Wrench:
        point = None if isinstance(control, Torque) else self.points.on_link(copy, part, control.point)
        none = (0.0, 0.0, 0.0)
        if isinstance(control, Impulse):
            # An impulse is a force of one step: the program divides by its time step.
            return Wrench(copy.name, part, control.at, control.at, control.impulse, none, None, False, point, *origin)
        span = span_of(control.during, NEVER_REACHED)
        force, torque = (control.force, none) if isinstance(control, Force) else (none, control.torque)
        scale = scale_constructor(control.scale)
        return Wrench(copy.name, part, *span, force, torque, scale, control.frame == "body", point, *origin)

    def _weld(self, a: Copy, b: Copy, attach: Attach, when: Attach | Release, origin: Origin) -> Weld:
        event = when.on if isinstance(when, Release) else None
        own, to = parse_selector(attach.body), parse_selector(attach.to)
        part = to.part if to.body == b.body else None
        at = NEVER_REACHED if when.at is None else when.at
        pivot = self.points.on_link(a, own.part, attach.pivot) if when is attach else None
        stiff = pivot is None and any(isinstance(copy.model, Beam) for copy in (a, b))
        return Weld(at, when is attach, a.name, own.part, b.name, part, *origin, event, pivot, stiff, attach.strength)


def breaking_welds(welds: Sequence[Weld]) -> Iterator[FaceBond]:
    """Yield the bonds without a face that stand for welds with a strength."""
    for weld in welds:
        if (force := weld.strength) is not None:
            a, b = (".".join(filter(None, end)) for end in ((weld.a, weld.a_link), (weld.b, weld.b_link)))
            yield FaceBond(a, b, None, None, None, force, force, weld.line, weld.control)


def _linear_of_fragment(control: InitialVelocity, copy: Copy, copies: list[Copy]) -> Vec:
    """Return the start velocity [m/s] of a copy: fragments that are all selected turn as one body."""
    if not isinstance(copy.shape, Fragment) or parse_selector(control.body).first is not None:
        return control.linear
    total = sum(one.shape.volume for one in copies)
    x, y, z = (sum(one.shape.volume * one.pos[k] for one in copies) / total for k in range(3))
    return vector_plus(control.linear, vector_cross(control.angular, vector_minus(copy.pos, (x, y, z))))


def _pairs(attach: Attach | Spring, copies: dict[str, list[Copy]]) -> list[tuple[Copy, Copy]]:
    """Pair copies one to one, or all with the only one on the other side."""
    a, _ = select(attach.body, copies)
    if attach.to == WORLD and WORLD not in copies:
        # The engine only welds links to links: something that never moves stands for the world.
        b = [
            next(
                copy
                for group in copies.values()
                for copy in group
                if isinstance(copy.model, Static) and not copy.model.carries
            )
        ]
    else:
        b, _ = select(attach.to, copies)
    if len(b) == 1:
        return [(copy, b[0]) for copy in a]
    if len(a) == 1:
        return [(a[0], copy) for copy in b]
    if len(a) != len(b):
        raise ValueError(
            f"{attach.kind} pairs copies one to one: {attach.body} has {len(a)} copies and {attach.to} has {len(b)}"
        )
    return list(zip(a, b, strict=True))


def _held_twice(loaded: LoadedCase, rows: ControlRows) -> list[Problem]:
    """Report attachments of links that are joined already, each for one pair: the engine has one weld for two links.

    What an event may have released by then is not counted.
    """
    found: dict[str, Problem] = {}
    holder: dict[frozenset[tuple[str, str | None]], str] = {
        frozenset(((bond.a, None), (bond.b, None))): "" for bond in rows.bonds
    }
    pairs = [frozenset(((weld.a, weld.a_link), (weld.b, weld.b_link))) for weld in rows.welds]
    loose = {pair for weld, pair in zip(rows.welds, pairs, strict=True) if weld.event is not None}
    for weld, pair in zip(rows.welds, pairs, strict=True):
        if not weld.on:
            holder.pop(pair, None)
            continue
        if pair in holder:
            by = f"by `{holder[pair]}` already; a hinge is a `mount`" if holder[pair] else "by a `bond` already"
            text = f"`{weld.a}` and `{weld.b}` are joined {by}: the engine joins two links only once"
            where = ("actions", "controls", weld.control)
            found.setdefault(weld.control, loaded.problem(where, text, rule="held-twice"))
        if pair not in loose:
            holder[pair] = weld.control
    return list(found.values())


def lower_motions(copies: dict[str, list[Copy]]) -> list[Prescribed]:
    """Return the rows for bodies with prescribed motion."""
    rows = []
    for group in copies.values():
        for copy in group:
            if not isinstance(copy.model, Driven):
                continue
            motion = copy.model.motion
            if isinstance(motion, Spin):
                rows.append(Prescribed(copy.name, ("turn",), (), (constructor(motion.speed),), copy.line))
            elif isinstance(motion, Oscillate):
                rows.append(Prescribed(copy.name, ("slide",), (oscillation(motion),), (), copy.line))
            else:
                rows.append(
                    Prescribed(copy.name, ("slide_x", "slide_y", "slide_z"), waypoint_functions(motion), (), copy.line)
                )
    return rows
