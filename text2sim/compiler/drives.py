"""Drives of joints: a timed drive takes over from the one before it, another when its event happens."""

from collections.abc import Callable, Iterable, Mapping

from text2sim.compiler.action_rows import DriveSegment, JointDrive, LaterDrive
from text2sim.compiler.literal import Code
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.schedules import constructor, value_at
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.models.controls import Drive
from text2sim.spec_schema.models.motion import Constant, Ramp, Schedule, start_of
from text2sim.spec_schema.names.selectors import named_by

DriveTarget = tuple[float, str, Schedule, int, str]
"""A drive: its start [s], what it controls, its target, and the line and name of its control."""
DriveTargets = dict[tuple[str, str], list[DriveTarget]]
"""Drives by copy and joint."""


def joints_named(copy: Copy, part: str | None, trees: Mapping[str, Tree]) -> list[str]:
    """Return the names of the joints that a drive means: one, or all hinges and sliders that a pattern fits.

    Args:
        copy: The copy.
        part: Name of a joint, or a pattern with `*`; None for a body on a hinge or slider.
        trees: Trees of links by copy.
    """
    if part is None or "*" not in part or copy.name not in trees:
        return [part or copy.body]
    return named_by(part, [name for name, joint in trees[copy.name].joints() if joint.kind in ("hinge", "slider")])


def add_drive(
    control: Drive,
    copy: Copy,
    joints: Iterable[str],
    line: int,
    name: str,
    targets: DriveTargets,
    later: dict[tuple[str, str], list[LaterDrive]],
    later_targets: DriveTargets,
) -> None:
    """Add a drive of joints of one copy to the timed drives, or to those that wait for events.

    Args:
        control: The drive.
        copy: Whose joints it drives.
        joints: Their names.
        line: Of the case, for the program.
        name: Of the control.
        targets: Timed drives; added to.
        later: Drives that wait for events; added to.
        later_targets: The targets of those; added to.
    """
    mode, schedule = next((m, s) for m in ("position", "velocity", "force") if (s := getattr(control, m)) is not None)
    for joint in joints:
        if control.on is None:
            targets.setdefault((copy.name, joint), []).append((start_of(schedule), mode, schedule, line, name))
        else:
            row = LaterDrive(control.on, mode, constructor_after(schedule), line, name)
            later.setdefault((copy.name, joint), []).append(row)
            later_targets.setdefault((copy.name, joint), []).append((0.0, mode, schedule, line, name))


def constructor_after(schedule: Schedule) -> Code:
    """Return source text: given the target so far, it makes the function of time for a schedule."""
    return Code(f"lambda before: {constructor(schedule, Code('before'))}")


def joint_drives(
    targets: DriveTargets, later: Mapping[tuple[str, str], list[LaterDrive]], initial: Mapping[str, Mapping[str, float]]
) -> list[JointDrive]:
    """Return the drives of every joint. Until its event, a joint that only an event drives is held or at rest.

    Args:
        targets: Timed drives.
        later: Drives that wait for events, by copy and joint.
        initial: Start positions [rad or m] by copy and joint.
    """
    for key, rows in later.items():
        if key not in targets:
            first = initial.get(key[0], {}).get(key[1], 0.0) if rows[0].mode == "position" else 0.0
            hold = Constant(kind="constant", value=first)
            targets[key] = [(0.0, rows[0].mode, hold, rows[0].line, rows[0].control)]
    made = []
    for (entity, joint), rows in targets.items():
        first = initial.get(entity, {}).get(joint, 0.0)
        if (entity, joint) not in later:
            made.append(JointDrive(entity, joint, _chain(rows, first)))
            continue
        # Where a later timed drive starts from depends on events before it, so it waits for its time as they do.
        timed = [
            LaterDrive(start, mode, constructor_after(schedule), line, name)
            for start, mode, schedule, line, name in rows
            if start > 0.0
        ]
        begun: list[DriveTarget] = [row for row in rows if row[0] <= 0.0]
        if not begun:
            _, mode, _, line, name = min(rows, key=lambda row: row[0])
            hold = Constant(kind="constant", value=first if mode == "position" else 0.0)
            begun = [(0.0, mode, hold, line, name)]
        waiting = (*sorted(timed, key=lambda row: row.when), *later[entity, joint])
        made.append(JointDrive(entity, joint, _chain(begun, first), waiting))
    return made


def _chain(segments: list[DriveTarget], first: float) -> tuple[DriveSegment, ...]:
    """Order the drives of one joint; a ramp without `from` starts where the one before it is then.

    Until the first begins, the joint is held where it starts, or at rest, or pushed by nothing.
    """
    segments = sorted(segments, key=lambda segment: segment[0])
    rows: list[DriveSegment] = []
    start, mode, schedule, line, name = segments[0]
    held = first if mode == "position" else 0.0
    if start > 0.0 and not (isinstance(schedule, Ramp) and schedule.from_ in (None, held)):  # these hold it themselves
        rows.append(DriveSegment(0.0, mode, constructor(held), line, name))
    value: Callable[[float], float] = lambda t: first  # noqa: E731
    mode_before = None
    for index, (start, mode, schedule, line, name) in enumerate(segments):
        before = value(start) if mode == mode_before or (index == 0 and mode == "position") else 0.0
        rows.append(DriveSegment(start if rows else 0.0, mode, constructor(schedule, before), line, name))
        value = lambda t, s=schedule, b=before: value_at(s, t, b)  # noqa: E731
        mode_before = mode
    return tuple(rows)
