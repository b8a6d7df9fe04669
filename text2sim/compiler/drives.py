"""Drives of joints: a timed drive takes over from the one before it, another when its event happens."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from text2sim.compiler.action_rows import DriveSegment, JointDrive, LaterDrive, Origin
from text2sim.compiler.literal import Code
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.schedules import constructor, value_at
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.models.controls import Drive
from text2sim.spec_schema.models.motion import Constant, Ramp, Schedule, start_of
from text2sim.spec_schema.names.selectors import named_by


class DriveTarget(NamedTuple):
    """What a control makes a joint follow from a time on."""

    start: float
    """[s]; 0 for one that begins at an event, which may come at any time."""
    mode: str
    """`position`, `velocity` or `force`."""
    schedule: Schedule
    line: int
    control: str


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


def constructor_after(schedule: Schedule) -> Code:
    """Return source text: given the target so far, it makes the function of time for a schedule."""
    return Code(f"lambda before: {constructor(schedule, Code('before'))}")


@dataclass
class JointTargets:
    """What controls make joints follow, by copy and joint, in the order of the case."""

    targets: DriveTargets = field(default_factory=dict)
    """What begins at times."""
    later: dict[tuple[str, str], list[LaterDrive]] = field(default_factory=dict)
    """What begins at events."""
    later_targets: DriveTargets = field(default_factory=dict)
    """Targets of `later`."""

    def add(self, control: Drive, copy: Copy, joints: Iterable[str], origin: Origin) -> None:
        """Add a drive of joints of one copy.

        Args:
            control: The drive.
            copy: Whose joints it drives.
            joints: Their names.
            origin: The control's line and name.
        """
        modes = ("position", "velocity", "force")
        mode, schedule = next((m, s) for m in modes if (s := getattr(control, m)) is not None)
        for joint in joints:
            key = copy.name, joint
            if control.on is None:
                self.targets.setdefault(key, []).append(DriveTarget(start_of(schedule), mode, schedule, *origin))
            else:
                row = LaterDrive(control.on, mode, constructor_after(schedule), *origin)
                self.later.setdefault(key, []).append(row)
                self.later_targets.setdefault(key, []).append(DriveTarget(0.0, mode, schedule, *origin))

    def all_of(self, entity: str, joint: str) -> list[DriveTarget]:
        """Return all that a joint follows: first what begins at times, then what begins at events."""
        key = entity, joint
        return [*self.targets.get(key, ()), *self.later_targets.get(key, ())]

    def drives(self, initial: Mapping[str, Mapping[str, float]]) -> list[JointDrive]:
        """Return the drives of every joint. Until its event, a joint that only an event drives is held or at rest.

        Args:
            initial: Start positions [rad or m] by copy and joint.
        """
        for key, events in self.later.items():
            if key not in self.targets:
                begin = initial.get(key[0], {}).get(key[1], 0.0) if events[0].mode == "position" else 0.0
                hold = Constant(kind="constant", value=begin)
                self.targets[key] = [DriveTarget(0.0, events[0].mode, hold, events[0].line, events[0].control)]
        made = []
        for (entity, joint), rows in self.targets.items():
            first = initial.get(entity, {}).get(joint, 0.0)
            if (entity, joint) not in self.later:
                made.append(JointDrive(entity, joint, _chain(rows, first)))
                continue
            # Where a later timed drive starts from depends on events before it, so it waits for its time as they do.
            timed = [
                LaterDrive(start, mode, constructor_after(schedule), line, name)
                for start, mode, schedule, line, name in rows
                if start > 0.0
            ]
            begun = [row for row in rows if row.start <= 0.0]
            if not begun:
                one = min(rows, key=lambda row: row.start)
                hold = Constant(kind="constant", value=first if one.mode == "position" else 0.0)
                begun = [one._replace(start=0.0, schedule=hold)]
            waiting = (*sorted(timed, key=lambda row: row.when), *self.later[entity, joint])
            made.append(JointDrive(entity, joint, _chain(begun, first), waiting))
        return made


def _chain(segments: list[DriveTarget], first: float) -> tuple[DriveSegment, ...]:
    """Order the drives of one joint; a ramp without `from` starts where the one before it is then.

    Until the first begins, the joint is held where it starts, or at rest, or pushed by nothing.
    """
    segments = sorted(segments, key=lambda segment: segment.start)
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
