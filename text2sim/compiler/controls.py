"""Controls of the case become rows of the program: start velocities, drives, wrenches and welds.

Those of deformable bodies are lowered in `soft/controls.py`.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from text2sim.compiler.action_rows import Airflow as AirflowRow
from text2sim.compiler.action_rows import (
    FaceBond,
    Field,
    Hold,
    JointDrive,
    LaterDrive,
    Prescribed,
    Push,
    Removal,
    StartVelocity,
    Weld,
    Wrench,
)
from text2sim.compiler.action_rows import Spring as SpringRow
from text2sim.compiler.drives import DriveTarget, DriveTargets, add_drive, joint_drives, joints_named
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
    targets: DriveTargets = field(default_factory=dict)
    """What `drives` are made of, by copy and joint, in the order of the case."""
    later: dict[tuple[str, str], list[LaterDrive]] = field(default_factory=dict)
    """What begins at events, likewise."""
    later_targets: DriveTargets = field(default_factory=dict)
    """Targets of `later`; their times count from the event, which may come at any time."""
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
    for name, control in loaded.case.actions.controls.items():
        pointer = ("actions", "controls", name)
        line = loaded.line(pointer)
        if isinstance(control, ANY_FIELD):
            rows.fields.append(lower_field(control, line, name))
            continue
        if isinstance(control, Release):
            attach = loaded.case.actions.controls[control.attach]
            assert isinstance(attach, Attach)
            if not is_soft(copies[body_of(attach.body)][0].model):
                rows.welds += [_weld(a, b, attach, control, line, name, points) for a, b in _pairs(attach, copies)]
            continue
        if isinstance(control, Spring):
            _springs(loaded, control, copies, rows, name, points)
            continue
        if isinstance(control, Bond):
            _bond(loaded, control, copies, rows, name)
            continue
        if isinstance(control, Airflow):
            _airflow(loaded, control, copies, rows, name)
            continue
        chosen, part = select(control.joint if isinstance(control, Drive) else control.body, copies)
        varies = loaded.varies(pointer)
        try:
            if isinstance(control, Attach) and soft is not None and is_soft(chosen[0].model):
                ends = ends_of(loaded, name)
                rows.holds += [soft.hold(copy, to, ends, line, name) for copy, to in held_copies(loaded, name, copies)]
                continue
            for copy in chosen:
                own = loaded.control_copy(name, copy.variables) if varies else control
                if isinstance(own, Force | Impulse) and soft is not None and is_soft(copy.model):
                    rows.pushes.append(soft.push(copy, own, line, name))
                elif isinstance(own, Reach):
                    _reach(own, copy, part or "", points, held.get(copy.name, ()), rows, line, name)
                else:
                    _lower(own, copy, part, copies, rows, line, name, points)
        except RegionError as error:
            key = next((key for key in ("region", "point") if getattr(control, key, None) is not None), "body")
            rows.problems.append(loaded.problem((*pointer, key), f"`{chosen[0].body}`: {error}", rule="empty-region"))
        except ReachError as error:
            where = (*pointer, error.key) if error.index is None else (*pointer, error.key, error.index)
            rows.problems.append(loaded.problem(where, str(error), rule="out-of-reach"))
    rows.drives += joint_drives(rows.targets, rows.later, initial)
    rows.welds.sort(key=lambda weld: (weld.at, weld.on))
    rows.problems += _held_twice(loaded, rows)
    return rows


def _airflow(loaded: LoadedCase, control: Airflow, copies: dict[str, list[Copy]], rows: ControlRows, name: str) -> None:
    pointer = ("actions", "controls", name)
    acting = {row.entity: row.control for row in rows.airflows}
    for copy in select_all(control.body, copies):
        if copy.name in acting:
            text = f"`{acting[copy.name]}` already acts on `{copy.name}`; change it by its `scale`"
            rows.problems.append(loaded.problem((*pointer, "body"), text, rule="second-airflow"))
        own = loaded.control_copy(name, copy.variables)
        assert isinstance(own, Airflow)
        rows.airflows.append(lower_airflow(copy, own, loaded.case.scene.duration, loaded.line(pointer), name))


def _bond(loaded: LoadedCase, control: Bond, copies: dict[str, list[Copy]], rows: ControlRows, name: str) -> None:
    from text2sim.compiler.bonds import face_bonds  # arrays, which few cases need

    pointer = ("actions", "controls", name)
    bonds = face_bonds(control, select_all(control.of, copies), loaded.folder, loaded.line(pointer), name)
    taken = {frozenset((bond.a, bond.b)) for bond in rows.bonds}
    twice = next((bond for bond in bonds if frozenset((bond.a, bond.b)) in taken), None)
    if not bonds:
        text = f"no two of these bodies share a flat face within {control.gap:g} m (`gap`), so that nothing is bonded"
        rows.problems.append(loaded.problem((*pointer, "of"), text, rule="no-bond"))
    elif twice is not None:
        text = f"`{twice.a}` and `{twice.b}` are bonded already"
        rows.problems.append(loaded.problem((*pointer, "of"), text, rule="no-bond"))
    rows.bonds += bonds
    if len(rows.bonds) > MAX_BONDS:
        text = f"with this, the scene has {len(rows.bonds):,} bonds, and the engine can solve some {MAX_BONDS:,}"
        rows.problems.append(loaded.problem((*pointer, "of"), text, rule="too-many"))


def _springs(
    loaded: LoadedCase,
    control: Spring,
    copies: dict[str, list[Copy]],
    rows: ControlRows,
    name: str,
    points: BodyPoints,
) -> None:
    pointer = ("actions", "controls", name)
    varies, line = loaded.varies(pointer), loaded.line(pointer)
    chosen: list[Copy | None] = [*select(control.body, copies)[0]] if varies else [None]
    for copy in chosen:
        own = control if copy is None else loaded.control_copy(name, copy.variables)
        assert isinstance(own, Spring)
        for a, b in _pairs(own, copies):
            if copy is not None and a is not copy:
                continue
            ends: list[tuple[str, str | None, Vec]] = []
            for one, selector, key in ((a, own.body, "point"), (b, own.to, "to_point")):
                part = parse_selector(selector).part
                try:
                    ends.append((one.name, part, points.on_link(one, part, getattr(own, key)) or ORIGIN))
                except RegionError as error:
                    text = f"`{one.body}`: {error}"
                    rows.problems.append(loaded.problem((*pointer, key), text, rule="empty-region"))
                    return
            k, c, length, span = own.stiffness, own.damping, own.length, span_of(own.during, NEVER_REACHED)
            rows.springs.append(SpringRow(*ends[0], *ends[1], k, c, length, own.form == "cord", *span, line, name))


def _reach(
    control: Reach,
    copy: Copy,
    link: str,
    points: BodyPoints,
    held: Collection[str],
    rows: ControlRows,
    line: int,
    name: str,
) -> None:
    from text2sim.compiler.inverse_kinematics import reach_targets  # arrays, which few cases need

    begun: dict[str, DriveTarget] = {}
    for (entity, joint), targets in rows.targets.items():
        earlier = [target for target in targets if target[1] == "position" and target[0] <= control.start]
        if entity == copy.name and earlier:
            begun[joint] = max(earlier, key=lambda target: target[0])
    before = {joint: value_at(target[2], control.start) for joint, target in begun.items()}
    for joint, found in reach_targets(control, copy, link, points.trees[copy.name], held, before, line, name).items():
        rows.targets.setdefault((copy.name, joint), []).extend(found)


def _lower(
    control: Control,
    copy: Copy,
    part: str | None,
    copies: dict[str, list[Copy]],
    rows: ControlRows,
    line: int,
    name: str,
    points: BodyPoints,
) -> None:
    if isinstance(control, InitialVelocity):
        linear = _linear_of_fragment(control, copy, copies[copy.body])
        rows.velocities.append(StartVelocity(copy.name, linear, control.angular, line, name))
    elif isinstance(control, Impulse | Force | Torque):
        rows.wrenches.append(_wrench(control, copy, part, line, name, points))
    elif isinstance(control, Remove):
        rows.removals.append(Removal(copy.name, control.at, control.on, line, name))
    elif isinstance(control, Attach):
        for a, b in _pairs(control, copies):
            if a is copy:
                rows.welds.append(_weld(a, b, control, control, line, name, points))
    elif isinstance(control, Drive):
        joints = joints_named(copy, part, points.trees)
        add_drive(control, copy, joints, line, name, rows.targets, rows.later, rows.later_targets)


def _wrench(
    control: Impulse | Force | Torque, copy: Copy, part: str | None, line: int, name: str, points: BodyPoints
) -> Wrench:
    point = None if isinstance(control, Torque) else points.on_link(copy, part, control.point)
    none = (0.0, 0.0, 0.0)
    if isinstance(control, Impulse):
        # An impulse is a force of one step: the program divides by its time step.
        return Wrench(copy.name, part, control.at, control.at, control.impulse, none, None, False, point, line, name)
    start, end = span_of(control.during, NEVER_REACHED)
    force, torque = (control.force, none) if isinstance(control, Force) else (none, control.torque)
    scale = scale_constructor(control.scale)
    local = control.frame == "body"
    return Wrench(copy.name, part, start, end, force, torque, scale, local, point, line, name)


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


def _weld(a: Copy, b: Copy, attach: Attach, when: Attach | Release, line: int, name: str, points: BodyPoints) -> Weld:
    event = when.on if isinstance(when, Release) else None
    own, to = parse_selector(attach.body), parse_selector(attach.to)
    part = to.part if to.body == b.body else None
    at = NEVER_REACHED if when.at is None else when.at
    pivot = points.on_link(a, own.part, attach.pivot) if when is attach else None
    stiff = pivot is None and any(isinstance(copy.model, Beam) for copy in (a, b))
    return Weld(at, when is attach, a.name, own.part, b.name, part, line, name, event, pivot, stiff)


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
