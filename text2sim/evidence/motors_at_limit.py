"""Motors that work at their `max_force` for a good part of a drive, and how far they are from its target then."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from text2sim.compiler.schedules import value_at
from text2sim.evidence.events import EventLog, acted_on
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.resistance import ancestors, is_blocked, opponents
from text2sim.evidence.selection import SelectionError
from text2sim.recording.states import Array, JointRecord
from text2sim.spec_schema.models.controls import Drive, Reach
from text2sim.spec_schema.models.motion import Schedule, start_of

FULL = 0.99
"""Part of its limit from which a motor counts as working at it."""
LEAST_SHARE = 0.2
"""Part of a drive's time at the limit from which it is reported."""
END = 0.1
"""Part of a drive's time that is its end: a motor that fails is at its limit in nine tenths of it."""
MIN_FRAMES = 5
"""Frames of a drive below which nothing is said about it."""
FAR = {"hinge": 0.1, "slider": 0.01}
"""Mean distance from a position [rad, m] at the end of a drive that is reported; from rest, the same per second."""
MISSING_SPEED = 0.1
"""Part of a target's speed that may be missing."""


@dataclass(frozen=True)
class _Span:
    """A drive during the time that it alone controls its joint."""

    control: str
    mode: str
    """`position`, `velocity`, `force` or `reach`."""
    start: float
    end: float
    """Start and end [s]."""
    target: Callable[[float], float]


def motors_at_limit(recording: RecordedCase, events: EventLog) -> list[dict[str, Any]]:
    """Return the drives that had their motor at its limit for a good part of their time, or at their end.

    Args:
        recording: The recording. One of an older version does not tell the limits, and yields nothing.
        events: What happened, for drives that wait for events.
    """
    found = []
    for (label, joint), drives in _drives(recording, events).items():
        for span in _spans(recording, joint, drives):
            row = _row(recording, joint, span)
            if row is not None:
                found.append({"joint": label, **row})
    return found


def overloaded(rows: list[dict[str, Any]]) -> list[str]:
    """Return a message for each drive whose motor fails."""
    return [
        f"motor `{row['joint']}` works at its max_force of {row['max_force']:.3g} {row['force_unit']} for "
        f"{row['share']:.0%} of the time from {row['start']:.3g} to {row['end']:.3g} s (`{row['control']}`), "
        f"{row['off']:.3g} {row['unit']} from its target at the end: its load is too heavy for it, or something is in "
        "its way"
        for row in rows
        if row["failed"]
    ]


_Drives = list[tuple[float, float, str, str, Schedule | None]]
"""Start [s], shift of the times of its target [s], name, mode and target of drives; None where it is not known."""


def _drives(recording: RecordedCase, events: EventLog) -> dict[tuple[str, JointRecord], _Drives]:
    """Return the drives of each joint with a limited motor; of copies that one control drives, for the first."""
    found: dict[tuple[str, JointRecord], _Drives] = {}
    for name, control in recording.case.actions.controls.items():
        try:
            if isinstance(control, Drive):
                mode = next(m for m in ("position", "velocity", "force") if getattr(control, m) is not None)
                begun = 0.0 if control.on is None else acted_on(recording, control.on, events)
                if begun is None:
                    continue
                labelled = recording.names.select_joints(control.joint)
                for label, joint in labelled:
                    if joint.max_force is not None and joint.body == labelled[0][1].body:
                        schedule = getattr(control, mode)
                        start = start_of(schedule) if control.on is None else begun
                        found.setdefault((label, joint), []).append((start, begun, name, mode, schedule))
            elif isinstance(control, Reach):
                target = recording.names.select(control.body)[0]
                carriers = set(ancestors(recording, target.root))
                for joint in recording.states.joints:
                    if joint.link in carriers and joint.max_force is not None:
                        label = f"{joint.body}.{joint.name}"
                        found.setdefault((label, joint), []).append((control.start, 0.0, name, "reach", None))
        except SelectionError:
            continue
    return found


def _spans(recording: RecordedCase, joint: JointRecord, drives: _Drives) -> Iterator[_Span]:
    """Yield the drives of a joint, each until the next takes over; the first holds the joint until it begins."""
    states = recording.states
    if not states.frames:
        return
    drives = sorted(drives, key=lambda row: row[0])
    last = min(states.end, states.removed.get(joint.body, states.end))
    mode_before, value = "position", lambda t: float(states.qpos[0, joint.q[0]])
    for index, (start, shift, name, mode, schedule) in enumerate(drives):
        before = value(start) if mode == mode_before else 0.0
        end = drives[index + 1][0] if index + 1 < len(drives) else last
        value = _target(schedule, start, shift, before)
        yield _Span(name, mode, start if index else 0.0, min(end, last), value)
        mode_before = mode


def _target(schedule: Schedule | None, start: float, shift: float, before: float) -> Callable[[float], float]:
    if schedule is None:
        return lambda t: np.nan
    return lambda t: value_at(schedule, t - shift, before) if t >= start else before


def _row(recording: RecordedCase, joint: JointRecord, span: _Span) -> dict[str, Any] | None:
    """Return what is told of a drive; None if its motor is not at its limit for long."""
    states, limit = recording.states, joint.max_force
    frames = np.flatnonzero((states.time > span.start) & (states.time <= span.end))
    if span.mode == "force" or len(frames) < MIN_FRAMES or not limit:
        return None
    force = states.dofs_force[frames, joint.dof[0]].astype(float)
    full = np.abs(force) >= FULL * limit
    end = slice(-max(2, round(END * len(frames))), None)
    at_end = full[end].mean() >= 1 - END
    if full.mean() < LEAST_SHARE and not at_end:
        return None
    speed = span.mode == "velocity"
    unit, force_unit = ("rad", "N m") if joint.kind == "hinge" else ("m", "N")
    actual = (states.dofs_velocity[frames, joint.dof[0]] if speed else states.qpos[frames, joint.q[0]]).astype(float)
    wanted = np.array([span.target(float(t)) for t in states.time[frames]])
    sense = float(np.sign(force[end].sum()))
    behind = sense * float((wanted - actual)[end].mean())
    known = np.isfinite(behind)
    failed = bool(at_end and known and behind > _tolerance(joint, wanted[end] if speed else None))
    return {
        "control": span.control,
        "max_force": limit,
        "force_unit": force_unit,
        "share": float(full.mean()),
        "start": span.start,
        "end": float(states.time[frames[-1]]),
        "off": abs(behind) if known else None,
        "unit": unit + "/s" * speed,
        "against": opponents(recording, joint, sense, frames[end]) if at_end else [],
        "failed": failed and not is_blocked(recording, joint, sense, frames[end]),
    }


def _tolerance(joint: JointRecord, speeds: Array | None) -> float:
    """Return the distance from a target [rad, m] or speed [rad/s, m/s] beyond which a motor fails."""
    wanted = 0.0 if speeds is None else MISSING_SPEED * abs(float(speeds.mean()))
    return wanted or FAR[joint.kind]
